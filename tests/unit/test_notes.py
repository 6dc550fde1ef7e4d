"""Notes: what is allowed but may be a slip."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.model.notes import notes_of
from bsm_mesh.text.result_text import tables_of
from tests.scenes.models import framed
from tests.scenes.shapes import grid
from tests.scenes.small_case import MODEL, Case

ROCK = bsm.Rock("rock", unit_weight=26e3)
LAW = bsm.MohrCoulomb(friction=30, cohesion=1e5, residual_cohesion=0)
JOINT = bsm.Joint("J", 1e9, 1e9, law=LAW, tensile_strength=1e4)
PLAIN = bsm.Model(
    blocks=framed(bsm.Blocks.from_polygons(grid(2, 2), rock="rock"), 2, 2),
    rocks=[ROCK],
    joints=[JOINT],
    default_joint="J",
    supports=[bsm.Fixed(boundary="bottom")],
)


def joint(**keys: object) -> bsm.Joint:
    return bsm.Joint("J", **{"normal_stiffness": 1e9, "shear_stiffness": 1e9, "law": bsm.Patton(friction=30), **keys})


def test_an_ordinary_model_has_none() -> None:
    assert notes_of(PLAIN) == []


def test_strength_is_small_beside_the_weight_of_blocks() -> None:
    """Of blocks of 2 cm, which weigh 10 N/m, and of weightless ones 50 Pa is not small."""
    law = bsm.MohrCoulomb(friction=30, cohesion=50.0, residual_cohesion=0)
    small = bsm.Blocks.from_polygons([0.02 * np.array(one) for one in grid(20, 10)], rock="rock")
    model = PLAIN.replace(blocks=framed(small, 0.4, 0.2), joints=[joint(law=law)])
    assert not any("cohesion" in note for note in notes_of(model))
    rock = bsm.Rock("rock", unit_weight=26e3, friction=30, tensile_strength=2.0)
    assert any(
        "rock 'rock': tensile_strength = 2 Pa carries less" in note for note in notes_of(PLAIN.replace(rocks=[rock]))
    )
    assert not any("cohesion =" in note for note in notes_of(model.replace(rocks=[bsm.Rock("rock", unit_weight=0)])))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"rocks": [ROCK, bsm.Rock("rcok", unit_weight=1)]}, "rock 'rcok' is used by no block; did you mean 'rock'?"),
        ({"joints": [JOINT, bsm.Joint("K", 1e9, 1e9)]}, "joint 'K' is used by no face (known: J)"),
        (
            {"rocks": [bsm.Rock("rock", unit_weight=26)]},
            "rock 'rock': unit_weight = 26 N/m^3 is unusual (5000 to 50000",
        ),
        ({"rocks": [bsm.Rock("rock", unit_weight=0)]}, "rock 'rock' has no weight: unit_weight = 0"),
        (
            {"joints": [joint(law=bsm.MohrCoulomb(friction=0.6))]},
            "joint 'J': friction = 0.6 degrees is less than that of any rock or clay. It is an angle in degrees: "
            "31 if 0.6 is its tangent, 34.4 if it is in radians",
        ),
        (
            {"rocks": [bsm.Rock("rock", unit_weight=25e3, friction=0.7)], "joints": [], "default_joint": None},
            "rock 'rock': friction = 0.7 degrees is less than that of any rock or clay",
        ),
        (
            {"joints": [joint(law=bsm.MohrCoulomb(friction=30, cohesion=50.0, residual_cohesion=0))]},
            "joint 'J': cohesion = 50 Pa carries less than 1 % of a block's weight on a side of the block; a number "
            'without its unit is in Pa: write "50 kPa" for kPa',
        ),
        (
            {"joints": [joint(law=bsm.MohrCoulomb(friction=30, cohesion=5e-3, residual_cohesion=0))]},
            "joint 'J': cohesion = 0.005 Pa carries less than 1 % of a block's weight on a side of the block; a number "
            "without its unit is in Pa: write MPa for megapascal, for mPa is 0.001 Pa",
        ),
        (
            {
                "bolts": [
                    bsm.Bolt(start=(0.5, 2), end=(0.5, 0.5), diameter=0.025, yield_strength=5e8, bond_strength=150.0)
                ]
            },
            "bolts: bond_strength = 150 N/m holds less than 1 % of a block's weight along a whole bolt; a number "
            'without its unit is in N/m: write "150 kN/m" for kN/m',
        ),
        ({"joints": [joint(law=bsm.Patton(friction=80))]}, "joint 'J': friction = 80 degrees is unusual (0 to 70"),
        (
            {"joints": [joint(law=bsm.MohrCoulomb(friction=30, cohesion=1e5))]},
            "joint 'J': it keeps its cohesion when it slips; if slip destroys the cohesion, give residual_cohesion = 0",
        ),
        ({"joints": [joint(normal_stiffness=1e3)]}, "joint 'J': normal_stiffness = 1000 Pa/m is unusual"),
        ({"rocks": [replace(ROCK, poisson=0.2)]}, "rock 'rock': poisson has no effect without young"),
        ({"joints": [joint(aperture=1e-4)]}, "joint 'J': aperture has no effect: [flow] is not given"),
        (
            {"rocks": [replace(ROCK, cohesion=1e5, residual_cohesion=0)]},
            "rock 'rock': its cohesion, friction and tensile_strength have no effect: faces without a joint of "
            "their own have default_joint = 'J'",
        ),
        (
            {
                "rocks": [replace(ROCK, young=1e9, poisson=0.2, cohesion=1e5, residual_cohesion=0, zones=bsm.Zones())],
                "default_joint": None,
                "joints": [],
            },
            "rock 'rock': its zones are elastic, and its strength limits only faces without a joint",
        ),
        (
            {"options": bsm.Options(sliding_stiffness=0.1)},
            "solver: sliding_stiffness has no effect with scheme = 'continuation'",
        ),
        (
            {"options": bsm.Options(scheme="linear", max_steps=3, falls=bsm.Falls(on_fall="remove"))},
            "solver: max_steps and falls have no effect with scheme = 'linear'",
        ),
        (
            {"joints": [joint(law=bsm.MohrCoulomb(friction=30, cohesion=5e8, residual_cohesion=0))]},
            "joint 'J': cohesion = 5e+08 Pa is unusual (0 to 2e6 Pa is usual): tests of joints give less than 1 MPa; "
            "kPa may be meant; check the number and its unit",
        ),
        (
            {"joints": [joint(law=bsm.MohrCoulomb(friction=30, cohesion=15e6, residual_cohesion=0))]},
            "joint 'J': cohesion = 1.5e+07 Pa is unusual (0 to 2e6 Pa is usual)",
        ),
        (
            {"joints": [joint(law=bsm.Patton(friction=30, dilation=10, cohesion=15e6))]},
            "joint 'J': cohesion = 1.5e+07 Pa is unusual (0 to 2e6 Pa is usual)",
        ),
        (
            {"joints": [joint(law=bsm.Patton(friction=30), tensile_strength=15e6)]},
            "joint 'J': tensile_strength = 1.5e+07 Pa is unusual (0 to 2e6 Pa is usual)",
        ),
        ({"joints": [joint(law=None)]}, "joint 'J' has no law (friction): it neither slips nor opens"),
        (
            {
                "joints": [
                    joint(law=bsm.MohrCoulomb(friction=45, cohesion=1e5, residual_cohesion=0), tensile_strength=1.1e5)
                ]
            },
            "tensile_strength = 110000 Pa is above cohesion / tan(friction) = 1e+05 Pa",
        ),
        ({"supports": [bsm.Fixed(blocks=range(4))]}, "every block is held by supports: nothing can move"),
        ({"gravity_direction": 90.0}, "gravity pulls upwards: its direction is 90 degrees (-90 is down)"),
        ({"gravity_direction": -1.5708}, "gravity pulls sideways: its direction is -1.5708 degrees (-90 is down)"),
        ({"water": bsm.Water(table=[(0, 1)], unit_weight=1e5)}, "water: unit_weight = 100000 N/m^3 is unusual"),
        ({"water": bsm.Water(table=[(0, 1000)])}, "water: the table lies 998 m above the top of the model (y = 2 m)"),
        (
            {"stages": [bsm.Stage(name="a", water=bsm.Water(table=[(0, 1000)]))]},
            "stage 'a': water: the table lies 998 m above",
        ),
        ({"stages": [bsm.Stage(name="a")]}, "stage 'a' changes nothing"),
        ({"gravity_horizontal": 0.9}, "gravity: horizontal = 0.9 is unusual (-0.5 to 0.5 is usual)"),
        ({"stages": [bsm.Stage(name="a", gravity=(0, -1))]}, "stage 'a': gravity: vertical = -1 is unusual"),
        (
            {"stages": [bsm.Stage(name="a", strength={"J": 80})]},
            "stage 'a': strength of 'J' = 80 is unusual (1e-6 to 1",
        ),
        (
            {"stages": [bsm.Stage(name="a", shaking=bsm.Shaking(record=([0, 1], [0, 1]), scale=50))]},
            "stage 'a': shaking: scale = 50 is unusual (-10 to 10 is usual)",
        ),
        (
            {"loads": [bsm.EarthPressure(boundary="left", surface=2.0, state="active", unit_weight=20, friction=30)]},
            "load 1 (EarthPressure): unit_weight = 20 N/m^3 is unusual (5000 to 50000 N/m^3 is usual)",
        ),
        (
            {"in_situ": bsm.InSitu(surface=1.4)},
            "2 blocks above the surface: without stress at the start; surface may be the line",
        ),
        (
            {"in_situ": bsm.InSitu(surface=900.0)},
            "surface lies 898 m above the top of the model on average, and nothing loads",
        ),
        ({"in_situ": bsm.InSitu(surface=2.0, k0=15)}, "in_situ: k0 = 15 is unusual (0 to 5 is usual)"),
        (
            {"bolts": [bsm.Bolt(start=(0.5, 1.8), end=(0.5, 0.2), diameter=0.4, yield_strength=500e6)]},
            "bolts: diameter = 0.4 m is unusual (0.005 to 0.1 m is usual)",
        ),
        (
            {"bolts": [bsm.Bolt(start=(0.5, 1.8), end=(0.5, 0.2), diameter=0.025)]},
            "1 bolt without yield_strength: the steel never yields, whatever it carries",
        ),
        (
            {
                "bolts": [bsm.Bolt(start=(0.5, 0.5), end=(1.5, 1.3), diameter=0.02, yield_strength=5e8, stage="cut")],
                "stages": [bsm.Stage("cut", excavate=[[(1, 0), (2, 0), (2, 1), (1, 1)]])],
            },
            "bolt 1 from (0.5, 0.5) to (1.5, 1.3) crosses 0.1601 m without rock where it is installed",
        ),
        (
            {"stages": [bsm.Stage("full", loads=[bsm.Pressure(boundary="top", pressure=-20e3)])]},
            "stage 'full': load 1 (Pressure): -20000 Pa pulls on 'top': a positive pressure acts into the blocks",
        ),
        (
            {"in_situ": bsm.InSitu(stress={"xx": 1e6, "yy": (1e6, 0, 26e3), "xy": 0})},
            "in_situ: stress is tension in all directions: compression is negative",
        ),
        (
            {"stages": [bsm.Stage("quake", gravity=(0.1, 0.0), relaxation=[0.6]), bsm.Stage("after")]},
            "stage 'quake': relaxation has no effect: nothing is excavated, and no stage before holds forces",
        ),
    ],
)
def test_what_is_noted(changes: dict[str, object], words: str) -> None:
    (note,) = notes_of(PLAIN.replace(**changes))
    assert words in note


def test_a_relaxation_that_releases_forces_of_the_stage_before_is_no_slip() -> None:
    cut = bsm.Stage("cut", excavate=[[(1, 1), (2, 1), (2, 2), (1, 2)]], relaxation=[0.5])
    assert notes_of(PLAIN.replace(stages=[cut, bsm.Stage("more", relaxation=[0.8])])) == []


def test_zones_that_yield_are_not_told_to_take_a_residual_strength() -> None:
    """They refuse one; elastic zones of the same rock have faces that slip."""
    rock = bsm.Rock("rock", unit_weight=26e3, young=1e9, poisson=0.2, cohesion=1e5, friction=20)
    elastic = notes_of(PLAIN.replace(rocks=[replace(rock, zones=bsm.Zones(size=1.0))]))
    assert any("give residual_cohesion = 0" in note for note in elastic)
    assert notes_of(PLAIN.replace(rocks=[replace(rock, zones=bsm.Zones(size=1.0, law="mohr_coulomb"))])) == []


def test_ground_above_the_model_that_a_load_stands_for_is_no_slip() -> None:
    deep = PLAIN.replace(in_situ=bsm.InSitu(surface=900.0))
    assert len(notes_of(deep)) == 1
    assert notes_of(deep.replace(loads=[bsm.InSituTraction(boundary="top")])) == []
    assert notes_of(deep.replace(supports=[bsm.Fixed(boundary="bottom"), bsm.Fixed(boundary="top")])) == []


def test_ground_above_the_model_is_told_from_a_twentieth_of_its_height() -> None:
    """One that is as deep as it is high was a slip without a note; a slope below its crest has no ground above it."""
    assert notes_of(PLAIN.replace(in_situ=bsm.InSitu(surface=2.09))) == []
    (note,) = notes_of(PLAIN.replace(in_situ=bsm.InSitu(surface=3.0)))
    assert '[[load]] boundary = "top", in_situ = true' in note
    stairs = bsm.Blocks.from_polygons([*grid(2, 1), [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="rock")
    ground = bsm.InSitu(surface=[(0, 1), (1, 1), (1.001, 2), (2, 2)])
    assert notes_of(PLAIN.replace(blocks=framed(stairs, 2, 2), in_situ=ground)) == []


def test_a_field_out_of_balance_with_the_weights() -> None:
    """Vertical stress of level ground grows downwards by the unit weight, 26 kN/m3; shear by xy may carry a part."""
    balanced = bsm.InSitu(stress={"xx": -1e6, "yy": (-1e6, 0, 26e3)})
    assert not notes_of(PLAIN.replace(in_situ=balanced))
    by_shear = bsm.InSitu(stress={"xy": (0, 26e3, 0), "yy": -1e6})
    assert not notes_of(PLAIN.replace(in_situ=by_shear))
    (note,) = notes_of(PLAIN.replace(in_situ=bsm.InSitu(stress={"xx": -1e6, "yy": -1e6})))
    assert note.startswith("in_situ: stress does not balance the weights")
    assert note.endswith("yy = [c, 0, 2.6e+04]")


def test_water_above_excavated_surfaces() -> None:
    """The table crosses an excavated block of 1 m: water presses on its floor, as deep as the table is above it."""
    dug, wet = bsm.Stage(name="dug", excavate=(3,)), bsm.Water(table=[(0, 1.75)])
    says = "stage 'dug': the water table lies up to 0.75 m above excavated surfaces, deepest at (1.5, 1): the water"
    note = next(iter(notes_of(PLAIN.replace(water=wet, stages=[dug]))))
    assert note.startswith(says)
    assert notes_of(PLAIN.replace(stages=[replace(dug, water=wet)])) == [note]
    assert not notes_of(PLAIN.replace(water=wet, stages=[replace(dug, water=bsm.Water())]))
    assert not notes_of(PLAIN.replace(water=bsm.Water(table=[(0, 1)]), stages=[dug]))


def test_water_that_slopes_above_the_ground() -> None:
    """Open water is level: a table that slopes is groundwater, and lies in the ground."""
    top = float(PLAIN.blocks.vertices[:, 1].max())
    left, right = PLAIN.blocks.extent
    rising = bsm.Water(table=[(left, top - 0.5), (right, top + 0.5)])
    (note,) = notes_of(PLAIN.replace(water=rising))
    assert note.startswith("water: the table slopes and lies up to 0.499 m above the ground, most at (")
    assert note.endswith("Lower the table to the ground, or make it level there")
    later = PLAIN.replace(stages=[bsm.Stage(name="rain", water=rising)])
    assert notes_of(later) == [f"stage 'rain': {note}"]
    assert not notes_of(PLAIN.replace(water=bsm.Water(table=[(left, top + 0.5)])))
    assert not notes_of(PLAIN.replace(water=bsm.Water(table=[(left, top - 0.5), (right, top)])))


def test_faces_without_strength() -> None:
    """Two of the four faces carry the joint; T-junctions count too."""
    elastic = bsm.Rock("rock", unit_weight=26e3, young=1e10, poisson=0.2)
    bare = PLAIN.replace(rocks=[elastic], default_joint=None, joints=[])
    assert notes_of(bare)[0].startswith("4 faces of rock without a joint and without strength: they neither slip")
    assert notes_of(bare, fails=False) == []
    dug = bare.replace(stages=[bsm.Stage(name="dug", excavate=[3])])  # its outline is rock until then, by intent
    assert notes_of(dug)[0].startswith("2 faces of rock without a joint")
    strong = bsm.Rock("rock", unit_weight=26e3, young=1e10, poisson=0.2, friction=30)
    assert notes_of(bare.replace(rocks=[strong])) == []
    bond = bsm.Blocks.from_polygons([*grid(2, 1), grid(1, 1)[0] + (0.5, 1)], rock="rock")
    assert notes_of(bsm.Model(blocks=bond, rocks=[elastic]))[0].startswith("3 faces of rock")


@pytest.mark.parametrize(
    ("size", "notes"),
    [
        (1e-3, ["the model measures 0.002 m by 0.002 m: check the unit of length of its mesh"]),
        (
            2e3,
            [
                "the model measures 4000 m by 4000 m: check the unit of length of its mesh "
                '(unit = "mm" where it is in mm)'
            ],
        ),
        (900.0, []),
    ],
)
def test_a_model_of_another_unit_of_length(size: float, notes: list[str]) -> None:
    """4 km of rock are most likely 4 m, in mm; a slope of 1.8 km is one."""
    blocks = bsm.Blocks.from_polygons([size * polygon for polygon in grid(2, 2)], rock="rock")
    assert notes_of(bsm.Model(blocks=blocks, rocks=[ROCK], joints=[JOINT], default_joint="J")) == notes


@pytest.mark.parametrize("command", ["run", "check", "limit", "compare"])
def test_commands_tell_the_notes(case: Case, command: str) -> None:
    case.write(
        "model.toml",
        MODEL.replace("friction = 35", "friction = 80").replace('mesh.msh"', 'mesh.msh"\nallow_unused = true')
        + '[joint.J2]\nnormal_stiffness = "1 GPa/m"\nshear_stiffness = "1 GPa/m"\nfriction = 30\n',
    )
    words = ("joint 'J2' is used by no face", "friction = 80 degrees is unusual")
    outcome = case.run(command, "model.toml")
    assert outcome.code == 0
    assert all(word in outcome.out + outcome.err for word in words)
    told = json.loads(case.run(command, "model.toml", "--json").out)
    assert all(word in str(told) for word in words)


def test_a_note_on_the_input_of_a_stage_is_printed_with_that_stage_alone() -> None:
    results = bsm.run(PLAIN.replace(stages=[bsm.Stage(name="idle")]))
    (note,) = results.stages[0].notes
    assert note.startswith("stage 'idle'")
    assert note in [line for table in tables_of(results) for line in table.lines]


def test_results_keep_the_notes() -> None:
    results = bsm.run(PLAIN.replace(rocks=[bsm.Rock("rock", unit_weight=26)]))
    assert "unit_weight = 26 N/m^3 is unusual" in results.stages[0].notes[0]


def test_the_linear_scheme_says_what_is_beyond_strength() -> None:
    """A block on a plane of 40 degrees: with 20 degrees of friction it slides, which one linear step does not find."""
    tilted = PLAIN.replace(gravity_direction=-50.0, joints=[joint(law=bsm.MohrCoulomb(friction=20))])
    (note,) = bsm.run(tilted, bsm.Options(scheme="linear")).stages[0].notes
    assert note.startswith("forces are beyond the strength of ")
    assert note.endswith("here nothing slips or opens; scheme = 'continuation' says whether it is stable")
    level = PLAIN.replace(joints=[joint(law=bsm.MohrCoulomb(friction=20))])
    assert bsm.run(level, bsm.Options(scheme="linear")).stages[0].notes == ()
