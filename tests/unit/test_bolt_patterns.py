"""Patterns of bolts, in Python and in model files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.bolt_patterns import bolts_from_table, bolts_on_curves, radial_bolts, row_of_bolts
from tests.scenes.models import framed
from tests.scenes.shapes import grid, rectangle, turned
from tests.scenes.small_case import MODEL, Case, check_refusal
from tests.scenes.square_mesh import CURVES, NODES, msh

KEYS = {"diameter": 0.025, "pretension": 5e4, "name": "crown"}


def ends(bolts):
    return np.array([(bolt.start, bolt.end) for bolt in bolts])


def test_radial():
    bolts = radial_bolts(centre=(1, 2), radius=3, length=2, count=5, first=30, last=150, **KEYS)
    angles = np.radians([30, 60, 90, 120, 150])
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    assert_allclose(ends(bolts)[:, 0], (1, 2) + 3 * directions)
    assert_allclose(ends(bolts)[:, 1], (1, 2) + 5 * directions)
    assert [bolt.name for bolt in bolts] == [f"crown {k}" for k in range(1, 6)]
    assert all(bolt.pretension == 5e4 for bolt in bolts)


def test_radial_all_round_has_no_bolt_twice():
    bolts = radial_bolts(centre=(0, 0), radius=1, length=1, count=8, first=0, last=360, diameter=0.02)
    assert len(np.unique(ends(bolts).round(9), axis=0)) == 8


@pytest.mark.parametrize("angle", [0.0, 25.0])
def test_row_normal_to_the_boundary(angle):
    blocks = framed(bsm.Blocks.from_polygons(grid(4, 3), rock="any"), 4, 3)
    blocks = bsm.Blocks(
        **{n: getattr(blocks, n) for n in ("offsets", "nodes", "rock", "rock_names", "edge_joint", "boundaries")},
        vertices=turned(blocks.vertices, angle),
    )
    found = ends(row_of_bolts(blocks, boundary="top", length=1.2, interval=1.5, **KEYS))
    expected = np.array([((x, 3), (x, 1.8)) for x in (3.25, 1.75, 0.25)])  # the rock is to the left: from the right
    assert_allclose(found, turned(expected.reshape(-1, 2), angle).reshape(-1, 2, 2), atol=1e-12)


def test_row_with_offset_and_direction():
    blocks = framed(bsm.Blocks.from_polygons(grid(4, 3), rock="any"), 4, 3)
    found = row_of_bolts(blocks, boundary="left", length=2, interval=1, offset=0.5, direction=30, diameter=0.02)
    assert_allclose(ends(found)[:, 0], [(0, 2.5), (0, 1.5), (0, 0.5)])
    assert_allclose(ends(found)[:, 1] - ends(found)[:, 0], np.tile((np.sqrt(3), 1), (3, 1)))


def opening(excavated):
    """Return a ring of eight squares round a ninth, whose outline is the boundary ``wall`` from both sides."""
    blocks = bsm.Blocks.from_polygons(grid(3, 3), rock="any")
    names = ("vertices", "offsets", "nodes", "rock", "rock_names", "edge_joint")
    x, y = blocks.vertices.T
    inside = (np.abs(x - 1.5) < 0.6) & (np.abs(y - 1.5) < 0.6)
    edges = np.flatnonzero(inside & inside[blocks.following])
    return bsm.Blocks(
        **{n: getattr(blocks, n) for n in names},
        boundaries={"wall": edges},
        excavations={"1": [4]} if excavated else {},
    )


def test_row_round_an_opening_to_come():
    ring = [0, 1, 2, 3, 5, 6, 7, 8]
    both = replace(opening(True), excavations={"1": [4], "2": ring})
    found = ends(row_of_bolts(opening(True), boundary="wall", length=0.5, interval=1.0, diameter=0.02))
    middle = found.mean(axis=1)
    assert len(found) == 4
    assert_allclose(np.hypot(*(found[:, 0] - 1.5).T), 0.5)
    assert_allclose(np.hypot(*(middle - 1.5).T), 0.75)
    with pytest.raises(bsm.ModelError, match=r"no boundary 'face'.*name the face of an excavation by its line"):
        row_of_bolts(opening(True), boundary="face", length=0.5, interval=1.0, diameter=0.02)
    for excavated, fault in ((opening(False), "rock on both sides, and neither"), (both, "excavations take the rock")):
        with pytest.raises(bsm.ModelError, match=fault):
            row_of_bolts(excavated, boundary="wall", length=0.5, interval=1.0, diameter=0.02)


def test_row_on_a_face_that_a_later_stage_takes_away():
    """Two benches of one column each beside the rock that stays: the first stage lays the second bench bare."""
    blocks = bsm.Blocks.from_polygons(grid(3, 4), rock="any")
    x, y = blocks.vertices.T
    face = [np.flatnonzero((np.abs(x - 1) < 1e-9) & (y > low) & (y[blocks.following] > low)) for low in (0.9, 1.9)]
    face = [edges[np.abs(x[blocks.following[edges]] - 1) < 1e-9] for edges in face]
    regions = {"first": np.array([6, 9]), "second": np.array([1, 4, 7, 10])}
    blocks = replace(blocks, boundaries={"face": face[0], "high": face[1]}, excavations=regions)
    stages = [bsm.Stage("one", excavate=["first"]), bsm.Stage("two", excavate=["second"])]
    row = {"length": 1.5, "interval": 1, "diameter": 0.02, "stages": stages}
    found = row_of_bolts(blocks, boundary="face", stage="one", **row)
    assert_allclose(ends(found), [((1, y), (2.5, y)) for y in (3.5, 2.5)])  # below y = 2 nothing is bare yet
    with pytest.raises(bsm.ModelError, match="give the bolts the stage that lays the face bare"):
        row_of_bolts(blocks, boundary="high", **row)


def test_curves():
    pieces = np.array([((0, 0), (1, 0)), ((5, 5), (5, 4)), ((1, 0), (2, 0)), ((5, 4), (5, 3))], dtype=float)
    bolts = bolts_on_curves(pieces, diameter=0.02, name="B")
    assert_allclose(ends(bolts), [((0, 0), (2, 0)), ((5, 5), (5, 3))])
    assert [bolt.name for bolt in bolts] == ["B 1", "B 2"]


@pytest.mark.parametrize(
    ("pieces", "words"),
    [
        ([((0, 0), (1, 0)), ((1, 0), (1, 1))], "bends"),
        ([((0, 0), (1, 0)), ((1, 0), (2, 0)), ((1, 0), (1, 1))], "no open line"),
        ([((0, 0), (1, 0)), ((1, 0), (1, 1)), ((1, 1), (0, 0))], "no open line"),
    ],
)
def test_curves_that_are_no_bolts(pieces, words):
    with pytest.raises(bsm.ModelError, match=words):
        bolts_on_curves(np.array(pieces, dtype=float), diameter=0.02)


def test_table(tmp_path):
    file = tmp_path / "bolts.csv"
    file.write_text("start_x,start_y,end_x,end_y,pretension,name,kind\n0,0,0,3,,A,\n1, 0, 1, 4, 2e4, B, end_anchored\n")
    bolts = bolts_from_table(file, diameter=0.02, bond_strength=None)
    assert_allclose(ends(bolts), [((0, 0), (0, 3)), ((1, 0), (1, 4))])
    assert [(b.name, b.kind, b.pretension) for b in bolts] == [("A", "grouted", 0), ("B", "end_anchored", 2e4)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "start_x,start_y,end_x\n0,0,1\n",
            "needs the columns start_x, start_y, end_x, end_y; it has start_x, start_y, end_x",
        ),
        ("start_x,start_y,end_x,end_y\n", "has no rows; it needs a header"),
        ("start_x,start_y,end_x,end_y,pretensoin\n0,0,1,1,2\n", "did you mean 'pretension'"),
        ("start_x,start_y,end_x,end_y\n0,0,1,1\n0,0,x,1\n", "bolts.csv, line 3"),
        ("start_x,start_y,end_x,end_y\n0,0,1\n", "more or fewer cells"),
        ("start_x,start_y,end_x,end_y\n0,0,,1\n", "end_x must be given"),
        ("start_x,start_y,end_x,end_y\n0,0,0,0\n", "bolts.csv, line 2: bolt: start and end are the same point"),
    ],
)
def test_tables_that_are_wrong(tmp_path, text, words):
    file = tmp_path / "bolts.csv"
    file.write_text(text)
    with pytest.raises(bsm.ModelError) as caught:
        bolts_from_table(file, diameter=0.02)
    assert words in str(caught.value)


# --- in model files ---------------------------------------------------------------------------------------------

BOLTS = """
[[bolt]]
name = "single"
start = [0.3, 0.3]
end = [0.3, 1.8]
diameter = "25 mm"
yield_strength = "500 MPa"
bond_strength = "200 kN/m"
spacing = "1.5 m"

