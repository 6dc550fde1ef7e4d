"""Dynamic relaxation: blocks reach rest in equilibrium, without overshooting; where there is none it says so."""

import numpy as np
import pytest

from bsm_mesh.solve.methods.nearby_equilibrium import NearbyEquilibrium
from bsm_mesh.solve.motion.dynamic_relaxation import SETTINGS, Decay, RelaxToRest
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.step.attempt import Attempt, Goal, Iterate, Outcome
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, running_bond, turned
from tests.scenes.steps import begun

AT_REST, GOAL = Iterate(residual=1.0), Goal(max_residual=1e-4, rest=1e-6)


def relaxed(polygons, turn=0.0, **given) -> Attempt:
    return RelaxToRest().solve(begun(model_of([turned(p, turn) for p in polygons], **given)), AT_REST, GOAL)


def column(height=6):
    return [rectangle(-2, -1, 3, 0), *(rectangle(0, y, 1, y + 1) for y in range(height))]


def wall():
    return [rectangle(-1, -0.5, 7, 0), *running_bond(6, 6)]


@pytest.mark.parametrize(("polygons", "turn"), [(column(), 0.0), (column(2), 12.0), (wall(), 0.0), (wall(), 10.0)])
def test_it_ends_at_rest_in_equilibrium(polygons, turn):
    found = relaxed(polygons, turn)
    assert found.outcome is Outcome.ACCEPTABLE
    assert found.velocity is None
    assert found.equations.residual_at(found.position).rms < 1e-3


def test_a_column_under_its_weight_slips_nowhere_and_is_compressed_by_it():
    found = relaxed(column())
    at = found.at
    assert at.sticking[at.closed].all()
    step = found.equations
    statics = NearbyEquilibrium().solve(begun(model_of(column())), AT_REST, Goal(max_residual=1e-9, rest=1e-9))
    assert statics.outcome is Outcome.SOLVED
    np.testing.assert_allclose(found.position, statics.position, rtol=0, atol=1e-3 * np.abs(statics.position).max())
    assert step.movement(found.position) < step.system.d


def test_contacts_are_searched_for_once_at_every_level_and_at_the_end(monkeypatch):
    """At the last level only, what moved would reach rest on old contacts first."""
    residuals, search = [], ExplicitMotion.search
    monkeypatch.setattr(ExplicitMotion, "search", lambda m: residuals.append(m.residual.rms) or search(m))
    relaxed(wall(), 10.0)
    first, *_, last = SETTINGS.levels
    assert last < residuals[0] < first
    assert len(residuals) == len(SETTINGS.levels) + 1


@pytest.mark.parametrize(
    ("polygons", "turn"), [([rectangle(-1, -1, 2, 0), rectangle(0, 0, 1, 1)], 50.0), (column(8), 20.0)]
)
def test_where_there_is_no_equilibrium_it_stalls(polygons, turn):
    assert relaxed(polygons, turn).outcome is Outcome.STALLED


def ends_after(energies, begins=20, period=10):
    """Return after how many cycles energies, one a cycle, have stalled; None: never."""
    decay = Decay(begins, period)
    ended = (cycle for cycle, energy in enumerate(energies, 1) if not decay.goes_on(cycle, energy))
    return next(ended, None)


CYCLES = np.arange(1, 400)


def test_energy_that_swings_while_it_falls_goes_on():
    assert ends_after((1 + 0.5 * np.sin(2 * np.pi * CYCLES / 3)) * np.exp(-CYCLES / 60)) is None


@pytest.mark.parametrize("energies", [np.ones(400), CYCLES])
def test_energy_that_does_not_fall_ends_after_two_periods(energies):
    assert ends_after(energies) == 40


def test_energy_counts_from_when_all_loads_act():
    """It rises while they come, and falls slowly from then on: to nine tenths in a period."""
    assert ends_after(np.where(CYCLES < 20, CYCLES**2, 400 * 0.9 ** (CYCLES / 10))) is None


def test_the_equations_asked_are_unchanged():
    step = begun(model_of(wall()))
    contacts, bolts, shear = step.contacts, step.system.bolts, step.contacts.old_shear.copy()
    RelaxToRest().solve(step, AT_REST, GOAL)
    assert step.contacts is contacts
    assert step.system.bolts is bolts
    np.testing.assert_array_equal(contacts.old_shear, shear)


def test_the_elastic_solution_is_found_once_in_a_step():
    """A wall on a steep slope: the first method begins with it and fails, the second takes it as it is."""
    step = begun(model_of([turned(p, 30.0) for p in wall()], friction=35.0))
    assert NearbyEquilibrium().solve(step, AT_REST, GOAL).outcome is Outcome.STALLED
    known, count = step.elastic_position.copy(), step.factors.count
    RelaxToRest().solve(step, AT_REST, GOAL)
    assert step.factors.count == count
    np.testing.assert_array_equal(step.elastic_position, known)


def test_another_step_has_an_elastic_solution_of_its_own():
    step = begun(model_of(wall()))
    softly = step.elastic_position
    stiffly = step.with_regularization(1e3 / step.system.d).elastic_position
    assert step.movement(stiffly - step.start) < 0.5 * step.movement(softly - step.start)
    assert step.elastic_position is softly
