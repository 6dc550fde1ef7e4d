"""Meshes in forms that meshio does not know: the same groups as of the form that it knows, or the true reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bsm_mesh.converters import NoteKind, read_mesh
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries import gmsh_session
from tests.scenes.mesh_files import two_squares

COUNTS = {"rock:gneiss": 8, "rock:schist": 8, "excavation:core": 8, "joint:J1": 4, "boundary:top": 4}
NAMES = ["rock:gneiss", "rock:schist", "excavation:core", "joint:J1", "boundary:top"]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two unit squares of eight triangles each, and a joint between them, in many forms."""
    folder = tmp_path_factory.mktemp("forms")
    with gmsh_session("two squares") as session:
        level, upright = two_squares(session.model)
        groups = [(2, [1]), (2, [2]), (2, [2]), (1, [upright[1]]), (1, [level[0, 1], level[1, 1]])]
        for number, ((dimension, entities), name) in enumerate(zip(groups, NAMES, strict=True), start=1):
            session.model.addPhysicalGroup(dimension, entities, number, name)
        session.model.mesh.generate(2)
        for name, options in {
            "plain.msh": {"MshFileVersion": 2.2},
            "one.msh": {"MshFileVersion": 1},
            "parametric.msh": {"MshFileVersion": 2.2, "SaveParametric": 1},
            "parametric_binary.msh": {"MshFileVersion": 2.2, "SaveParametric": 1, "Binary": 1},
            "of_2018.msh": {"MshFileVersion": 4.0},
            "of_2018_parametric.msh": {"MshFileVersion": 4.0, "SaveParametric": 1},
            "all.msh": {"MshFileVersion": 2.2, "SaveAll": 1},
            "all_parametric.msh": {"MshFileVersion": 2.2, "SaveAll": 1, "SaveParametric": 1},
            "mesh.cgns": {},
            "mesh.bdf": {},
            "mesh.unv": {"SaveGroupsOfElements": 1},
        }.items():
            for option in ("SaveParametric", "Binary", "SaveAll"):
                session.option.setNumber(f"Mesh.{option}", 0)
            for option, value in options.items():
                session.option.setNumber(f"Mesh.{option}", value)
            session.write(str(folder / name))
    return folder


@pytest.mark.parametrize(
    "name",
    ["parametric.msh", "parametric_binary.msh", "of_2018.msh", "of_2018_parametric.msh", "mesh.cgns", "mesh.unv"],
)
def test_forms_of_gmsh_that_meshio_does_not_know(written: Path, name: str) -> None:
    blocks, report = read_mesh(written / name)
    assert report.groups == COUNTS
    np.testing.assert_allclose(blocks.vertices[blocks.edge_joint == 0, 0], 1.0)
    assert blocks.moments.area.sum() == pytest.approx(2.0)


def test_the_first_version_has_numbers_of_groups(written: Path) -> None:
    groups: Any = {f"gmsh:physical={number}": name for number, name in enumerate(NAMES, start=1)}
    assert read_mesh(written / "one.msh", groups=groups)[1].groups == COUNTS


def test_groups_of_elements_of_one_surface_stay_apart(tmp_path: Path) -> None:
    """Other programs give all elements one elementary number: Gmsh would put all into all groups."""
    names = '$PhysicalNames\n4\n1 3 "joint:J"\n1 4 "boundary:b"\n2 1 "rock:a"\n2 2 "rock:b"\n$EndPhysicalNames\n'
    nodes = "".join(f"{k + 1} {k % 3} {k // 3} 0 0 {k + 1}\n" for k in range(6))
    elements = "1 1 2 3 1 2 5\n2 1 2 4 1 1 2\n3 1 2 4 1 2 3\n4 3 2 1 1 1 2 5 4\n5 3 2 2 1 2 3 6 5\n"
    (tmp_path / "a.msh").write_text(
        f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{names}$ParametricNodes\n6\n{nodes}$EndParametricNodes\n"
        f"$Elements\n5\n{elements}$EndElements\n"
    )
    assert read_mesh(tmp_path / "a.msh")[1].groups == {"rock:a": 1, "rock:b": 1, "joint:J": 2, "boundary:b": 2}


def test_bulk_data_without_its_first_line(written: Path, tmp_path: Path) -> None:
    """What Gmsh writes is read as with the line that it leaves out: the same elements by the same numbers."""
    groups = {"nastran:ref=1": "rock:a", "nastran:ref=2": "rock:b"}
    data = (written / "mesh.bdf").read_text()
    assert "BEGIN BULK" not in data
    (tmp_path / "whole.bdf").write_text(f"SOL 101\nCEND\nBEGIN BULK\n{data}")
    found, whole = (read_mesh(path, groups=groups)[1] for path in (written / "mesh.bdf", tmp_path / "whole.bdf"))
    assert found.groups == whole.groups == {"rock:a": 8, "rock:b": 8}


