"""Joints and boundaries by place on a mesh without any: lines that cut it, borders, sides of the model."""

from __future__ import annotations

import json
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.converters import convert_mesh
from bsm_mesh.converters.meshes.marks import Marks, Place
from bsm_mesh.errors import ModelError
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolt_patterns import row_of_bolts
from bsm_mesh.model.overlap import find_overlaps
from tests.scenes.small_case import MODEL as SMALL
from tests.scenes.small_case import Case

X, Y = np.meshgrid(np.linspace(0, 10, 11), np.linspace(0, 5, 6))
NODE = np.arange(X.size).reshape(X.shape)
QUADS = np.stack([NODE[:-1, :-1], NODE[:-1, 1:], NODE[1:, 1:], NODE[1:, :-1]], axis=-1).reshape(-1, 4)
LOW = np.flatnonzero(Y[:-1, :-1].ravel() < 2)
HIGH = np.flatnonzero(Y[:-1, :-1].ravel() >= 2)
ROCKS = {"rock:a": [LOW], "rock:b": [HIGH]}
WEST = {"WEST": [np.flatnonzero(X[:-1, :-1].ravel() < 4)]}


def marked(marks: Marks, sets: Any = MappingProxyType({}), **options: Any) -> tuple[Blocks, Any]:
    points = np.column_stack([X.ravel(), Y.ravel()])
    return convert_mesh(points, [("quad", QUADS)], {**ROCKS, **sets}, marks=marks, **options)


def joint_edges(blocks: Blocks, name: str) -> np.ndarray:
    return np.flatnonzero(blocks.edge_joint == blocks.joint_names.index(name))


def length(blocks: Blocks, edges: np.ndarray) -> float:
    return float(np.hypot(*(blocks.vertices[blocks.following[edges]] - blocks.vertices[edges]).T).sum())


def test_boundaries_by_place() -> None:
    places = {
        "bottom": Place(below=0.01),
        "top": Place(above=5 - 1e-6),
        "left": Place(left_of=0),
        "right low": Place(right_of=10, below=2),
        "along": Place(along=np.array([(0, 5), (0, 0), (3, 0.001)])),
    }
    blocks, report = marked(Marks(boundaries=places))
    assert {name: len(edges) for name, edges in blocks.boundaries.items()} == {
        **{"bottom": 10, "top": 10, "left": 5, "right low": 2, "along": 8}
    }
    assert report.groups["boundary:bottom"] == 10
    assert (blocks.vertices[blocks.boundaries["bottom"], 1] == 0).all()


def test_a_line_along_the_face_of_an_excavation_takes_it_for_a_row_of_bolts() -> None:
    """Both sides of it; the bolts are in the rock that stays."""
    face = Place(along=np.array([(4, 0), (4, 5)]))
    blocks, report = marked(Marks(boundaries={"face": face}), {"excavation:west": WEST["WEST"]})
    assert len(blocks.boundaries["face"]) == 10
    assert any("usual for a face that a later stage excavates" in note.text for note in report.notes)
    bolts = row_of_bolts(blocks, boundary="face", length=2, interval=1, diameter=0.02)
    assert_allclose([bolt.start for bolt in bolts], [(4, y) for y in (4.5, 3.5, 2.5, 1.5, 0.5)])
    assert_allclose([bolt.end for bolt in bolts], [(6, y) for y in (4.5, 3.5, 2.5, 1.5, 0.5)])


FACED = """
from bsm_mesh.geometries import Excavation, JointSet, Region, RockMass, cut_blocks, rectangle, write_blocks


def build(path):
    rock = Region(outline=rectangle(0, 0, 2, 2), rock="gneiss")
    cut = Excavation(outline=rectangle(0, 0, 1, 2), name="cut")
    joints = [JointSet(name="J1", dip=0, spacing=1)]
    write_blocks(cut_blocks(RockMass(regions=[rock, cut], joints=joints)), path)
"""
FACE = '[boundary.face]\nalong = [[1, 0], [1, 2]]\n[[stage]]\nname = "dig"\nexcavate = ["cut"]\n'


