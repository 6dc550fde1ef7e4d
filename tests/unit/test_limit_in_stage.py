"""Limit analysis of a stage: the last by default, with its blocks, loads, water, strength, gravity and bolts."""

import json

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.vtk_files import read_vtu
from bsm_mesh.solve.limit_analysis import limit_tilt, strength_limit
from bsm_mesh.solve.stages.as_built import in_stage
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.scenes.small_case import Case

DIP, FRICTION = 30.0, 40.0
EXACT = np.tan(np.radians(FRICTION)) / np.tan(np.radians(DIP))
LP = 1e-4


def cliff(**given):
    """Return a block on a plane, which leans on a held one until that is excavated; rain weakens the joint then."""
    polygons = [rectangle(-20, -5, 5, 0), rectangle(-3, 0, -1, 0.5), rectangle(-1, 0, 1, 0.5)]
    model = model_of([turned(p, DIP) for p in polygons], friction=FRICTION, fixed=(0, 1), **given)
    stages = [bsm.Stage(name="dig", excavate=[1]), bsm.Stage(name="rain", strength={"J": 0.8})]
    return model.replace(stages=stages)


@pytest.mark.parametrize(("stage", "factor"), [(None, 0.8 * EXACT), ("rain", 0.8 * EXACT), ("dig", EXACT)])
def test_factor_of_strength_of_a_stage(stage, factor):
    found = strength_limit(cliff(), stage=stage)
    assert found.factor == pytest.approx(factor, rel=LP)
    assert found.stage == (stage or "rain")
    assert f"in stage {found.stage}" in str(found)
    assert found.present.tolist() == [True, False, True]
    assert np.abs(found.mechanism[2, :2]).max() > 0.5
    assert not found.mechanism[:2].any()
    assert set(found.contacts.block_a) | set(found.contacts.block_b) == {0, 2}
    assert set(cliff().blocks.owner[found.contacts.edge]) <= {0, 2}
    assert found.proof.witness.velocity.shape == (3, 3)


@pytest.mark.heavy
def test_the_first_stage_is_the_model_as_given():
    assert strength_limit(cliff(), stage="initial").factor == np.inf
    assert bsm.limit_analysis(cliff(), stage="initial").admissible
    tilt = [limit_tilt(cliff(), stage=stage, clockwise=True) for stage in ("initial", "dig")]
    assert tilt[0] > tilt[1] + 10


def test_factor_on_a_load_of_a_stage():
    """A push down the plane, by the weight w of the block: w sin(dip) + push = strength of the joint."""
    weight = float(cliff().weights[2])
    down = -np.array([np.cos(np.radians(DIP)), np.sin(np.radians(DIP))])
    middle = tuple(turned(np.array([[0.0, 0.0]]), DIP)[0])
    push = bsm.PointLoad(block=2, point=middle, force=tuple(1e3 * down))
    for stage, part in ((None, 0.8), ("dig", 1.0)):
        found = bsm.limit_analysis(cliff(), [push], stage=stage)
        slides = weight * (part * np.cos(np.radians(DIP)) * np.tan(np.radians(FRICTION)) - np.sin(np.radians(DIP)))
        assert found.factor == pytest.approx(slides / 1e3, rel=LP) if slides > 0 else found.factor == 0.0
        assert found.stage == (stage or "rain")
    gone = bsm.PointLoad(block=1, point=tuple(turned(np.array([[-2.0, 0.25]]), DIP)[0]), force=(1e3, 0.0))
    with pytest.raises(bsm.ModelError, match="the chosen loads are zero in stage rain"):
        bsm.limit_analysis(cliff(), [gone])


@pytest.mark.heavy
def test_tilt_of_a_stage():
    for stage, part in ((None, 0.8), ("dig", 1.0)):
        slides = np.degrees(np.arctan(part * np.tan(np.radians(FRICTION)))) - DIP
        assert limit_tilt(cliff(), stage=stage, clockwise=True) == pytest.approx(slides, abs=1e-4)


