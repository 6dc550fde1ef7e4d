"""A semicircular arch of equal straight-sided voussoirs under their weight."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import bsm_mesh as bsm


def arch(n, thickness, friction=89.0):
    """Return n stones, radius 1 m to the centre line, on two fixed springings."""
    angle = np.linspace(np.pi, 0, n + 1)
    inner, outer = 1 - thickness / 2, 1 + thickness / 2
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    stones = [[inner * a, inner * b, outer * b, outer * a] for a, b in pairwise(ray)]
    springings = [[(s * inner, 0), (s * outer, 0), (s * outer, -0.2), (s * inner, -0.2)] for s in (-1, 1)]
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([*stones, *springings], rock="stone"),
        rocks=[bsm.Rock("stone", unit_weight=25e3)],
        joints=[bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=friction))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[n, n + 1])],
    )
