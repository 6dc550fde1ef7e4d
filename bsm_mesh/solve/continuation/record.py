"""The record of a stage's end, in the plane and in space: columns and fields that follow from the motion alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.strength import MAX_UTILISATION
from bsm_mesh.results.records import ContactStatus, StageResult
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.solve.stages.scheme import Outcome


def motion_outcome(motion: Motion, origin: FloatArray, bar_forces: FloatArray, joints: int, **known: Any) -> Outcome:
    """Return a stage's end with its forces and stresses.

    Parameters
    ----------
    motion : Motion
        State and verdict at the end.
    origin : (n, axes) float64 [m, rad]
        Position that the stage's displacements count from.
    bar_forces : (b,) float64 [N/m]
        Forces in the bars of the supports; in space [N].
    joints : int
        Number of the model's joints.
    known
        Fields of `StageResult` that depend on the kind of the blocks, by their names.
    """
    stage = StageResult.of_submodel(
        motion.position,
        joints,
        status=motion.status,
        reason=motion.reason,
        stage_displacement=motion.position - origin,
        loads=motion.loads,
        unstable_blocks=motion.unstable_blocks,
        start_residual=motion.start_residual,
        residual=motion.residual,
        reference_weight=motion.reference,
        steps=motion.steps,
        **known,
    )
    return Outcome(stage, bar_forces, motion.down, motion.small)


def contact_columns(motion: Motion, kept: IntArray, shear: FloatArray) -> dict[str, Any]:
    """Return fields of `ContactForces` that need no axes, of the contacts `kept` (k,).

    `shear` (m,) is the magnitude of the shear force of every contact [N/m]; in space [N].
    """
    at, c = motion.at, motion.contacts.candidates
    status = np.where(at.at_strength, ContactStatus.SLIPPING, ContactStatus.STICKING)
    status = np.where(at.closed, status, ContactStatus.OPEN)
    with np.errstate(divide="ignore", invalid="ignore"):
        used = np.where(at.bears & (shear > 0), shear / at.strength, 0.0)  # without strength: infinite
    return {
        "block_a": c.block_a[kept],
        "block_b": c.block_b[kept],
        "length": c.length[kept],
        "normal_force": -at.pressure[kept],
        "opening": at.gap[kept],
        "status": status[kept].astype(np.int8),
        "utilisation": np.minimum(used, MAX_UTILISATION)[kept],
        "joint": motion.contacts.joint[kept],
    }
