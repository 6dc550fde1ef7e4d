"""The same mesh from every kind of file, and files that are none."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gmsh
import meshio
import numpy as np
import pytest

from bsm_mesh.converters import NoteKind, convert_meshio, meshio_library, read_blocks, read_mesh
from bsm_mesh.converters.meshes.from_meshio import read_by_meshio
from bsm_mesh.errors import MeshWarning, ModelError
from bsm_mesh.geometries import gmsh_session
from bsm_mesh.model import Blocks
from tests.scenes.mesh_files import two_squares

COUNTS = {"rock:gneiss": 8, "rock:schist": 8, "excavation:core": 8, "joint:J1": 4}
COUNTS |= {"boundary:top": 4, "boundary:left": 2}


@pytest.fixture
def model() -> Iterator[Any]:
    """Two unit squares of eight triangles each; the joint between them, in the group in reversed direction."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("two squares")
    level, upright = two_squares(gmsh.model)
    groups: list[tuple[int, list[int], str]] = [
        (2, [1], "rock:gneiss"),
        (2, [2], "rock:schist"),
        (2, [2], "excavation:core"),
        (1, [-upright[1]], "joint:J1"),
        (1, [level[0, 1], -level[1, 1]], "boundary:top"),
        (1, [upright[0]], "boundary:left"),
    ]
    for k, (dimension, entities, name) in enumerate(groups):
        gmsh.model.addPhysicalGroup(dimension, entities, k % 3 + 1, name)  # curves and surfaces share numbers
    gmsh.model.mesh.generate(2)
    yield gmsh.model
    gmsh.finalize()


def write(path: Path, version: float = 4.1, binary: int = 0, **options: float) -> Path:
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    for name, value in options.items():
        gmsh.option.setNumber(f"Mesh.{name}", value)
    gmsh.write(str(path))
    return path


@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("version", [4.1, 2.2])
def test_gmsh_files_of_all_versions(model: Any, tmp_path: Path, version: float, binary: int) -> None:
    blocks, report = read_mesh(write(tmp_path / "a.msh", version, binary))
    assert report.groups == COUNTS
    assert blocks.moments.area.sum() == pytest.approx(2.0)
    x = blocks.vertices[blocks.edge_joint == 0, 0]
    np.testing.assert_allclose(x, 1.0)
    assert report.count(NoteKind.JOINED) == (0 if version == 4.1 else 8)  # MSH 2.2 repeats them for each group


@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_higher_order_meshes_are_reduced(model: Any, tmp_path: Path, order: int, binary: int) -> None:
    model.mesh.setOrder(order)
    _, report = read_mesh(write(tmp_path / "a.msh", binary=binary))
    assert report.groups == COUNTS
    assert report.count(NoteKind.REDUCED) == (0 if order == 1 else 16)
    assert report.count(NoteKind.UNUSED) == 0


def test_incomplete_quads_of_gmsh_are_reduced(model: Any, tmp_path: Path) -> None:
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
    model.mesh.recombine()
    model.mesh.setOrder(2)
    blocks, _ = read_mesh(write(tmp_path / "a.msh"))
    assert set(np.diff(blocks.offsets)) == {4}


@pytest.mark.parametrize("binary", [0, 1])
def test_elements_in_no_group_and_parametric_nodes(model: Any, tmp_path: Path, binary: int) -> None:
    model.removePhysicalGroups([(2, 1)])
    _, report = read_mesh(write(tmp_path / "a.msh", binary=binary, SaveAll=1, SaveParametric=1))
    assert report.count(NoteKind.NO_ROCK) == 8
    assert report.groups["rock:schist"] == 8


def test_groups_without_a_name_are_found_by_their_number(model: Any, tmp_path: Path) -> None:
    model.removePhysicalName("rock:gneiss")
    _, report = read_mesh(write(tmp_path / "a.msh"), groups={"gmsh:physical=1": "rock:granite"})
    assert report.groups["rock:granite"] == 8
    with pytest.raises(ModelError, match=r"8 elements are in 'rock:x' and in 'rock:schist'"):
        read_mesh(tmp_path / "a.msh", groups={"gmsh:geometrical=2": "rock:x"})


