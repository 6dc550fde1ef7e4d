"""A column of blocks in shear: waves from its moving base go through a joint in the middle, and end before they return.

Rollers on both sides hold the blocks upright. Springs between rigid blocks have the shear stiffness of the rock. So the
column is a chain, and its waves have the rock's speed and impedance where a wavelength has many blocks.
"""

from __future__ import annotations

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from tests.scenes.shapes import rectangle

SHEAR_MODULUS, DENSITY = 10e9, 2600.0  # Pa, kg/m3
IMPEDANCE, SPEED = np.sqrt(SHEAR_MODULUS * DENSITY), np.sqrt(SHEAR_MODULUS / DENSITY)
BELOW, ABOVE = "below", "above"


def in_time(count, height):
    """Return how long a column is as if endless, seen from its middle [s]: until waves come back from both ends."""
    return 1.5 * count * height / SPEED


def column(shaking, count, height, stiffness=None, strength=None):
    """Return a column of so many blocks, with a joint in its middle of a stiffness [Pa/m] and a shear strength [Pa].

    Without them the rock continues there. The joint's face has the rock's spring in series with the joint's.
    """
    middle, own = count // 2, SHEAR_MODULUS / height
    blocks = bsm.Blocks.from_polygons(
        [rectangle(0, height * k, 1, height * (k + 1)) for k in range(count)], rock="rock"
    )
    blocks = blocks.with_boundary("sides", lambda x, y: np.minimum(x, 1 - x) < 1e-6)
    blocks = blocks.with_joint("J", lambda x, y: np.abs(y - middle * height) < 1e-6)
    joint = own if stiffness is None else 1 / (1 / own + 1 / stiffness)
    law = None if strength is None else bsm.MohrCoulomb(friction=0, cohesion=strength)
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=DENSITY * GRAVITY)],
        joints=[
            bsm.Joint("rock", normal_stiffness=own, shear_stiffness=own),
            bsm.Joint("J", normal_stiffness=joint, shear_stiffness=joint, law=law),
        ],
        default_joint="rock",
        supports=[bsm.Fixed(blocks=[0]), bsm.Roller(boundary="sides", direction=90)],
        in_situ=bsm.InSitu(stress={"xx": -1e6, "yy": -1e6}),
        gravity_vertical=1.0,  # no weights
        stages=[bsm.Stage(name="wave", shaking=shaking)],
        histories=[bsm.History(name=BELOW, block=middle - 1), bsm.History(name=ABOVE, block=middle)],
    )


def velocities(results, shaking):
    """Return times and, by history, velocities in space, of the base's frame no more: means between two times."""
    steps = [step for stage in results.stages for step in stage.steps]
    shaken = np.array([step.time is not None for step in steps])
    time = np.append(0.0, [step.time for step in steps if step.time is not None])
    middle = (time[1:] + time[:-1]) / 2
    base = BaseMotion(shaking).velocity_at(middle)
    moved = {name: np.append(0.0, np.asarray(results.histories[name]["u"])[shaken]) for name in (BELOW, ABOVE)}
    return middle, {name: np.diff(u) / np.diff(time) + base for name, u in moved.items()}
