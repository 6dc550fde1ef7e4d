"""The continuation over scenes: verdicts, blocks named, methods handing over, models turned and renumbered."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.continuation.plan import PLANS, Phase
from bsm_mesh.solve.methods.newton import ExactNewton
from bsm_mesh.solve.motion.following import FollowMotion
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, running_bond, turned

BASE = rectangle(-4, -1, 8, 0)


def ended(polygons, *, turn=0.0, **given):
    options = bsm.Options(max_steps=given.pop("max_steps", 300))
    return bsm.run(model_of([turned(p, turn) for p in polygons], **given), options).stages[-1]


def on_a_slope():
    return [BASE, rectangle(0, 0, 1, 1), rectangle(3, 0, 4, 1)]


@pytest.mark.heavy
@pytest.mark.parametrize(("slope", "status"), [(30.0, "stable"), (40.0, "unstable")])
def test_blocks_slide_where_friction_does_not_hold_them(slope, status):
    stage = ended(on_a_slope(), turn=slope)
    assert stage.status == status
    assert set(stage.unstable_blocks) <= {1, 2}
    assert bool(len(stage.unstable_blocks)) == (status == "unstable")


def test_only_the_blocks_that_move_are_named():
    """Block 1 is on the flat, block 2 on nothing."""
    stage = ended([BASE, rectangle(0, 0, 1, 1), rectangle(8.0, -0.5, 9.0, 0.5)])
    assert stage.status == "unstable"
    assert list(stage.unstable_blocks) == [2]


def test_a_run_that_has_no_steps_left_says_so():
    stage = ended(on_a_slope(), turn=40.0, max_steps=3)
    assert stage.status == "not_converged"
    assert "limit of 3 steps" in stage.reason


@pytest.mark.heavy
@pytest.mark.parametrize("slope", [30.0, 40.0])
def test_explicit_motion_to_the_end_gives_the_same_verdict(monkeypatch, slope):
    wanted = ended(on_a_slope(), turn=slope)
    for phase in (Phase.START, Phase.AFTER_CHANGE):
        monkeypatch.setitem(PLANS, phase, (FollowMotion(),))
    monkeypatch.setitem(PLANS, Phase.NEAR_REST, (ExactNewton(), FollowMotion()))  # which confirms that blocks rest
    found = ended(on_a_slope(), turn=slope)
    assert found.status == wanted.status
    assert list(found.unstable_blocks) == list(wanted.unstable_blocks)


@pytest.mark.heavy
@pytest.mark.parametrize("slope", [20.0, 40.0])
def test_a_mirrored_and_a_renumbered_wall_have_its_verdict(slope):
    wall = [rectangle(-1, -0.5, 6, 0), *running_bond(4, 5)]
    given = ended(wall, turn=slope)
    mirrored = ended([(p * (-1, 1))[::-1] for p in wall], turn=-slope)
    order = np.random.default_rng(0).permutation(len(wall))
    renumbered = ended([wall[k] for k in order], turn=slope, fixed=(int(np.flatnonzero(order == 0)[0]),))
    assert given.status == mirrored.status == renumbered.status == ("stable" if slope == 20.0 else "unstable")
    if given.status == "stable":
        np.testing.assert_allclose(mirrored.displacement[:, 1], given.displacement[:, 1], atol=1e-9)
        np.testing.assert_allclose(renumbered.displacement, given.displacement[order], atol=1e-9)


class Asked:
    """A method that keeps what it is asked, and leaves the step to the next."""

    name = "asked"

    def __init__(self):
        self.goals = []

    def applies(self, equations, at, goal):
        self.goals.append((at.velocity is not None, at.residual, goal))
        return False


@pytest.mark.heavy
def test_velocities_end_in_an_equilibrium_within_the_tolerance_only(monkeypatch):
    """Solved to a part of its residual, a step would stop what slides slowly."""
    asked = Asked()
    for phase in Phase:
        monkeypatch.setitem(PLANS, phase, (asked, *PLANS[phase]))
    assert ended([BASE, rectangle(0, 0, 1, 1), rectangle(0.6, 1.02, 1.6, 2.02)]).status == "stable"
    moving = [(residual, goal) for moves, residual, goal in asked.goals if moves]
    assert max(residual / goal.rest for residual, goal in moving) > 1e3, "or nothing was tried"
    assert all(goal.max_residual <= goal.rest for _, goal in moving)
    assert any(goal.max_residual > goal.rest for moves, _, goal in asked.goals if not moves)