def test_nodes_in_other_coordinate_systems_of_nastran_are_refused(tmp_path: Path) -> None:
    grid = "".join(
        f"GRID    {k}       {k // 3}       {x}.0     {y}.0     0.0\n" for k, x, y in ((1, 0, 0), (2, 1, 0), (3, 1, 1))
    )
    (tmp_path / "a.bdf").write_text(f"{grid}CTRIA3  1       7       1       2       3\nENDDATA\n")
    with pytest.raises(ModelError, match=r"a.bdf: 1 node in a coordinate system other than the basic one .* such as 1"):
        read_mesh(tmp_path / "a.bdf", groups={"*": "rock:a"})


@pytest.mark.parametrize("name", ["all.msh", "all_parametric.msh"])
def test_msh_2_with_all_elements_has_lost_its_groups(written: Path, name: str) -> None:
    """Mesh.SaveAll leaves the groups out of MSH 2: that is said; values of the geometry may be mapped."""
    with pytest.raises(ModelError) as caught:
        read_mesh(written / name)
    assert "no element is in one of the groups of the file ('joint:J1', 'boundary:top', 'rock:gneiss'" in str(
        caught.value
    )
    assert "save it without Mesh.SaveAll, or as MSH 4.1" in str(caught.value)
    mapped = {"gmsh:geometrical=1": "rock:gneiss", "gmsh:geometrical=2": "rock:schist"}
    _, report = read_mesh(written / name, groups=mapped)
    assert report.groups == {"rock:gneiss": 8, "rock:schist": 8}
    assert any("Mesh.SaveAll" in note.text for note in report.notes if note.kind is NoteKind.EMPTY_GROUP)


@pytest.mark.parametrize("number", [2435, 2452, 2467, 2477])
def test_groups_of_universal_files_of_other_programs(tmp_path: Path, number: int) -> None:
    """Salome writes groups as data set 2467, and numbers them as its properties, of lines and of faces alike."""
    nodes = "".join(f"{k + 1:10}{1:10}{1:10}{11:10}\n{k % 3:25.16e}{k // 3:25.16e}{0:25.16e}\n" for k in range(6))
    lines = [(1, 2, 5), (2, 1, 2)]
    quads = [(3, 1, 2, 5, 4), (4, 2, 3, 6, 5)]
    row = "".join
    elements = row(f"{k:10}{11:10}{1:10}{1:10}{7:10}{2:10}\n{0:10}{1:10}{1:10}\n{a:10}{b:10}\n" for k, a, b in lines)
    elements += row(
        f"{k:10}{44:10}{1:10}{1:10}{7:10}{4:10}\n" + row(f"{node:10}" for node in corners) + "\n"
        for k, *corners in quads
    )
    groups = {"joint:J": (1, 1), "boundary:b": (2, 2), "rock:a": (1, 3), "rock:b": (2, 4)}
    members = row(
        f"{n:10}" + f"{0:10}" * 6 + f"{1:10}\n{name}\n{8:10}{element:10}{0:10}{0:10}\n"
        for name, (n, element) in groups.items()
    )
    text = row(
        f"    -1\n{dataset:6}\n{rows}    -1\n" for dataset, rows in ((2411, nodes), (2412, elements), (number, members))
    )
    (tmp_path / "a.unv").write_text(text.replace("e+", "D+"))
    _, report = read_mesh(tmp_path / "a.unv")
    assert report.groups == {"rock:a": 1, "rock:b": 1, "joint:J": 2, "boundary:b": 1}
    assert report.notes == ()


@pytest.mark.parametrize("name", ["one.msh", "parametric.msh", "parametric_binary.msh", "of_2018.msh", "mesh.cgns"])
def test_files_that_are_cut_off_are_refused(written: Path, tmp_path: Path, name: str) -> None:
    data = (written / name).read_bytes()
    for share in (0.3, 0.6, 0.75, 0.9, 0.98):
        (tmp_path / name).write_bytes(data[: int(share * len(data))])
        with pytest.raises(ModelError):
            read_mesh(tmp_path / name, groups={"*": "rock:a"})


@pytest.mark.parametrize(
    ("name", "text"), [("a.node", "# 2D\n3 2 0 0\n1 0 0\n2 1 0\n3 1 1\n"), ("a.ele", "1 3 0\n1 1 2 3\n")]
)
def test_meshes_of_triangle_are_called_so(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(ModelError, match=r"a plane mesh of Triangle: .* meshio reads TetGen's meshes in space alone"):
        read_mesh(tmp_path / name, groups={"*": "rock:a"})
