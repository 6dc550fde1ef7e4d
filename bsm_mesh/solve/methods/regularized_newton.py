"""Newton's method with softened tangents, and what needs no factorization of the whole between its corrections.

Open and slipping contacts keep a part of their stiffness in the tangent, so that a correction does not throw blocks
that hardly bear on others; the few blocks that are worst out of balance are solved apart.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.methods.newton import chord_method, newton
from bsm_mesh.solve.methods.subdomain_newton import RINGS, WORSE, correct_locally, relax_locally
from bsm_mesh.solve.step.attempt import Found
from bsm_mesh.solve.step.equations import SCATTERED, Balance, Step

SHRINKING = 0.25  # softened Newton's method goes on while it shrinks the 2-norm to this in two factorizations
MOST_SOFTENED = 30  # of them at most
MOST_ROUNDS, HALVED = 6, 0.5  # of what needs no factorization, and the part of the 2-norm to which a round brings it
NEAR_BALANCE = 0.1  # greatest force out of balance up to which the last factors may serve all blocks
NEARLY = 0.3  # and up to which it is given time, and all is tried for the worst blocks: with these,
SPREAD = 10.0  # the 2-norm may grow to this before the last factors have served the blocks around them,
FEW = 0.15  # of the greatest force: root mean square out of balance of which few blocks are the cause
IDLE = 0.97  # of the 2-norm: where blocks solved apart left more, and a correction of all too, they would again
STUCK, MOST_RINGS = 0.9, 4 * RINGS  # and if it hardly shrinks, more blocks around them move
WORTHWHILE = 0.7  # of the 2-norm: part to which corrections must shrink it, nearly in balance or from zero stress


def softened_newton(
    step: Step,
    position: FloatArray,
    tolerance: float,
    *,
    inside: bool = False,
    shrinking: float = SHRINKING,
    enough: Callable[[Balance], bool] | None = None,
    locally: bool = False,
) -> Found:
    """Return where Newton's method with softened tangents ends, before and after each of them settled (`_settled`).

    `inside`: the worst blocks by the interior point method too, which may take them to an equilibrium farther away.
    `shrinking`: the part to which two factorizations must shrink the 2-norm while blocks are far out of balance.
    `enough`: whether it may end with what is out of balance, though few blocks lack more than the tolerance.
    `locally`: where few blocks are worst out of balance, corrections move those around them alone.
    """
    before = step.balance_at(position).norm
    here = step.balance_at(_settled(step, position, tolerance, inside=inside))
    norms = [np.inf, np.inf, here.norm]
    found = Found(here.position, here.at, converged=False)
    for _ in range(MOST_SOFTENED):
        if enough is not None and enough(here):
            return Found(here.position, here.at, converged=True)
        if norms[-1] > (WORTHWHILE if here.greatest < NEARLY else shrinking) * norms[-3]:
            break
        contacts = step.contacts
        corrected = correct_locally(step, here.position, tolerance) if locally else None
        found = corrected or newton(step, here.position, tolerance, softened=True, most=1)
        if found.converged:
            break
        idle, position = norms[-1] > IDLE * before, found.position
        before = step.balance_at(position).norm
        if not (idle and before > IDLE * norms[-1]):
            position = _settled(step, position, tolerance, inside=inside)
        here = step.balance_at(position)
        norms.append(here.norm)
        if step.contacts is not contacts:  # some broke: with them gone it is another problem
            norms = [np.inf, np.inf, here.norm]
    return found


def _settled(step: Step, position: FloatArray, tolerance: float, *, inside: bool) -> FloatArray:
    """Return a position from which whatever needs no factorization of the whole is done.

    The worst blocks are solved apart, then what that leaves out of balance around them is spread with the last factors
    of the whole; in turns, while it halves the 2-norm. Where many blocks are far out of balance the last factors lead
    astray, and are left alone. Where few are, a round that is stuck is tried with more blocks around the worst.
    """
    here, rings = step.balance_at(position), RINGS
    for _ in range(MOST_ROUNDS):
        if here.greatest < tolerance:
            break
        near, contacts = here.greatest < NEARLY and step.factors.ready, step.contacts
        worse = SPREAD if near else WORSE
        relaxed = relax_locally(
            step,
            here.position,
            tolerance,
            inside=near or (inside and not step.jammed),
            rings=rings,
            worse=worse,
            fewer=_is_of_few(step, here),
        )
        if step.factors.ready and (relaxed is not here.position or here.greatest < NEAR_BALANCE):
            relaxed = chord_method(step, relaxed, tolerance)
        there = step.balance_at(relaxed)
        gained = there.norm / here.norm
        if gained > WORSE:
            step.contacts = contacts  # what broke on a way that is not taken
        else:
            here = there
        if gained > HALVED and not (near and gained > STUCK and rings < MOST_RINGS):
            break
        rings = 2 * rings if gained > STUCK else rings
    return here.position


def _is_of_few(step: Step, here: Balance) -> bool:
    """Return whether few blocks are the cause of what is out of balance."""
    return step.is_scattered(here, max(SCATTERED, min(NEARLY, FEW * here.greatest)))