def test_gravity_loads_and_bolts_of_a_stage_are_there():
    """An earthquake that the block does not carry, then a load up the plane that it carries with it, then a bolt."""
    model = cliff()
    quake = bsm.Stage(name="quake", gravity=(-0.3, 0.0))
    up = 1e4 * np.array([np.cos(np.radians(DIP)), np.sin(np.radians(DIP))])
    held = bsm.Stage(
        name="held", loads=[bsm.PointLoad(block=2, point=tuple(turned(np.array([[0.0, 0.25]]), DIP)[0]), force=up)]
    )
    model = model.replace(stages=[model.stages[0], quake, held])
    assert bsm.limit_analysis(model, stage="dig").admissible
    assert not bsm.limit_analysis(model, stage="quake").admissible
    across = np.array([-np.sin(np.radians(DIP)), np.cos(np.radians(DIP))])
    bolt = bsm.Bolt(
        start=tuple(0.25 * across),
        end=tuple(-3 * across),
        kind="end_anchored",
        diameter=0.05,
        young=200e9,
        yield_strength=500e6,
        stage="held",
    )
    for changed in (model, model.replace(stages=[*model.stages[:2], bsm.Stage(name="held")], bolts=[bolt])):
        assert bsm.limit_analysis(changed).admissible


@pytest.mark.parametrize("ask", [bsm.limit_analysis, strength_limit, limit_tilt])
def test_what_statics_cannot_tell_is_refused(ask):
    with pytest.raises(bsm.ModelError, match="there is no stage 'digg'; did you mean 'dig'"):
        ask(cliff(), stage="digg")
    relaxed = cliff().replace(stages=[bsm.Stage(name="dig", excavate=[1], relaxation=[0.5])])
    with pytest.raises(bsm.ModelError, match="'dig' holds part of the excavation forces"):
        ask(relaxed)


STAGE = '\n[[stage]]\nname = "steep"\ngravity = {horizontal = -0.9}\n'


def test_the_command_names_the_stage(case: Case) -> None:
    """The blocks, friction 35, slide under .9 of their weight to the side."""
    text = (case.folder / "model.toml").read_text().replace('pressure = "1 MPa"', 'pressure = "1 Pa"')
    case.write("model.toml", text + STAGE)
    told = {
        stage: json.loads(case.run("limit", "model.toml", *words, "--json").out)
        for stage, words in (("steep", ()), ("initial", ("--stage", "initial")))
    }
    assert {stage: (each["stage"], each["admissible"]) for stage, each in told.items()} == {
        "steep": ("steep", False),
        "initial": ("initial", True),
    }
    assert "in stage steep" in told["steep"]["notes"][-1]
    assert read_vtu(case.folder / told["steep"]["file"]).cell_data["block_id"].tolist() == [0, 1, 2, 3]
    outcome = case.run("limit", "model.toml", "--strength")
    assert "stage" in outcome.out
    assert "steep" in outcome.out
    case.refuses("limit", "model.toml", "--stage", "step", says=["there is no stage 'step'; did you mean 'steep'"])


@pytest.mark.parametrize(("kind", "left"), [("grouted", 1), ("end_anchored", 0)])
def test_excavation_cuts_a_bolt(kind, left):
    """A bolt from the held block through the sliding one into the ground ends in the void once that is excavated."""
    start, end = turned(np.array([[-2.0, 0.45], [1.0, -0.5]]), DIP)
    model = cliff().replace(bolts=[bsm.Bolt(start=tuple(start), end=tuple(end), diameter=0.025, kind=kind)])
    before, after = (in_stage(model, stage)[1].model.bolts for stage in ("initial", "rain"))
    assert before == tuple(model.bolts)
    assert len(after) == left
    stronger = strength_limit(model).factor > strength_limit(cliff()).factor + 0.01
    assert stronger == bool(left)
    if left:
        assert turned(np.array([after[0].start]), -DIP)[0, 0] == pytest.approx(-1)
        assert after[0].end == tuple(end)