def test_doubled_nodes_of_gmshs_crack_plugin_conform_again(model: Any, tmp_path: Path) -> None:
    crack = model.addPhysicalGroup(1, [6])
    gmsh.plugin.setNumber("Crack", "Dimension", 1)
    gmsh.plugin.setNumber("Crack", "PhysicalGroup", crack)
    gmsh.plugin.run("Crack")
    blocks, report = read_mesh(write(tmp_path / "a.msh"))
    assert report.count(NoteKind.MERGED) > 0
    assert report.groups["joint:J1"] == 4
    assert blocks.nodes.max() + 1 == 17 - 4 + 2


def test_abaqus_sets_of_gmsh(model: Any, tmp_path: Path) -> None:
    gmsh.option.setNumber("Mesh.SaveGroupsOfElements", 1)
    _, report = read_mesh(write(tmp_path / "a.inp"))
    assert report.groups == COUNTS
    assert "Surface1, Surface2" in report.about(NoteKind.UNKNOWN_GROUP)


def test_abaqus_sets_on_some_element_lines_only(tmp_path: Path) -> None:
    text = """*NODE
1, 0, 0
2, 1, 0
3, 0, 1
4, 1, 1
5, 2, 0
6, 2, 1
*ELEMENT, TYPE=CPS3
1, 1, 2, 3
*ELEMENT, TYPE=CPS3, ELSET=Soft
2, 2, 4, 3
*ELEMENT, TYPE=CPS4, ELSET=Soft
3, 2, 5, 6, 4
"""
    (tmp_path / "a.inp").write_text(text)
    blocks, _ = read_mesh(tmp_path / "a.inp", groups={"Soft": "rock:soft", "*": "rock:hard"})
    assert [blocks.rock_names[k] for k in blocks.rock] == ["hard", "soft", "soft"]


POINTS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2.5, 0.5, 0), (2, 1, 0), (0.5, 2, 0)])
CELLS = [("line", [[1, 2]]), ("polygon", [[1, 4, 5, 6, 2]]), ("quad", [[0, 1, 2, 3]]), ("triangle", [[3, 2, 7]])]
MATERIALS = [np.array([9]), np.array([2]), np.array([1]), np.array([1])]
RENAMING = {"MaterialIDs=1": "rock:a", "MaterialIDs=2": "rock:b", "MaterialIDs=9": "joint:J"}


@pytest.mark.parametrize(
    ("ending", "options"),
    [
        ("vtu", {"binary": False}),
        ("vtu", {"binary": True, "compression": None}),
        ("vtu", {"binary": True, "compression": "zlib"}),
        ("vtk", {"binary": False}),
        ("vtk", {"binary": True}),
    ],
)
def test_vtk_files_with_polygons_keep_their_order(tmp_path: Path, ending: str, options: Any) -> None:
    mesh = meshio.Mesh(POINTS, CELLS, cell_data={"MaterialIDs": MATERIALS})
    mesh.write(tmp_path / f"a.{ending}", **options)
    blocks, report = read_mesh(tmp_path / f"a.{ending}", groups=RENAMING)
    assert np.diff(blocks.offsets).tolist() == [5, 4, 3]
    assert [blocks.rock_names[k] for k in blocks.rock] == ["b", "a", "a"]
    assert report.groups["joint:J"] == 2
    in_memory, _ = convert_meshio(mesh, groups=RENAMING)
    np.testing.assert_array_equal(in_memory.vertices, blocks.vertices)


