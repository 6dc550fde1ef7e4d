"""Separate stones in OBJ and STL: written, read as convex blocks, run from a model file, refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters.three_d import read_stones, write_surfaces
from bsm_mesh.converters.three_d.surface_files import RECORD
from bsm_mesh.geometries import three_d
from bsm_mesh.solve.limit_analysis import strength_limit
from bsm_mesh.three_d.blocks.polygons import vector_areas
from tests.scenes.polyhedra import box, on_incline, rotation, turned
from tests.scenes.rock_3d import planes
from tests.scenes.small_case import Case

TETRAHEDRON = """# of other programs: textures, normals, numbers from the end
o stone
v 0 0 0
v 2 0 0
v 0 2 0
v 0 0 2
vn 0 0 1
f 1/1/1 3/1/1 2/1/1
f -4//1 -3//1 -1//1
g side
usemtl marble
f 1 4 3
f 2 3 4
"""


def cuts() -> bsm.Polyhedra:
    """Return a box that three joint sets cut."""
    low, high = (0, 0, 0), (4, 4, 3)
    return bsm.Polyhedra.from_cells(
        three_d.cut_cells(three_d.RockMass(box=(low, high), joints=planes(low, high, 1.2, 3)))
    )


def binary(text: str) -> bytes:
    """Return the binary form of an STL text."""
    lines = [line.split() for line in text.splitlines()]
    corners = np.array([[float(word) for word in words[1:]] for words in lines if words[:1] == ["vertex"]])
    records = np.zeros(len(corners) // 3, RECORD)
    records["corners"] = corners.reshape(-1, 3, 3)
    return b"solid, and yet binary".ljust(80) + len(records).to_bytes(4, "little") + records.tobytes()


@pytest.mark.parametrize("name", ["rock.obj", pytest.param("rock.stl", marks=pytest.mark.heavy)])
def test_blocks_come_back_as_they_were_written(tmp_path: Path, name: str) -> None:
    blocks = cuts()
    again = read_stones(write_surfaces(tmp_path / name, blocks), rock="rock")
    assert again.count == blocks.count > 50
    assert_allclose(again.moments.volume, blocks.moments.volume, rtol=1e-8)
    assert_allclose(again.moments.centroid, blocks.moments.centroid, atol=1e-9)
    floor = again.boundaries["bottom"]
    assert_allclose(again.face_blocks[floor, 1], -1)
    area = np.linalg.norm(vector_areas(again.vertices[again.face_vertices], again.face_offsets)[floor], axis=1)
    assert area.sum() == pytest.approx(16)


def test_moved_blocks_are_written_where_they_are(tmp_path: Path) -> None:
    blocks = bsm.Polyhedra.from_solids([box((0, 0, 0), (1, 1, 1))], rock="rock")
    moved = write_surfaces(tmp_path / "moved.obj", blocks, movement=np.array([[1.0, 2.0, 3.0, 0, 0, np.pi / 4]]))
    again = read_stones(moved, rock="rock", unit_scale=1e-3)
    assert_allclose(again.moments.centroid, [[1.5e-3, 2.5e-3, 3.5e-3]])
    assert_allclose(np.ptp(again.vertices, axis=0), np.array([np.sqrt(2), np.sqrt(2), 1]) * 1e-3)


def test_a_file_of_another_program(tmp_path: Path) -> None:
    (tmp_path / "stone.obj").write_text(TETRAHEDRON, encoding="utf-8")
    blocks = read_stones(tmp_path / "stone.obj", rock="marble")
    assert_allclose(blocks.moments.volume, [8 / 6])
    assert_allclose(blocks.moments.centroid, [[0.5, 0.5, 0.5]])


def test_corners_on_straight_edges_are_none(tmp_path: Path) -> None:
    """A turned cube with the middle of an edge, rounded outwards, as a corner of both its faces."""
    corners, faces = box((0, 0, 0), (1, 1, 1))
    split = [
        [c for a, b in zip(f, [*f[1:], f[0]], strict=True) for c in ((a, 8) if {a, b} == {0, 1} else (a,))]
        for f in faces
    ]
    lines = [f"v {x} {y} {z}" for x, y, z in ([*corners.tolist(), [0.5, -1e-8, -1e-8]] @ rotation(25, 40).T).tolist()]
    lines += [f"f {' '.join(str(corner + 1) for corner in face)}" for face in split]
    (tmp_path / "cube.obj").write_text("\n".join(lines), encoding="utf-8")
    blocks = read_stones(tmp_path / "cube.obj", rock="rock")
    assert np.diff(blocks.face_offsets).tolist() == [4] * 6
    assert_allclose(blocks.moments.volume, [1.0])


@pytest.mark.parametrize("form", ["text", "binary"])
def test_a_cube_of_triangles_slides_on_its_whole_face(tmp_path: Path, form: str) -> None:
    """The two triangles of each side are one face again: tan(35) / tan(30) by limit analysis."""
    model = on_incline(30, 20, friction=35)
    path = write_surfaces(tmp_path / "cube.stl", model.blocks)
    if form == "binary":
        path.write_bytes(binary(path.read_text(encoding="utf-8")))
    blocks = read_stones(path, rock="granite", joint="J1", merge_tolerance=1e-5)
    assert blocks.contact_polygons.count == 1
    assert_allclose(blocks.contact_polygons.area, [1.0], rtol=1e-6)
    factor = strength_limit(model.replace(blocks=blocks)).factor
    assert_allclose(factor, np.tan(np.radians(35)) / np.tan(np.radians(30)), rtol=1e-4)


MODEL = """
dimensions = 3

