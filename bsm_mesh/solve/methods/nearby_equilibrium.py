"""The equilibrium near the start of a stage: regularised Newton, with contacts updated to where it leads.

Contacts change with the movement: corners pass edges' ends, shared lengths grow and shrink. So they are searched again
where Newton's method ended, and it continues from there, until an update changes nothing any more. Nothing is committed
in between: what slides still remembers where it began to.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from bsm_mesh.solve.algebra.pardiso import LARGE
from bsm_mesh.solve.methods.corrections import chord_method
from bsm_mesh.solve.methods.newton import SETTINGS as NEWTON
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.step.attempt import FEW_CHANGE, MAX_RMS, Attempt, Goal, Iterate, Outcome
from bsm_mesh.solve.step.equations import StepEquations


@dataclass(frozen=True, slots=True, kw_only=True)
class NearbySettings:
    """When contacts are updated, and what ends it. Residuals are over the mean weight.

    Attributes
    ----------
    updated : float
        Part of the residual after an update that is solved for before the next, which leaves about as much.
    unloaded : float
        As `NewtonSettings.shrinking`, where no contact has carried a force yet: there is no path of loading to keep to.
    """

    updated: float = 0.03
    unloaded: float = 0.7


SETTINGS = NearbySettings()


class NearbyEquilibrium:
    """Regularised Newton from the elastic solution, its contacts updated up to six times.

    Parameters
    ----------
    localized : bool
        As `newton` takes it: after an excavation, where few of many blocks are set free.
    """

    def __init__(self, *, localized: bool = False) -> None:
        self.name = "nearby equilibrium by subdomains" if localized else "nearby equilibrium"
        self._localized = localized

    def applies(self, equations: StepEquations, at: Iterate, goal: Goal) -> bool:
        """Return whether blocks are at rest where the step begins."""
        return at.velocity is None

    def solve(self, equations: StepEquations, at: Iterate, goal: Goal) -> Attempt:
        """Return the equilibrium, or the last state before contacts were updated without success."""
        step, inner = equations, goal.max_residual
        if step.residual_at(step.start).max_norm < inner and not step.supports_move:
            return Attempt(equations=step, position=step.start, outcome=Outcome.SOLVED)  # moves not by rounding either
        loaded = bool((step.contacts.candidates.history >= 0).any())  # before the step
        sweeps = not loaded and len(step.start) >= LARGE  # below, factorizing the whole costs no more than a part
        shrinking = NEWTON.shrinking if loaded else SETTINGS.unloaded
        position = step.elastic_position
        step = step.allowing_settlement(position)
        wanted = max(FEW_CHANGE, inner)
        for update in range(NEWTON.max_updates + 1):
            # Where the rms residual is low already, an end by it would leave blocks and contacts as they are.
            rms = FEW_CHANGE if wanted >= FEW_CHANGE and step.residual_at(position).rms >= FEW_CHANGE else 0.0
            attempt = newton(
                step, position, wanted, shrinking=shrinking, max_rms=rms, localized=self._localized, sweeps=sweeps
            )
            step, position = attempt.equations.allowing_settlement(attempt.position), attempt.position
            attempt = replace(attempt, equations=step)
            if not attempt.may_end or update == NEWTON.max_updates or not step.within_search_range(position):
                break
            step = attempt.equations.with_contacts_at(position)
            del attempt  # with the contacts before: a gigabyte in a model of a million blocks
            left = step.residual_at(position).max_norm
            if left < goal.rest:
                attempt = Attempt(equations=step, position=position, outcome=Outcome.SOLVED)
                break
            if left < wanted and step.factors.ready:  # the next updates would change nothing: on to rest
                inner = min(inner, goal.rest)
                position = chord_method(step, position, inner)
                left = step.residual_at(position).max_norm
            loosest = FEW_CHANGE if update < NEWTON.max_updates - 1 else inner
            wanted = max(inner, min(loosest, SETTINGS.updated * left))
        return _ended(attempt)


def _ended(attempt: Attempt) -> Attempt:
    """Return an attempt polished by the last factors, so that closed forms hold to rounding; or accepted, or not."""
    step = attempt.equations
    if attempt.outcome is Outcome.SOLVED:
        if not step.factors.ready:
            return attempt
        return replace(attempt, position=chord_method(step, attempt.position, 0.0))
    if step.residual_at(attempt.position).rms < MAX_RMS:
        return replace(attempt, outcome=Outcome.ACCEPTABLE)
    return replace(attempt, outcome=Outcome.STALLED)
