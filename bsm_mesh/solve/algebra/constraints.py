"""Exact elimination of supports, block by block.

A supported block's bars are rows c . u = w. The singular value decomposition of its rows gives axes in which
the block is constrained and axes in which it is free; constrained ones are struck out of the equations. No stiff bar
(Wang's 1e20) ever enters the matrix, so soft joints and inclined bars keep their digits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray, rounding_of
from bsm_mesh.errors import ModelError, place
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Bars, bars_of


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Constraints:
    """Constrained and free axes of every supported block.

    Attributes
    ----------
    bars : Bars
        The bars themselves.
    block : (k,) int32
        The supported blocks.
    number : (n,) int32
        Row of each block of the model in the arrays below; -1 without support.
    basis : (k, axes, axes) float64
        Columns: the block's axes in (u, v, theta), in space (u, v, w and a rotation vector), the constrained ones
        first. They are orthonormal once rotations are multiplied by the block's radius of gyration.
    constrained : (k,) int32
        Number of constrained axes.
    prescribed : (n, axes) float64
        Displacements that satisfy every bar and are zero along the free axes.
    slot : (n_bars,) int32
        Place of each bar among its block's bars.
    share : (k, most bars, axes) float64
        Turns a block's reaction (Fx, Fy, M) into the forces in its bars: least squares where they repeat.
    """

    bars: Bars
    block: IntArray
    number: IntArray
    basis: FloatArray
    constrained: IntArray
    prescribed: FloatArray
    slot: IntArray
    share: FloatArray

    @property
    def fixed(self) -> BoolArray:
        """Blocks (n,) with all axes constrained."""
        fixed: BoolArray = self.number >= 0
        fixed[self.block] = self.constrained == self.basis.shape[1]
        return fixed

    def of(self, blocks: IntArray) -> Constraints:
        """Return what `free_part`, `scaled` and `expand` need of some of the blocks (q,), in their numbers."""
        number = self.number[blocks]
        supported = np.flatnonzero(number >= 0)
        rows = number[supported]
        number = np.full(len(blocks), -1, dtype=np.int32)
        number[supported] = np.arange(len(supported))
        block, basis, constrained = supported.astype(np.int32), self.basis[rows], self.constrained[rows]
        prescribed = self.prescribed[blocks]
        return replace(self, block=block, number=number, basis=basis, constrained=constrained, prescribed=prescribed)

    def free_part(self, forces: FloatArray) -> FloatArray:
        """Return forces (n, axes) in the equations' axes with the constrained components zero."""
        free = forces.copy()
        free[self.block] = self._free_part_of_supported(forces)
        return free

    def scaled(self, forces: FloatArray, scale: FloatArray) -> FloatArray:
        """Return `free_part` with the forces of blocks without support multiplied by a scale (n, axes)."""
        free = forces * scale
        free[self.block] = self._free_part_of_supported(forces)  # whose axes have that scale in them
        return free

    def unconstrained(self, forces: FloatArray, scale: FloatArray) -> FloatArray:
        """Project forces (n, axes) onto the axes that supports leave free, times a scale, in the model's own axes."""
        free = self.scaled(forces, scale)
        axes = self.basis / scale[self.block][:, :, None]  # orthonormal
        free[self.block] = np.einsum("kri,ki->kr", axes, free[self.block])
        return free

    def _free_part_of_supported(self, forces: FloatArray) -> FloatArray:
        turned: FloatArray = np.einsum("kri,kr->ki", self.basis, forces[self.block])
        turned[np.arange(self.basis.shape[1]) < self.constrained[:, None]] = 0.0
        return turned

    def expand(self, solution: FloatArray) -> FloatArray:
        """Return displacements (n, axes) from the unknowns along the equations' axes."""
        U = solution.copy()
        U[self.block] = np.einsum("kri,ki->kr", self.basis, solution[self.block])
        return U

    def reactions(self, forces: FloatArray) -> FloatArray:
        """Return the reactions (n, axes) that balance `forces` (n, axes) along the constrained axes."""
        reactions = np.zeros_like(forces)
        inverse = np.linalg.inv(self.basis)  # rows: dual axes, so that the free axes do no work on the reaction
        turned = np.einsum("kri,kr->ki", self.basis, forces[self.block])
        turned[np.arange(self.basis.shape[1]) >= self.constrained[:, None]] = 0.0
        reactions[self.block] = -np.einsum("kir,ki->kr", inverse, turned)
        return reactions

    def bar_forces(self, reactions: FloatArray) -> FloatArray:
        """Return the force in every bar, (n_bars,) [N/m, or N for a rotation], from the blocks' reactions."""
        forces = np.einsum("kbr,kr->kb", self.share, reactions[self.block])
        of_bar: FloatArray = forces[self.number[self.bars.block], self.slot]
        return of_bar


