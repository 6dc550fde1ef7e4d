"""Factors of safety of models with stages: whose strength is divided, and where trials begin."""

import pickle

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.safety.factor import factor_of_safety
from bsm_mesh.safety.trials import Reduction, strength_trials
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.unit.test_safety import DIP, EXACT, FRICTION, incline

BLOCKS = [turned(p, DIP) for p in (rectangle(-20, -5, 5, 0), rectangle(-1, 0, 1, 0.5), rectangle(-3, 0, -1, 0.5))]


@pytest.mark.heavy
def test_the_stage_in_question_is_weakened_and_what_is_before_it_not():
    """The block is held by another one until that is excavated."""
    model = model_of(BLOCKS, friction=FRICTION, kn=1e10, fixed=(0, 2)).replace(
        stages=[bsm.Stage(name="dig", excavate=[2])]
    )
    found = factor_of_safety(model)
    assert found.stable < EXACT <= found.unstable * (1 + 1e-4)
    assert len(found.states[found.stable].stages) == 2
    assert factor_of_safety(model, stage="initial").unstable is None
    for start in ("after", "throughout"):
        other = factor_of_safety(model, start=start)
        assert other.stable == pytest.approx(EXACT, rel=0.006)


def test_trials_from_a_checkpoint_are_those_from_the_start():
    """To the last digit: what comes before the stage is solved once."""
    model = model_of(BLOCKS, friction=FRICTION, kn=1e10, fixed=(0,)).replace(
        stages=[bsm.Stage(name="one", excavate=[2]), bsm.Stage(name="two", loads=[])]
    )
    trials = strength_trials(model, bsm.Options(), Reduction(), None, "stage", lambda text: None)
    assert trials.begun is not None
    for factor in (1.2, 1.4, 1.2):
        whole = bsm.run(trials.changed(factor)).stages[-1]
        part = pickle.loads(pickle.dumps(trials)).run(factor)
        assert np.array_equal(part.displacement, whole.stage_displacement)
        assert np.array_equal(part.results.stages[-1].contacts.shear_force, whole.contacts.shear_force)


@pytest.mark.heavy
@pytest.mark.parametrize("start", ["stage", "after"])
def test_a_stage_that_is_not_reached_has_a_factor_below_1(start):
    """The block slides as soon as what holds it is excavated: more strength in all stages leads to the next one."""
    model = model_of(BLOCKS, friction=20.0, kn=1e10, fixed=(0, 2)).replace(
        stages=[bsm.Stage(name="dig", excavate=[2]), bsm.Stage(name="later")]
    )
    found = factor_of_safety(model, start=start)
    assert found.stable < np.tan(np.radians(20.0)) / np.tan(np.radians(DIP)) <= found.unstable * (1 + 1e-4)
    assert found.is_closed
    assert found.stage == "later"
    assert found.start == "strength reduced in every stage up to 'later'"
    assert found.notes[0].startswith("stage 'dig' is unstable with the strength that is given")
    assert len(found.states[found.stable].stages) == 3


def staged(**given):
    """Return an incline whose joint weathers in a stage, which a later one does not name."""
    stages = [bsm.Stage(name="rain", strength={"J": 0.9}), bsm.Stage(name="later", loads=[])]
    return incline().replace(stages=stages, **given)


@pytest.mark.heavy
@pytest.mark.parametrize("start", ["stage", "after", "throughout"])
def test_strength_that_stages_have_left_is_what_is_divided(start):
    """As of the stage in question, whether it names a part of strength itself or a former one did."""
    for stage, part in (("later", 0.9), ("rain", 0.9), ("initial", 1.0)):
        found = factor_of_safety(staged(), stage=stage, start=start)
        assert found.stable < part * EXACT <= found.unstable * (1 + 1e-4), (stage, str(found))
        assert found.limit.factor == pytest.approx(part * EXACT, rel=1e-4)


@pytest.mark.heavy
def test_a_stage_is_asked_about_before_the_bolts_of_a_later_one_are_there():
    """The bolt would hold the block at any strength that is tried."""
    along = np.array([np.cos(np.radians(DIP)), np.sin(np.radians(DIP))])
    across = np.array([-along[1], along[0]])
    start, end = (tuple(distance * across) for distance in (0.25, -3.0))
    bolt = bsm.Bolt(
        start=start, end=end, kind="end_anchored", diameter=0.05, young=200e9, pretension=1e6, stage="bolts"
    )
    stages = [bsm.Stage(name="first", loads=[]), bsm.Stage(name="bolts")]
    model = incline().replace(stages=stages, bolts=[bolt])
    for stage in ("initial", "first"):
        found = factor_of_safety(model, stage=stage)
        assert found.stable < EXACT <= found.unstable * (1 + 1e-4)
    assert factor_of_safety(model).stable > 3.0


def slides_to_a_wall(*stages):
    """Return a block that slides to a wall as soon as what holds it is excavated, and the stages after that."""
    wall = turned(rectangle(-3.5, 0, -3.2, 0.5), DIP)
    model = model_of([*BLOCKS, wall], friction=20.0, kn=1e10, fixed=(0, 2, 3))
    return model.replace(stages=[bsm.Stage(name="dig", excavate=[2]), *stages])


@pytest.mark.heavy
def test_a_slide_to_rest_in_an_earlier_stage_is_said_beside_the_factor_of_where_the_block_lies():
    """The wall holds the block at any strength; in stage `dig` it has a factor below 1."""
    found = factor_of_safety(slides_to_a_wall(bsm.Stage(name="later")))
    assert found.unstable is None
    assert found.start == "strength reduced as stage 'later' begins"
    assert found.notes[0].startswith("1 block moved by 2.2 m (2.2 times the block's size) in stage 'dig'")
    values = [trial.value for trial in found.trials]
    assert len(values) == len(set(values))


@pytest.mark.heavy
def test_a_stage_that_fails_after_a_slide_has_the_strength_of_every_stage_raised():
    """No strength in stage `later`, which takes the wall away, brings the block back to where it was."""
    told = []
    found = factor_of_safety(slides_to_a_wall(bsm.Stage(name="later", excavate=[3])), report=told.append)
    assert found.stable < np.tan(np.radians(20.0)) / np.tan(np.radians(DIP)) <= found.unstable * (1 + 1e-4)
    assert found.is_closed
    assert found.start == "strength reduced in every stage up to 'later'"
    assert found.notes[0].startswith("1 block moved by 2.2 m (2.2 times the block's size) in stage 'dig' with the")
    assert len(found.trials) <= 4


def test_strength_that_stages_have_left_is_named_with_what_is_divided():
    """In the words of the answer, for the stage in question; joints that are not divided are left out."""
    left = "; of the strength that stages left, a part of the given one: J 0.9"
    model = staged()
    assert Reduction().words(model).endswith(left)
    assert left not in Reduction().words(model.replace(stages=()))
    other = bsm.Joint("K", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30))
    assert left not in Reduction(joints=("K",)).words(model.replace(joints=[*model.joints, other]))
