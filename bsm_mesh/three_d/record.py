"""The record of a stage's end in space: contact forces, supports, mean stress of every block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import counted, place
from bsm_mesh.movements import turned
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.records import SupportForces
from bsm_mesh.solve.continuation.record import contact_columns, motion_outcome
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.solve.stages.scheme import Outcome
from bsm_mesh.three_d.contacts.history import faces_of
from bsm_mesh.three_d.evidence import evidence_of
from bsm_mesh.three_d.loads.water import joint_water
from bsm_mesh.three_d.point_forces import PointForces3D
from bsm_mesh.three_d.step.block_system import BlockSystem


def outcome_of(
    system: BlockSystem, motion: Motion, origin: FloatArray, bars_before: FloatArray, bolts: BoltForces
) -> Outcome:
    """Return the record of a stage's end; displacements count from `origin` (n, 6)."""
    reactions = motion.constraints.reactions(motion.loads + motion.bolts_at.forces + motion.at.forces)
    size = _bar_forces(system, motion, reactions, bars_before)
    kept = np.flatnonzero(motion.at.closed | motion.contacts.within_tolerance)
    contacts = point_forces(system, motion, kept)
    supports = _support_forces(system, motion.position, size)
    effective = _stress(system, motion, contacts, supports)
    water, dyad = system.water.on_blocks(motion.position)
    of_water = (dyad + dyad.transpose(0, 2, 1)) / (2 * system.model.blocks.moments.bulk[:, None, None])
    outcome = motion_outcome(
        motion,
        origin,
        size,
        len(system.model.joints),
        stress=effective + of_water,
        stress_effective=effective,
        reactions=reactions,
        water=water,
        joint_water=joint_water(system.model),
        contacts=contacts,
        supports=supports,
        bolts=bolts,
        evidence=evidence_of(system, motion, kept),
    )
    pairs, depth = system.passed_faces(motion.contacts, motion.position)
    notes = (*outcome.stage.notes, *notes_on_passed(system.centroid[pairs], depth))
    return replace(outcome, stage=replace(outcome.stage, notes=notes))


def notes_on_passed(centroids: FloatArray, depth: FloatArray) -> list[str]:
    """Return a note on pairs of blocks whose faces have passed each other by depths (k,) [m].

    Their centroids as given (k, 2, 3) [m] name them: in a stage blocks have other numbers than in the whole.
    """
    if not len(depth):
        return []
    a, b = map(place, centroids[depth.argmax()])
    return [
        f"faces of {counted(len(depth), 'pair')} of blocks have passed each other without contact, by up to "
        f"{depth.max():.3g} m (the blocks at {a} and {b} m); no force acts there"
    ]


def point_forces(system: BlockSystem, motion: Motion, kept: IntArray) -> PointForces3D:
    """Return the forces of the contact points `kept` (k,) at the end."""
    table, at, c = motion.contacts, motion.at, motion.contacts.candidates
    _, _, arm_a, _ = table.frames(motion.position)
    turn = motion.position[c.block_b[kept], 3:]
    slip = np.linalg.norm(table.along(at.place - table.first_place), axis=1)
    face_a, face_b = faces_of(table.key[kept])
    return PointForces3D(
        **contact_columns(motion, kept, at.size),
        point=system.placed(motion.position)[c.block_a[kept]] + arm_a[kept],
        normal=turned(table.geometry[kept, 6:9], turn),
        shear_force=at.size[kept],
        shear=turned(-at.shear[kept], turn),
        slip=np.nan_to_num(slip)[kept],
        water_pressure=np.zeros(len(kept)),
        face=face_b,
        point_face=face_a,
    )


def _bar_forces(system: BlockSystem, motion: Motion, reactions: FloatArray, before: FloatArray) -> FloatArray:
    """Return the force in every bar, (b,): those before, and the change by least squares where bars repeat."""
    bars, arm = motion.constraints.bars, system.bar_arms(motion.position)
    held = np.zeros_like(reactions)
    np.add.at(held, bars.block, bars.rows(arm) * before[:, None])
    changed: FloatArray = before + motion.constraints.bar_forces(reactions - held)
    return changed


def _support_forces(system: BlockSystem, position: FloatArray, size: FloatArray) -> SupportForces:
    """Return the forces at supported points, those of bars at the same point of the same block added up."""
    bars, arm = system.bars, system.bar_arms(position)
    key = np.column_stack([bars.block, bars.point])
    _, first, place = np.unique(key, axis=0, return_index=True, return_inverse=True)
    action = bars.rows(np.zeros_like(arm)) * size[:, None]
    total = np.zeros((len(first), 6))
    np.add.at(total, place.reshape(-1), action)
    block = bars.block[first]
    point = system.placed(position)[block] + arm[first]
    return SupportForces(block=block, point=point, reaction=total[:, :3], moment=total[:, 3:])


def _stress(system: BlockSystem, motion: Motion, contacts: PointForces3D, supports: SupportForces) -> FloatArray:
    """Return the mean stress of every block, (n, 3, 3) [Pa]: forces times their arms over the volume."""
    placed = system.placed(motion.position)
    total = np.zeros((len(placed), 3, 3))
    bolted = motion.bolts.on_blocks(motion.bolts_at)
    parts = [
        (contacts.block_b, contacts.point, contacts.force),
        (contacts.block_a, contacts.point, -contacts.force),
        (supports.block, supports.point, supports.reaction),
        system.point_forces_at(motion.position),
        (bolted.block, bolted.point, bolted.force),
    ]
    for block, point, force in parts:
        np.add.at(total, block, (point - placed[block])[:, :, None] * force[:, None, :])
    mean = (total + total.transpose(0, 2, 1)) / 2
    stress: FloatArray = mean / system.model.blocks.moments.bulk[:, None, None]
    return stress
