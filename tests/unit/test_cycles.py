"""Cycles that threads share: the same to the last digit, however many there are."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from step_scenes import WEIGHT, begun, block_on_a_base

import bsm_mesh as bsm
from bsm_mesh.solve.motion import cycles
from bsm_mesh.solve.motion.cycles import blocks_in_order
from bsm_mesh.solve.motion.damped_motion import DampedMotion
from bsm_mesh.solve.step.equations import Step

benchmarks = pytest.importorskip("benchmarks.scenes")


def slope_with_rollers() -> bsm.Model:
    """Return a slope of which some blocks near its middle may move along a line only."""
    model = benchmarks.jointed_slope(300, friction=25.0).model()
    centroid = model.blocks.moments.centroid
    near = np.argsort(np.hypot(*(centroid - centroid.mean(axis=0)).T))[:5]
    rollers = [bsm.Roller(point=tuple(centroid[block]), direction=60.0) for block in near]
    return model.replace(supports=(*model.supports, *rollers))


def after_cycles(step: Step, threads: int, monkeypatch: pytest.MonkeyPatch) -> DampedMotion:
    """Return the motion after thrice 30 cycles, shared out however few contacts there are."""
    monkeypatch.setattr(cycles, "WORTH_A_THREAD", 1)
    shared = SimpleNamespace(options=SimpleNamespace(threads=threads), pattern_of=step.factors.pattern_of)
    monkeypatch.setattr(step, "factors", shared)
    motion = DampedMotion(step, 20, 0.2)
    for _ in range(3):
        motion.advance(30)
    return motion


def test_no_digit_depends_on_the_number_of_threads(monkeypatch):
    step = begun(slope_with_rollers())
    alone = after_cycles(step, 1, monkeypatch)
    on_rollers = step.supports.block[step.supports.constrained == 1]
    assert np.abs(alone.velocity[on_rollers]).max() > 0
    for threads in (2, 3, 7):
        shared = after_cycles(step, threads, monkeypatch)
        assert_array_equal(shared.residual.position, alone.residual.position)
        assert_array_equal(shared.velocity, alone.velocity)
        assert_array_equal(shared.contacts.old_shear, alone.contacts.old_shear)
        assert_array_equal(shared.contacted, alone.contacted)


@pytest.mark.parametrize(("worth", "cores", "used"), [(1, 3, [3]), (10**6, 3, []), (300, 64, [4])])
def test_threads_are_as_many_as_there_are_cores_and_work(monkeypatch, worth, cores, used):
    step, shares = begun(benchmarks.jointed_slope(300, friction=25.0).model()), []
    share_out = cycles._run_in_strips
    monkeypatch.setattr(cycles, "_run_in_strips", lambda *given: shares.append(len(given[3])) or share_out(*given))
    monkeypatch.setattr(cycles.os, "cpu_count", lambda: cores)
    monkeypatch.setattr(cycles, "WORTH_A_THREAD", worth)
    DampedMotion(step, 20, 0.2).advance(2)
    assert shares == used


def test_strips_lie_across_the_longer_side():
    centroid = np.array([(0.0, 2.0), (1.0, 0.0), (0.5, 3.0), (0.2, 1.0)])
    assert_array_equal(blocks_in_order(centroid), [1, 3, 0, 2])
    assert_array_equal(blocks_in_order(centroid[:, ::-1]), [1, 3, 0, 2])


def test_tensile_strength_lost_within_cycles_stays_lost_though_the_contact_closes_again():
    """A block is thrown off its base, and lands within the same cycles."""
    step, landed = begun(block_on_a_base(law=bsm.MohrCoulomb(friction=30, cohesion=1e9), tension=1.0)), 0
    for count in range(40, 60):
        motion = DampedMotion(step, 1, 0.5)
        motion.advance(1)
        motion.velocity[1, 1] = 15 * WEIGHT / motion.least_mass[1, 1]
        motion.advance(count)
        if motion.residual.at.closed.all():
            landed += 1
            assert motion.contacts.failed.all()
            assert not motion.contacts.tension.any()
    assert landed
