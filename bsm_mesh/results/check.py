"""An independent check of results: equilibrium of every block from the forces alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.results.records import Results, StageResult


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """What was found, worst stage first in every number.

    Attributes
    ----------
    block_residual : float
        Greatest force, or moment over radius of gyration, out of balance of a block, over the reference weight.
    worst_block : int
        The block where it is.
    balance : float
        Sum of loads and reactions, over the sum of their magnitudes.
    tolerance : float
        What both are held to.
    utilisation : float
        Greatest shear force over shear strength; 0 in the linear scheme, where nothing can slip.
    overlap : float [m2]
        Area by which blocks overlap beyond what the contacts' closure accounts for, over the square of their size.
    """

    block_residual: float
    worst_block: int
    balance: float
    tolerance: float
    utilisation: float = 0.0
    overlap: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether all is within the tolerance."""
        at_rest = self.block_residual <= self.tolerance and self.balance <= self.tolerance
        return at_rest and self.utilisation <= 1 + UTILISATION and self.overlap <= OVERLAP

    def __str__(self) -> str:
        """Return one line for a person."""
        verdict = "in equilibrium" if self.ok else "NOT in equilibrium"
        text = (
            f"{verdict}: greatest residual of a block {self.block_residual:.1e} (block {self.worst_block}), "
            f"loads against reactions {self.balance:.1e}, tolerance {self.tolerance:.0e}"
        )
        if self.utilisation > 0:
            text += f"; greatest shear over strength {self.utilisation:.6f}, unexplained overlap {self.overlap:.1e} h2"
        return text


UTILISATION = 1e-9  # a law returns its strength to rounding
OVERLAP = 1.3e-3  # of the square of the block size: what touching within a thousandth of it allows
LINEAR_TOLERANCE = 1e-9  # of the reference weight: a linear solution loses no more than rounding
NONLINEAR_TOLERANCE = 1e-6  # of the reference weight: where the iteration ends


def check_results(results: Results) -> Check:
    """Return the check of all stages."""
    found = [_stage_residual(results, stage) for stage in results.stages]
    residual, block = max(found)
    balance = max(_stage_balance(stage) for stage in results.stages)
    tolerance = LINEAR_TOLERANCE if results.scheme == "linear" else NONLINEAR_TOLERANCE
    moved = results.scheme != "linear"
    return Check(
        block_residual=residual,
        worst_block=block,
        balance=balance,
        tolerance=tolerance,
        utilisation=max(float(s.contacts.utilisation.max(initial=0.0)) for s in results.stages) if moved else 0.0,
        overlap=max(unexplained_overlap(results.blocks, stage) for stage in results.stages) if moved else 0.0,
    )


def unexplained_overlap(blocks: Blocks, stage: StageResult) -> float:
    """Return the overlapping area less the closure of the contacts times their length, over the size squared."""
    owner = blocks.owner
    x, y = (blocks.vertices - blocks.moments.centroid[owner]).T
    u, v, turn = (stage.origin + stage.displacement)[owner].T
    cosine, sine = np.cos(turn), np.sin(turn)
    centre = blocks.moments.centroid[owner]
    corners = centre + np.stack([u + cosine * x - sine * y, v + sine * x + cosine * y], axis=1)
    from bsm_mesh.results.shared_area import shared_area  # compiled code: not before it is needed

    there = stage.present[owner]
    offsets = np.concatenate([[0], np.cumsum(np.diff(blocks.offsets)[stage.present])]).astype(np.int32)
    shared = shared_area(corners[there], offsets)
    closure = float((np.maximum(-stage.contacts.opening, 0.0) * stage.contacts.length).sum())
    return (shared - closure) / float(np.median(blocks.moments.area))


def block_residuals(results: Results, stage: StageResult) -> FloatArray:
    """Return the force out of balance of every block, (n, 3) [N/m, N/m, N/m: moment over radius of gyration]."""
    total = stage.loads + stage.reactions
    centroid = results.blocks.moments.centroid + (stage.origin + stage.displacement)[:, :2] * (
        results.scheme != "linear"
    )
    force = stage.contacts.force
    for block, sign in ((stage.contacts.block_b, 1.0), (stage.contacts.block_a, -1.0)):
        arm = stage.contacts.point - centroid[block]
        moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        for column, part in enumerate((force[:, 0], force[:, 1], moment)):
            total[:, column] += sign * np.bincount(block, part, minlength=len(total))
    block, point, force = stage.bolts.on_blocks()
    arm = point - centroid[block]
    moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
    np.add.at(total, block, np.column_stack([force, moment]))
    total[:, 2] /= results.blocks.moments.gyration
    total[~stage.present] = 0.0
    return total


def _stage_residual(results: Results, stage: StageResult) -> tuple[float, int]:
    size = np.abs(block_residuals(results, stage)).max(axis=1) / max(stage.reference_weight, np.finfo(float).tiny)
    worst = int(size.argmax())
    return float(np.nan_to_num(size[worst], nan=np.inf)), worst  # so that the maximum of stages keeps it


def _stage_balance(stage: StageResult) -> float:
    loads, reactions = stage.loads[stage.present, :2], stage.reactions[stage.present, :2]
    applied = float(np.hypot(*loads.T).sum() + np.hypot(*reactions.T).sum())
    off = float(np.nan_to_num(np.hypot(*(stage.total_load + stage.total_reaction)), nan=np.inf))
    return off / applied if applied > 0 else off
