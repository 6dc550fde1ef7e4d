"""An independent check of results in space: equilibrium of every block from the forces alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.movements import cross
from bsm_mesh.results.check import ROUNDINGS, Check, point_forces
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.three_d.overlap import unexplained_overlap


def check_stage(results: Results, stage: StageResult) -> Check:
    """Return the check of a stage: balance of every block and of the whole, shear within strength."""
    reference = max(stage.reference_weight, np.finfo(float).tiny)
    blocks: Any = results.blocks
    moments = blocks.moments
    centroid = moments.centroid + (stage.origin + stage.displacement)[:, :3]
    total, borne = stage.loads + stage.reactions, np.zeros(len(centroid))
    for block, point, force in point_forces(stage):
        np.add.at(total, block, np.hstack([force, cross(point - centroid[block], force)]))
        borne += np.bincount(block, np.linalg.norm(force, axis=1), minlength=len(borne))
    total[:, 3:] /= moments.gyration[:, None]
    total[~stage.present] = 0.0
    far = float(np.abs(centroid[stage.present]).max(initial=0.0))
    residual, rounding = np.abs(total).max(axis=1) / reference, ROUNDINGS * far * borne / moments.gyration / reference
    worst = int(np.nan_to_num(residual - rounding, nan=np.inf).argmax())
    loads, reactions = stage.loads[stage.present, :3], stage.reactions[stage.present, :3]
    applied = max(np.linalg.norm(loads, axis=1).sum() + np.linalg.norm(reactions, axis=1).sum(), reference)
    return Check(
        block_residual=float(np.nan_to_num(residual[worst], nan=np.inf)),
        worst_block=worst,
        balance=float(np.nan_to_num(np.linalg.norm(stage.total_load + stage.total_reaction) / applied, nan=np.inf)),
        tolerance=results.tolerance,
        rounding=float(rounding[worst]),
        utilisation=float(np.nan_to_num(stage.contacts.utilisation.max(initial=0.0), nan=np.inf)),
        overlap=unexplained_overlap(blocks, stage),
        bulk=blocks.bulk_name,
    )
