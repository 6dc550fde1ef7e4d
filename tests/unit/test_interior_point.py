"""The interior point method: its smoothed laws, their limit, and that it finds what is there."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.contacts.history import History
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.solve.continuation.strategies import SWITCH_RESIDUAL
from bsm_mesh.solve.methods.interior_kernels import BONDED, LIMITED, mean_product, smoothed_pressure, smoothed_shear
from bsm_mesh.solve.methods.interior_point import interior_point
from bsm_mesh.solve.methods.newton import elastic_position, newton
from bsm_mesh.solve.step.equations import Step

KN, KS = 2e9, 1e9


def contacts_of(gap, trial, friction=0.6, tension=0.0, kind=LIMITED):
    """Return `now`, `spring` and `kind` of contacts with gaps and trial shears (m,)."""
    gap = np.asarray(gap, dtype=float)
    now = np.stack([gap, np.full_like(gap, trial), np.zeros_like(gap), np.full_like(gap, friction)])
    spring = np.stack([np.full_like(gap, KN), np.full_like(gap, KS), np.full_like(gap, tension)])
    return now, spring, np.full((2, len(gap)), kind, dtype=np.int8)


def smoothed(now, spring, kind, barrier):
    """Return the state with all products equal to `barrier`."""
    state = smoothed_pressure(now, spring, kind, barrier)
    now[2] = now[3] * np.maximum(state[0], 0.0)
    smoothed_shear(now, spring, kind, barrier, state)
    return state


@pytest.mark.parametrize("barrier", [1e-2, 1.0, 1e4])
def test_the_smoothed_state_has_the_products_it_is_made_for(barrier):
    now, spring, kind = contacts_of([-1e-3, -1e-6, 0.0, 1e-6, 1e-2], 3e4)
    state = smoothed(now, spring, kind, barrier)
    pressure, shear, opening, onwards, backwards = state
    assert_allclose(opening, now[0] + pressure / KN, atol=1e-12)
    assert_allclose(pressure * opening, barrier, rtol=1e-9)
    assert_allclose(onwards * (now[2] - shear), barrier, rtol=1e-6)
    assert_allclose(backwards * (now[2] + shear), barrier, rtol=1e-6)
    assert_allclose(now[1] - KS * (onwards - backwards), shear, atol=1e-4 * np.abs(now[1]).max())
    assert_allclose(mean_product(now, spring, kind, state, np.zeros_like(state), 0.0), barrier, rtol=1e-6)


def test_without_a_barrier_left_the_smoothed_state_is_the_law():
    gap = np.array([-1e-4, -1e-5, 1e-5])
    now, spring, kind = contacts_of(gap, 5e4)
    pressure, shear = smoothed(now, spring, kind, 1e-12)[:2]
    law = KN * np.maximum(-gap, 0.0)
    assert_allclose(pressure, law, atol=1e-3)
    assert_allclose(shear, np.minimum(5e4, 0.6 * law), atol=1.0)


def test_a_contact_without_a_limit_is_a_linear_spring():
    now, spring, kind = contacts_of([1e-4, -1e-4], -5e4, kind=BONDED)
    state = smoothed(now, spring, kind, 1.0)
    assert_allclose(state[0], -KN * now[0])
    assert_allclose(state[1], now[1])


def wall(tilt, courses=8, bricks=8):
    """Return a wall in running bond on a base, with the gravity `tilt` degrees from the vertical."""
    bed = [[(-1, -0.5), (bricks + 1, -0.5), (bricks + 1, 0), (-1, 0)]]
    for course in range(courses):
        ends = np.arange(bricks + 1.0)
        if course % 2:
            ends = np.concatenate([[0], np.arange(bricks) + 0.5, [bricks]])
        y = 0.5 * course
        bed += [[(a, y), (b, y), (b, y + 0.5), (a, y + 0.5)] for a, b in pairwise(ends)]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([np.array(p, dtype=float) for p in bed], rock="brick"),
        rocks=[bsm.Rock("brick", 25e3)],
        joints=[bsm.Joint("bed", 1e10, 1e10, law=bsm.MohrCoulomb(friction=35))],
        default_joint="bed",
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-90.0 + tilt,
    )


def first_step(model):
    """Return the continuation of a model and the step that looks for equilibrium at once."""
    engine = Continuation(model, bsm.Options(scheme="continuation"), lambda *record: None)
    contacts = engine.system.gather(History.none(), engine.system.start, first=True)
    return Step(engine.system, engine.factors, contacts, engine.system.start, engine.min_lam)


def test_it_ends_where_newton_can_take_over():
    step = first_step(wall(5.0))
    near = interior_point(step, elastic_position(step), SWITCH_RESIDUAL)
    assert near is not None
    forces = step.residual(near, step.evaluate(near).forces)
    assert step.residual_norms(forces, step.system.weight(step.evaluate(near)))[0] < SWITCH_RESIDUAL
    found = newton(step, near, 5e-7)
    assert found.converged
    assert step.factors.count < 20


def test_it_finds_nothing_where_nothing_is():
    """A wall on a slope steeper than its friction slides for ever."""
    step = first_step(wall(40.0))
    assert interior_point(step, elastic_position(step), SWITCH_RESIDUAL) is None
