"""Opening and slip of joints by two methods, at the points of the continuum's interfaces.

Blocks have them from the movement of the two blocks, wherever their contacts are: with the rock's own springs, where
rock is elastic.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.continuum.differences import Difference, measure_difference
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import ContactForces


class JointMovement(NamedTuple):
    """Opening and slip by the Block-Spring Model at the points of the continuum's joints, (q,) each [m]."""

    opening: FloatArray
    slip: FloatArray


def joint_movement(blocks: Blocks, position: FloatArray, points: ContactForces) -> JointMovement:
    """Return what blocks that moved have at the points of a continuum's joints.

    Parameters
    ----------
    blocks : Blocks
        As given.
    position : (n, 3) float64 [m, m, rad]
        Their movement since they were given.
    points : ContactForces
        Of the continuum.
    """
    a, b = (displacement_of(blocks, position, block, points.point) for block in (points.block_a, points.block_b))
    x, y = points.normal.T
    apart = a - b
    return JointMovement(apart[:, 0] * x + apart[:, 1] * y, apart[:, 1] * x - apart[:, 0] * y)


def joint_movement_errors(ours: JointMovement, points: ContactForces, held: BoolArray) -> tuple[Difference, ...]:
    """Return how far opening and slip lie apart, of all points but those between held blocks (n,); none if all rest.

    Means are weighted by length. A negligible one is measured by both.
    """
    length = points.length * ~(held[points.block_a] & held[points.block_b])
    if not length.any():
        return ()
    both = np.stack([points.opening, points.slip], axis=1)
    whole = float(np.sqrt((length[:, None] * both**2).sum() / length.sum())), float(np.hypot(*both.T).max())
    if not whole[0] > 0:
        return ()
    on = length > 0
    pairs = {"opening of joints": (ours.opening, points.opening), "slip of joints": (ours.slip, points.slip)}
    return tuple(
        measure_difference(name, "m", one * on, other * on, length, whole) for name, (one, other) in pairs.items()
    )
