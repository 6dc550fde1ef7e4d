"""Blocks that are followed: how far a step goes, what is fast, supports that move."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.following import FREE, FollowMotion, accelerates, is_fast
from bsm_mesh.solve.step.attempt import Goal, Iterate, Outcome
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.scenes.steps import begun, still

BASE, BLOCK = rectangle(-20, -1, 20, 0), rectangle(-0.5, 0, 0.5, 1)
GOAL = Goal(max_residual=1e-4, rest=1e-6)
BOLT = bsm.Bolt(start=(0.0, 0.9), end=(0.0, -0.5), kind="end_anchored", diameter=0.025, young=2e11)


def sliding(**given) -> bsm.Model:
    return model_of([turned(p, 45.0) for p in (BASE, BLOCK)], friction=20.0, **given)


def test_a_step_ends_after_a_step_length_with_the_velocity_of_the_slide():
    step = begun(sliding())
    found = FollowMotion().solve(step, Iterate(residual=1.0, velocity=still(2), moving_steps=9), GOAL)
    moved = np.hypot(*found.position[1, :2])
    assert found.outcome is Outcome.ACCEPTABLE
    assert step.system.d <= moved < 1.3 * step.system.d
    wanted = 2 * moved * (np.sin(np.pi / 4) - np.cos(np.pi / 4) * np.tan(np.radians(20)))
    assert (found.velocity[1, :2] ** 2).sum() == pytest.approx(wanted, rel=0.15)  # lightly damped
    assert not found.position[0].any()


@pytest.mark.parametrize(("speed", "fast"), [(0.0, False), (1e-4, False), (1.0, True)])
def test_fast_is_what_moves_by_a_step_length_in_a_step(speed, fast):
    at = Iterate(residual=1.0, velocity=still(2, b1=(speed, 0.0, 0.0)))
    assert is_fast(begun(sliding()), at) is fast


@pytest.mark.parametrize(("speed", "on"), [(1e-4, True), (-1e-4, False)])
def test_blocks_accelerate_where_forces_act_along_their_movement(speed, on):
    """Down a plane of 45 degrees, friction 20; blocks at rest do not."""
    step = begun(sliding())
    assert accelerates(step, Iterate(residual=1.0, velocity=still(2, b1=(-speed, -speed, 0.0)))) is on
    assert not accelerates(step, Iterate(residual=1.0))


def test_a_fall_takes_no_more_cycles_where_a_third_of_the_blocks_weighs_nothing():
    """Their own masses would ask for many times as many: they have larger ones."""
    polygons = [BASE, *(rectangle(2 * k, 0, 2 * k + 1, 1) for k in range(-4, 5))]
    model = model_of(polygons, kn=1e11)
    rocks = [*model.rocks, bsm.Rock("foam", unit_weight=0.0)]
    blocks = bsm.Blocks.from_polygons(polygons, rock=["rock"] * 7 + ["foam"] * 3)
    cycles = [ExplicitMotion(begun(m), FREE).fall_cycles for m in (model, model.replace(blocks=blocks, rocks=rocks))]
    assert cycles[1] == pytest.approx(cycles[0], rel=0.01)


def test_what_is_at_rest_is_not_fast():
    assert not is_fast(begun(sliding()), Iterate(residual=1.0))


def test_moving_supports_arrive_and_take_their_blocks_along():
    sinks = [
        bsm.PrescribedDisplacement(blocks=[0], direction=90.0, displacement=-0.2),
        bsm.Roller(blocks=[0], direction=0.0),
    ]
    model = model_of([BASE, BLOCK], supports=sinks)
    step = begun(model)
    assert step.supports_move
    found = FollowMotion().solve(step, Iterate(residual=1.0), GOAL)
    np.testing.assert_allclose(found.position[0, 1], step.start[0, 1], atol=1e-9)
    stage = bsm.run(model).stages[-1]
    assert stage.status == "stable"
    np.testing.assert_allclose(stage.displacement[:, 1], -0.2, atol=1e-3)


@pytest.mark.parametrize("bolts", [[], [BOLT]])
def test_a_bolted_model_is_followed_too(bolts):
    step = begun(model_of([BASE, BLOCK], bolts=bolts))
    before = step.system.bolts
    velocity = still(2, b1=(0.0, 1.0, 0.0))
    found = FollowMotion().solve(step, Iterate(residual=1.0, velocity=velocity, moving_steps=9), GOAL)
    assert found.outcome is Outcome.ACCEPTABLE
    assert step.system.bolts is before
    thrown = 1.0**2 - 2 * found.position[1, 1]  # square of the velocity of a free flight
    assert (found.velocity[1, 1] ** 2 < 0.5 * thrown) == bool(bolts)
