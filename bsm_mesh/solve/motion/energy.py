"""Energy of blocks in motion and in the springs of contacts, in double precision; their real masses."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.model import Model


def spring_energy(contacts: Any, at: Any) -> float:
    """Return the energy in the normal and shear springs of closed contacts, or of points of joints of zones [N]."""
    pressure, shear = np.where(at.closed, at.pressure, 0.0), np.where(at.closed, at.shear, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        normal: FloatArray = np.where(contacts.normal_stiffness > 0, pressure**2 / (2 * contacts.normal_stiffness), 0.0)
        along = np.where(at.springs.stiffness > 0, shear**2 / (2 * at.springs.stiffness), 0.0)
    for feature in contacts.features:
        normal = feature.energies(normal, pressure)
    return float(normal.sum() + along.sum())


def kinetic_energy(model: Model, velocity: FloatArray) -> float:
    """Return the kinetic energy of blocks with velocities (n, 3) [m/s, m/s, rad/s], [N]."""
    mass = real_masses(model.weights, model.blocks)
    return float((mass * velocity**2).sum() / 2)


def real_masses(weights: FloatArray, blocks: Blocks) -> FloatArray:
    """Return the masses of blocks by their weights (n,) [N/m]: (n, 3) [kg/m, kg/m, kg m], about the centroid."""
    moments = blocks.moments
    polar: FloatArray = np.column_stack([np.ones((len(weights), 2)), moments.polar / moments.area])
    return weights[:, None] / GRAVITY * polar