def build_constraints(model: Model) -> Constraints:
    """Return the constraints of the model's supports at the start.

    Raises
    ------
    ModelError
        If bars on one block prescribe displacements that contradict each other.
    """
    bars = bars_of(model.supports, model.blocks)
    return constrain_bars(model, bars, bars.point - model.blocks.moments.centroid[bars.block], bars.value)


def constrain_bars(
    model: Model, bars: Bars, arm: FloatArray, value: FloatArray, *, conflicts: bool = True
) -> Constraints:
    """Return the constraints that bars make of small displacements.

    Parameters
    ----------
    model : Model
        The model.
    bars : Bars
        The bars.
    arm : (n_bars, 2 or 3) float64 [m]
        From the block's centroid to the supported point, at the current position.
    value : (n_bars,) float64 [m or rad]
        The rest of the prescribed displacement.
    conflicts : bool
        Whether contradictions raise a `ModelError`; after large rotations small ones are rounding.
    """
    moments = model.blocks.moments
    block, row_of_bar, counts = np.unique(bars.block, return_inverse=True, return_counts=True)
    slot = _slots(row_of_bar, counts)
    k, most, axes = len(block), int(counts.max(initial=1)), model.blocks.axes
    radius = moments.gyration[block]
    rows, values = np.zeros((k, most, axes)), np.zeros((k, most))
    rows[row_of_bar, slot] = bars.rows(arm / radius[row_of_bar, None])
    # A bar that holds the rotation counts as one at the radius of gyration, or units of length would weigh it.
    lever = np.where(bars.holds_rotation, radius[row_of_bar], 1.0)
    values[row_of_bar, slot] = value * lever
    left, size, own = np.linalg.svd(rows, full_matrices=False) if most >= axes else _svd_padded(rows)
    # A smaller singular value is that of a bar that repeats others, a smaller misfit no contradiction.
    least = np.maximum(ROUNDING, rounding_of(model.blocks.vertices) / radius)
    constrained = (size > least[:, None] * size[:, :1]).sum(axis=1)
    inverse = np.where(np.arange(axes) < constrained[:, None], 1 / np.where(size > 0, size, 1.0), 0.0)
    pseudo = np.einsum("kia,ki,kbi->kab", own, inverse, left)  # (k, axes, bars): (u, v, r theta) from the values
    prescribed = np.einsum("kab,kb->ka", pseudo, values)
    misfit = np.abs(np.einsum("kba,ka->kb", rows, prescribed)[row_of_bar, slot] - value * lever)
    share = np.transpose(pseudo, (0, 2, 1))
    share[row_of_bar, slot] *= lever[:, None]
    if conflicts:
        _check_conflicts(bars, misfit, least[row_of_bar])
    moves = moments.centroid.shape[1]
    scale = np.hstack([np.ones((k, moves)), np.tile(1 / radius[:, None], axes - moves)])
    number = np.full(model.blocks.count, -1, dtype=np.int32)
    number[block] = np.arange(k)
    all_prescribed = np.zeros((model.blocks.count, axes))
    all_prescribed[block] = prescribed * scale
    return Constraints(
        bars=bars,
        block=block.astype(np.int32),
        number=number,
        basis=np.ascontiguousarray(np.transpose(own, (0, 2, 1)) * scale[:, :, None]),
        constrained=constrained.astype(np.int32),
        prescribed=all_prescribed,
        slot=slot,
        share=share * scale[:, None, :],
    )


def _slots(row_of_bar: IntArray, counts: IntArray) -> IntArray:
    """Return the place of each bar among the bars of its block."""
    order = np.argsort(row_of_bar, kind="stable")
    slot = np.empty(len(row_of_bar), dtype=np.int32)
    slot[order] = np.arange(len(row_of_bar)) - np.repeat(np.cumsum(counts) - counts, counts)
    return slot


def _svd_padded(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the decomposition of blocks with fewer bars than axes each, padded with empty bars."""
    axes = rows.shape[2]
    padded = np.concatenate([rows, np.zeros((len(rows), axes - rows.shape[1], axes))], axis=1)
    left, size, axes = np.linalg.svd(padded, full_matrices=False)
    return left[:, : rows.shape[1]], size, axes


def _check_conflicts(bars: Bars, misfit: FloatArray, tolerance: FloatArray) -> None:
    bad = np.flatnonzero(misfit > tolerance * float(np.abs(bars.value).max(initial=0.0)))
    if bad.size:
        raise ModelError(
            [
                f"block {bars.block[i]}: support {bars.support[i] + 1} prescribes {bars.value[i]:g} at "
                f"{place(bars.point[i])}, which contradicts the block's other supports; "
                "remove one of them"
                for i in bad[np.unique(bars.block[bad], return_index=True)[1]]
            ]
        )
