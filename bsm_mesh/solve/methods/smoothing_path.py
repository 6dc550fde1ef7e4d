"""From laws that are rounded off to the laws themselves: a path that Newton's method can follow.

Where thousands of contacts open and slip at once, Newton's method on the laws has to guess which, and stands still.
With a smoothing of the size of the contacts' elastic energy the equations are soft; their solution is followed while
the smoothing shrinks, one factorization for every part of the way (a non-interior path-following method, Burke and Xu
1998). What is out of balance by the smoothed laws is held to a part of what the smoothing itself is worth. Between
factorizations the few blocks that have left the path are brought back on their own. Where that fails, too little of a
correction holds, the path is taken up again with a greater smoothing.

Friction does not dilate, so the problem is not convex and nothing is proved: there may be no path to follow, as there
may be no equilibrium nearby.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.contacts.smoothed_forces import Smoothed, drift, typical_smoothing
from bsm_mesh.solve.methods.newton import newton
from bsm_mesh.solve.methods.subdomain_newton import relax_locally
from bsm_mesh.solve.motion.sliding import can_slide
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import Balance, Step, moved_by

MOST_ITERATIONS = 90  # factorizations
FIRST, LEAST, SLOWEST = 0.3, 0.01, 0.9  # to what part an iteration wants the smoothing: at first, and bounds of it
CAREFUL = 0.3  # its least part once the path had been lost
OFF = 0.3  # of the 2-norm by the exact laws: more out of balance by the smoothed ones is off the path
NEAR, NEAREST = 0.1, 0.02  # and with less, longer steps are tried
HALVINGS, MOST_HALVINGS = 4, 8  # of a correction that shrinks the smoothing, and of one that only returns to the path
SLOW, SLOWLY = 0.5, 0.7  # an iteration is slow if less of its correction holds, or more of the smoothing is left;
MOST_SLOW, FEW_LEFT = 4, 0.1  # so many in a row, and less of a weight (root mean square) left: the path is held up
PATIENCE = 3  # so many, and more left: a path that was quick has become slow
POOR = 0.1  # of a correction: where less holds the path is lost
RAISED, MOST_RAISED = 4.0, 4  # by what the smoothing grows then, and how often
FAR = 20.0  # step lengths: blocks that move farther have no equilibrium nearby
FLAGGED = 0.1  # of the greatest force out of balance: blocks above this are solved apart,
FEW = 50.0  # where the 2-norm is less than so many times the greatest force: few are out of balance
ROUNDS, WORTHWHILE = 5, 0.7  # of solving blocks apart, and the part of the 2-norm to which one must bring it
NEAR_END = 0.1  # greatest force out of balance by the exact laws from which on Newton's method may end the path;
CONTRACTION = 0.5  # it must shrink the 2-norm to this an iteration,
CLOSER = 0.1  # or the path goes on to this part of what was out of balance
LITTLE = 1e-6  # of the typical smoothing: the least to begin with


def fitting_smoothing(step: Step, position: FloatArray) -> float:
    """Return a smoothing that is worth about twice what is out of balance at a position (n, 3) [N].

    With one that is worth no more than that a path was lost twice before it came far.
    """
    here, weight = step.balance_at(position), step.moving.weight(step.evaluate(position))
    smoothing = LITTLE * typical_smoothing(step.contacts, position, weight)
    for _ in range(MOST_ITERATIONS):
        change = step.free(step.smoothed(smoothing).balance_at(position).forces - here.forces)
        if np.sqrt(np.einsum("ij,ij", change, change)) > here.norm:
            break
        smoothing *= RAISED
    return RAISED * smoothing


def follow_path(
    step: Step,
    position: FloatArray,
    smoothing: float,
    tolerance: float,
    *,
    rough: float = 0.0,
) -> Found:
    """Return the solution at the path's end by Newton's method, or how near to it the path led.

    Where few blocks hold up all others near the end, it is theirs: their contacts may have passed a corner on the way,
    which a step does not know of.

    Parameters
    ----------
    step : Step
        The equations.
    position : (n, 3) float64
        Where the path begins,
    smoothing : float [N]
        and with what.
    tolerance : float
        Greatest force out of balance by the exact laws, over the mean weight.
    rough : float
        Root mean square out of balance, of a weight, to which the path is followed if not to its end.
    """
    path, goal = _Path(step, position, smoothing), NEAR_END
    for _ in range(MOST_ITERATIONS):
        if path.is_held_up or step.is_scattered(path.exact, rough):
            break
        if path.is_given_up:
            break
        if path.exact.greatest < goal:
            contacts = step.contacts
            found = newton(step, path.here.position, tolerance, contraction=CONTRACTION)
            if found.converged:
                return found
            step.contacts = contacts
            goal = CLOSER * path.exact.greatest
        if not path.advance() or path.is_far:
            return Found(position, step.evaluate(position), converged=False)
    return Found(path.exact.position, path.exact.at, converged=False)


class _Trial(NamedTuple):
    """What a part of a correction leads to: the smoothed step there, and what is out of balance by both laws."""

    part: float
    wanted: float
    step: Step
    smoothing: float
    here: Balance
    exact: Balance


class _Path:
    """Where the path has come to.

    Attributes
    ----------
    here, exact : Balance
        What is out of balance by the smoothed laws and by the exact ones.
    """

    def __init__(self, step: Step, position: FloatArray, smoothing: float) -> None:
        self.step, self._smoothing, self._patient = step, smoothing, not can_slide(step)
        self._smoothed = step.smoothed(smoothing)
        self.here, self.exact = self._smoothed.balance_at(position), step.balance_at(position)
        self._wanted, self._least, self._raised, self._slow = FIRST, LEAST, 0, 0
        self._was_quick = self._was_lost = False

    @property
    def is_far(self) -> bool:
        """Whether blocks have left the neighbourhood of the start."""
        moved = self.step.movement(self.here.position - self.step.anchor)
        return not moved <= FAR * self.step.moving.d + self.step.room

    @property
    def is_held_up(self) -> bool:
        """Whether few blocks are out of balance, and the last iterations were slow."""
        return self._slow >= MOST_SLOW and self.step.is_scattered(self.exact, FEW_LEFT)

    @property
    def is_given_up(self) -> bool:
        """Whether many blocks are out of balance on a path that was lost, or is slow, and cycles can follow them."""
        hopeless = self._was_lost or (self._was_quick and self._slow >= PATIENCE)
        return hopeless and not self._patient and not self.step.is_scattered(self.exact, FEW_LEFT)

    def advance(self) -> bool:
        """Go on by one factorization; return False where there is no way on."""
        if not self._smoothed.factorize(self._smoothed.tangent(self.here.at), self.here.position):
            return False
        trial = self._try(self._wanted, HALVINGS) if self._wanted < 1 else None
        self._was_lost |= self._wanted < 1 and trial is None
        if self.is_given_up:
            return True
        trial = trial or self._try(1.0, MOST_HALVINGS)
        part = trial.part if trial else 0.0
        shrunk = trial.smoothing / self._smoothing if trial else 1.0
        self._slow = self._slow + 1 if part < SLOW or shrunk > SLOWLY else 0
        self._was_quick |= self._slow == 0
        if part < POOR:
            self._slow = MOST_SLOW
        if part < POOR and not self.is_held_up and self._raised < MOST_RAISED:
            self._raise()
            return True
        if trial is None:
            return self.is_held_up
        self._smoothed, self._smoothing, self.here, self.exact = trial[2:]
        self._wanted = self._next(trial.part, trial.wanted)
        return True

    def _try(self, wanted: float, halvings: int) -> _Trial | None:
        """Return what the greatest part of a correction that keeps to the path leads to.

        With it the smoothing shrinks towards a part of itself; 1: the correction only returns to the path.
        """
        step, here = self._smoothed, self.here
        movement = step.solve(here.forces + self._drift(wanted) if wanted < 1 else here.forces)
        size = step.movement(movement)
        if not np.isfinite(size):
            return None
        part = min(1.0, FAR * step.moving.d / size) if size > 0 else 1.0
        for _ in range(halvings):
            smoothing = self._smoothing * wanted**part
            smoothed = self.step.smoothed(smoothing)
            there, exact = self._brought_back(smoothed, moved_by(here.position, part * movement))
            if there.norm <= OFF * exact.norm or there.norm <= (1 - 0.1 * part) * here.norm:
                return _Trial(part, wanted, smoothed, smoothing, there, exact)
            part /= 2
        return None

    def _drift(self, wanted: float) -> FloatArray:
        """Return by what forces change where the smoothing shrinks to a part of itself, (n, 3).

        Nobody keeps the contact forces behind it while parts of a correction are tried: 0.6 GB of a million blocks.
        """
        at = self.here.at
        assert isinstance(at, Smoothed)
        return drift(self._smoothed.contacts, at, (wanted - 1) * self._smoothing)

    def _raise(self) -> None:
        """Take up the path again with a greater smoothing, and return to it before going on."""
        self._raised, self._slow = self._raised + 1, 0
        self._smoothing *= RAISED
        self._wanted, self._least = 1.0, CAREFUL
        self._smoothed = self.step.smoothed(self._smoothing)
        self.here = self._smoothed.balance_at(self.here.position)

    def _brought_back(self, smoothed: Step, position: FloatArray) -> tuple[Balance, Balance]:
        """Return what is out of balance by the smoothed and by the exact laws once few blocks off the path are back."""
        here, exact = smoothed.balance_at(position), self.step.balance_at(position)
        for _ in range(ROUNDS):
            few = FEW * here.greatest * here.weight
            if here.norm > few or here.norm < NEAREST * exact.norm:
                break
            position = relax_locally(smoothed, here.position, 0.0, flagged=FLAGGED)
            there = smoothed.balance_at(position)
            gained = there.norm / here.norm
            if gained < 1:
                here, exact = there, self.step.balance_at(position)
            if gained > WORTHWHILE:
                break
        return here, exact

    def _next(self, part: float, wanted: float) -> float:
        """Return to what part the next iteration wants the smoothing, after a part of a correction to one."""
        off = self.here.norm / self.exact.norm if self.exact.norm > 0 else 0.0
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
