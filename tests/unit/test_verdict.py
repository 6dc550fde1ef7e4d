"""Collapse criterion: loaded blocks without contact, twice, that moved far enough; else too large displacements."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.contact.history import History
from bsm_mesh.solve.continuation.verdict import CollapseCriterion
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

FREE_MOVE, INSIDE = 0.1, 0.05  # of a block's size, of its area
FAR, NEAR = 2.0 * FREE_MOVE, 0.5 * FREE_MOVE  # of a block's size, 1 m


def watch(heights, limit=100.0, **given):
    """Return the text after steps in which a square lies a height above its base."""
    moving = BlockSystem(model_of([rectangle(-2, -1, 2, 0), rectangle(-0.5, 0, 0.5, 1)], **given))
    falling = CollapseCriterion(moving, moving.start, limit, bsm.Falls())
    said = []
    for height in heights:
        above, position = (np.array([(0, 0, 0), (0, at, 0)]) for at in (max(height, 0.0), height))
        contacts = moving.gather(History.none(), above, first=False)
        said.append(falling.check(contacts, moving.evaluate(contacts, position).closed, position))
    return said


@pytest.mark.parametrize(
    ("heights", "comes_down"),
    [
        ([FAR], False),  # one step may jump off
        ([FAR, 0.0, FAR], False),  # and land
        ([FAR, FAR], True),
        ([0.0, NEAR, FAR], True),
        ([NEAR, NEAR, NEAR], False),  # it has hardly moved since it was detached
    ],
)
def test_a_block_comes_down_that_is_free_after_two_steps_and_has_moved(heights, comes_down):
    pressed = [-1e-5 if height == 0.0 else height for height in heights]
    *before, collapse = watch(pressed)
    assert not any(before)
    assert (collapse is not None) == comes_down
    if collapse:
        assert collapse.reason == "a block has lost all contact and moves freely"
        assert_array_equal(collapse.down, [1])
        assert_array_equal(collapse.small, [False])


def test_a_small_block_is_free_once_it_has_moved_as_a_block_of_mean_size_would():
    """A chip of a tenth of its neighbour's width, above the base and beside it; the second time it is free."""
    moving = BlockSystem(model_of([rectangle(-2, -1, 2, 0), rectangle(-0.5, 0, 0.5, 1), rectangle(0.7, 0, 0.8, 0.1)]))
    far = FREE_MOVE * np.sqrt((1 + 0.01) / 2)
    for height, comes_down in ((0.95 * far, False), (1.05 * far, True)):
        falling = CollapseCriterion(moving, moving.start, 100.0, bsm.Falls())
        position = np.array([(0, 0, 0), (0, -1e-5, 0), (0, height, 0)])
        contacts = moving.gather(History.none(), np.maximum(position, 0.0), first=False)
        closed = moving.evaluate(contacts, position).closed
        assert falling.check(contacts, closed, position) is None
        collapse = falling.check(contacts, closed, position)
        assert ([2] if comes_down else None) == (None if collapse is None else list(collapse.down))


def test_a_block_without_any_load_does_not_come_down():
    assert watch([FAR, FAR], gamma=0.0)[-1] is None


def test_a_block_on_a_taut_bolt_does_not_come_down():
    bolt = bsm.Bolt(start=(0.0, 0.5), end=(0.0, -0.5), kind="end_anchored", diameter=0.025, young=2e11)
    assert watch([FAR, FAR], bolts=[bolt])[-1] is None


def test_a_block_that_has_moved_too_far_comes_down_at_once():
    collapse = watch([-1e-5, 0.5], limit=0.4)[-1]
    assert collapse.reason == "a block moved more than 0.4 m"
    assert_array_equal(collapse.down, [1])


def test_what_only_settles_in_the_first_step_does_not_come_down():
    squares = [rectangle(-0.5, 0, 0.5, 1), rectangle(2.5, 0, 3.5, 1)]
    moving = BlockSystem(model_of([rectangle(-2, -1, 5, 0), *squares]))
    falling = CollapseCriterion(moving, moving.start, 100.0, bsm.Falls())
    for height in (-1e-5, FAR, 2 * FAR):
        position = np.array([(0, 0, 0), (0.3, height, 0), (0.3, -1e-5, 0)])
        contacts = moving.gather(History.none(), np.maximum(position, 0.0), first=False)
        collapse = falling.check(contacts, moving.evaluate(contacts, position).closed, position)
    assert_array_equal(collapse.unstable, [1])


