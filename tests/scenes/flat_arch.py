"""Flat arches of one or two stones that snap through, and the exact limit.

A stone of length L and height H is between walls on the diagonal, whose angle is b and whose length is D. Turned to
the angle b it thrusts against k, the springs at its ends in series, by ``k (D cos b - L)``, and carries the weight
``W(b) = 2 k tan b (D cos b - L)``, or half of it at its upper corner. The greatest W is the limit.

Two stones meet on a face that turns, so that their shear spring carries a part of the thrust: with shear springs
stiffer than normal ones the formula holds for one stone beside a smooth wall, whose face stays upright.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import bsm_mesh as bsm
from tests.scenes.shapes import rectangle

L = 2.0


def carried(flatness, k):
    """Return angles (m,) of the diagonal from flat to the start, and the weights (m,) carried there."""
    angle = np.linspace(0, np.arctan(flatness), 200_001)
    return angle, 2 * k * np.tan(angle) * (L * np.hypot(1, flatness) * np.cos(angle) - L)


def pair_or_half(flatness, kn, *, half, shear=1.0, friction=80.0):
    """Return two stones between walls, or one beside a smooth wall in the plane of symmetry; and their springs.

    Shear springs are `shear` times as stiff as normal ones.
    """
    height = flatness * L
    held = [rectangle(-L, -L, 0, height + L), rectangle((1 if half else 2) * L, -L, (2 if half else 3) * L, height + L)]
    stones = [rectangle(k * L, 0, (k + 1) * L, height) for k in range(1 if half else 2)]
    blocks = bsm.Blocks.from_polygons([*held, *stones], rock="rock")
    joints = [bsm.Joint("rough", kn, shear * kn, law=bsm.MohrCoulomb(friction=friction))]
    if half:
        joints.append(bsm.Joint("smooth", kn, shear * kn, law=bsm.MohrCoulomb(friction=0.0)))
        at_wall = (blocks.vertices[:, 0] == L) & (blocks.vertices[blocks.following, 0] == L)
        blocks = replace(blocks, edge_joint=np.where(at_wall, 0, -1).astype(np.int32), joint_names=("smooth",))
    return blocks, joints, kn * height / 2 / (2 if half else 1.5)


def snapped(flatness, fraction, kn, *, half, weight=False, stages=1, shear=1.0, friction=80.0):
    """Return the last stage and the exact turn of the stones [rad], nan beyond the limit."""
    blocks, joints, k = pair_or_half(flatness, kn, half=half, shear=shear, friction=friction)
    angle, borne = carried(flatness, k)
    load, top = fraction * borne.max(), int(borne.argmax())
    exact = angle[-1] - np.interp(load, borne[top:][::-1], angle[top:][::-1]) if fraction < 1 else np.nan
    stones = range(2, blocks.count)
    push = [bsm.PointLoad(block=b, point=(L, flatness * L), force=(0.0, -load / 2 / stages)) for b in stones]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=load / (flatness * L**2) if weight else 0.0)],
        joints=joints,
        default_joint="rough",
        supports=[bsm.Fixed(blocks=[0, 1])],
        loads=[] if weight else push,
        stages=[bsm.Stage(name=str(stage), loads=push) for stage in range(1, stages)],
    )
    return bsm.run(model).stages[-1], exact


def is_right(stage, exact, tolerance=5e-3):
    """Return whether verdict and turn are the exact ones."""
    if np.isnan(exact):
        return stage.status == "unstable"
    return stage.status == "stable" and abs(abs(stage.displacement[2, 2]) / exact - 1) < tolerance
