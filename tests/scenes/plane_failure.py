"""Hoek and Bray's slope: plane failure with a tension crack, water in it, cohesion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import bsm_mesh as bsm

GAMMA, WATER, PHI, C = 26e3, 9.81e3, 37.0, 25e3
TOE, CREST, TOP, CRACK = (0.0, 0.0), (6.928, 12.0), (10.928, 12.0), (10.928, 7.652)


def plane_failure(zw, factor=1.0, cohesion=C, **law):
    """Return the slope with water of a height in the crack [m], its strength reduced by a factor."""
    rock = [(0.0, -15.0), (20.0, -15.0), (20.0, 12.0), TOP, CRACK, TOE]
    sliding, below = np.array([TOE, CRACK, TOP, CREST]), np.array(rock)
    reduced = np.degrees(np.arctan(np.tan(np.radians(PHI)) / factor))
    blocks = bsm.Blocks.from_polygons([below, sliding], rock="rock")
    in_crack = (blocks.vertices[:, 0] == CRACK[0]) & (blocks.vertices[blocks.following, 0] == CRACK[0])
    joints = [
        bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=reduced, cohesion=cohesion / factor, **law)),
        bsm.Joint("crack", 1e10, 1e10, law=bsm.MohrCoulomb(friction=0.0)),
    ]
    return bsm.Model(
        blocks=replace(blocks, edge_joint=np.where(in_crack, 0, -1).astype(np.int32), joint_names=("crack",)),
        rocks=[bsm.Rock("rock", unit_weight=GAMMA)],
        joints=joints,
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
        water=bsm.Water(table=[(0, 0), (CRACK[0], CRACK[1] + zw)]) if zw else None,
    )


def factor_of(zw, cohesion=C, pull=0.0, plunge=0.0):
    """Return the book's factor of safety, with a bolt that pulls with a force [N/m] at a plunge [degrees]."""
    p = np.arctan2(CRACK[1] - TOE[1], CRACK[0] - TOE[0])
    base = float(np.hypot(*np.subtract(CRACK, TOE)))
    x, y = np.array([TOE, CRACK, TOP, CREST]).T
    W = GAMMA * 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    V, U = WATER * zw**2 / 2, WATER * zw * base / 2
    along = np.radians(plunge) + p
    normal = W * np.cos(p) - U - V * np.sin(p) + pull * np.sin(along)
    shear = W * np.sin(p) + V * np.cos(p) - pull * np.cos(along)
    return (cohesion * base + normal * np.tan(np.radians(PHI))) / shear
