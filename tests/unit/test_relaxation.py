"""Dynamic relaxation: it ends where statics says, keeps what slipped and broke, and gives up where blocks slide on."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from step_scenes import CONTINUATION, WEIGHT, begun, block_on_a_base

import bsm_mesh as bsm
from bsm_mesh.solve.continuation import first_step, strategies
from bsm_mesh.solve.continuation import loop as continuation
from bsm_mesh.solve.methods import smoothing_path
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.motion import relaxation, sliding
from bsm_mesh.solve.motion.damped_motion import DampedMotion
from bsm_mesh.solve.motion.relaxation import damp_to_rest, relax
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Step

benchmarks = pytest.importorskip("benchmarks.scenes")


def test_where_nothing_slips_or_opens_it_ends_where_newtons_method_does():
    step = begun(benchmarks.tilted_wall(100, tilt=0.0).model())
    exact = newton(step, step.start, 1e-9, from_rest=True)
    assert exact.converged
    rest = relax(step, 1e-9)
    assert_allclose(rest.start, exact.position, atol=1e-3 * np.abs(exact.position).max())


def test_a_block_that_sticks_comes_to_rest_where_its_springs_balance_its_weight():
    rest = relax(begun(block_on_a_base(20.0)), 1e-9)
    along, down = np.sin(np.radians(20.0)), np.cos(np.radians(20.0))
    at = rest.evaluate(rest.start)
    assert_allclose(at.pressure.sum(), WEIGHT * down, rtol=1e-6)
    assert_allclose(np.abs(at.shear).sum(), WEIGHT * along, rtol=1e-6)


def test_a_block_that_slides_on_keeps_its_velocity():
    """Its movement in another cycle; contacts are as they are where it has come to."""
    step = begun(block_on_a_base(40.0))
    on = relax(step, 1e-6)
    velocity, gone = on.velocity[1, 0], on.start[1, 0] - step.start[1, 0]
    assert 0 < 50 * velocity < gone
    assert abs(on.velocity[1, 1]) < 1e-6 * velocity
    assert on.contacts.old_tangential == pytest.approx(on.evaluate(on.start).tangential, abs=1e-12)
    assert step.velocity is None


def test_many_blocks_that_slide_on_are_followed_with_the_velocity_that_they_have_come_to(monkeypatch):
    """No ramp is run through again. Of few blocks implicit steps tell what becomes of them."""
    model = benchmarks.jointed_slope(300, friction=25.0).model()
    begun_with, slid = [], sliding.follow_dynamically
    monkeypatch.setattr(
        strategies, "follow_dynamically", lambda step, *given: begun_with.append(step.velocity) or slid(step, *given)
    )
    assert bsm.run(model, CONTINUATION).status == "unstable"
    assert begun_with
    assert not any(velocity is None for velocity in begun_with)
    step = begun(model)
    sliding_on, found = first_step.relaxed_step(step, 1e-6)
    assert found.converged
    assert found.velocity is sliding_on.velocity
    assert found.position is sliding_on.start
    monkeypatch.setattr(sliding, "MIN_BLOCKS", len(step.start) + 1)
    assert first_step.relaxed_step(step, 1e-6) is None


def test_blocks_rest_within_their_strength_and_in_equilibrium():
    step = begun(benchmarks.leaning_slope(1000, friction=32.0).model())
    given = step.contacts
    rest = relax(step, 5e-7)
    at, left = rest.evaluate(rest.start), rest.residual_at(rest.start)
    assert rest.is_localized(left, relaxation.REFINED[-1])
    assert (at.pressure[at.closed] > 0).all()
    assert (np.abs(at.shear) <= at.strength * (1 + 1e-12)).all()
    slipped = np.abs(at.tangential - rest.contacts.first_tangential)[at.closed]
    elastic = (np.abs(at.shear) / rest.contacts.shear_stiffness)[at.closed]
    assert (slipped > 2 * elastic).sum() > 100
    assert step.contacts is given  # nothing is done to the step it began with


def test_it_is_the_same_every_time():
    ends = [relax(begun(benchmarks.leaning_slope(300).model()), 1e-6).start for _ in range(2)]
    assert_array_equal(*ends)


def test_damping_and_ramp_decide_little(monkeypatch):
    """What the loads overshoot shrinks with the ramp; what is left of it is worth a few parts of a hundred."""
    model = benchmarks.leaning_slope(1000, friction=32.0).model(1.0)

    def settlement():
        return -relax(in_situ(model), 5e-7).start[:, 1].sum()

    usual = settlement()
    monkeypatch.setattr(relaxation, "DAMPING", 0.8)
    assert_allclose(settlement(), usual, rtol=0.04)
    monkeypatch.undo()
    monkeypatch.setattr(relaxation, "RAMP_TRANSITS", 80.0)
    assert_allclose(settlement(), usual, rtol=0.04)
    path = -bsm.run(model, CONTINUATION).stages[-1].displacement[:, 1].sum()  # followed from the start in one step
    assert_allclose(settlement(), path, rtol=0.04)


def in_situ(model: bsm.Model) -> Step:
    """Return the first step from the in-situ stress."""
    steps = []

    def begin(step, *_, **__):
        steps.append(step)
        raise StopIteration

    with pytest.MonkeyPatch.context() as patch, suppress(StopIteration):
        patch.setattr(continuation, "first_step", begin)
        bsm.run(model, CONTINUATION)
    return steps[0]


def test_supports_hold_what_they_hold_and_leave_the_rest_free():
    """A block on a plane of rollers at 60 degrees, pushed by its weight along it onto a smooth wall.

    The rollers bear R with R sin 60 = W cos 30, the wall W sin 30 + R cos 60: both are W.
    """
    beside = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)], [(1, 0), (2, 0), (2, 1), (1, 1)]], rock="r")
    corners = [(2.0, 0.0), (2.0, 1.0)]
    model = block_on_a_base(
        -30.0,
        blocks=beside,
        law=bsm.MohrCoulomb(friction=0),
        supports=[bsm.Fixed(blocks=[0]), *(bsm.Roller(point=corner, direction=120.0) for corner in corners)],
    )
    rest = relax(begun(model), 1e-9)
    assert_allclose(rest.evaluate(rest.start).pressure.sum(), WEIGHT, rtol=1e-6)
    u, v, turn = rest.start[1]
    assert_allclose([u * np.cos(np.radians(120)) + v * np.sin(np.radians(120)), turn], 0, atol=1e-15)
    assert u < -1e-6


def test_a_support_that_couples_moving_and_turning_holds_its_point():
    """A block on a tilted base, held at a corner along an inclined line: it ends where Newton's method does."""
    angle = np.radians(30.0)
    supports = [bsm.Fixed(blocks=[0]), bsm.Roller(point=(2.0, 2.0), direction=30.0)]
    step = begun(block_on_a_base(20.0, supports=supports))
    exact = newton(step, step.start, 1e-10, from_rest=True)
    rest = relax(step, 1e-10)
    assert_allclose(rest.start, exact.position, rtol=1e-4, atol=1e-11)
    u, v, turn = rest.start[1]  # the corner lies half a metre to the right of the centroid and above it
    assert_allclose((u - 0.5 * turn) * np.cos(angle) + (v + 0.5 * turn) * np.sin(angle), 0, atol=1e-9)