@pytest.mark.parametrize("steps", [4, 7])
def test_what_settles_in_the_first_half_of_few_steps_does_not_come_down(steps):
    squares = [rectangle(-0.5, 0, 0.5, 1), rectangle(2.5, 0, 3.5, 1)]
    moving = BlockSystem(model_of([rectangle(-2, -1, 5, 0), *squares]))
    falling = CollapseCriterion(moving, moving.start, 100.0, bsm.Falls())
    for step in range(1, steps + 1):
        height = max(-1e-5, (step + 2 - steps) * FAR)
        position = np.array([(0, 0, 0), (0, height, 0), (0.3 * min(step, steps // 2), -1e-5, 0)])
        contacts = moving.gather(History.none(), np.maximum(position, 0.0), first=False)
        collapse = falling.check(contacts, moving.evaluate(contacts, position).closed, position)
    assert_array_equal(collapse.unstable, [1])


@pytest.mark.parametrize(("deep", "free"), [(0.9 * INSIDE, True), (1.1 * INSIDE, False)])
def test_a_block_without_contact_inside_another_is_no_answer(deep, free):
    """A unit square, so that its depth is its share, that has slid along its base by more than makes it free."""
    moving = BlockSystem(model_of([rectangle(-2, -1, 2, 0), rectangle(-0.5, 0, 0.5, 1)]))
    falling = CollapseCriterion(moving, moving.start, 100.0, bsm.Falls())
    position = np.array([(0.0, 0.0, 0.0), (FAR, -deep, 0.0)])
    contacts = moving.gather(History.none(), moving.start, first=False)
    nothing_bears = np.zeros(contacts.count, dtype=bool)
    assert falling.check(contacts, nothing_bears, position) is None
    collapse = falling.check(contacts, nothing_bears, position)
    assert_array_equal(collapse.down, [1] if free else [])
    assert ("moves freely" in collapse.reason) == free
    assert ("at (0.2, 0.445) overlaps its neighbours by 0.055 of its area" in collapse.reason) == (not free)
    assert ("or a fill was placed where others are now" in collapse.reason) == (not free)


@pytest.mark.parametrize("scheme", ["continuation", "wang"])
@pytest.mark.parametrize(("kn", "status"), [(1e7, "stable"), (3e5, "not_converged")])
def test_a_block_that_stands_is_not_unstable_because_its_joints_are_soft(kn, status, scheme):
    """It closes them by five hundredths of its size: more than contacts are followed, less than is refused."""
    polygons = [turned(p, 40.0) for p in (rectangle(-30, -10, 30, 0), rectangle(-5, 0, 5, 10))]
    stage = bsm.run(model_of(polygons, kn=kn, friction=41.0, gamma=20e3), bsm.Options(scheme=scheme)).stages[-1]
    assert stage.status == status
    assert status == "stable" or scheme == "wang" or "too soft for the forces" in stage.reason


@pytest.mark.heavy
@pytest.mark.parametrize(("limit", "reason"), [(None, "moved by more than 3 times its size"), (20.0, "more than 20 m")])
def test_a_block_that_runs_on_is_followed_as_far_as_asked(limit, reason):
    """A unit square on a plane of 60 m that is steeper than its friction: nothing down there will stop it."""
    polygons = [turned(p, 40.0) for p in (rectangle(-60, -5, 5, 0), rectangle(-0.5, 0, 0.5, 1))]
    options = bsm.Options(scheme="continuation", displacement_limit=limit)
    stage = bsm.run(model_of(polygons, friction=20.0), options).stages[-1]
    assert (stage.status, list(stage.unstable_blocks)) == ("unstable", [1])
    assert reason in stage.reason
    assert stage.max_displacement > (limit or 3.0)


@pytest.mark.heavy
def test_a_block_that_slides_far_and_lands_does_not_run_on():
    """The same with a wall in its way after four sizes."""
    polygons = [
        turned(p, 25.0) for p in (rectangle(-10, -5, 5, 0), rectangle(-10, 0, -4.5, 2), rectangle(-0.5, 0, 0.5, 1))
    ]
    model = model_of(polygons, friction=20.0, fixed=(0, 1))
    stage = bsm.run(model, bsm.Options(scheme="continuation", displacement_limit=100.0)).stages[-1]
    assert stage.status == "stable"
    assert stage.max_displacement == pytest.approx(4.0, abs=1e-2)


@pytest.mark.heavy
@pytest.mark.parametrize("half", [10.0, 1000.0, 3000.0])
def test_a_base_of_kilometres_hides_no_slide(half):
    """Residuals are over the weight of what may move: on a base of millions of m2 a block of one slides too."""
    polygons = [turned(p, 45.0) for p in (rectangle(-half, -half, half, 0), rectangle(-0.5, 0, 0.5, 1))]
    results = bsm.run(model_of(polygons, friction=20.0), bsm.Options(scheme="continuation"))
    assert (results.status, list(results.unstable_blocks)) == ("unstable", [1])
    assert results.stages[-1].reference_weight == pytest.approx(25e3, rel=0.1)
