"""Equilibrium of a part of a stage: at once, in parts of the unbalanced force, after motion or viscous flow."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.solve.zones.equilibrium import Equations, Iterate
from bsm_mesh.solve.zones.following import follow
from bsm_mesh.solve.zones.loose_blocks import loose
from bsm_mesh.solve.zones.newton import flowed
from bsm_mesh.solve.zones.plastic_collapse import plastic_collapse
from bsm_mesh.solve.zones.unyielding import yielding_no_further

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_run import StageRun

PARTS = 4  # of the unbalanced force, one after the other, where all at once leads nowhere

Reached = tuple[Equations, Iterate, bool]


def reached(run: StageRun, equations: Equations, present: BoolArray) -> Reached:
    """Return the equations of blocks that are there (n,), the state at the end of the search, and whether it rests.

    Without equilibrium they are those of the search at once, or of blocks that fall. The run's displacements are where
    the search for them began, or where blocks fall.
    """
    u = run.state.u
    first: Reached = equations, equations.at(u, equations.free.none), False
    apart = loose(run.of, *first[:2], present)
    if not apart:
        first = run.settled(equations, present)
        if first[2]:
            return first
        apart = loose(run.of, *first[:2], present)
    run.state.u = u
    found = None if apart else _in_parts(run, equations, present)
    if found is None and equations.large is not None:
        found = _after_motion(run, equations, present)
    elif found is None and equations.plastic is not None and not apart:
        found = _after_flow(run, first, present)
    return found or first


def _in_parts(run: StageRun, equations: Equations, present: BoolArray) -> Reached | None:
    """Return equilibrium after parts of the force that is unbalanced at the start; None if one of them finds none."""
    u, now = run.state.u, equations
    out_of_balance = equations.at(u, equations.free.none).residual
    held_back, at = np.zeros_like(u), None
    for part in range(1, PARTS + 1):
        before, held_back = held_back, (1 - part / PARTS) * out_of_balance
        now, at, converged = run.settled(replace(now, load=now.load + before - held_back), present)
        if not converged:
            run.state.u = u
            return None
        run.state.u = at.u
    assert at is not None
    return now, at, True


def _after_motion(run: StageRun, equations: Equations, present: BoolArray) -> Reached | None:
    """Return equilibrium of blocks in large displacement after their motion, or their fall; None if neither shows."""
    if equations.plastic is not None and _settles_unyielding(run, equations, present):
        return None
    rest = follow(run, equations, present)
    if rest is None:
        return None
    moved, run.fall = rest
    if run.fall is not None:
        return moved, moved.at(run.state.u, moved.free.none), False
    return run.settled(moved, present)


def _settles_unyielding(run: StageRun, equations: Equations, present: BoolArray) -> bool:
    """Return whether equilibrium is found of rock that yields no further: then motion would lead there."""
    u, further = run.state.u, yielding_no_further(equations)
    apart = loose(run.of, further, further.at(u, further.free.none), present)
    found = not apart and run.settled(further, present)[2]
    run.state.u = u
    return found


def _after_flow(run: StageRun, first: Reached, present: BoolArray) -> Reached | None:
    """Return equilibrium of rock that yields after viscous flow from a search without; None: none, or a collapse."""
    u, (equations, at, _) = run.state.u, first
    if plastic_collapse(equations, at, u) is not None:
        return None
    rest = flowed(equations, at, run.report)
    if rest.is_balanced:
        run.state.u = rest.u
        found = run.settled(equations, present)
        if found[2]:
            return found
        run.state.u = u
    return None
