"""Reactions: forces in the bars of supports, and at supported points."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.supports import Bars
from bsm_mesh.results.records import SupportForces
from bsm_mesh.solve.algebra.constraints import Constraints


def bar_forces(constraints: Constraints, reactions: FloatArray, arm: FloatArray, before: FloatArray) -> FloatArray:
    """Return the force in every bar, (b,) [N/m, or N for a constrained rotation].

    Where bars repeat, statics leaves open how they share a reaction: their forces before stay, and the change is
    shared by least squares.

    Parameters
    ----------
    constraints : Constraints
        The supports as the blocks are.
    reactions : (n, 3) float64
        Their resultant on every block.
    arm : (b, 2) float64 [m]
        From centroids to the supported points.
    before : (b,) float64
        Forces in the bars before.
    """
    bars = constraints.bars
    force = before[:, None] * bars.direction
    moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0] + before * bars.holds_rotation
    change = reactions.copy()
    np.add.at(change, bars.block, -np.column_stack([force, moment]))
    changed: FloatArray = before + constraints.bar_forces(change)
    return changed


def support_forces(bars: Bars, point: FloatArray, size: FloatArray) -> SupportForces:
    """Return the forces at supported points, those of bars at the same point of the same block added up.

    Parameters
    ----------
    bars : Bars
        The bars.
    point : (b, 2) float64 [m]
        Where they hold the blocks now.
    size : (b,) float64
        Force in every bar.
    """
    key = np.column_stack([bars.block, bars.point])
    _, first, place = np.unique(key, axis=0, return_index=True, return_inverse=True)
    place = place.reshape(-1)
    force, moment = np.zeros((len(first), 2)), np.zeros(len(first))
    np.add.at(force, place, size[:, None] * bars.direction)
    np.add.at(moment, place, size * bars.holds_rotation)
    return SupportForces(block=bars.block[first], point=point[first], reaction=force, moment=moment)