[[bolt]]
name = "row"
row = { boundary = "top", length = "1.4 m", interval = 0.7 }
diameter = 0.02
kind = "end_anchored"
pretension = "20 kN"

[[bolt]]
radial = { centre = [0.9, 1.1], radius = 0.2, length = 0.5, count = 3, first = -20, last = 160 }
diameter = 0.02

[[bolt]]
curve = "B1"
diameter = 0.02

[[bolt]]
table = "bolts.csv"
diameter = 0.02
"""


def bolted_case(case: Case, bolts: str) -> None:
    nodes = [*NODES, (0.5, 0.5), (0.5, 1.5)]
    case.write("mesh.msh", msh(nodes=nodes, curves={**CURVES, "bolt:B1": [(9, 10)]}))
    case.write("model.toml", MODEL + bolts)
    case.write("bolts.csv", "start_x,start_y,end_x,end_y,diameter\n1.2,1.9,1.3,0.2,22 mm\n")


def test_model_file_builds_the_same_bolts(case: Case) -> None:
    bolted_case(case, BOLTS)
    model = bsm.load("model.toml")
    blocks = model.blocks
    expected = [
        bsm.Bolt(
            start=(0.3, 0.3),
            end=(0.3, 1.8),
            name="single",
            diameter=0.025,
            yield_strength=500e6,
            bond_strength=200e3,
            spacing=1.5,
        ),
        *row_of_bolts(
            blocks,
            boundary="top",
            length=1.4,
            interval=0.7,
            diameter=0.02,
            kind="end_anchored",
            pretension=2e4,
            name="row",
        ),
        *radial_bolts(centre=(0.9, 1.1), radius=0.2, length=0.5, count=3, first=-20, last=160, diameter=0.02),
        bsm.Bolt(start=(0.5, 0.5), end=(0.5, 1.5), diameter=0.02, name="B1 1"),
        bsm.Bolt(start=(1.2, 1.9), end=(1.3, 0.2), diameter=0.022),
    ]
    assert model.bolts == tuple(expected)
    assert model == model.replace(bolts=expected)
    assert model != model.replace(bolts=expected[1:])


def test_run_writes_bolts_and_runs_again(case: Case) -> None:
    bolted_case(case, BOLTS)
    assert case.run("run", "model.toml", "-o", "deep/out").code == 0
    assert (case.folder / "deep/out/bolts.pvd").exists()
    assert bsm.load("deep/out/model.toml") == bsm.load("model.toml")


WRONG = [
    ("diameter = 0.02\n", ["[[bolt]] number 1: say where", "given: none of them"]),
    ("start = [0, 0]\ndiameter = 0.02\n", ["say where", "given: start"]),
    ("start = [0.3, 0.3]\nend = [0.3, 1.8]\n", ["needs the key 'diameter'"]),
    ("start = [0.3, 0.3]\nend = [0.3, 1.8]\ndiamter = 0.02\n", ["did you mean 'diameter'"]),
    ('curve = "B2"\ndiameter = 0.02\n', ["no curve 'bolt:B2'", "did you mean 'B1'"]),
    ('row = { boundary = "roof", length = 1, interval = 1 }\ndiameter = 0.02\n', ["no boundary 'roof'"]),
    ('table = "none.csv"\ndiameter = 0.02\n', ["none.csv", "cannot be read"]),
    ("start = [0.3, 0.3]\nend = [0.3, 2.8]\ndiameter = 0.02\n", ["end in the void, 0.8 m"]),
    ("start = [1, 0.3]\nend = [1, 1.8]\ndiameter = 0.02\n", ["runs along an edge of block"]),
    (
        'start = [0.3, 0.3]\nend = [0.3, 1.8]\ndiameter = 0.02\npretension = "3 kPa"\n',
        ["pretension", "does not convert to N"],
    ),
    ('start = [0.3, 0.3]\nend = [0.3, 1.8]\ndiameter = 0.02\nstage = "crown"\n', ["there is no stage 'crown'"]),
]


@pytest.mark.parametrize(("text", "words"), WRONG)
def test_wrong_bolts_are_told(case: Case, text: str, words: list[str]) -> None:
    bolted_case(case, f"[[bolt]]\n{text}")
    check_refusal(case.run("run", "model.toml"), words)


def test_unused_curves_are_told(case: Case) -> None:
    bolted_case(case, "")
    with pytest.warns(bsm.MeshWarning, match="bolt curve 'B1' is not used"):
        bsm.load("model.toml")


def test_row_longer_than_its_boundary() -> None:
    blocks = framed(bsm.Blocks.from_polygons([rectangle(0, 0, 1, 1)], rock="any"), 1, 1)
    keys = {"boundary": "top", "length": 0.5, "diameter": 0.02}
    with pytest.raises(bsm.ModelError, match=r"'top': no bolt fits: the first head, 1\.5 m from .*smaller interval"):
        row_of_bolts(blocks, interval=3, **keys)
    with pytest.raises(bsm.ModelError, match=r"no bolt fits: the first head, 7 m from .*offset"):
        row_of_bolts(blocks, interval=0.1, offset=7, **keys)


def test_a_row_of_too_many_bolts() -> None:
    blocks = framed(bsm.Blocks.from_polygons([rectangle(0, 0, 20, 1)], rock="any"), 20, 1)
    with pytest.raises(bsm.ModelError, match=r"interval = 0\.001 m makes 20000 bolts on 20 m; at most 10000"):
        row_of_bolts(blocks, boundary="top", length=0.5, interval=1e-3, diameter=0.02)
