"""The VTU files of a run, read back by VTK and by PyVista: names, components and values."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import pyvista
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

import bsm_mesh as bsm
from bsm_mesh.converters.result_files import SERIES, corner_displacement
from bsm_mesh.converters.vtk_library import POLYGON, VERTEX
from bsm_mesh.results import Results
from bsm_mesh.results.stress import principal_stresses
from tests.scenes import shapes

CONTACT_ARRAYS = ["block_a", "block_b", "length", "normal_force", "shear_force"]
CONTACT_ARRAYS += ["status", "utilisation", "opening", "slip", "joint"]
LARGE = 2.5  # rad; far beyond any small-angle formula


@pytest.fixture(scope="module")
def results() -> Results:
    """Return blocks of three, four and five corners with a large rotation put in."""
    pentagon = shapes.turned([(np.cos(a), np.sin(a)) for a in np.radians(72) * np.arange(5)], 20, (5, 5))
    triangle = np.array([(0.0, 1.0), (1.0, 1.0), (0.5, 2.0)])
    blocks = bsm.Blocks.from_polygons([shapes.SQUARE, triangle, pentagon], rock=["gneiss", "schist", "gneiss"])
    results = bsm.run(
        bsm.Model(
            blocks=blocks,
            rocks=[bsm.Rock("gneiss", unit_weight=26e3), bsm.Rock("schist", unit_weight=24e3)],
            joints=[
                bsm.Joint("J0", normal_stiffness=1e9, shear_stiffness=1e9),
                bsm.Joint("J1", normal_stiffness=2e9, shear_stiffness=5e8, law=bsm.MohrCoulomb(friction=35)),
            ],
            default_joint="J1",
            supports=[bsm.Fixed(blocks=[0, 2])],
            loads=[bsm.PointLoad(block=1, point=(0.5, 2.0), force=(3e3, 0))],
        )
    )
    (stage,) = results.stages
    moved = stage.displacement + np.array([[0, 0, 0], [0, 0, 0], [0.3, -0.2, LARGE]])
    return replace(results, stages=(replace(stage, displacement=moved, unstable_blocks=np.array([2], np.int32)),))


@pytest.fixture(scope="module")
def folder(results: Results, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return results.save(tmp_path_factory.mktemp("out"))


def read(path: Path) -> tuple[Any, dict[str, np.ndarray], dict[str, np.ndarray]]:
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    arrays = []
    for data in (grid.GetPointData(), grid.GetCellData()):
        numbers = [data.GetArray(k) for k in range(data.GetNumberOfArrays()) if data.GetArray(k)]  # texts are none
        arrays.append({array.GetName(): vtk_to_numpy(array) for array in numbers})
    return grid, arrays[0], arrays[1]


def test_blocks(results: Results, folder: Path) -> None:
    grid, points, cells = read(folder / "blocks_0000.vtu")
    (stage,) = results.stages
    assert [grid.GetCellType(k) for k in range(3)] == [POLYGON] * 3
    assert [grid.GetCell(k).GetNumberOfPoints() for k in range(3)] == [4, 3, 5]
    np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData())[:, :2], results.blocks.vertices)
    np.testing.assert_array_equal(cells["block_id"], [0, 1, 2])
    np.testing.assert_array_equal(cells["rock"], [0, 1, 0])
    np.testing.assert_array_equal(cells["displacement"], np.pad(stage.displacement[:, :2], ((0, 0), (0, 1))))
    np.testing.assert_array_equal(cells["rotation"], stage.displacement[:, 2])
    s = stage.stress
    zero = np.zeros(3)
    np.testing.assert_array_equal(
        cells["stress"], np.column_stack([s[:, 0, 0], s[:, 1, 1], zero, s[:, 0, 1], zero, zero])
    )
    sigma_1, sigma_3 = principal_stresses(s)
    np.testing.assert_array_equal(cells["sigma_1"], sigma_1)
    np.testing.assert_array_equal(cells["sigma_3"], sigma_3)
    assert np.all(cells["sigma_1"] <= cells["sigma_3"])
    np.testing.assert_array_equal(cells["unstable"], [0, 0, 1])
    assert [grid.GetFieldData().GetArray(f"rock:{name}").GetValue(0) for name in ("gneiss", "schist")] == [0, 1]
    assert points["displacement"].shape == (12, 3)


def test_warped_corners_are_those_of_the_turned_block(results: Results, folder: Path) -> None:
    """Warp By Vector on the point array gives the block turned as a rigid body, whatever the angle."""
    _, points, _ = read(folder / "blocks_0000.vtu")
    blocks, (stage,) = results.blocks, results.stages
    corners = blocks.vertices[blocks.offsets[2] :]
    u, v, _ = stage.displacement[2]
    centroid = blocks.moments.centroid[2]
    expected = shapes.turned(corners - centroid, np.degrees(LARGE), centroid + np.array((u, v)))
    moved = corners + points["displacement"][blocks.offsets[2] :, :2]
    np.testing.assert_allclose(moved, expected, rtol=1e-13)
    side = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    np.testing.assert_allclose(np.hypot(*(np.roll(moved, -1, axis=0) - moved).T), side, rtol=1e-13)


def test_tiny_rotations_keep_their_digits() -> None:
    blocks = bsm.Blocks.from_polygons([shapes.SQUARE], rock="any")
    theta = 1e-12
    moved = corner_displacement(blocks, np.array([[0.0, 0.0, theta]]))
    np.testing.assert_allclose(moved[0], [theta / 2, -theta / 2], rtol=1e-9)


def test_contacts(results: Results, folder: Path) -> None:
    grid, points, cells = read(folder / "contacts_0000.vtu")
    contacts = results.stages[0].contacts
    assert grid.GetNumberOfCells() == len(contacts.length) == 2
    assert {grid.GetCellType(k) for k in range(2)} == {VERTEX}
    np.testing.assert_array_equal(points["position"][:, :2], contacts.point)
    for name in CONTACT_ARRAYS:
        np.testing.assert_array_equal(cells[name], getattr(contacts, name), err_msg=name)
    np.testing.assert_allclose(cells["normal_traction"], contacts.normal_force / contacts.length)
    np.testing.assert_allclose(cells["shear_traction"], contacts.shear_force / contacts.length)
    n = contacts.normal
    t = np.column_stack([-n[:, 1], n[:, 0]])
    force = contacts.normal_force[:, None] * n + contacts.shear_force[:, None] * t
    np.testing.assert_allclose(cells["force"], np.pad(force, ((0, 0), (0, 1))))
    np.testing.assert_array_equal(cells["normal"], np.pad(n, ((0, 0), (0, 1))))
    np.testing.assert_array_equal(cells["joint"], [1, 1])
    upper = np.where(contacts.block_b == 1, 1, -1)[:, None] * force  # on the triangle
    np.testing.assert_allclose(upper.sum(axis=0), [-3e3, 24e3 * 0.5], rtol=1e-9)


def test_supports(results: Results, folder: Path) -> None:
    _, _, cells = read(folder / "supports_0000.vtu")
    assert cells["reaction"].shape == (2, 3)
    np.testing.assert_array_equal(cells["block_id"], [0, 2])
    np.testing.assert_allclose(cells["reaction"].sum(axis=0)[:2], -results.stages[0].total_load, rtol=1e-9)


@pytest.mark.parametrize("kind", SERIES)
def test_pyvista_reads_the_series(folder: Path, kind: str) -> None:
    root = ElementTree.parse(folder / f"{kind}.pvd").getroot()
    assert [(e.get("timestep"), e.get("file")) for e in root.iter("DataSet")] == [("0", f"{kind}_0000.vtu")]
    reader = pyvista.get_reader(folder / f"{kind}.pvd")
    assert reader.time_values == [0.0]
    grid = reader.read()[0]
    _, points, cells = read(folder / f"{kind}_0000.vtu")
    assert set(cells) <= set(grid.cell_data)
    assert set(points) <= set(grid.point_data)


@pytest.mark.parametrize(("compression", "compressor"), [("zlib", b"vtkZLib"), ("lz4", b"vtkLZ4")])
def test_files_are_compressed(results: Results, tmp_path: Path, compression: Any, compressor: bytes) -> None:
    results.save(tmp_path, compression=compression)
    for path in tmp_path.glob("*_0000.vtu"):
        assert compressor + b"DataCompressor" in path.read_bytes()[:400]
    again = Results.load(tmp_path).stages[0]
    np.testing.assert_array_equal(again.displacement, results.stages[0].displacement)


def test_nothing_but_whole_files(folder: Path) -> None:
    assert [path.name for path in folder.iterdir() if path.name.startswith(".")] == [".bsm-mesh-results"]
