"""Stages as they are given: what is refused, what groups, numbers and polygons mean, and stages that cannot stand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.stages import presence
from bsm_mesh.model.submodel import submodel_of
from bsm_mesh.model.supports import bars_of
from bsm_mesh.results.movement import verdict_in_words
from bsm_mesh.results.stress import extreme_stresses
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import grid

CONTINUATION = bsm.Options(scheme="continuation")
SOUTH = ((-1, -1), (9, -1), (9, 1), (-1, 1))  # the lowest row


def tower(stages=(), columns=2, rows=3, **more):
    """Return columns of unit blocks on a fixed bottom; group "top" is the uppermost row."""
    blocks = bsm.Blocks.from_polygons(grid(columns, rows), rock="rock")
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9).with_boundary("top", lambda x, y: y > rows - 1e-9)
    blocks = dataclasses.replace(blocks, excavations={"top": np.arange(columns * (rows - 1), columns * rows)})
    settings = {"joints": [bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9)], "default_joint": "J", **more}
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=25e3)],
        supports=[bsm.Fixed(boundary="bottom")],
        stages=stages,
        **settings,
    )


@pytest.mark.parametrize(
    ("stages", "words"),
    [
        ([bsm.Stage(name="a", excavate=["tpo"])], ["stage 'a'", "no excavation 'tpo'", "did you mean 'top'"]),
        ([bsm.Stage(name="a", excavate=[6])], ["no block 6", "0 to 5"]),
        ([bsm.Stage(name="a", excavate=[((5, 5), (6, 5), (6, 6))])], ["no block has its centroid", "(5, 5)"]),
        (
            [bsm.Stage(name="a", excavate=[((0, 0), (3, 2), (3, 0), (0, 2))])],
            ["stage 'a': excavate: the polygon from (0, 0)", "crosses or touches itself at (1.5, 1)", "in their order"],
        ),
        ([bsm.Stage(name="a", excavate=["top"]), bsm.Stage(name="b", excavate=["top"])], ["'b'", "gone already"]),
        ([bsm.Stage(name="a", fill=["top"])], ["stage 'a'", "fill", "there already"]),
        ([bsm.Stage(name="a", excavate=range(6))], ["leaves no block", "excavate less"]),
        ([bsm.Stage(name="a"), bsm.Stage(name="a")], ["'a' is defined more than once", "rename"]),
        ([bsm.Stage(name="a", loads=[bsm.Pressure(boundary="tops", pressure=1.0)])], ["stage 'a'", "'tops'", "'top'"]),
        ([bsm.Stage(name="a", loads=[bsm.InSituTraction(boundary="top")])], ["needs the field", "[in_situ]"]),
        ([bsm.Stage(name="a", water=bsm.Water(table=[(50, 0), (60, 1)]))], ["stage 'a'", "outside the model", "50 m"]),
        ([bsm.Stage(name="a", water=bsm.Water(joint_pressure={"K": 1.0}))], ["no joint 'K'"]),
        (
            [bsm.Stage(name="a", strength={"K": 0.5})],
            ["stage 'a': strength: there is no joint 'K'", "(known: J)"],
        ),
        ([bsm.Stage(name="a", strength={"rock:rok": 0.5})], ["there is no rock 'rok'", "did you mean 'rock'"]),
        ([bsm.Stage(name="a", strength={"J": 0.5})], ["joint 'J' has no law", "give it friction"]),
    ],
)
def test_what_does_not_fit_the_model(stages, words):
    with pytest.raises(bsm.ModelError) as caught:
        tower(stages)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"name": ""}, ["name", "non-empty"]),
        ({"name": "initial"}, ["before the first stage", "choose another"]),
        ({"name": "a", "excavate": [1.5]}, ["stage 'a'", "1.5", "polygon"]),
        ({"name": "a", "excavate": [((0, 0), (1, 0))]}, ["3 points"]),
        ({"name": "a", "excavate": [((0, 0), (1, 0), (1, np.nan))]}, ["polygon point", "nan"]),
        ({"name": "a", "relaxation": [0.5, 0.5]}, ["must rise", "[0.5, 1.0]"]),
        ({"name": "a", "relaxation": [1.5]}, ["relaxation = 1.5 must be 0 to 1"]),
        ({"name": "a", "relaxation": []}, ["must rise"]),
        ({"name": "a", "pressure": "high"}, ["pressure", "not a finite number"]),
        ({"name": "a", "strength": 0.5}, ["strength = 0.5 must be a mapping by names"]),
        ({"name": "a", "strength": {"J": 0}}, ["strength of 'J' = 0 must be 1e-6 to 1e6"]),
        ({"name": "a", "gravity": 0.1}, ["gravity = 0.1 must be two numbers (x, y)"]),
        ({"name": "a", "gravity": (0, 9.81)}, ["gravity y = 9.81 must be -2 to 2", "part of the unit weight"]),
    ],
)
def test_what_is_no_stage(given, words):
    with pytest.raises(bsm.ModelError) as caught:
        bsm.Stage(**given)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_stage_keeps_its_numbers_to_itself():
    parts = {"J": 1}
    stage = bsm.Stage(name="a", strength=parts, gravity=[np.float32(0.5), 0])
    parts["J"] = 5
    assert (dict(stage.strength), stage.gravity) == ({"J": 1.0}, (0.5, 0.0))
    assert hash(stage) == hash(bsm.Stage(name="a", gravity=(0.5, 0.0)))
    with pytest.raises(TypeError):
        stage.strength["J"] = 2.0


def test_a_strength_that_no_law_can_have_is_refused_before_the_run():
    law = bsm.MohrCoulomb(friction=30, cohesion=1e6)
    stages = [bsm.Stage(name="a", strength={"J": 1e4})]
    with pytest.raises(bsm.ModelError, match=r"stage 'a': joint 'J': strength divided by 0.0001: .*cohesion = 1e\+10"):
        tower(stages, joints=[bsm.Joint("J", 1e9, 1e9, law=law)])
    stages = [bsm.Stage(name=name, strength={"J": 500}) for name in "ab"]  # not cumulative: not refused
    tower(stages, joints=[bsm.Joint("J", 1e9, 1e9, law=law)])


def test_regions():
    blocks = tower().blocks
    stages = [
        bsm.Stage(name="a", excavate=["top"]),
        bsm.Stage(name="b", excavate=[3, ((-1, 0), (1, 0), (1, 3), (-1, 3))]),  # the left column, its top gone
        bsm.Stage(name="c", fill=[4]),
    ]
    here = [np.flatnonzero(now).tolist() for now in presence(stages, blocks)]
    assert here == [[0, 1, 2, 3, 4, 5], [0, 1, 2, 3], [1], [1, 4]]


def test_a_part_keeps_joints_boundaries_supports_and_loads():
    model = tower(
        loads=[bsm.Pressure(boundary="top", pressure=7.0), bsm.PointLoad(block=2, point=(0.5, 1.5), force=(3, 0))]
    )
    present = np.array([True, True, False, True, True, True])
    bars, forces = bars_of(model.supports, model.blocks), point_forces_of(model.loads, model.blocks)
    part = submodel_of(model, present, bars, forces, None)
    assert part.block.tolist() == [0, 1, 3, 4, 5]
    assert_array_equal(part.model.blocks.vertices, model.blocks.vertices[part.corner])
    assert part.corner[part.model.blocks.boundaries["top"]].tolist() == model.blocks.boundaries["top"].tolist()
    assert part.bar.tolist() == list(range(len(bars.block)))
    found = point_forces_of(part.model.loads, part.model.blocks)
    assert part.block[found.block].tolist() == [4, 4, 5, 5]
    assert_allclose(found.force.sum(axis=0), [0, -14.0])
    assert_allclose(part.in_whole(np.ones(5)), [1, 1, 0, 1, 1, 1])


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_loads_of_stages_stay(options):
    stages = [
        bsm.Stage(name="a", loads=[bsm.Pressure(boundary="top", pressure=1e3)]),
        bsm.Stage(name="b", loads=[bsm.PointLoad(block=5, point=(1.5, 2.5), force=(0, -500.0))]),
        bsm.Stage(name="c"),
    ]
    results = bsm.run(tower(stages), options)
    weight = 6 * 25e3
    assert_allclose([stage.total_load[1] for stage in results.stages], [-weight, -weight - 2e3, *[-weight - 2.5e3] * 2])
    assert_allclose(
        [stage.total_reaction[1] for stage in results.stages], [weight, weight + 2e3, *[weight + 2.5e3] * 2]
    )
    assert results.check().ok


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_prescribed_displacements_are_applied_once(options):
    support = bsm.PrescribedDisplacement(boundary="bottom", direction=90, displacement=2e-3)
    model = tower([bsm.Stage(name="a"), bsm.Stage(name="b", excavate=["top"])])
    model = model.replace(supports=[support, bsm.Roller(boundary="bottom", direction=0)])
    last = bsm.run(model, options).stages[-1]
    assert_allclose(last.displacement[:2, 1], 2e-3, rtol=1e-9)


def test_a_stage_that_takes_the_support_away_is_unstable():
    """Both schemes name the blocks that are left without it, and the run ends."""
    stages = [bsm.Stage(name="under", excavate=[SOUTH]), bsm.Stage(name="never")]
    linear = bsm.run(tower(stages), LINEAR)
    assert [stage.name for stage in linear.stages] == ["initial", "under"]
    assert linear.status == "unstable"
    assert linear.unstable_blocks.tolist() == [2, 3, 4, 5]
    assert "block 2, 3, 4, 5 at" in linear.stages[-1].reason
    assert "no support holds it" in linear.stages[-1].reason
    falling = bsm.run(tower(stages), CONTINUATION)
    assert falling.status == "unstable"
    assert falling.unstable_blocks.tolist() == [2, 3, 4, 5]
    assert verdict_in_words(falling.blocks, falling.stages[-1]) == "unstable, 4 blocks fall: 100 % of the area"
    for results in (linear, falling):  # no support is left, and stresses are of free blocks
        assert np.isfinite(extreme_stresses(results.blocks, results.stages[-1])).all()


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_a_stage_that_isolates_a_block(options):
    results = bsm.run(tower([bsm.Stage(name="gap", excavate=[2, 3])], columns=2), options)
    assert results.status == "unstable"
    assert results.unstable_blocks.tolist() == [4, 5]


def test_a_free_part_at_the_start_is_still_refused():
    with pytest.raises(bsm.ModelError, match="free to move"):
        bsm.run(tower().replace(supports=()), LINEAR)


@pytest.mark.parametrize("options", [LINEAR, pytest.param(CONTINUATION, marks=pytest.mark.heavy)])
def test_results_of_stages_are_read_back(options, tmp_path):
    stages = [bsm.Stage(name="dug", excavate=["top"]), bsm.Stage(name="wet", water=bsm.Water(table=[(0, 1.5)]))]
    in_situ = bsm.InSitu(method="gravity")
    results = bsm.run(tower(stages, in_situ=in_situ), options)
    found = bsm.Results.load(results.save(tmp_path / "out"))
    assert len(found.stages) == 3
    for one, other in zip(results.stages, found.stages, strict=True):
        for field in dataclasses.fields(one):
            value, read = getattr(one, field.name), getattr(other, field.name)
            if isinstance(value, np.ndarray):
                assert_array_equal(read, value, err_msg=field.name)
            elif not dataclasses.is_dataclass(value):
                assert read == value, field.name
        assert_array_equal(other.contacts.water_pressure, one.contacts.water_pressure)
    assert found.check().ok
    assert found.stages[1].present.tolist() == [True] * 4 + [False] * 2


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_fill_bears_its_weight(options):
    """Put back between joints with friction: nothing pushes it at first, then it rests on the block under it."""
    joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30.0))
    stages = [
        bsm.Stage(name="dug", excavate=["top"]),
        bsm.Stage(name="filled", fill=[4]),
        bsm.Stage(name="all", fill=[5]),
    ]
    results = bsm.run(tower(stages, joints=[joint]), options)
    verdict = "no_verdict" if options is LINEAR else "stable"
    assert [stage.status for stage in results.stages] == [verdict] * 4
    assert results.check().ok
    filled = results.stages[2]
    assert filled.present.tolist() == [True] * 5 + [False]
    assert_allclose(filled.displacement[4, 1], filled.stage_displacement[4, 1])
    pair = {frozenset((2, 4))}
    contacts = filled.contacts
    between = [frozenset(ids) in pair for ids in zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)]
    assert_allclose(-contacts.normal_force[between].sum(), 25e3, rtol=1e-5)
    assert_allclose(results.stages[-1].total_reaction[1], 6 * 25e3, rtol=1e-9)


@pytest.mark.parametrize(("gap", "said"), [(0.05, False), (0.11, True)])
def test_blocks_that_come_to_rest_far_off_are_noted(gap, said):
    """A unit block above a floor: it falls, rests and is stable; more than a tenth of its size, that is said."""
    floor = [(-2, -1), (3, -1), (3, 0), (-2, 0)]
    block = [(0, gap), (1, gap), (1, 1 + gap), (0, 1 + gap)]
    model = model_of([floor, block], friction=30.0)
    stage = bsm.run(model, CONTINUATION).stages[0]
    assert stage.status == "stable"
    words = "before it reached rest, 1 block moved by more than a tenth of its size, up to 0.11 m: block 1"
    assert any(words in note and "displacement_limit in [solver]" in note for note in stage.notes) is said
    assert verdict_in_words(model.blocks, stage) == (
        "stable, after 1 block moved by 0.11 m (0.11 of the block's size)" if said else "stable"
    )


def test_a_stage_of_the_results_has_a_name_too() -> None:
    results = bsm.run(tower([bsm.Stage(name="dig", excavate=["top"])]), LINEAR)
    assert results.stages["dig"] is results.stages[1]
    assert results.stages[:1] == (results.stages["initial"],)
    with pytest.raises(KeyError, match=r"^there is no stage 'dg'; did you mean 'dig'\? \(known: dig, initial\)$"):
        results.stages["dg"]
