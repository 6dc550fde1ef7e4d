"""Polyhedra and contact polygons as VTU: read back by VTK with their volumes, areas and names."""

from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import bsm_mesh as bsm
from bsm_mesh.converters import three_d as files
from bsm_mesh.converters.vtk_library import load_vtk, names_in
from bsm_mesh.geometries import three_d
from bsm_mesh.three_d.blocks.polygons import vector_areas
from tests.scenes.rock_3d import planes, tunnel_rock
from tests.unit.test_key_blocks import ROCK, joint


def read(path):
    load_vtk()
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    sized = vtkCellSizeFilter()
    sized.SetInputData(reader.GetOutput())
    sized.Update()
    data = sized.GetOutput()
    arrays = data.GetCellData()
    found = {arrays.GetArrayName(k): vtk_to_numpy(arrays.GetArray(k)) for k in range(arrays.GetNumberOfArrays())}
    return data, found, names_in(data)


def corners_of(face):
    """Return the corners of a face of VTK, which is another one when the next is asked for."""
    return np.array([face.GetPoints().GetPoint(k) for k in range(face.GetNumberOfPoints())])


def test_blocks_are_polyhedra_of_their_volume(tmp_path):
    low, high = (0, 0, 0), (4, 4, 3)
    blocks = bsm.Polyhedra.from_cells(
        three_d.cut_cells(three_d.RockMass(box=(low, high), joints=planes(low, high, 1.2, 3)))
    )
    data, found, names = read(files.write_blocks(tmp_path / "blocks.vtu", blocks))
    assert data.GetNumberOfCells() == blocks.count > 50
    assert_allclose(found["Volume"], blocks.moments.volume, rtol=1e-9, atol=1e-14)
    assert_allclose(found["volume"], blocks.moments.volume)
    assert names == {"rock:rock": 0}
    sides = np.bincount(
        blocks.face_blocks[(blocks.face_blocks >= 0) & (blocks.face_blocks[:, ::-1] != blocks.face_blocks)]
    )
    for number in range(0, blocks.count, 10):
        cell = data.GetCell(number)
        corners = [corners_of(cell.GetFace(k)) for k in range(cell.GetNumberOfFaces())]
        area = vector_areas(np.concatenate(corners), np.cumsum([0, *map(len, corners)]))
        height = np.array([one.mean(axis=0) for one in corners]) - blocks.moments.centroid[number]
        assert len(corners) == sides[number]
        assert_allclose((area * height).sum() / 3, blocks.moments.volume[number], rtol=1e-9, atol=1e-14)
    (cells,) = ElementTree.parse(tmp_path / "blocks.vtu").iter("Cells")
    arrays = [array.get("Name") for array in cells]
    assert arrays == ["connectivity", "offsets", "types", "faces", "faceoffsets"]  # as ParaView 5 reads them
    data, found, names = read(files.write_contacts(tmp_path / "contacts.vtu", blocks))
    assert_allclose(found["Area"], blocks.contact_polygons.area, rtol=1e-9, atol=1e-14)
    assert_allclose(found["normal"], blocks.contact_polygons.normal)
    assert names == {f"joint:J{k + 1}": k for k in range(3)}
    with pytest.raises(bsm.ModelError, match=r"give a name that ends in .vtu"):
        files.write_blocks(tmp_path / "blocks.vtk", blocks)


def test_key_blocks_are_arrays_of_the_blocks(tmp_path):
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock(5.0)))
    found = bsm.key_blocks(blocks, rocks=ROCK, joints=[joint(f"J{k}") for k in (1, 2, 3)], free=["tunnel"])
    _, arrays, names = read(files.write_blocks(tmp_path / "blocks.vtu", blocks, key_blocks=found))
    inner = np.setdiff1d(np.arange(blocks.count), found.block)
    assert (arrays["mode"][inner] == -1).all()
    assert np.isnan(arrays["factor"][inner]).all()
    assert arrays["mode"][found.block].tolist() == found.mode.tolist()
    assert names["mode:falls"] == 2


def test_surfaces_of_blocks_of_several_cells_are_closed():
    """Volumes by the faces of the file; VTK's own are wrong where a polyhedron is not convex."""
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock(5.0)))
    grid = files.block_grid(blocks)
    assert np.bincount(blocks.cell_block).max() > 1
    sizes, owner = np.diff(grid.faces.offsets), np.repeat(np.arange(blocks.count), np.diff(grid.faces.cell_offsets))
    corner = grid.points[grid.faces.connectivity] - blocks.moments.centroid[np.repeat(owner, sizes)]
    vector = vector_areas(corner, grid.faces.offsets.astype(np.int32))
    height = (vector * corner[grid.faces.offsets[:-1]]).sum(axis=1)
    assert_allclose(np.bincount(owner, height) / 3, blocks.moments.volume, rtol=1e-9, atol=1e-12)


def test_points_of_turned_blocks_are_where_the_blocks_are():
    """A large turn and a shift of the second of two blocks, exact."""
    rock = three_d.RockMass(
        box=((0, 0, 0), (2, 1, 1)),
        joints=[three_d.JointPlane(name="A", dip=90, dip_direction=90, point=(1, 0, 0))],
    )
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    shift = np.array([(0, 0, 0), (0.3, 0, -5.0)])
    turn = np.stack([np.eye(3), Rotation.from_rotvec((0.3, -1.2, 0.8)).as_matrix()])
    grid = files.block_grid(blocks, movement=np.hstack([shift, [(0, 0, 0), (0.3, -1.2, 0.8)]]))
    placed = grid.points + grid.point_data["displacement"]
    assert len(grid.points) == 16
    centre = blocks.moments.centroid[1]
    second = slice(*grid.offsets[1:3])
    assert_allclose(placed[second], (grid.points[second] - centre) @ turn[1].T + centre + shift[1], atol=1e-12)
    assert_allclose(placed[: grid.offsets[1]], grid.points[: grid.offsets[1]])