[mesh]
file = "stones.obj"
default_joint = "J1"

[rock.granite]
unit_weight = "26 kN/m^3"

[joint.J1]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 35

[[support]]
boundary = "bottom"
fix = "all"
"""


def test_a_model_file_names_stones(case: Case) -> None:
    """A cube on a table that is larger: 0.026 MN go through it to the floor."""
    blocks = bsm.Polyhedra.from_solids([box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1))], rock="granite")
    write_surfaces("stones.obj", blocks)
    case.write("stones.toml", MODEL)
    outcome = case.run("run", "stones.toml")
    assert outcome.code == 0
    said = " ".join(outcome.out.split())
    assert "verdict stable" in said
    assert "reactions (x, y, z) 0 N, 0 N, 260 kN" in said
    case.write("stones.toml", MODEL.replace('default_joint = "J1"', "") + '[groups]\n"a" = "joint:J1"\n')
    case.refuses("run", "stones.toml", says=["[groups] are of a mesh of volumes", "default_joint must name the joint"])


def test_check_counts_stones_that_touch_on_parts_of_faces(case: Case) -> None:
    """A block on two others shares no face with them: it was reported as unsupported, and the run held it."""
    stones = [
        box((0, 0, 0), (4, 2, 1)),
        box((0, 0, 1), (1, 2, 2)),
        box((3, 0, 1), (4, 2, 2)),
        box((0, 0, 2), (4, 2, 3)),
    ]
    write_surfaces("stones.obj", bsm.Polyhedra.from_solids(stones, rock="granite"))
    case.write("stones.toml", MODEL)
    told = json.loads(case.run("check", "stones.toml", "--json").out)
    assert (told["contact_polygons"], told["touching_pairs"], told["parts"]) == (0, 4, 1)
    assert (told["without_contact"], told["unsupported"], told["notes"]) == ([], [], [])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TETRAHEDRON.replace("f 2 3 4\n", ""), "stone 0 is open: 3 of its edges have one face; close it"),
        (TETRAHEDRON.replace("v 0 0 2", "v 1 1 0"), "stone 0 has no volume; leave it out"),
        (TETRAHEDRON.replace("f 2 3 4", "f 2 4 3"), "stone 0 is not convex, or its faces turn different ways"),
        (TETRAHEDRON.replace("f 2 3 4", "f 2 3 5"), "line 13: 'f 2 3 5' is no face"),
        (TETRAHEDRON.replace("v 0 0 2", "v 0 0 x"), "line 6: 'v 0 0 x' is no point"),
        (TETRAHEDRON.replace("v 0 0 2", "v 0 0 nan"), "has a coordinate that is no number"),
        ("v 0 0 0\n", "has no faces"),
    ],
)
def test_what_is_no_stone_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "stone.obj").write_text(text, encoding="utf-8")
    with pytest.raises(bsm.ModelError, match=said):
        read_stones(tmp_path / "stone.obj", rock="marble")


def test_other_files_are_refused(tmp_path: Path) -> None:
    blocks = bsm.Polyhedra.from_solids(turned([box((0, 0, 0), (1, 1, 1))], np.eye(3)), rock="rock")
    with pytest.raises(bsm.ModelError, match=r"give a name that ends in .obj or .stl"):
        write_surfaces(tmp_path / "cube.ply", blocks)
    (tmp_path / "cube.ply").write_text("ply", encoding="utf-8")
    with pytest.raises(bsm.ModelError, match="surfaces are read from OBJ and STL"):
        read_stones(tmp_path / "cube.ply", rock="rock")
    with pytest.raises(bsm.ModelError, match="there is no such file"):
        read_stones(tmp_path / "none.stl", rock="rock")
