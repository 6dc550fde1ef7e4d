"""Mechanisms: parts of the model that can move as rigid bodies because their supports leave them free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import ROUNDING, FloatArray, IntArray, rounding_of
from bsm_mesh.errors import listing, place
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.algebra.constraints import Constraints


def connected_parts(pattern: BlockPattern) -> IntArray:
    """Return the number of the connected part to which each block belongs, (n,) int32."""
    n = pattern.rows
    graph = csr_array((np.ones(len(pattern.column), np.int8), pattern.column, pattern.row_start), shape=(n, n))
    part: IntArray = connected_components(graph, directed=False)[1].astype(np.int32)
    return part


@dataclass(frozen=True, eq=False, slots=True)
class FreePart:
    """Blocks that can move as a whole: which (k,), and a sentence about it."""

    blocks: IntArray
    text: str


def free_parts(
    blocks: Blocks, constraints: Constraints, pattern: BlockPattern, names: IntArray | None = None
) -> list[FreePart]:
    """Return every connected part that its supports leave free to move; `names` (n,) number blocks in sentences."""
    all_there, names = names is None, np.arange(blocks.count) if names is None else names
    part = connected_parts(pattern)
    count = int(part.max()) + 1
    bars = constraints.bars
    settled = np.zeros(count, dtype=bool)
    settled[part[constraints.fixed]] = True
    with_bars = np.zeros(count, dtype=bool)
    with_bars[part[bars.block]] = True
    found = []
    for p in np.flatnonzero(~settled):
        members = np.flatnonzero(part == p)
        motion = _free_motion(constraints, part[bars.block] == p) if with_bars[p] else "move in any direction"
        if motion:
            whole = all_there and count == 1 and len(members) == blocks.count
            where = place(blocks.moments.centroid[members[0]])
            part_name = "the model" if whole else f"block {listing(names[members])} at {where}"
            held = "no support holds it" if not with_bars[p] else "its supports do not hold it"
            cure = (
                "hold a boundary, a block or a point of it" if not with_bars[p] else "add a support across that motion"
            )
            found.append(FreePart(members, f"{part_name} is free to {motion}: {held}; {cure}"))
            if len(found) > 100:  # each is a sentence; nobody reads more
                break
    return found


def _free_motion(constraints: Constraints, chosen: FloatArray) -> str:
    """Return in words the rigid motion that the chosen bars allow; empty if they allow none."""
    bars = constraints.bars
    point, direction = bars.point[chosen], bars.direction[chosen]
    centre = point.mean(axis=0)
    arm = point - centre
    size = max(float(np.abs(arm).max()), 1e3 * rounding_of(point), 1e-300)
    moment = (arm[:, 0] * direction[:, 1] - arm[:, 1] * direction[:, 0]) / size + bars.holds_rotation[chosen]
    rows = np.column_stack([direction, moment])
    _, values, axes = np.linalg.svd(np.vstack([rows, np.zeros((3, 3))]))
    rank = int((values > max(ROUNDING, rounding_of(point) / size) * values[0]).sum())
    if rank == 3:
        return ""
    u, v, turn = axes[rank]
    if rank == 1:  # of two free motions name the plain one, a slide
        u, v, turn = axes[1] * axes[2, 2] - axes[2] * axes[1, 2]
        u, v, turn = (u, v, 0.0) if np.hypot(u, v) > ROUNDING else axes[1]
    if abs(turn) < 1e-6:
        return f"slide in the direction {np.degrees(np.arctan2(v, u)) % 180:.4g} degrees"
    x, y = centre[0] - v * size / turn, centre[1] + u * size / turn
    return f"turn about {place((x, y))}"
