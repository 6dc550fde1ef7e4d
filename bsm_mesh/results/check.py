"""An independent check of results: equilibrium of every block from the forces alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh import space
from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import place
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.results.records import StageResult

if TYPE_CHECKING:
    from bsm_mesh.results.results import Results


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """Findings of the check; every number is that of the worst stage.

    Attributes
    ----------
    block_residual : float
        Greatest force, or moment over radius of gyration, out of balance of a block, over the reference weight.
    worst_block : int
        The block where it is.
    balance : float
        Sum of loads and reactions, over the sum of their magnitudes, or the reference weight if that is greater.
    tolerance : float
        Tolerance of both: that of the run; of a linear one no more than rounding.
    rounding : float
        Part of that block's residual that rounding of the coordinates can cause: far from the origin it counts.
    utilisation : float
        Greatest shear force over shear strength; 0 in the linear scheme, where nothing can slip.
    overlap : float
        Area by which blocks overlap beyond the contacts' closure, over the square of their size; in space the volume
        over the median volume.
    bulk : str
        Kind of both: area or volume.
    where : str
        The two blocks of the plane that overlap most, where `overlap` is beyond its tolerance.
    """

    block_residual: float
    worst_block: int
    balance: float
    tolerance: float
    rounding: float = 0.0
    utilisation: float = 0.0
    overlap: float = 0.0
    bulk: str = "area"
    where: str = ""

    @property
    def ok(self) -> bool:
        """Whether all is within the tolerance."""
        return not self.faults

    @property
    def faults(self) -> tuple[str, ...]:
        """Quantities beyond their tolerance, in words."""
        least, off = f"tolerance {self.tolerance:.0e}", f"{self.block_residual:.1e} of the reference weight"
        told = (
            (
                self.block_residual <= self.tolerance + self.rounding,
                f"block {self.worst_block} is out of balance by {off} ({least})",
            ),
            (
                self.balance <= self.tolerance,
                f"loads and reactions differ by {self.balance:.1e} of their sum ({least})",
            ),
            (self.utilisation <= 1 + UTILISATION, f"a contact carries {self.utilisation:.6g} times its shear strength"),
            (
                self.overlap <= OVERLAP,
                f"blocks have passed into each other by {self.overlap:.2g} of a block's {self.bulk}{self.where}",
            ),
        )
        return tuple(text for holds, text in told if not holds)  # not a number holds nothing

    def __str__(self) -> str:
        """Return one line for a person."""
        verdict = "in equilibrium" if self.ok else "NOT in equilibrium"
        text = (
            f"{verdict}: greatest residual of a block {self.block_residual:.1e} (block {self.worst_block}), "
            f"loads against reactions {self.balance:.1e}, tolerance {self.tolerance:.0e}"
        )
        if self.utilisation > 0:
            beyond = f"{self.overlap:.1e} of a block's {self.bulk}" if self.overlap > 0 else "none"
            text += (
                f"; greatest shear over strength {self.utilisation:.6f}; overlap beyond the joints' closure: {beyond}"
            )
        return text


UTILISATION = 1e-9  # a law returns its strength to rounding
OVERLAP = 1.3e-3  # of the square of the block size: what touching within a thousandth of it allows
LINEAR_TOLERANCE = 1e-9  # of the reference weight: a linear solution loses no more than rounding
ROUNDINGS = 4.0 * np.finfo(float).eps  # of coordinates, in an arm: of the point, the centroid and its movement


def check_results(results: Results) -> Check:
    """Return the check of all stages."""
    found = [_check_stage(results, stage) for stage in results.stages]
    worst = max(found, key=lambda check: _excess(check.block_residual, check.rounding))
    greatest = {name: max(getattr(check, name) for check in found) for name in ("balance", "utilisation", "overlap")}
    return replace(worst, **greatest, where=max(found, key=lambda check: check.overlap).where)


def _check_stage(results: Results, stage: StageResult) -> Check:
    if in_space(results.blocks):
        return space.check_stage(results, stage)
    fails = results.scheme != "linear"
    reference = max(stage.reference_weight, np.finfo(float).tiny)
    residual = np.abs(block_residuals(results, stage)).max(axis=1) / reference
    rounding = _rounding(results, stage) / reference
    worst = int(_excess(residual, rounding).argmax())
    used = _finite(stage.contacts.utilisation.max(initial=0.0))
    overlap = 0.0 if results.has_small_displacements else _finite(unexplained_overlap(results.blocks, stage))
    return Check(
        block_residual=_finite(residual[worst]),
        worst_block=worst,
        balance=_stage_balance(stage),
        tolerance=results.tolerance if fails else min(results.tolerance, LINEAR_TOLERANCE),
        rounding=float(rounding[worst]),
        utilisation=used if fails else 0.0,
        overlap=overlap,
        where=_greatest_overlap(results.blocks, stage) if overlap > OVERLAP else "",
    )


def _finite(value: float) -> float:
    """Return a number; NaN counts as infinite, so that the maximum of stages keeps it."""
    return float(np.nan_to_num(value, nan=np.inf))


def _excess(residual: Any, rounding: Any) -> Any:
    return np.nan_to_num(residual - rounding, nan=np.inf)


def unexplained_overlap(blocks: Blocks, stage: StageResult) -> float:
    """Return the overlapping area less the closure of the contacts times their length, over the size squared."""
    from bsm_mesh.results.shared_area import shared_area  # compiled code: not before it is needed

    closure = float((np.maximum(-stage.contacts.opening, 0.0) * stage.contacts.length).sum())
    return (shared_area(*_outlines_there(blocks, stage)) - closure) / float(np.median(blocks.moments.area))


def _greatest_overlap(blocks: Blocks, stage: StageResult) -> str:
    """Return which two blocks share the greatest area, where, and the most likely reasons."""
    from bsm_mesh.results.shared_area import greatest_pair  # compiled code: not before it is needed

    one, other = np.flatnonzero(stage.present)[list(greatest_pair(*_outlines_there(blocks, stage)))].tolist()
    at = place(blocks.moments.centroid[min(one, other, key=lambda block: blocks.moments.area[block])].round(2))
    return (
        f", most blocks {one} and {other} near {at}: corners may have met in a point, or fill with a support lies "
        "over displaced rock; divide the blocks differently, or fill without the support"
    )


def _outlines_there(blocks: Blocks, stage: StageResult) -> tuple[FloatArray, IntArray]:
    """Return corners and offsets of the blocks that are there, at the end of a stage."""
    evidence = stage.evidence
    if evidence is not None and evidence.outline is not None and evidence.outline_offsets is not None:
        corners, offsets = evidence.outline - evidence.outline[0], evidence.outline_offsets
    else:
        corners, offsets = _placed_corners(blocks, stage), blocks.offsets
    there = np.repeat(stage.present, np.diff(offsets))
    starts = np.concatenate([[0], np.cumsum(np.diff(offsets)[stage.present])]).astype(np.int32)
    return corners[there], starts


def _placed_corners(blocks: Blocks, stage: StageResult) -> FloatArray:
    """Return the corners of rigid blocks at the end of a stage, (n_vertices, 2) [m], from the first centroid."""
    owner, centroid = blocks.owner, blocks.moments.centroid
    x, y = (blocks.vertices - centroid[owner]).T
    u, v, turn = (stage.origin + stage.displacement)[owner].T
    cosine, sine = np.cos(turn), np.sin(turn)
    centre = (centroid - centroid[0])[owner]  # near the origin, that rounding is of the model's size
    corners: FloatArray = centre + np.stack([u + cosine * x - sine * y, v + sine * x + cosine * y], axis=1)
    return corners


def block_residuals(results: Results, stage: StageResult) -> FloatArray:
    """Return the force out of balance of every block, (n, 3) [N/m, N/m, N/m: moment over radius of gyration]."""
    total, centroid = stage.loads + stage.reactions, _centroids(results, stage)
    for block, point, force in point_forces(stage):
        arm = point - centroid[block]
        moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        for column, part in enumerate((force[:, 0], force[:, 1], moment)):
            total[:, column] += np.bincount(block, part, minlength=len(total))
    total[:, 2] /= results.blocks.moments.gyration
    total[~stage.present] = 0.0
    return total


def _rounding(results: Results, stage: StageResult) -> FloatArray:
    """Return the part of the blocks' residuals that rounding of coordinates can cause, by their moments, (n,) [N/m]."""
    borne = np.zeros(results.blocks.count)
    for block, _, force in point_forces(stage):
        borne += np.bincount(block, np.hypot(*force.T), minlength=len(borne))
    far = float(np.abs(_centroids(results, stage)[stage.present]).max(initial=0.0))
    return ROUNDINGS * far * borne / results.blocks.moments.gyration


def point_forces(stage: StageResult) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    """Yield block, point and force of what acts at points of blocks: contacts, on both sides, and bolts."""
    contacts, force = stage.contacts, stage.contacts.force
    yield contacts.block_b, contacts.point, force
    yield contacts.block_a, contacts.point, -force
    yield stage.bolts.on_blocks()


def _centroids(results: Results, stage: StageResult) -> FloatArray:
    moved = (stage.origin + stage.displacement)[:, :2] * (not results.has_small_displacements)
    return results.blocks.moments.centroid + moved


def _stage_balance(stage: StageResult) -> float:
    loads, reactions = stage.loads[stage.present, :2], stage.reactions[stage.present, :2]
    applied = float(np.hypot(*loads.T).sum() + np.hypot(*reactions.T).sum())
    off = _finite(np.hypot(*(stage.total_load + stage.total_reaction)))
    measure = max(applied, stage.reference_weight)  # pretension alone is neither load nor reaction
    return off / measure if measure > 0 else off