def test_a_vtu_that_names_its_rocks_needs_no_renaming(tmp_path: Path) -> None:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    grid, points = vtkUnstructuredGrid(), vtkPoints()
    points.SetData(numpy_to_vtk(POINTS[[1, 4, 5, 6, 2, 0, 1, 2, 3]], deep=True))  # every block has points of its own
    grid.SetPoints(points)
    grid.InsertNextCell(7, 5, [0, 1, 2, 3, 4])
    grid.InsertNextCell(9, 4, [5, 6, 7, 8])
    grid.InsertNextCell(4, 3, [5, 6, 7])  # a poly-line of two pieces
    rock = numpy_to_vtk(np.array([1, 0, -1], dtype=np.int32), deep=True)
    rock.SetName("rock")
    grid.GetCellData().AddArray(rock)
    for number, name in enumerate(("rock:gneiss", "rock:schist")):
        array = numpy_to_vtk(np.array([number]), deep=True)
        array.SetName(name)
        grid.GetFieldData().AddArray(array)
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(tmp_path / "a.vtu"))
    writer.SetInputData(grid)
    writer.Write()
    blocks, report = read_mesh(tmp_path / "a.vtu", groups={"rock=-1": "boundary:b"})
    assert [blocks.rock_names[k] for k in blocks.rock] == ["schist", "gneiss"]
    assert blocks.nodes.max() + 1 == 7
    assert report.groups["boundary:b"] == 3


@pytest.mark.parametrize("ending", ["inp", "bdf", "mesh", "avs", "ply", "post", "vol"])
def test_other_formats_of_meshio(tmp_path: Path, ending: str) -> None:
    meshio.Mesh(POINTS, [CELLS[2], CELLS[3]]).write(tmp_path / f"a.{ending}")
    blocks, _ = read_mesh(tmp_path / f"a.{ending}", groups={"*": "rock:a"})
    assert np.diff(blocks.offsets).tolist() == [4, 3]
    assert blocks.nodes.max() + 1 == 5


