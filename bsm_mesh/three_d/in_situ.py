"""Contact points under the in-situ stress, in the given geometry (Wang 4.5.1 without turning gravity on)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.in_situ import beyond_strength
from bsm_mesh.model.model import Model
from bsm_mesh.three_d.contacts.contact_set import ContactSet
from bsm_mesh.three_d.contacts.history import PointHistory
from bsm_mesh.three_d.loads.water import joint_water
from bsm_mesh.three_d.step.block_system import BlockSystem
from bsm_mesh.three_d.stress_field import SpaceStress


def in_situ_history(model: Model) -> tuple[PointHistory, tuple[str, ...]]:
    """Return contact points with the forces of the in-situ field in the given geometry, and notes on it.

    A point has the effective traction there times its area. The resultant of a linear field on the face is exact, and
    so is the moment of a uniform one. The closure under the field is taken as past.
    """
    system = BlockSystem(model)
    found = system.gather(PointHistory.none(), system.start, first=True)
    found = found.some(np.flatnonzero(found.within_tolerance), np.arange(len(system.start), dtype=np.int32))
    point = system.centroid[found.candidates.block_a] + found.geometry[:, :3]
    force = _forces(system, found, point)  # on a
    normal = found.geometry[:, 6:9]
    pressure = np.einsum("ij,ij->i", force, normal)
    shear = force - pressure[:, None] * normal
    _, place, *_ = found.frames(system.start)
    offset = found.gaps(place) + found.features.closure.overlaps(pressure, found.normal_stiffness)
    history = found.closed_history(place, shear, offset)
    size = np.linalg.norm(shear, axis=1)
    under_stress = replace(found, offset=history.offset, old_shear=shear)
    at = system.evaluate_contacts(under_stress, system.catalogue.laws, system.start)
    peak = np.where(at.closed, at.strength, np.inf)  # tension beyond the strength is reported as such
    return history, beyond_strength(point, pressure, size, peak, found.tension)


def _forces(system: BlockSystem, found: ContactSet, point: FloatArray) -> FloatArray:
    """Return the effective forces of the field on block a of contact points, (m, 3) [N]: normals point into a."""
    normal, area = found.geometry[:, 6:9], found.candidates.length
    own = np.append(joint_water(system.model), np.nan)[found.joint]
    traction = -np.einsum("kij,kj->ki", SpaceStress(system.model).at(point), normal)
    effective: FloatArray = area[:, None] * (traction - system.water.pressure_at(point, own)[:, None] * normal)
    return effective
