"""What a run refuses, it refuses before it begins; from Python and from the command line, and `check` does too."""

import json

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.merged_points import merge_points
from bsm_mesh.solve.linear.readiness import make_ready
from tests.scenes.shapes import grid, rectangle, running_bond, square
from tests.scenes.small_case import FILE, LINEAR, LOAD, MODEL, ROCK, SUPPORT, Case
from tests.scenes.square_mesh import NODES, msh

SCHEMES = ("linear", "continuation", "wang")
OPTIONS = [bsm.Options(scheme=scheme) for scheme in SCHEMES]


def pile(polygons=None, *, kn=1e9, ks=None, fixed=(0,), rock=None, friction=35.0, **given):
    """Return squares on top of each other, or other blocks, on one joint."""
    rock = rock or bsm.Rock("r", unit_weight=25e3)
    joint = bsm.Joint("J", kn, kn if ks is None else ks, law=bsm.MohrCoulomb(friction=friction))
    defaults = {
        "blocks": bsm.Blocks.from_polygons(grid(1, 3) if polygons is None else polygons, rock="r"),
        "rocks": [rock],
        "joints": [joint],
        "default_joint": "J",
        "supports": [bsm.Fixed(blocks=list(fixed))],
    }
    return bsm.Model(**{**defaults, **given})


@pytest.mark.parametrize("options", OPTIONS)
def test_a_model_without_support(options):
    with pytest.raises(bsm.ModelError, match="free to move in any direction: no support holds it; hold a boundary"):
        bsm.run(pile(supports=()), options)


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("rock", [bsm.Rock("r", 25e3), bsm.Rock("r", 25e3, young=1e9, poisson=0.2, stiffness="rigid")])
def test_rigid_rocks_that_meet_without_a_joint(options, rock):
    with pytest.raises(bsm.ModelError, match=r"blocks 0 and 1 meet at \(1, 1\) without a joint") as refused:
        bsm.run(pile(default_joint=None, rock=rock), options)
    assert len(refused.value.faults) == 2  # one a face


@pytest.mark.parametrize("options", OPTIONS)
def test_blocks_that_overlap(options):
    """Made from arrays, where nothing has looked at them yet."""
    vertices = np.concatenate([square(0, 0), square(0.5, 0.5)])
    blocks = bsm.Blocks(
        vertices=vertices,
        offsets=[0, 4, 8],
        nodes=merge_points(vertices, 1e-9),
        rock=[0, 0],
        rock_names=("r",),
        edge_joint=np.full(8, -1, dtype=np.int32),
    )
    with pytest.raises(bsm.ModelError, match=r"blocks 0 and 1 overlap by 0.25 m2 near \(0.75, 0.75\)"):
        bsm.run(pile(blocks=blocks), options)


@pytest.mark.parametrize("options", OPTIONS)
def test_supports_that_contradict_each_other(options):
    up = bsm.PrescribedDisplacement(blocks=[0], direction=90, displacement=0.1)
    with pytest.raises(bsm.ModelError, match="contradicts"):
        bsm.run(pile(supports=[bsm.Fixed(blocks=[0]), up]), options)


def test_all_is_told_at_once(monkeypatch):
    monkeypatch.setattr("bsm_mesh.solve.algebra.pardiso._library", lambda: None)
    model = pile(supports=(), default_joint=None)
    with pytest.raises(bsm.ModelError) as refused:
        bsm.run(model, bsm.Options(linear_solver="pardiso"))
    told = "\n".join(refused.value.faults)
    assert all(words in told for words in ("no support", "'pardiso' needs the package mkl", "without a joint"))


def test_parts_that_are_free_are_refused_by_the_linear_scheme_and_followed_by_the_others():
    model = pile([*grid(1, 2), *(square(3 * k, 1) for k in range(1, 6))])
    with pytest.raises(bsm.ModelError, match=r"block 2 at \(3.5, 1.5\) is free to move in any direction"):
        bsm.run(model, OPTIONS[0])
    results = bsm.run(model, OPTIONS[1])
    assert results.status == "unstable"
    notes = [note for note in results.stages[0].notes if "free to move" in note]
    assert notes[0].startswith("block 2 at (3.5, 1.5) is free to move in any direction")
    assert notes[-1] == "2 more parts are free to move"
    assert len(notes) == 4


def test_a_model_that_is_ready_has_no_notes():
    assert make_ready(pile(), OPTIONS[1]).notes == ()


