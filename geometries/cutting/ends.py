"""Ends of traces brought exactly onto the lines that they nearly touch.

An end within the tolerance of another end becomes the same point; one within the tolerance of another line moves along
its own line onto that one, which gets a vertex there. A joint that ends at another, a hair too short or too long, then
meets it without depending on how a grid rounds.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from bsm_mesh.geometries.cutting.pieces import IntArray, Pieces
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.merged_points import merge_points

FARTHEST = 50.0  # tolerances that an end moves along its own line to a line that it meets at a small angle


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lines:
    """The pieces with a vertex wherever another one ends on them.

    Attributes
    ----------
    pieces : Pieces
        The pieces, their ends moved.
    vertices : (n, 2) float64 [m]
        Vertices, piece after piece, each from end to end.
    owner : (n,) int64
        Piece of every vertex.
    """

    pieces: Pieces
    vertices: FloatArray
    owner: IntArray


def join_ends(pieces: Pieces, tolerance: float) -> Lines:
    """Return the pieces with their ends joined to lines within the tolerance."""
    ends = _merge_ends(pieces, tolerance)
    pieces = dataclasses.replace(pieces, ends=ends)
    pieces = pieces.chosen(pieces.length > tolerance)
    end, target, place = _on_lines(pieces, tolerance)
    moved = pieces.ends.reshape(-1, 2).copy()
    moved[end] = place
    pieces = dataclasses.replace(pieces, ends=moved.reshape(-1, 2, 2))
    pieces = dataclasses.replace(pieces, ends=_merge_ends(pieces, tolerance))
    place = pieces.ends.reshape(-1, 2)[end]
    start, vector = pieces.ends[target, 0], pieces.ends[target, 1] - pieces.ends[target, 0]
    squared = np.maximum(np.einsum("nj,nj->n", vector, vector), np.finfo(np.float64).tiny)
    share = np.einsum("nj,nj->n", place - start, vector) / squared
    inside = (share > 0) & (share < 1)
    count = len(pieces.ends)
    owner = np.concatenate([np.repeat(np.arange(count), 2), target[inside]])
    along = np.concatenate([np.tile([0.0, 1.0], count), share[inside]])
    order = np.lexsort([along, owner])
    vertices = np.concatenate([pieces.ends.reshape(-1, 2), place[inside]])
    return Lines(pieces=pieces, vertices=vertices[order], owner=owner[order])


def _merge_ends(pieces: Pieces, tolerance: float) -> FloatArray:
    """Return the ends; those within the tolerance of each other at one place, that of an outline's corner first."""
    flat = pieces.ends.reshape(-1, 2)
    group = merge_points(flat, tolerance)
    order = np.lexsort([np.arange(len(flat)), np.repeat(pieces.region < 0, 2), group])
    _, first = np.unique(group[order], return_index=True)
    merged: FloatArray = flat[order[first]][group].reshape(-1, 2, 2)
    return merged


def _on_lines(pieces: Pieces, tolerance: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Return ends of traces (2 a piece) near another piece, that piece, and the point where they meet.

    Of several pieces, outlines come first, then the one given first.
    """
    import shapely

    flat = pieces.ends.reshape(-1, 2)
    chunks, owner = pieces.chunks(4 * tolerance)
    end, chunk = shapely.STRtree(shapely.linestrings(chunks)).query(
        shapely.points(flat), predicate="dwithin", distance=tolerance
    )
    target = owner[chunk]
    at_end = (flat[end][:, None] == pieces.ends[target]).all(axis=2).any(axis=1)
    free = (pieces.region[end // 2] < 0) & (target != end // 2) & ~at_end
    end, target = end[free], target[free]
    order = np.lexsort([target, pieces.region[target] < 0, end])
    end, target = end[order], target[order]
    once = np.concatenate([[True], end[1:] != end[:-1]]) if len(end) else np.empty(0, dtype=np.bool_)
    end, target = end[once], target[once]
    return end, target, _meeting(pieces, end, target, tolerance)


def _meeting(pieces: Pieces, end: IntArray, target: IntArray, tolerance: float) -> FloatArray:
    """Return where the line of an end meets its target, or the foot of the end there at too small an angle."""
    here = pieces.ends.reshape(-1, 2)[end]
    u, v = pieces.direction[end // 2], pieces.direction[target]
    gap = here - pieces.ends[target, 0]
    cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        back = -(gap[:, 0] * v[:, 1] - gap[:, 1] * v[:, 0]) / cross
        along = np.einsum("nj,nj->n", gap, v) + back * np.einsum("nj,nj->n", u, v)
    near = np.isfinite(back) & (np.abs(back) <= np.minimum(FARTHEST * tolerance, pieces.length[end // 2] / 4))
    along = np.where(near, along, np.einsum("nj,nj->n", gap, v))
    place: FloatArray = pieces.ends[target, 0] + np.clip(along, 0.0, pieces.length[target])[:, None] * v
    return place