def test_what_broke_stays_broken():
    """A block glued to a ceiling: it hangs, or its glue fails under the weight and it falls."""
    ceiling = bsm.Blocks.from_polygons([[(0, 1), (4, 1), (4, 2), (0, 2)], [(1, 0), (2, 0), (2, 1), (1, 1)]], rock="r")
    glue = bsm.MohrCoulomb(friction=35, cohesion=1e6)
    hanging = relax(begun(block_on_a_base(blocks=ceiling, law=glue, tension=2 * WEIGHT)), 1e-9)
    at = hanging.evaluate(hanging.start)
    assert_allclose(at.pressure.sum(), -WEIGHT, rtol=1e-6)
    assert relax(begun(block_on_a_base(blocks=ceiling, law=glue, tension=0.5 * WEIGHT)), 1e-9).velocity is not None


def test_cohesion_that_failed_is_gone():
    """On a slope of 30 degrees with 25 of friction cohesion holds the block, or fails and is gone."""
    holds = WEIGHT * (np.sin(np.radians(30)) - np.cos(np.radians(30)) * np.tan(np.radians(25)))
    for part, rests in ((6.0, True), (0.8, False)):
        law = bsm.MohrCoulomb(friction=25, cohesion=part * holds)
        rest = relax(begun(block_on_a_base(30.0, law=law)), 1e-6)
        assert (rest.velocity is None and rest.residual_at(rest.start).max_norm < 1e-6) is rests