JOINTED = MODEL.replace(FILE, FILE + 'default_joint = "J1"\n').replace('young = "10 GPa"\npoisson = 0.25\n', "")
SOFT = JOINTED.replace('"5 GPa/m"', '"1 Pa/m"').replace('"1 GPa/m"', '"1 Pa/m"')
STIFF = JOINTED.replace('"5 GPa/m"', "1e18")
REFUSED = [
    (SUPPORT, "", ["the model is free to move in any direction", "no support holds it"]),
    (SUPPORT, SUPPORT.replace('boundary = "bottom"', "blocks = []"), ["must not be empty"]),
    (ROCK, '[rock.gneiss]\nunit_weight = "26 kN/m^3"\n', ["blocks 0 and 1 meet at", "default_joint"]),
    (SUPPORT, SUPPORT + '[[support]]\nboundary = "bottom"\ndirection = 90\ndisplacement = 0.1\n', ["contradicts"]),
    (SUPPORT, SUPPORT.replace('"all"', '"normal"') + LINEAR, ["free to slide in the direction 0 deg"]),
    (MODEL, STIFF, ["joint 'J1'", "too stiff for double precision"]),
    (MODEL, SOFT, ["joint 'J1'", "too soft"]),
    (ROCK, ROCK.replace('"10 GPa"', "1e18"), ["faces of rock without a joint", "too stiff"]),
]


@pytest.mark.parametrize(("old", "new", "words"), REFUSED)
def test_check_refuses_what_run_refuses(case: Case, old: str, new: str, words: list[str]) -> None:
    case.change(old, new)
    by_run = case.refuses("run", "model.toml", "-q", says=["model.toml: ", *words])
    by_check = case.refuses("check", "model.toml", "-q", says=words)
    assert by_check == by_run
    with pytest.raises(bsm.ModelError) as refused:
        bsm.run(bsm.load("model.toml"))
    assert all(fault in by_run for fault in refused.value.faults)


def test_check_notes_what_run_notes(case: Case) -> None:
    case.write("mesh.msh", msh([*NODES, (5, 0), (6, 0), (6, 1), (5, 1)], [(0, 1, 4, 3), (9, 10, 11, 12)]))
    case.change(LOAD, "")
    outcome = case.run("check", "model.toml")
    assert outcome.code == 0
    assert "note: block 1 at (5.5, 0.5) is free to move" in outcome.out
    notes = json.loads(case.run("check", "model.toml", "--json").out)["notes"]
    assert any("block 1 at (5.5, 0.5) is free to move" in note for note in notes)
    told = json.loads(case.run("run", "model.toml", "--json").out)
    assert set(notes) <= {*told["notes"], *told["stages"][0]["notes"]}


# --- stiffness: what a contact closes by, against rounding and against the blocks' size


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("scheme", ["continuation", "wang"])
def test_too_stiff_is_what_rounding_spoils(scheme, tolerance):
    """Positions of the size of two half blocks round by eps; the tolerance asks for a part of the closure."""
    reach, eps = 2 * np.hypot(0.5, 0.5), np.finfo(float).eps
    most = pile().weights.mean() * tolerance / (0.5 * eps * reach)
    options = bsm.Options(scheme=scheme, tolerance=tolerance)
    assert bsm.run(pile(kn=0.99 * most), options).status == "stable"
    with pytest.raises(bsm.ModelError, match=r"joint 'J': .* Pa/m is too stiff for double precision"):
        bsm.run(pile(kn=1.01 * most), options)


def test_the_stiffness_that_a_refusal_names_is_taken():
    with pytest.raises(bsm.ModelError) as refused:
        bsm.run(pile(kn=1e9, ks=1e18))
    (fault,) = refused.value.faults
    named = float(fault.split("give ")[1].split(" Pa/m")[0])
    assert bsm.run(pile(kn=1e9, ks=named)).status == "stable"


def test_the_forces_decide_and_not_the_stiffness():
    """A thousand times the weight allows a thousand times the stiffness; so does stress in situ, without any weight."""
    heavy = bsm.Rock("r", unit_weight=25e6)
    with pytest.raises(bsm.ModelError, match="too stiff"):
        bsm.run(pile(kn=1e16))
    assert bsm.run(pile(kn=1e16, rock=heavy)).status == "stable"
    weightless = {"rock": bsm.Rock("r", unit_weight=0.0), "gravity_direction": -90.0}
    field = bsm.InSitu(stress={"xx": 0.0, "yy": -25e6, "xy": 0.0})
    top = bsm.Pressure(boundary="top", pressure=25e6)
    blocks = bsm.Blocks.from_polygons(grid(1, 3), rock="r").with_boundary("top", lambda x, y: y > 2.99)
    assert bsm.run(pile(kn=1e16, blocks=blocks, in_situ=field, loads=[top], **weightless)).status == "stable"


