"""Factors of safety of models with stages: whose strength is divided, and where trials begin."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.safety.factor import _on_opening, factor_of_safety
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


def test_blocks_that_moved_in_an_earlier_stage_are_why_no_strength_is_enough():
    """A block slides to a wall once its holder is gone: not its joints are to blame for a fall in the next stage."""
    stages = [bsm.Stage(name="dig", excavate=[2]), bsm.Stage(name="later")]
    wall = turned(rectangle(-3.5, 0, -3.2, 0.5), DIP)
    nothing_holds = SimpleNamespace(
        trials=[SimpleNamespace(value=0.05)], bracket=SimpleNamespace(stable=None, unstable=0.05, undecided=())
    )
    for friction, words in ((20.0, "1 block moved by up to 2.2 m in stage 'dig'"), (FRICTION, "open joints carry no")):
        model = model_of([*BLOCKS, wall], friction=friction, kn=1e10, fixed=(0, 2, 3)).replace(stages=stages)
        runs = strength_trials(model, bsm.Options(), Reduction(), None, "stage", lambda text: None)
        (note,) = _on_opening(runs, nothing_holds, SimpleNamespace(factor=0.7))
        assert words in note
        assert ("--start throughout" in note) == (friction == 20.0)
