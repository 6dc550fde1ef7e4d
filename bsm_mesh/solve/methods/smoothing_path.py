"""Smoothing path: the solution by smoothed laws is followed as the smoothing mu goes to zero.

Where thousands of contacts open and slip at once, Newton's method on the exact laws has to guess the active set, and
stalls. With mu of the size of the contacts' elastic energy the equations are smooth; their solution is followed while
mu shrinks, with one factorization a step (non-interior path following, Burke and Xu 1998). The smoothed residual is
kept below a part of the exact one. Between factorizations blocks off the path are corrected as subdomains. Where too
small a part of a correction is accepted, the path restarts with a greater mu.

Friction does not dilate, so the problem is not convex and convergence is not proved: there may be no path, as there may
be no equilibrium nearby.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.smoothed_forces import Smoothed, dforces_dmu, typical_mu
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.methods.subdomain_newton import subdomain_newton
from bsm_mesh.solve.motion.sliding import can_follow_dynamically
from bsm_mesh.solve.step.attempt import Attempt
from bsm_mesh.solve.step.equations import Residual, Step, moved_by

MAX_ITERATIONS = 90  # factorizations
FIRST, LEAST, SLOWEST = 0.3, 0.01, 0.9  # factor on mu wanted by an iteration: initial value and bounds
CAREFUL = 0.3  # its smallest value once the path was lost
OFF = 0.3  # smoothed over exact 2-norm of the residual, above which a position is off the path
NEAR, NEAREST = 0.1, 0.02  # and below which longer steps are tried
HALVINGS, MAX_HALVINGS = 4, 8  # of a correction that reduces mu, and of one that only returns to the path
SLOW, SLOWLY = 0.5, 0.7  # an iteration is slow if less of its correction is accepted, or more of mu is left;
MAX_SLOW, FEW_LEFT = 4, 0.1  # so many in a row with a smaller rms residual: the path is blocked by few blocks
PATIENCE = 3  # so many with a larger one: the path has become slow
POOR = 0.1  # accepted part of a correction, below which the path is lost
RAISED, MAX_RAISED = 4.0, 4  # factor on mu then, and how often
FAR = 20.0  # step lengths: beyond there is no equilibrium nearby
RESIDUAL_CUTOFF = 0.1  # over the maximum norm: blocks with a larger residual are solved as a subdomain,
FEW = 50.0  # where the 2-norm is less than so many times the maximum norm: few blocks are the cause
ROUNDS, WORTHWHILE = 5, 0.7  # of subdomain solutions, and the part of the 2-norm to which one must reduce it
NEAR_END = 0.1  # maximum norm of the exact residual, below which Newton's method is tried;
CONTRACTION = 0.5  # it must reduce the 2-norm to this part an iteration,
CLOSER = 0.1  # or the path continues to this part of the residual
LITTLE = 1e-6  # over the typical mu: smallest initial one


def initial_mu(step: Step, position: FloatArray) -> float:
    """Return an initial mu whose change of forces is about twice the residual at a position (n, 3) [N].

    With a smaller one the path was lost early.
    """
    here, weight = step.residual_at(position), step.system.weight(step.evaluate(position))
    mu = LITTLE * typical_mu(step.contacts, position, weight)
    for _ in range(MAX_ITERATIONS):
        change = step.project(step.smoothed(mu).residual_at(position).forces - here.forces)
        if np.sqrt(np.einsum("ij,ij", change, change)) > here.l2_norm:
            break
        mu *= RAISED
    return RAISED * mu


def follow_path(
    step: Step,
    position: FloatArray,
    mu: float,
    tolerance: float,
    *,
    rough: float = 0.0,
) -> Attempt:
    """Return the solution at the end of the path by Newton's method, or the last position on the path.

    Near the end few blocks may block it: their contacts passed a corner on the way, beyond the contact set of the step.

    Parameters
    ----------
    step : Step
        The equations.
    position : (n, 3) float64
        Start of the path.
    mu : float [N]
        Initial smoothing.
    tolerance : float
        Maximum norm of the exact residual over the mean weight.
    rough : float
        Rms residual over the weight, at which the path may end early.
    """
    path, goal = _Path(step, position, mu), NEAR_END
    for _ in range(MAX_ITERATIONS):
        if path.is_held_up or step.is_localized(path.exact, rough):
            break
        if path.is_given_up:
            break
        if path.exact.max_norm < goal:
            contacts = step.contacts
            found = newton(step, path.here.position, tolerance, contraction=CONTRACTION)
            if found.converged:
                return found
            step.contacts = contacts
            goal = CLOSER * path.exact.max_norm
        if not path.advance() or path.is_far:
            return Attempt(position, step.evaluate(position), converged=False)
    return Attempt(path.exact.position, path.exact.at, converged=False)


class _Trial(NamedTuple):
    """The result of a part of a correction: the smoothed step, and the residuals by both laws."""

    part: float
    wanted: float
    step: Step
    mu: float
    here: Residual
    exact: Residual


class _Path:
    """The current point of the path.

    Attributes
    ----------
    here, exact : Balance
        Residuals by the smoothed and by the exact laws.
    """

    def __init__(self, step: Step, position: FloatArray, mu: float) -> None:
        self.step, self._mu, self._patient = step, mu, not can_follow_dynamically(step)
        self._smoothed = step.smoothed(mu)
        self.here, self.exact = self._smoothed.residual_at(position), step.residual_at(position)
        self._wanted, self._least, self._raised, self._slow = FIRST, LEAST, 0, 0
        self._was_quick = self._was_lost = False

    @property
    def is_far(self) -> bool:
        """Whether blocks have left the neighbourhood of the start."""
        moved = self.step.movement(self.here.position - self.step.anchor)
        return not moved <= FAR * self.step.system.d + self.step.settlement_allowance

    @property
    def is_held_up(self) -> bool:
        """Whether few blocks are the cause of the residual, and the last iterations were slow."""
        return self._slow >= MAX_SLOW and self.step.is_localized(self.exact, FEW_LEFT)

    @property
    def is_given_up(self) -> bool:
        """Whether the path was lost or is slow with a residual of many blocks, and explicit motion can follow them."""
        hopeless = self._was_lost or (self._was_quick and self._slow >= PATIENCE)
        return hopeless and not self._patient and not self.step.is_localized(self.exact, FEW_LEFT)

    def advance(self) -> bool:
        """Advance by one factorization; return False where there is no way on."""
        if not self._smoothed.factorize(self._smoothed.tangent(self.here.at), self.here.position):
            return False
        trial = self._try(self._wanted, HALVINGS) if self._wanted < 1 else None
        self._was_lost |= self._wanted < 1 and trial is None
        if self.is_given_up:
            return True
        trial = trial or self._try(1.0, MAX_HALVINGS)
        part = trial.part if trial else 0.0
        shrunk = trial.mu / self._mu if trial else 1.0
        self._slow = self._slow + 1 if part < SLOW or shrunk > SLOWLY else 0
        self._was_quick |= self._slow == 0
        if part < POOR:
            self._slow = MAX_SLOW
        if part < POOR and not self.is_held_up and self._raised < MAX_RAISED:
            self._raise()
            return True
        if trial is None:
            return self.is_held_up
        self._smoothed, self._mu, self.here, self.exact = trial[2:]
        self._wanted = self._next(trial.part, trial.wanted)
        return True

    def _try(self, wanted: float, halvings: int) -> _Trial | None:
        """Return the result of the largest part of a correction that stays on the path.

        Mu is reduced by the factor `wanted`; 1: the correction only returns to the path.
        """
        step, here = self._smoothed, self.here
        movement = step.solve(here.forces + self._dforces(wanted) if wanted < 1 else here.forces)
        size = step.movement(movement)
        if not np.isfinite(size):
            return None
        part = min(1.0, FAR * step.system.d / size) if size > 0 else 1.0
        for _ in range(halvings):
            mu = self._mu * wanted**part
            smoothed = self.step.smoothed(mu)
            there, exact = self._brought_back(smoothed, moved_by(here.position, part * movement))
            if there.l2_norm <= OFF * exact.l2_norm or there.l2_norm <= (1 - 0.1 * part) * here.l2_norm:
                return _Trial(part, wanted, smoothed, mu, there, exact)
            part /= 2
        return None

    def _dforces(self, wanted: float) -> FloatArray:
        """Return the change of forces with mu reduced by a factor, (n, 3).

        Contact forces are not kept while parts of a correction are tried: 0.6 GB in a model of a million blocks.
        """
        at = self.here.at
        assert isinstance(at, Smoothed)
        return dforces_dmu(self._smoothed.contacts, at, (wanted - 1) * self._mu)

    def _raise(self) -> None:
        """Restart the path with a greater mu, and return to it before advancing."""
        self._raised, self._slow = self._raised + 1, 0
        self._mu *= RAISED
        self._wanted, self._least = 1.0, CAREFUL
        self._smoothed = self.step.smoothed(self._mu)
        self.here = self._smoothed.residual_at(self.here.position)

    def _brought_back(self, smoothed: Step, position: FloatArray) -> tuple[Residual, Residual]:
        """Return smoothed and exact residuals after subdomain corrections of blocks off the path."""
        here, exact = smoothed.residual_at(position), self.step.residual_at(position)
        for _ in range(ROUNDS):
            few = FEW * here.max_norm * here.weight
            if here.l2_norm > few or here.l2_norm < NEAREST * exact.l2_norm:
                break
            position = subdomain_newton(smoothed, here.position, 0.0, cutoff=RESIDUAL_CUTOFF)
            there = smoothed.residual_at(position)
            gained = there.l2_norm / here.l2_norm
            if gained < 1:
                here, exact = there, self.step.residual_at(position)
            if gained > WORTHWHILE:
                break
        return here, exact

    def _next(self, part: float, wanted: float) -> float:
        """Return the factor on mu for the next iteration, after a part of a correction with one."""
        off = self.here.l2_norm / self.exact.l2_norm if self.exact.l2_norm > 0 else 0.0
        slower = min(SLOWEST, float(np.sqrt(max(wanted, LEAST))))
        if part >= 1 and off < NEAR:
            return max(self._least, min(wanted, SLOWEST) * min(wanted, SLOWEST))
        if part >= 1 and off < OFF:
            return min(wanted, 0.5)
        if off < NEAREST:
            return 0.5
        if off < OFF or (part >= 0.25 and not (part >= 1 and wanted >= 1)):
            return slower
        return 1.0
