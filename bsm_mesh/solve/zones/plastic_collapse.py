"""Plastic collapse: a distance within which no displacement is an equilibrium.

The unbalanced force r of rock with associated flow falls along displacements: for any two of them
``(r(x) - r(w)) . (w - x) >= 0``. In equilibrium r(w) = 0, so that ``r(x) . (w - u) >= r(x) . (x - u)`` for the start u
of a stage. Some point of the rock has to move by at least ``r(x) . (x - u) / |r(x)|_1`` before equilibrium is possible.
Any x gives such a bound. Far along a mechanism the bound grows with the distance, for there the force no longer falls.

With dilation below friction, and where joints slip, the inequality is not proved. There the bound says that the
unbalanced force still drives the rock on at that distance.

References
----------
Koiter (1960), General theorems for elastic-plastic solids, Progress in Solid Mechanics 1, 165-221: the energy of
plastic rock with associated flow is convex.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.zones.equilibrium import Equations, Iterate
from bsm_mesh.solve.zones.small_displacements import MOVED

REGULARIZATIONS = 1e-1, 1e-2, 1e-3, 1e-4  # of the elastic stiffness: directions that are tried
DISTANCES = 0.0, 1.0, 10.0, 100.0, 1000.0  # times the size of a block: places along them
ELASTIC = 10.0  # times the elastic displacement: a bound below says little of rock that is soft


class Collapse(NamedTuple):
    """No equilibrium within small displacements.

    Attributes
    ----------
    distance : float [m]
        Some point moves at least so far before equilibrium is possible.
    u : (N,) float64 [m]
        Displacements that show it: far along the mechanism.
    """

    distance: float
    u: FloatArray


def plastic_collapse(equations: Equations, at: Iterate, start: FloatArray) -> Collapse | None:
    """Return the collapse of rock that yields, by a state without equilibrium; None where nothing shows it.

    The distance has to exceed small displacements and ten times the elastic displacements under the same load.

    Parameters
    ----------
    equations : Equations
        No equilibrium of theirs was found.
    at : Iterate
        The state in which the search ended.
    start : (N,) float64 [m]
        Displacements at the start.
    """
    if at.plastic is None or not at.plastic.yields.any():
        return None
    try:
        distance, u = max(_bounds(equations, at, start), key=lambda found: found[0])
        elastic = equations.free.solve(equations.elastic(), equations.at(start, equations.free.none).residual, start)[0]
    except ModelError:  # a tangent that cannot be factorized shows nothing
        return None
    least = max(MOVED * equations.size, ELASTIC * float(np.abs(elastic).max(initial=0.0)))
    return Collapse(distance, u) if distance > least else None


def _bounds(equations: Equations, at: Iterate, start: FloatArray) -> list[tuple[float, FloatArray]]:
    """Return bounds of the distance [m] by places along some directions from a state, and those places."""
    free, found = equations.free, [(0.0, at.u)]
    for regularization in REGULARIZATIONS:
        direction, _ = free.solve(equations.tangent(at, regularization), at.residual, at.u)
        most = float(np.abs(direction).max(initial=0.0))
        if not 0 < most < np.inf:
            continue
        for distance in DISTANCES:
            there = equations.at(at.u + distance * equations.size / most * direction, at.multipliers)
            work = float(there.left @ free.reduced(there.u - start, np.zeros_like(at.multipliers)))
            bound = work / float(np.abs(there.left).sum())
            if np.isfinite(bound):
                found.append((bound, there.u))
    return found