def test_the_linear_scheme_takes_any_stiffness_that_numbers_hold():
    soft, stiff = (bsm.run(pile(kn=k), OPTIONS[0]).stages[0].displacement[:, 1] for k in (1e9, 1e18))
    np.testing.assert_allclose(stiff * 1e9, soft, rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("options", OPTIONS)
def test_too_soft_is_what_blocks_sink_into(options):
    """A square whose own weight closes its joints by a quarter of its size; by less, friction being no part of it."""
    least = 25e3 / (2 * 0.25)  # of a block between two others; the topmost has one face only
    with pytest.raises(bsm.ModelError, match=r"joint 'J': .* too soft: block 2 at .* sinks by 0.5") as refused:
        bsm.run(pile(kn=0.99 * least), options)
    assert "2 more" not in str(refused.value)
    assert "1 more block too" in str(refused.value)
    with pytest.raises(bsm.ModelError, match=r"raise the stiffness 2 times at least"):
        bsm.run(pile(kn=least, ks=1e9), options)


def test_one_block_that_sinks_is_told_though_its_neighbour_is_fixed():
    with pytest.raises(bsm.ModelError, match=r"block 1 at .* sinks by 0\.5"):
        make_ready(pile(grid(1, 2), kn=25e3 / 0.5), OPTIONS[1])


def test_how_far_a_block_sinks_is_told_over_its_size():
    """The topmost of three squares of 2 m has one face, whose springs its weight closes by half its size."""
    side, part = 2.0, 0.5
    polygons = [rectangle(0, side * k, side, side * (k + 1)) for k in range(3)]
    with pytest.raises(bsm.ModelError, match=r"block 2 at .* sinks by 1 m .* 0\.5 of its size"):
        make_ready(pile(polygons, kn=25e3 * side**2 / (side * part * side)), OPTIONS[1])


def test_a_number_without_its_unit_is_told_with_the_joints_that_it_makes_too_soft():
    """The springs of rock and joint are in series: with 30 Pa for 30 GPa the stiffest joint gives way."""
    rock = bsm.Rock("r", unit_weight=25e3, young=30.0, poisson=0.2)
    with pytest.raises(bsm.ModelError, match="too soft") as refused:
        make_ready(pile(rock=rock), OPTIONS[1])
    assert refused.value.faults[0].startswith("rock 'r': young = 30 Pa is unusual")


def test_shear_springs_too_soft_for_a_block_on_an_incline():
    """It would slide by kilometres before friction carries it."""
    tilted = {"gravity_direction": -105.0, "friction": 40.0}
    assert bsm.run(pile(**tilted)).status == "stable"
    with pytest.raises(bsm.ModelError, match=r"1e\+09 and 1 Pa/m .* too soft"):
        bsm.run(pile(ks=1.0, **tilted))
    make_ready(pile(ks=1.0), OPTIONS[1])  # level, nothing pulls it that way


def test_what_is_held_otherwise_does_not_sink():
    polygons = [rectangle(-1, -1, 2, 0), square(0, 0), rectangle(-1, 1, 2, 2)]
    bolt = bsm.Bolt(start=(0.5, 1.5), end=(0.5, 0.5), diameter=0.025, young=2e11, kind="end_anchored")
    with pytest.raises(bsm.ModelError, match="too soft"):
        make_ready(pile(polygons, kn=1e4), OPTIONS[1])
    make_ready(pile(polygons, kn=1e4, supports=[bsm.Fixed(blocks=[0, 1, 2])]), OPTIONS[1])
    make_ready(pile(polygons, kn=1e4, bolts=[bolt]), OPTIONS[1])


def test_stress_in_situ_sinks_nothing():
    """What the field's contacts carry is in balance with the weights before anything closes."""
    blocks = bsm.Blocks.from_polygons(running_bond(3, 3), rock="r")
    given = {"blocks": blocks, "fixed": (0, 1, 2), "kn": 1e4}
    with pytest.raises(bsm.ModelError, match="too soft"):
        make_ready(pile(**given), OPTIONS[1])
    make_ready(pile(**given, in_situ=bsm.InSitu(surface=1.5, k0=0.0)), OPTIONS[1])
