"""How far the blocks of a step may go: two step lengths, and further together, from where the step starts."""

import numpy as np
import pytest

from bsm_mesh.contact.history import History
from bsm_mesh.solve.step.equations import StepEquations
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.steps import begun

ONE_STEP, TOGETHER = 2.0, 3.0  # step lengths: in any step; of neighbours, where blocks settle together


def moved(step: StepEquations, position: np.ndarray, by: float) -> np.ndarray:
    """Return a position from which the block, which lies on a base, has continued by so many step lengths."""
    there = position.copy()
    there[1, 0] += by * step.system.d
    return there


@pytest.fixture(params=[0.0, 2.0])
def step(request) -> StepEquations:
    """Return a step that starts where a block has come by so many step lengths."""
    first = begun(model_of([rectangle(-4, -1, 8, 0), rectangle(0, 0, 2, 1)]))
    anchor = moved(first, first.start, request.param)
    contacts = first.system.gather(History.none(), anchor, first=True)
    return StepEquations(first.system, first.factors, contacts, anchor, first.lam)


def test_a_block_may_go_two_step_lengths(step):
    assert step.within_search_range(moved(step, step.start, 0.99 * ONE_STEP))
    assert not step.within_search_range(moved(step, step.start, 1.01 * ONE_STEP))


@pytest.mark.parametrize("by", [1.01 * ONE_STEP, 0.99 * TOGETHER])
def test_it_may_go_as_far_as_it_settles_where_neighbours_hardly_move_apart(step, by):
    wider = step.allowing_settlement(moved(step, step.start, by))
    assert wider.max_movement == pytest.approx((ONE_STEP + by) * step.system.d)
    assert wider.within_search_range(moved(step, step.start, by))
    assert not wider.within_search_range(moved(step, step.start, 1.01 * TOGETHER))
    assert step.settlement_allowance == 0.0


@pytest.mark.parametrize("by", [0.99 * ONE_STEP, 1.01 * TOGETHER])
def test_no_farther_where_that_is_enough_or_neighbours_pass_each_other(step, by):
    assert step.allowing_settlement(moved(step, step.start, by)).max_movement == step.max_movement