def test_cohesion_is_gone_where_blocks_slipped():
    model = benchmarks.leaning_slope(300, friction=30.0).model()
    law = bsm.MohrCoulomb(friction=30, cohesion=1e3)
    rest = relax(begun(model.replace(joints=(replace(model.joints[0], law=law),))), 1e-6)
    contacts, at = rest.contacts, rest.evaluate(rest.start)
    slid = np.abs(at.tangential - contacts.first_tangential) > 5 * np.abs(at.shear) / contacts.shear_stiffness + 1e-6
    assert (slid & at.closed).sum() > 20
    assert contacts.failed[slid & at.closed].all()
    assert not contacts.failed[at.closed].all()


def test_cycles_are_stable_with_smaller_masses(monkeypatch):
    """With nine tenths of them blocks still come to rest; with a third waves grow."""
    model = benchmarks.leaning_slope(300).model()
    masses = DampedMotion._mass
    monkeypatch.setattr(DampedMotion, "_mass", lambda *given: 0.9 * masses(*given))
    assert relax(begun(model), 1e-6) is not None
    monkeypatch.setattr(DampedMotion, "_mass", lambda *given: masses(*given) / 3)
    assert relax(begun(model), 1e-6) is None


def test_with_bolts_it_does_not_begin():
    model = block_on_a_base(20.0)
    bolt = bsm.Bolt(start=(1.5, 1.8), end=(1.5, 0.2), diameter=0.025)
    step = begun(model.replace(bolts=(bolt,)))
    assert relax(step, 1e-6) is None
    assert damp_to_rest(step, step.start, 1e9) is None


def test_a_slow_path_is_left_for_it(monkeypatch):
    model = benchmarks.leaning_slope(1000).model(1.0)
    path = bsm.run(model, CONTINUATION)
    monkeypatch.setattr(smoothing_path, "PATIENCE", 0)
    relaxed = bsm.run(model, CONTINUATION)
    assert relaxed.stages[-1].status == "stable"
    assert relaxed.check().ok
    assert sum(s.factorizations for s in relaxed.stages[-1].steps) < sum(
        s.factorizations for s in path.stages[-1].steps
    )
    moved = [np.abs(run.stages[-1].displacement[:, :2]).max() for run in (path, relaxed)]
    assert_allclose(moved[1], moved[0], rtol=0.05)


def test_what_newton_does_not_end_is_taken_only_where_all_but_few_blocks_rest(monkeypatch):
    """A support may go on moving where relaxed blocks rest: then nothing of it is at rest."""
    step = begun(block_on_a_base())
    rest = relax(step, 1e-9)

    def gives_up(step, position, *_):
        return Attempt(position, step.evaluate(position), converged=False)

    monkeypatch.setattr(first_step, "regularized_newton", gives_up)
    for relaxed, taken in ((step, False), (rest, True)):
        monkeypatch.setattr(first_step, "relax", lambda *_, found=relaxed: found)
        assert (first_step.relaxed_step(step, 1e-6) is not None) is taken


def test_contacts_are_searched_once_at_a_position(monkeypatch):
    step, searched = begun(benchmarks.leaning_slope(300).model()), []
    gather = step.system.gather

    def watched(history, position, *, first):
        searched.append(position)
        return gather(history, position, first=first)

    monkeypatch.setattr(step.system, "gather", watched)
    rest = relax(step, 1e-6)
    assert searched[-1] is rest.start
    assert len({id(position) for position in searched}) == len(searched)


def test_no_block_is_lighter_than_is_asked():
    """A brick on one corner has less than half of the mean mass."""
    step = begun(benchmarks.tilted_wall(100, tilt=0.0).model())
    masses = {}
    for lightest in (0.0, 0.5):
        relaxation = DampedMotion(step, 1, 0.5, lightest=lightest)
        relaxation.advance(1)
        masses[lightest] = relaxation.least_mass
    free = ~step.system.outlines.fixed
    floor = 0.5 * masses[0.0][free].mean(axis=0)
    assert (masses[0.0][free] < floor).any()
    assert_allclose(masses[0.5], np.maximum(masses[0.0], floor), rtol=1e-12)