@pytest.mark.parametrize("is_loaded", [False, True])
def test_rock_on_both_sides_of_a_face_is_noted_where_a_load_acts_on_it(case: Case, is_loaded: bool) -> None:
    case.write("faced.py", FACED)
    load = '[[load]]\nboundary = "face"\npressure = "1 kPa"\n' if is_loaded else ""
    case.write(
        "model.toml", SMALL.replace('file = "mesh.msh"', 'geometry = "faced.py"\nblocks = "regions"') + load + FACE
    )
    outcome = case.run("check", "model.toml")
    assert outcome.code == 0
    assert "mesh: boundary:face: 4 block edges" in outcome.out
    assert outcome.out.partition("\n")[0].endswith("blocks (blocks = 'regions')")
    assert ("has blocks on both sides" in outcome.out) == is_loaded


def test_edges_within_the_rock_along_a_line_are_named() -> None:
    line = np.array([(6, 5), (6, 0), (10, 0)])
    blocks, report = marked(Marks(boundaries={"toe": Place(along=line)}))
    assert len(blocks.boundaries["toe"]) == 4
    assert ["10 block edges along its line" in note.text for note in report.notes if "'toe'" in note.text] == [True]
    with pytest.raises(ModelError, match="no edge of the rim or of an excavation's face lies there"):
        marked(Marks(boundaries={"face": Place(along=line[:2])}))


def test_a_boundary_where_nothing_is_tells_how_far_the_model_goes() -> None:
    with pytest.raises(ModelError) as caught:
        marked(Marks(boundaries={"bottom": Place(below=-1), "side": Place(right_of=3, left_of=2)}))
    assert caught.value.faults == (
        "boundary 'bottom': below = -1: no edge of the rim lies there; the blocks lie from x = 0 to 10, y = 0 to 5 m",
        "boundary 'side': left_of = 2, right_of = 3: no edge of the rim lies there; the blocks lie from x = 0 to 10, "
        "y = 0 to 5 m",
    )


@pytest.mark.parametrize(
    ("border", "expected"), [(("a", "b"), 10.0), ("rocks", 10.0), (("WEST", "b"), 3.0 + 4.0), ("part", 5.0)]
)
def test_joints_on_borders(border: Any, expected: float) -> None:
    """Between two rocks, a group and a rock, or two values of an array: both sides of every edge."""
    part = {"part": [(X[:-1, :-1].ravel() < 6).astype(int)]}
    blocks, report = marked(Marks(borders={"c": border}), sets=WEST, cell_data=part)
    assert bool(report.notes) == (border != ("WEST", "b"))  # else WEST is not used
    if border == ("WEST", "b"):  # WEST holds elements of b: their common edges are on the border too
        assert length(blocks, joint_edges(blocks, "c")) > 2 * expected
    else:
        assert_allclose(length(blocks, joint_edges(blocks, "c")), 2 * expected)


def test_names_that_are_not_there_are_told_with_all_that_are() -> None:
    with pytest.raises(
        ModelError, match=r"joint 'c': between: 'schist' is no rock and no group .known: WEST, a, b, rock:a, rock:b"
    ):
        marked(Marks(borders={"c": ("a", "schist")}), sets=WEST)
    with pytest.raises(ModelError, match=r"between = 'parts' is no array of whole numbers"):
        marked(Marks(borders={"c": "parts"}))


def test_a_line_along_edges_cuts_nothing() -> None:
    line = np.array([(0, 3.01), (10, 2.99)])
    blocks, report = marked(Marks(lines={"f": [line]}))
    assert blocks.count == 50
    (note,) = report.notes
    assert note.text == "10 nodes near lines of joints moved onto them, by 0.01 m at most"
    edges = joint_edges(blocks, "f")
    assert_allclose(length(blocks, edges), 2 * np.hypot(*(line[1] - line[0])), rtol=1e-9)
    x, y = blocks.vertices[edges].T
    assert_allclose(y, 3.01 - 0.002 * x, rtol=1e-14)  # the line is straight, whatever the mesh
    assert_allclose(blocks.moments.area.sum(), 50, rtol=1e-14)


def test_nodes_that_carry_something_stay() -> None:
    """Near a corner of the rim, of a boundary or of the border of two rocks the line passes beside the node."""
    border = np.array([(0, 2.02), (10, 2.03)])  # along the border of the rocks
    corner = np.array([(-1, 1.02), (1.01, -1)])  # past the corner (0, 0)
    blocks, _ = marked(Marks(lines={"f": [border], "g": [corner]}))
    given, _ = marked(Marks())
    assert {*map(tuple, given.vertices[np.repeat(given.rock, 4) == 0])} <= {*map(tuple, blocks.vertices)}
    assert_allclose(np.bincount(blocks.rock, blocks.moments.area), [20, 30], rtol=1e-12)
    assert_allclose(length(blocks, joint_edges(blocks, "f")), 2 * np.hypot(10, 0.01), rtol=1e-9)
    on_x, on_y = 1.02 * 2.01 / 2.02 - 1, 1.02 - 2.02 / 2.01
    assert_allclose(length(blocks, joint_edges(blocks, "g")), 2 * np.hypot(on_x, on_y), rtol=1e-9)


