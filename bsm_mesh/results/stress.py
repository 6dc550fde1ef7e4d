"""Average stress of every block from the forces on it."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.kernels import add_contact_moments
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.loads import PointForces
from bsm_mesh.results.records import ContactForces, StageResult, SupportForces

PointForce = tuple[IntArray, FloatArray, FloatArray]
"""Blocks (k,), points (k, 2) [m] and forces (k, 2) [N/m]."""
SLIVER = 0.01  # of the mean area of blocks


def block_stress(
    blocks: Blocks,
    centroid: FloatArray,
    contacts: ContactTable | ContactForces,
    normal_force: FloatArray,
    shear_force: FloatArray,
    point_forces: tuple[PointForce, ...],
) -> FloatArray:
    """Return the average stress, (n, 2, 2) [Pa], tension positive (Wang Eq. 3.45, Appendix B).

    The sum x_i F_j runs over contacts, loads and supports, with x from the centroid, so that the weight drops
    out (Eq. B.13). It is symmetric where the block is in equilibrium of moments; a block whose rotation is held
    at its centroid is not, and the symmetric part is returned. Where a block is held as a whole (`Fixed` with
    blocks) the place of the reaction is unknown and its contribution is left out.

    Parameters
    ----------
    blocks : Blocks
        For their areas.
    centroid : (n, 2) float64 [m]
        Where they are.
    contacts : ContactTable or ContactForces
        Who touches where.
    normal_force, shear_force : (m,) float64 [N/m]
        Contact forces.
    point_forces : tuple of PointForce
        Loads and support forces.
    """
    dyad = np.zeros((blocks.count, 2, 2))
    add_contact_moments(
        contacts.block_a,
        contacts.block_b,
        contacts.point,
        contacts.normal,
        normal_force,
        shear_force,
        centroid,
        dyad,
    )
    for block, point, force in point_forces:
        arm = point - centroid[block]
        np.add.at(dyad, block, arm[:, :, None] * force[:, None, :])
    stress: FloatArray = (dyad + dyad.transpose(0, 2, 1)) / (2 * blocks.moments.area[:, None, None])
    return stress


def total_and_effective_stress(
    blocks: Blocks,
    centroid: FloatArray,
    contacts: ContactForces,
    acting: tuple[PointForces, SupportForces],
    water: tuple[PointForce, ...],
) -> tuple[FloatArray, FloatArray]:
    """Return the average total stress of every block, and the effective one, (n, 2, 2) each [Pa].

    Contact and support forces are effective ones. With the water's forces their sum gives the total; without them
    the effective stress: the sum over the water alone is minus its mean pressure in the block, on the diagonal.
    """
    loads, supports = acting
    forces = ((loads.block, loads.point, loads.force), (supports.block, supports.point, supports.reaction))
    normal_force, shear_force = contacts.normal_force, contacts.shear_force
    effective = block_stress(blocks, centroid, contacts, normal_force, shear_force, forces)
    if not water:
        return effective, effective
    return block_stress(blocks, centroid, contacts, normal_force, shear_force, (*forces, *water)), effective


def stress_is_known(blocks: Blocks, stage: StageResult) -> BoolArray:
    """Return the blocks (n,) whose average stress says something of the rock.

    Not those that supports hold at two points or more in all directions, or as a whole. Statics does not give the
    place of their reactions; zones do. Not corner slivers, under `SLIVER` of the mean area (in space: volume).
    """
    present, supports = stage.present, stage.supports
    bulk = blocks.moments.bulk
    mean = float(bulk[present].mean()) if present.any() else 0.0
    if stage.zones is not None:
        within: BoolArray = present & (stage.zones.of_pieces(bulk * present) >= SLIVER * mean)
        return within
    both = np.flatnonzero(np.abs(supports.reaction).min(axis=1, initial=np.inf) > 0)
    held = np.bincount(supports.block[both], minlength=blocks.count)
    moments = np.abs(supports.moment)
    turns = moments if moments.ndim == 1 else moments.sum(axis=1)  # in space of three components
    whole = np.bincount(supports.block, turns, minlength=blocks.count) > 0
    known: BoolArray = present & (held < 2) & ~whole & (bulk >= SLIVER * mean)
    return known


def extreme_stresses(blocks: Blocks, stage: StageResult) -> tuple[float, float, int]:
    """Return the most compressive and the most tensile principal stress [Pa], and of how many blocks it is unknown.

    They are those of the blocks of which `stress_is_known`; of all, where it is of none.
    """
    known = stress_is_known(blocks, stage)
    sigma_1, sigma_3 = principal_stresses(stage.stress[known if known.any() else stage.present])
    return float(sigma_1.min()), float(sigma_3.max()), int((stage.present & ~known).sum())


def extreme_zone_stresses(stage: StageResult) -> tuple[float, float]:
    """Return the most compressive and the most tensile principal stress of a zone of blocks that count [Pa].

    NaN without zones.
    """
    zones = stage.zones
    chosen = np.zeros(0, np.intp) if zones is None else np.flatnonzero(stage.counts[zones.block])
    if zones is None or not len(chosen):
        return np.nan, np.nan
    sigma_1, sigma_3 = principal_stresses(zones.stress[chosen])
    return float(sigma_1.min()), float(sigma_3.max())


def principal_stresses(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (sigma_1, sigma_3) [Pa]: the most and the least compressive principal stress, tension positive."""
    if stress.shape[1] > 2:
        sigma = np.linalg.eigvalsh(stress).astype(np.float64)
        return sigma[:, 0], sigma[:, -1]
    mean = (stress[:, 0, 0] + stress[:, 1, 1]) / 2
    radius = np.hypot((stress[:, 0, 0] - stress[:, 1, 1]) / 2, stress[:, 0, 1])
    return mean - radius, mean + radius
