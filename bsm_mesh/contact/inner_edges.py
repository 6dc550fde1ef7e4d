"""Corners that a block slides over: they lie in the plane in which it lies flat on a third block.

A block that slides over two blocks meets the second one's corner where its edge is level with the first one. Springs
let the block sink a little, and its front edge would catch on that corner. The block's own corner meets the second
one's edge instead.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.contact.outlines import Record, RecordArray
from bsm_mesh.contact.rules import Rules


@njit(nogil=True, allocates=True)
def edges_on_blocks(
    vertices: RecordArray, owner: IntArray, active: RecordArray, rules: Rules
) -> IntArray:  # pragma: no cover - compiled
    """Return two blocks on which each edge lies flat, (n_vertices, 2); -1: none.

    The active contacts say so, also those without pressure. Of more than two blocks only two are there.
    """
    found = np.full((owner.size, 2), -1, np.int32)
    for q in range(active.size):
        v, e = active[q].key >> 32, active[q].key & 0xFFFFFFFF
        for side in range(2):
            f = v if side == 0 else vertices[v].preceding
            one, other = vertices[f], vertices[e]
            if one.dx * other.dx + one.dy * other.dy < 0.0 and abs(_cross(one, other)) <= rules.parallel:
                _set_one(found, f, owner[e])
                _set_one(found, e, owner[v])
    return found


@njit(forceinline=True)
def _set_one(found: IntArray, edge: int, block: int) -> None:  # pragma: no cover - compiled
    """Set a block on which an edge lies, where it is not known."""
    if found[edge, 0] < 0 or found[edge, 0] == block:
        found[edge, 0] = block
    else:
        found[edge, 1] = block


@njit(forceinline=True)
def _cross(one: Record, other: Record) -> float:  # pragma: no cover - compiled
    """Return the sine between the edges that start at two corners."""
    sine: float = one.dx * other.dy - one.dy * other.dx
    return sine


@njit(forceinline=True)
def slides_over(
    vertices: RecordArray, given: FloatArray, on_block: IntArray, h: float, rules: Rules, row: Record
) -> bool:  # pragma: no cover - compiled
    """Whether the block with the edge slides over the corner of a row, on a third block.

    The edge ends where the block's next edge lies flat on a third block. The corner is level with that edge. None
    of its own edges lies in that plane, as those of a block that slides there too. The block slid along it, from where
    the corners were `given` (n_vertices, 2) [m].
    """
    v, e = row.corner, row.edge
    at_start = row.tangential < 0.5 * row.edge_length
    f, w = (vertices[e].preceding, e) if at_start else (vertices[e].following, vertices[e].following)
    third, beside = False, False
    for side in range(2):
        third |= on_block[f, side] >= 0 and on_block[f, side] != row.block_a
        end = vertices[v].following if side == 0 else vertices[v].preceding
        beside |= abs(_height(vertices[end], vertices[w], vertices[f])) < rules.min_overlap * h
    if beside or not third:
        return False
    if abs(_height(vertices[v], vertices[w], vertices[f])) >= rules.min_overlap * h:
        return False
    moved_x = vertices[v].x - vertices[w].x - given[v, 0] + given[w, 0]
    moved_y = vertices[v].y - vertices[w].y - given[v, 1] + given[w, 1]
    along = moved_x * vertices[f].dx + moved_y * vertices[f].dy
    across = moved_x * vertices[f].dy - moved_y * vertices[f].dx
    return bool(abs(along) > rules.detach_tol * h and abs(across) <= rules.parallel * abs(along))


@njit(forceinline=True)
def _height(point: Record, corner: Record, edge: Record) -> float:  # pragma: no cover - compiled
    """Return how far a corner is out of the line through another along an edge [m]."""
    height: float = (point.x - corner.x) * edge.dy - (point.y - corner.y) * edge.dx
    return height