def test_a_line_across_elements_cuts_them() -> None:
    """Its whole length inside the model is joint, on both sides; areas, rocks and edges stay; nothing overlaps."""
    line = np.array([(2.3, -1.0), (6.1, 7.0)])
    blocks, report = marked(Marks(lines={"f": [line]}, boundaries={"bottom": Place(below=0)}))
    inside = np.hypot(*(line[1] - line[0])) * 5 / 8
    edges = joint_edges(blocks, "f")
    assert_allclose(length(blocks, edges), 2 * inside, rtol=1e-9)
    assert_allclose(np.bincount(blocks.rock, blocks.moments.area), [20, 30])
    assert_allclose(length(blocks, blocks.boundaries["bottom"]), 10)
    assert not find_overlaps(blocks.vertices, blocks.offsets, blocks.nodes, blocks.edge_table).pairs.size
    (note,) = report.notes
    assert note.text == "3.32 of 8.86 m of the lines of 'joint:f' lie outside the rock"
    ends = blocks.vertices[edges]
    off = np.abs(np.cross(np.append(line[1] - line[0], 0), np.column_stack([ends - line[0], np.zeros(len(ends))])))
    assert off.max() < 1e-9


def test_lines_that_cross_make_regions() -> None:
    lines = {
        "f": [np.array([(2.3, -1), (6.1, 7)])],
        "g": [np.array([(-1, 4.4), (11, 0.7)]), np.array([(8, -1), (8, 6)])],
    }
    blocks, _ = marked(Marks(lines=lines), blocks="regions")
    assert_allclose(blocks.moments.area.sum(), 50)
    whole, _ = marked(Marks(lines={}), blocks="regions")
    assert whole.count == 2  # the two rocks
    assert blocks.count == 6 + 4  # six parts between the lines; the border of the rocks parts four of them
    assert set(blocks.joint_names) == {"f", "g"}


def test_a_line_that_ends_inside() -> None:
    """The joint ends at the line's end; the element is divided to its edge, without a joint beyond the end."""
    blocks, report = marked(Marks(lines={"f": [np.array([(-1, 2.5), (4.5, 2.5)])]}))
    assert_allclose(length(blocks, joint_edges(blocks, "f")), 2 * 4.5)
    assert blocks.count == 50 + 5
    tip = np.flatnonzero((blocks.vertices == (4.5, 2.5)).all(axis=1))
    beyond = tip[(blocks.vertices[blocks.following[tip]] == (5, 2.5)).all(axis=1)]
    assert blocks.edge_joint[beyond].tolist() == [-1]
    assert [note.text for note in report.notes] == ["1 of 5.5 m of the lines of 'joint:f' lie outside the rock"]


def test_a_line_inside_one_element_and_a_loop() -> None:
    """Both ends, and a closed line, are joined to the outline of the element without a joint."""
    line, loop = np.array([(3.3, 2.4), (3.6, 2.7)]), np.array([(6.3, 2.3), (6.7, 2.3), (6.5, 2.6), (6.3, 2.3)])
    blocks, _ = marked(Marks(lines={"f": [line], "g": [loop]}))
    assert_allclose(length(blocks, joint_edges(blocks, "f")), 2 * 0.3 * np.sqrt(2))
    assert_allclose(length(blocks, joint_edges(blocks, "g")), 2 * (0.4 + 2 * np.hypot(0.2, 0.3)))
    assert blocks.count == 48 + 2 + 3
    assert_allclose(blocks.moments.area.sum(), 50, rtol=1e-12)


def test_lines_on_each_other_count_once() -> None:
    """Traces that are digitised twice, to rounding, ask for no more joint than one."""
    one, other = np.array([(0.7, 0.4), (9.3, 4.1)]), np.array([(1.0, 0.4), (9.0, 4.1)])
    share = (other[:, :1] - 0.7) / 8.6
    other[:, 1] = 0.4 + 3.7 * share[:, 0] + (1e-15, -1e-14)
    blocks, report = marked(Marks(lines={"f": [one, other, one]}))
    assert_allclose(length(blocks, joint_edges(blocks, "f")), 2 * np.hypot(8.6, 3.7), rtol=1e-9)
    assert [note for note in report.notes if "carry another" in note.text] == []


