"""Which edge of a corner gives the joint where the corner meets an edge of another block."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES


def edges_of_corners(
    directions: FloatArray, jointed: BoolArray, preceding: IntArray, corner: IntArray, edge: IntArray
) -> IntArray:
    """Return the edge at each corner that gives the joint to a contact with an edge of another block, (k,).

    It is the edge that is nearer to parallel with the other block's edge. Where the two meet at an angle and that edge
    has no joint, it is the other edge of the corner.

    Parameters
    ----------
    directions : (n, 2) float64
        Unit directions of the edges that start at the corners, as the blocks lie.
    jointed : (n,) bool
        Which edges have a joint.
    preceding : (n,) int
        The corner before, of the same block: the edge that ends at a corner starts there.
    corner, edge : (k,) int
        The corners, and the edges of other blocks that they meet.
    """
    before = preceding[corner]
    cosines = [(directions[own] * directions[edge]).sum(axis=1) for own in (corner, before)]
    ends = cosines[1] < cosines[0]
    nearer, farther = np.where(ends, before, corner), np.where(ends, corner, before)
    at_an_angle = np.minimum(*cosines) > -np.sqrt(1 - RULES.parallel**2)
    found: IntArray = np.where(at_an_angle & jointed[farther] & ~jointed[nearer], farther, nearer)
    return found
