"""Equilibrium of the continuum and its joints: Newton's method with the consistent tangent.

Where many points of joints slip or part at once Newton is helped in five ways:

* A correction is shortened until the residual is less than the greatest of the last few, not of the last: a point that
  goes from stick to slip to open and back may have to pass through a greater one (Grippo et al. 1986).
* None opens or shears joints by more than small displacements allow: where hardly anything holds a block a full one
  carries it metres away.
* A part of the joints' elastic stiffness is added to the tangent while corrections have to be shortened; the residual
  stays exact.
* Where rock yields, so is a part of its own elastic stiffness, up to all of it.
* If that leads nowhere, friction is frozen at the pressures reached, the convex problem that this leaves is solved, and
  Newton continues. Rock that yields leaves no convex problem, and its friction is not frozen. Of 60 random tunnels in
  such rock (`benchmarks.plastic_tunnels`) all ended alike with and without it, with it in 4.5 times the time.

The loop of rigid blocks (`methods/newton.py`) shares the line search, not these five. With its acceptance,
regularization and stall rule instead, 3 of the first 115 tests of zones failed: joints that slip or part.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.algebra.line_search import Decrease
from bsm_mesh.solve.stages.scheme import Reporter
from bsm_mesh.solve.zones.equilibrium import BALANCED, Equations, Iterate

MAX_ITERATIONS = 150  # corrections for one equilibrium before it counts as not found
WHOLE = 30  # corrections that are not shortened, of blocks that bend
MAX_FROZEN = 4  # times that friction is frozen before the state counts as not found
FROZEN_ITERATIONS = 25  # corrections with friction frozen, a convex problem
SHORTENED = (1.0, 0.5, 0.25, 0.1)  # parts of a correction that are tried
ENOUGH = 0.1  # of a part of a correction: by how much the residual has to fall for no shorter one to be tried
RECENT = 3  # residuals below the greatest of which it has to fall
FIRST_REGULARIZATION = 1e-4  # of the joints' elastic stiffness
MAX_REGULARIZATION = 0.1  # of the same: with more a correction hardly moves anything
LEAP = 10.0  # times the unbalanced force: a correction of viscous flow after which it is greater is not taken
FROZEN_REGULARIZATION = 1e-5  # of the same, where friction is frozen


def find_equilibrium(equations: Equations, u: FloatArray, report: Reporter = lambda text: None) -> tuple[Iterate, bool]:
    """Return the state of equilibrium near displacements u (N,), else the last tried, and whether it is one.

    `report` gets the unbalanced force of every correction, in words.

    Raises
    ------
    ModelError
        If the equations are singular, or the supports contradict each other.
    """
    free = equations.free
    at = equations.at(free.fulfilled(u), free.none)
    if equations.are_linear and at.is_balanced and not free.misfit(at.u).any():
        return at, True
    if equations.are_linear:
        solved = _shortened(equations, at, 0.0, at.norm, (1.0,))[0]
        at = replace(solved, scale=max(at.scale, solved.scale))  # a motion as a whole leaves no force to compare with
    else:
        at = _newton(equations, _bent(equations, _tied(equations, at)), report)
    free.refuse_misfit(at.u)
    return at, at.is_balanced


def _tied(equations: Equations, at: Iterate) -> Iterate:
    """Return the solution with all joints closed and sticking where some that touch carry no force yet."""
    misses = np.abs(equations.free.misfit(at.u)).max(initial=0.0) > 0
    if (at.state is None or not at.state.touching.any()) and not misses:
        return at
    correction, multipliers = equations.free.solve(equations.elastic(at), at.residual, at.u)
    return equations.at(equations.moved(at.u, correction), multipliers)


def _bent(equations: Equations, at: Iterate) -> Iterate:
    """Return the state after whole corrections of blocks in large displacement, or the given one where they fail.

    A correction that bends a slab stretches it by half the square of the angle. So the residual rises by far more than
    the loads, and falls with the next correction, never reached by shortened ones.
    """
    best, now, last = at, at, np.inf
    for _ in range(0 if equations.large is None else WHOLE):
        if now.is_balanced and (now.size <= BALANCED or now.norm > last / 2):  # no more than rounding is left
            break
        last = now.norm
        try:
            now = _shortened(equations, now, 0.0, np.inf, (1.0,))[0]
        except ModelError:  # a block came off its neighbours
            break
        if not np.isfinite(now.norm):
            break
        best = min(best, now, key=lambda one: one.norm)
    return best


def _newton(equations: Equations, at: Iterate, report: Reporter) -> Iterate:
    regularization, frozen, recent = 0.0, 0, deque([at.norm], RECENT)
    for number in range(MAX_ITERATIONS):
        report(f"correction {number}: unbalanced force {at.size:.1e} of the greatest")
        if at.is_balanced:
            break
        most = max(recent)
        try:
            new, part = _shortened(equations, at, regularization, most)
        except ModelError:
            if equations.large is None:
                raise
            break  # a block came off its neighbours, or is about to leave an equilibrium
        if new.norm < most * (1 - 1e-3):
            regularization = _relieved(regularization, part)
            at = new
            recent.append(at.norm)
            continue
        regularization = max(10 * regularization, FIRST_REGULARIZATION)
        if regularization > (MAX_REGULARIZATION if equations.plastic is None else 1):  # 1: as stiff as elastic rock
            if frozen == MAX_FROZEN or not equations.can_freeze:
                break
            frozen, regularization = frozen + 1, 0.0
            at = _with_frozen_friction(equations, at, report)
            recent = deque([at.norm], RECENT)
    return at


def flowed(equations: Equations, at: Iterate, report: Reporter) -> Iterate:
    """Return where rock flows to from a state against viscosity, which decreases as the unbalanced force does.

    Where friction exceeds dilation no path lowers the force from start to end. So it may grow in a correction, up to
    `LEAP` times. These are implicit steps of pseudo-time (Kelley & Keyes 1998, SIAM J. Numer. Anal. 35, 508-523).

    Of 12 random tunnels without a verdict 4 reach rest so (`benchmarks.plastic_tunnels`). It is 1 of the 4 without
    `LEAP`, and 2 if a force that grows by less than a tenth raises the viscosity. With a tenth of the first viscosity
    all 4 rest.
    """
    viscosity = MAX_REGULARIZATION
    for number in range(MAX_ITERATIONS):
        report(f"viscous flow, correction {number}: unbalanced force {at.size:.1e} of the greatest")
        if at.is_balanced:
            break
        try:
            new, _ = _shortened(equations, at, viscosity, np.inf, (1.0,))
        except ModelError:  # a matrix that cannot be factorized: no way on
            break
        growth = min(new.norm / at.norm, LEAP)
        if growth < LEAP:
            at = new
        viscosity = min(1.0, viscosity * (growth if growth > 1 + ENOUGH else min(growth, 0.5)))
    return at


def _relieved(regularization: float, part: float) -> float:
    """Return the regularization after a correction of which a part was taken."""
    if regularization <= 1e-7:
        return FIRST_REGULARIZATION if part < 0.25 else 0.0
    return regularization * (0.1 if part == 1 else 1.0 if part >= 0.25 else 3.0)


def _shortened(
    equations: Equations, at: Iterate, regularization: float, most: float, parts: tuple[float, ...] = SHORTENED
) -> tuple[Iterate, float]:
    """Return the state after a part of a correction: the first with a residual well below `most`, else the best."""
    correction, multipliers = equations.free.solve(equations.tangent(at, regularization), at.residual, at.u)
    allowed = equations.allowed(correction)
    tried, decrease = [], Decrease(most, ENOUGH)
    for part in (allowed * part for part in parts):
        new = equations.at(
            equations.moved(at.u, part * correction), at.multipliers + part * (multipliers - at.multipliers)
        )
        tried.append((new, part))
        if decrease.reached(new.norm, part):
            break
    return tried[decrease.chosen]


def _with_frozen_friction(equations: Equations, at: Iterate, report: Reporter) -> Iterate:
    """Return the equilibrium with shear strengths as at the pressures reached: the minimum of a convex energy."""
    assert at.state is not None
    pressure = at.state.pressure
    free, now = equations.free, equations.at(at.u, at.multipliers, pressure)
    for _ in range(FROZEN_ITERATIONS):
        if now.size <= 0.1 * BALANCED:
            break
        report(f"friction frozen: unbalanced force {now.size:.1e} of the greatest")
        K = equations.tangent(now, FROZEN_REGULARIZATION)
        correction, multipliers = free.solve(K, now.residual, now.u)
        now = _line_minimum(equations, now, correction, multipliers, pressure)
    return equations.at(now.u, now.multipliers)


def _line_minimum(
    equations: Equations, now: Iterate, correction: FloatArray, multipliers: FloatArray, pressure: FloatArray
) -> Iterate:
    """Return the state along a correction at which the forces out of balance do no more work on it."""
    along = equations.free.reduced(correction, np.zeros_like(now.multipliers))
    first = float(along @ now.left)
    low, high, part, new = 0.0, np.inf, 1.0, now
    for _ in range(FROZEN_ITERATIONS):  # halvings: a block that slips back stops within a micrometre
        new = equations.at(equations.moved(now.u, part * correction), multipliers, pressure)
        work = float(along @ new.left)
        if abs(work) < 0.1 * abs(first):
            break
        low, high = (part, high) if work > 0 else (low, part)
        part = 2 * part if np.isinf(high) else (low + high) / 2
    return new