def test_random_lines_keep_area_and_do_not_overlap() -> None:
    rng = np.random.default_rng(71)
    for _ in range(8):
        lines = [rng.uniform((-1, -1), (11, 6), (2, 2)) for _ in range(5)]
        blocks, _ = marked(Marks(lines={"f": lines}))
        assert_allclose(blocks.moments.area.sum(), 50, rtol=1e-9)
        assert blocks.moments.area.min() > 1e-6  # where three lines cross near one point
        assert not find_overlaps(blocks.vertices, blocks.offsets, blocks.nodes, blocks.edge_table).pairs.size


def test_curves_of_many_pieces_that_bend_on_edges_and_corners() -> None:
    """A sampled curve, some of whose points lie on edges of the mesh to rounding."""
    x = np.linspace(-1, 11, 49)
    curve = np.column_stack([x, 2.5 + 1.2 * np.sin(x / 2)])
    on_edges = np.column_stack([np.arange(-1, 12) + 1e-16, 3.3 + 0.1 * (-1.0) ** np.arange(13)])
    blocks, _ = marked(Marks(lines={"f": [curve], "g": [on_edges]}))
    assert_allclose(blocks.moments.area.sum(), 50, rtol=1e-9)
    edges = np.hypot(*(blocks.vertices[blocks.following] - blocks.vertices).T)
    assert edges.min() > 1e-9
    assert length(blocks, joint_edges(blocks, "f")) / 2 == pytest.approx(
        np.hypot(*np.diff(curve[4:-4], axis=0).T).sum(), rel=0.02
    )
    assert not find_overlaps(blocks.vertices, blocks.offsets, blocks.nodes, blocks.edge_table).pairs.size


MODEL = """
[mesh]
file = "quads.vtu"
blocks = "regions"
[groups]
"*" = "rock:a"
[rock.a]
unit_weight = "26 kN/m^3"
young = "10 GPa"
poisson = 0.25
[joint.fault]
along = "faults.geojson"
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 30
[joint.bed]
along = [[0, 2.5], [10, 2.5]]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 35
[boundary.base]
below = "1 cm"
[[support]]
boundary = "base"
fix = "all"
[solver]
scheme = "linear"
"""


@pytest.mark.heavy
def test_a_bare_mesh_in_a_model_file(case: Case) -> None:
    """Quadrilaterals without line elements or groups: everything else is in the model file, and runs again."""
    import meshio

    meshio.Mesh(np.column_stack([X.ravel(), Y.ravel(), 0 * X.ravel()]), [("quad", QUADS)]).write(
        case.folder / "quads.vtu"
    )
    line = {"type": "LineString", "coordinates": [[4.2, -1], [5.7, 6]]}
    feature = {"type": "Feature", "geometry": line, "properties": {"set": "F1"}}
    case.write("faults.geojson", json.dumps({"type": "FeatureCollection", "features": [feature]}))
    case.write("model.toml", MODEL)
    told = json.loads(case.run("run", "model.toml", "--json").out)
    assert {one["name"] for one in told["joints"]} == {"fault", "bed"}
    again = json.loads(case.run("run", "out/model/model.toml", "-o", "again", "--json").out)
    assert again["model_hash"] == told["model_hash"]
    case.write("model.toml", MODEL.replace("faults.geojson", "lost.geojson").replace('below = "1 cm"', ""))
    told = ["[joint.fault] along: ", "lost.geojson", "[boundary.base] needs one or more of below, above, left_of"]
    case.refuses("run", "model.toml", says=told)
    case.write("model.toml", MODEL.replace('below = "1 cm"', "beneath = 3"))
    case.refuses("check", "model.toml", says=["boundary.base", "beneath", "below"])
    case.write(
        "model.toml", MODEL.replace('file = "quads', 'file = "quads').replace('boundary = "base"', 'boundary = "basis"')
    )
    case.refuses("check", "model.toml", says=["there is no boundary 'basis'", "base"])
    case.write("model.toml", MODEL.replace('"*" = "rock:a"', '"SCHIST" = "rock:a"'))
    case.refuses("check", "model.toml", says=["no group 'SCHIST'", "there are none", '"*" = "rock:NAME" takes all'])
