"""Whatever a model file names and is nowhere in the mesh is an error, in every command; with allow_unused a note."""

from __future__ import annotations

import json

import pytest

import bsm_mesh as bsm
from tests.scenes.small_case import Case
from tests.scenes.square_mesh import CURVES, NODES, msh

JOINT = 'normal_stiffness = "5 GPa/m"\nshear_stiffness = "1 GPa/m"\nfriction = 35\n'
BOLT = '[[bolt]]\nname = "short"\nstart = [0.3, 0.3]\nend = [0.6, 0.6]\ndiameter = "25 mm"\n'
ROCK = '[rock.clay]\nunit_weight = "20 kN/m^3"\nyoung = "1 GPa"\npoisson = 0.3\n'
UNUSED = {  # added to the model file, and the description of it
    "rock": (ROCK, ["rock 'clay' is used by no block"]),
    "joint": (
        f"[joint.J2]\n{JOINT}",
        ["joint 'J2' is used by no face", "J1", "curve groups that are not used"],
    ),
    "line off the rock": (f"[joint.J2]\nalong = [[0, 7], [2, 7]]\n{JOINT}", ["joint 'J2' is used by no face"]),
    "line of another joint": (
        f"[joint.J2]\nalong = [[0, 1], [2, 1]]\n{JOINT}",
        ["2 of 2 m of the lines of 'joint:J2'", "(near (0.5, 1)", "joint 'J2' is used by no face"],
    ),
    "border": (f'[joint.J2]\nbetween = "rocks"\n{JOINT}', ["joint 'J2' lies nowhere: there is no edge between two"]),
    "traces": (
        f'[joint.J2]\nalong = {{ file = "t.csv", set = "b" }}\n{JOINT}',
        ["[joint.J2] along", "no set 'b'", "a"],
    ),
    "boundary": ("[boundary.base]\nbelow = -3\n", ["boundary 'base': below = -3: no edge of the rim lies there"]),
    "support": ('[[support]]\nboundary = "basis"\nfix = "all"\n', ["there is no boundary 'basis'"]),
    "water": ("[water]\ntable = [[0, -1]]\n", ["water: the table lies below all blocks", "y = 0 m"]),
    "water of a stage": (
        '[[stage]]\nname = "wet"\nwater = { table = [[0, -1], [2, -0.5]] }\n',
        ["stage 'wet': water: the table lies below all blocks"],
    ),
    "excavation": (
        '[[stage]]\nname = "dig"\nexcavate = ["2"]\n',
        ["stage 'dig': excavate: there is no excavation '2'"],
    ),
    "bolts": (BOLT, ["[[bolt]] number 1: 1 bolt lies in a single block and carries nothing (bolt 1 'short'"]),
    "bolt curve": ('[[bolt]]\ncurve = "B2"\ndiameter = 0.02\n', ["the mesh has no curve 'bolt:B2'", "B1"]),
    "excavation of a group": (
        '[groups]\n"dug" = "excavation:1"\n"*" = "rock:gneiss"\n',
        ["excavation '1' (4 blocks) is left"],
    ),
    "bolts of a group": ('[groups]\n"curve" = "bolt:C"\n', ["the bolt curve 'C' is not used"]),
    "boundary of a group": (
        '[groups]\n"far" = "boundary:side"\n',
        ["[groups] 'far' = 'boundary:side': no block and no"],
    ),
    "history": ('[[history]]\nname = "h"\njoint = "J3"\n', ["history 'h': there is no joint 'J3'"]),
    "strength": ('[[stage]]\nname = "a"\n[stage.strength]\nJ3 = 0.5\n', ["there is no joint 'J3'"]),
}
NEVER = {"traces", "boundary", "support", "excavation", "bolt curve", "history", "strength"}  # a slip in any case


@pytest.fixture
def mesh(case: Case) -> Case:
    """Return the four squares, with curves of bolts, one of another name and one outside."""
    curves = {"bolt:B1": [(9, 10)], "curve": [(9, 10)], "far": [(11, 12)]}
    nodes = [*NODES, (0.5, 0.5), (0.5, 1.5), (5, 5), (6, 5)]
    case.write("mesh.msh", msh(nodes=nodes, curves={**CURVES, **curves}))
    case.write("t.csv", "x,y,trace,set\n0,0.5,1,a\n2,0.5,1,a\n")
    return case