@pytest.mark.parametrize("library", ["meshio", "meshlane"])
def test_meshio_and_its_maintained_descendant_read_alike(
    tmp_path: Path, library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip(library)
    monkeypatch.setattr(meshio_library, "NAMES", (library,))
    for ending in ("bdf", "mesh", "avs", "ply", "post", "vol", "su2"):
        meshio.Mesh(POINTS[:, :2] if ending == "su2" else POINTS, [CELLS[2], CELLS[3]]).write(tmp_path / f"a.{ending}")
        cells = read_by_meshio(tmp_path / f"a.{ending}")
        assert sorted(np.diff(cells.offsets).tolist()) == [3, 4]


def test_universal_files_are_read_by_gmsh(tmp_path: Path) -> None:
    """Groups of elements keep their names; what is no such file is reported."""
    with gmsh_session("unv") as session:
        square = session.model.occ.addRectangle(0, 0, 0, 2, 1)
        session.model.occ.synchronize()
        session.option.setNumber("Mesh.MeshSizeMax", 0.5)
        session.model.addPhysicalGroup(2, [square], 1, "SCHIST")
        session.model.addPhysicalGroup(1, [1], 2, "BASE")
        session.model.mesh.generate(2)
        session.option.setNumber("Mesh.SaveGroupsOfElements", 1)
        session.write(str(tmp_path / "a.unv"))
    blocks, report = read_mesh(tmp_path / "a.unv", groups={"SCHIST": "rock:schist", "BASE": "boundary:base"})
    assert blocks.moments.area.sum() == pytest.approx(2)
    assert report.groups["rock:schist"] == blocks.count > 16
    assert (blocks.vertices[blocks.boundaries["base"], 1] == 0).all()
    (tmp_path / "b.unv").write_text("hello")
    with pytest.raises(ModelError, match=r"b\.unv: its content is no mesh"):
        read_mesh(tmp_path / "b.unv")


def test_families_of_med_are_groups() -> None:
    mesh = meshio.Mesh(POINTS, [CELLS[2], CELLS[3]], cell_data={"cell_tags": [np.array([-1]), np.array([-2])]})
    mesh.cell_tags = {-1: ["rock:a", "excavation:1"], -2: ["rock:b"]}
    blocks, report = convert_meshio(mesh)
    assert report.groups == {"rock:a": 1, "rock:b": 1, "excavation:1": 1}
    assert blocks.excavations["1"].tolist() == [0]


def test_reading_blocks_warns_of_what_was_mended_and_is_else_silent(tmp_path: Path, capfd: Any) -> None:
    mesh = meshio.Mesh(POINTS[:4], [("triangle", [[0, 2, 1], [0, 2, 3]])])
    mesh.write(tmp_path / "a.vtu")
    with pytest.warns(MeshWarning, match="a.vtu: 1 elements are given clockwise"):
        blocks = read_blocks(tmp_path / "a.vtu", groups={"*": "rock:a"})
    assert isinstance(blocks, Blocks)
    meshio.Mesh(POINTS[:4], [("triangle", [[0, 1, 2], [0, 2, 3]])]).write(tmp_path / "b.vtu")
    capfd.readouterr()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_blocks(tmp_path / "b.vtu", groups={"*": "rock:a"})
    assert capfd.readouterr() == ("", "")


def test_paths_that_no_mesh_is_at(tmp_path: Path) -> None:
    (tmp_path / "known.msh").write_text("$MeshFormat")
    (tmp_path / "empty.msh").touch()
    (tmp_path / "a.dwg").write_text("x")
    for name, message in (
        ("lost.msh", "no such file .*holds: empty.msh, known.msh"),
        ("", "is a folder"),
        ("empty.msh", "is empty"),
        ("a.dwg", "no mesh format has the ending '.dwg' .*.msh"),
        ("known.msh/a.msh", "cannot be opened|no such file"),
    ):
        with pytest.raises(ModelError, match=message):
            read_mesh(tmp_path / name)


def test_a_volume_mesh_is_refused_with_the_cure(tmp_path: Path) -> None:
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("box")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        for version in (4.1, 2.2):
            with pytest.raises(ModelError, match=r"three-dimensional mesh.*generate"):
                read_mesh(write(tmp_path / "a.msh", version))
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("ending", ["msh", "vtu", "vtk", "inp", "su2", "med", "off", "bdf", "xdmf"])
@pytest.mark.parametrize("content", [b"\x00\xff\x80junk\n" * 40, b"hello\n", b"$MeshFormat\n4.1 0 8\n"])
def test_junk_is_one_clear_error_and_nothing_is_printed(
    tmp_path: Path, capfd: Any, ending: str, content: bytes
) -> None:
    (tmp_path / f"a.{ending}").write_bytes(content)
    with pytest.raises(ModelError, match=r"a\.") as caught:
        read_mesh(tmp_path / f"a.{ending}")
    assert len(caught.value.faults) == 1
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("version", "binary"), [(4.1, 0), (4.1, 1), (2.2, 0), (2.2, 1)])
def test_a_file_cut_off_anywhere_is_an_error(model: Any, tmp_path: Path, version: float, binary: int) -> None:
    whole = write(tmp_path / "a.msh", version, binary).read_bytes()
    end = whole.rindex(b"$EndElements")
    read = read_mesh if version == 4.1 else read_by_meshio  # here, and not sixty times in a process of its own
    for length in np.linspace(1, end, 60).astype(int):
        (tmp_path / "b.msh").write_bytes(whole[:length])
        with pytest.raises(ModelError, match=r"b\.msh"):
            read(tmp_path / "b.msh")


def test_blocks_written_for_paraview_are_read_back_as_a_mesh(tmp_path: Path) -> None:
    from bsm_mesh.converters.vtk_files import Grid, write_vtu
    from bsm_mesh.converters.vtk_library import POLYGON

    outlines = [POINTS[[1, 4, 5, 6, 2], :2], POINTS[[3, 2, 7], :2], POINTS[:4, :2]]
    blocks = Blocks.from_polygons(outlines, rock=["schist", "gneiss", "schist"])
    grid = Grid(
        points=blocks.vertices,
        connectivity=np.arange(len(blocks.vertices)),
        offsets=blocks.offsets,
        cell_type=POLYGON,
        cell_data={"rock": blocks.rock},
        names={"rock:schist": 0, "rock:gneiss": 1},
    )
    write_vtu(tmp_path / "a.vtu", grid)
    again, _ = read_mesh(tmp_path / "a.vtu")
    np.testing.assert_array_equal(again.vertices, blocks.vertices)
    np.testing.assert_array_equal(again.offsets, blocks.offsets)
    assert [again.rock_names[k] for k in again.rock] == ["schist", "gneiss", "schist"]
    assert again.nodes.max() == blocks.nodes.max()
