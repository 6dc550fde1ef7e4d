"""Blocks on one kind of joint, and where they stand at the end."""

from __future__ import annotations

import numpy as np
from scenes import turned

import bsm_mesh as bsm

GAMMA = 25e3  # N/m3


def model_of(polygons, *, friction=35.0, kn=1e9, fixed=(0,), supports=None, law=None, gamma=GAMMA, **given):
    law = law or bsm.MohrCoulomb(friction=friction)
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="rock"),
        rocks=[bsm.Rock("rock", unit_weight=gamma)],
        joints=[bsm.Joint("J", kn, kn, law=law)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=list(fixed))] if supports is None else supports,
        **given,
    )


def moved_polygons(results):
    """Return the polygons of the blocks as they stand at the end."""
    blocks, displacement = results.blocks, results.stages[-1].displacement
    centroid = blocks.moments.centroid
    return [
        turned(blocks.polygon(b) - centroid[b], np.degrees(displacement[b, 2]), centroid[b] + displacement[b, :2])
        for b in range(blocks.count)
    ]