@pytest.mark.parametrize("name", UNUSED)
def test_what_ends_on_nothing_is_refused_by_check_and_run_alike(mesh: Case, name: str) -> None:
    text, words = UNUSED[name]
    if name == "excavation of a group":
        mesh.write("mesh.msh", msh(surface="dug"))
    mesh.write("model.toml", (mesh.folder / "model.toml").read_text() + text)
    cure = [] if name in NEVER else ["model.toml: ", "[mesh] allow_unused = true"]
    told = [mesh.refuses(command, "model.toml", says=[*words, *cure]) for command in ("check", "run")]
    faults = [[line for line in text.splitlines() if not line.startswith("[")] for text in told]
    assert faults[0] == faults[1]


@pytest.mark.parametrize("name", sorted({*UNUSED} - NEVER))
def test_what_is_allowed_is_noted(mesh: Case, name: str) -> None:
    text, words = UNUSED[name]
    if name == "excavation of a group":
        mesh.write("mesh.msh", msh(surface="dug"))
    mesh.change('"mesh.msh"', '"mesh.msh"\nallow_unused = true')
    mesh.write("model.toml", (mesh.folder / "model.toml").read_text() + text)
    notes = "\n".join(json.loads(mesh.run("check", "model.toml", "--json").out)["notes"])
    assert all(word in notes for word in words)


def test_water_that_a_stage_lowers_below_the_model_has_acted_before(mesh: Case) -> None:
    drained = '[water]\ntable = [[0, 1]]\n[[stage]]\nname = "dry"\nwater = { table = [[0, -1]] }\n'
    mesh.write("model.toml", (mesh.folder / "model.toml").read_text() + drained)
    assert mesh.run("check", "model.toml").code == 0


def test_a_table_is_wet_between_corners() -> None:
    """A crest of the water table within an edge is over its corners' level."""
    blocks = bsm.Blocks.from_polygons([[(0, 0), (2, 0), (2, 1), (0, 1)]], rock="rock")
    model = bsm.Model(blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=26e3)])
    from bsm_mesh.model.unused import is_wet

    assert is_wet(model.blocks, bsm.Water(table=[(0, -1), (1, 0.2), (2, -1)]))
    assert not is_wet(model.blocks, bsm.Water(table=[(0, -1), (1, -0.2), (2, -1)]))


def test_a_model_in_python_with_unused_parts_is_written_so_that_it_runs_again(case: Case) -> None:
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1), (1, 1), (1, 2), (0, 2)]], rock="r")
    joints = [bsm.Joint(name, 5e9, 1e9, law=bsm.Patton(friction=30)) for name in ("J", "K")]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=26e3)],
        joints=joints,
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
    )
    bsm.run(model).save("out")
    again = case.run("run", "out/model.toml", "-o", "again")
    assert again.code == 0
    assert "joint 'K' is used by no face" in again.out + again.err


def test_a_curve_that_the_mesh_does_not_follow_is_lost(mesh: Case) -> None:
    """A joint drawn over a mesh whose elements do not have its edges: one half would be there, one not."""
    mesh.write("mesh.msh", msh(curves={**CURVES, "joint:J1": [(3, 4), (4, 8)]}))
    words = ["1.41 of 2.41 m of 'joint:J1' run through blocks and divide none", "(near (1.5, 1.5))"]
    for command in ("check", "run"):
        mesh.refuses(command, "model.toml", says=words)
    mesh.change('"mesh.msh"', '"mesh.msh"\nallow_unused = true')
    assert words[0] in mesh.run("run", "model.toml").err


DEAD = f"""
[joint.J2]
along = [[-1, 0.5], [2, 0.5]]
{JOINT}
[joint.J3]
along = [[0.5, 0.2], [0.5, 0.8]]
{JOINT}
"""


def test_dead_ends_of_lines_in_regions_are_lost(mesh: Case) -> None:
    """A rigid block has no crack in it: what bounds no two blocks is reported where it is more than a hundredth."""
    mesh.change('"mesh.msh"', '"mesh.msh"\nblocks = "regions"')
    mesh.write("model.toml", (mesh.folder / "model.toml").read_text() + DEAD)
    mesh.refuses("run", "model.toml", says=["'joint:J3'", "0.6 m", "joint 'J3' is used by no face"])
