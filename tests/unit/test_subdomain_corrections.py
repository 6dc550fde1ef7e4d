"""Subdomain corrections after an excavation move the influence region alone, where it is small."""

from dataclasses import replace

import numpy as np
import pytest

from bsm_mesh.solve.methods import subdomain_newton as subdomain
from bsm_mesh.solve.methods.corrections import line_search, newton_correction, tangent_regularization
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.methods.subdomain_newton import subdomain_correction
from bsm_mesh.solve.step.attempt import Outcome
from bsm_mesh.solve.step.equations import StepEquations
from tests.scenes.steps import wall_at_rest

TOLERANCE, BLOCK, LAYERS = 5e-7, 400, 5


@pytest.fixture(scope="module")
def rest() -> tuple[StepEquations, np.ndarray]:
    return wall_at_rest(TOLERANCE)


@pytest.fixture
def near(monkeypatch) -> None:
    """Let fewer blocks around the worst count as far around: those of a small wall are few of all then."""
    monkeypatch.setattr(subdomain, "SETTINGS", replace(subdomain.SETTINGS, layers=LAYERS))


def pushed_from(position: np.ndarray) -> np.ndarray:
    pushed = position.copy()
    pushed[BLOCK, :2] += 2e-6
    return pushed


def test_a_subdomain_correction_moves_only_the_influence_region(rest, near):
    step, position = rest
    pushed, factorized = pushed_from(position), step.factors.count
    found = subdomain_correction(step, pushed)
    assert found is not None
    moved = np.flatnonzero((found != pushed).any(axis=1))
    away = np.hypot(*(step.system.outlines.centroid - step.system.outlines.centroid[BLOCK]).T)
    assert away[moved].max() < 1.2 * (LAYERS + 2)
    assert step.factors.count == factorized
    here = step.residual_at(pushed)
    correction = newton_correction(step, here, tangent_regularization(here.max_norm))
    whole = line_search(step, here, correction, here.l2_norm).position
    left, together = (step.residual_at(there).l2_norm for there in (found, whole))
    assert left == pytest.approx(together, rel=0.1)
    assert left < 0.5 * step.residual_at(pushed).l2_norm
    assert np.abs(found - whole).max() < 0.05 * np.abs(whole - pushed).max()


def test_where_the_influence_region_is_large_there_is_no_subdomain_correction(rest):
    step, position = rest
    assert subdomain_correction(step, pushed_from(position)) is None


def test_where_every_block_has_a_residual_there_is_none_either(rest, near):
    step, position = rest
    assert subdomain_correction(step, position + 1e-6 * np.random.default_rng(0).normal(size=position.shape)) is None


@pytest.mark.parametrize("localized", [False, True])
def test_localized_or_not_the_end_is_the_same(rest, near, localized):
    """Two blocks are set out of place."""
    step, position = rest
    pushed = position.copy()
    pushed[[BLOCK, BLOCK + 1], :2] += 2e-6
    found = newton(step, pushed, TOLERANCE, localized=localized)
    assert found.outcome is Outcome.SOLVED
    assert step.residual_at(found.position).max_norm < TOLERANCE
    np.testing.assert_allclose(found.position, position, rtol=0, atol=1e-9)
