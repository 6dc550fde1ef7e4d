"""Whether a mechanism leaves out what holds the blocks: faces, corners on edges, supports, found in the outlines."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import Arrays, cross, edges_of, size_of, turned_left

TOUCHES = 1e-9  # of a block's size: what is nearer touches; rounding of coordinates comes to it
SAME_PLACE = 1e-6  # of a block's size: a contact at the end of a face
SHORTER = 1e-3  # by how much the contacts of a face may represent less than it
PARALLEL = 1e-9  # of unit vectors
STRAIGHT = 1e-3  # rad: a node between two edges in line is no corner
BLOCKS_AT_ONCE = 256


def missing_faults(a: Arrays, p: Arrays) -> list[str]:
    """Return which faces and supports of blocks that move the mechanism has no contact, or bar, for."""
    near = TOUCHES * size_of(a) + 16 * np.finfo(float).eps * float(np.abs(a["vertices"]).max())
    faults = []
    for blocks in np.array_split(moving(p), max(1, -(-len(moving(p)) // BLOCKS_AT_ONCE))):
        pairs = pairs_near(a, p, blocks, near)
        faults += face_faults(a, p, faces(a, *pairs, near))[:1]
    return faults[:1] + bar_faults(a, p)


def moving(p: Arrays) -> Any:
    """Return the blocks that move in the mechanism."""
    return np.flatnonzero(p["velocity"].any(axis=1))


def pairs_near(a: Arrays, p: Arrays, blocks: Any, near: float) -> tuple[Any, Any]:
    """Return the pairs of edges (k,) of some blocks that move and of others whose boxes meet theirs, each pair once."""
    low, high = (bound.reduceat(a["vertices"], a["offsets"][:-1], axis=0) for bound in (np.minimum, np.maximum))
    meet = np.repeat(a["present"][None, :], len(blocks), axis=0)
    for axis in range(2):
        meet &= low[blocks, None, axis] <= high[None, :, axis] + near
        meet &= high[blocks, None, axis] >= low[None, :, axis] - near
    one, other = np.nonzero(meet)
    one = blocks[one]
    once = (one < other) | ((one != other) & ~p["velocity"][other].any(axis=1))
    first, row = edges_of(a, one[once])
    second, pair = edges_of(a, other[once][row])
    return first[pair], second


def faces(a: Arrays, one: Any, other: Any, near: float) -> tuple[Any, Any, Any, Any]:
    """Return both ends of the faces that edges (k,) share, (f, 2, 2), their normals, and the blocks on both sides."""
    start, along = a["vertices"][one], a["vertices"][a["following"][one]] - a["vertices"][one]
    length = np.hypot(*along.T)
    t = along / length[:, None]
    ends = [a["vertices"][other] - start, a["vertices"][a["following"][other]] - start]
    against = a["vertices"][a["following"][other]] - a["vertices"][other]
    opposed = (along * against).sum(axis=1) < 0
    flush = opposed & (np.maximum(*(np.abs(cross(t, end)) for end in ends)) <= near)
    stations = [(t * end).sum(axis=1) for end in ends]
    begin, finish = np.maximum(np.minimum(*stations), 0.0), np.minimum(np.maximum(*stations), length)
    chosen = flush & (finish - begin > SAME_PLACE * size_of(a))
    points = np.stack([start + s[:, None] * t for s in (begin, finish)], axis=1)
    return points[chosen], -turned_left(t[chosen]), a["owner"][one[chosen]], a["owner"][other[chosen]]


def face_faults(a: Arrays, p: Arrays, found: tuple[Any, Any, Any, Any]) -> list[str]:
    """Return which faces have no contact at one of their ends, or contacts that represent less."""
    points, normal, one, other = found
    count, size = len(a["present"]), size_of(a)
    keys = np.minimum(p["block_a"], p["block_b"]).astype(np.int64) * count + np.maximum(p["block_a"], p["block_b"])
    order = np.argsort(keys, kind="stable")
    wanted = np.minimum(one, other).astype(np.int64) * count + np.maximum(one, other)
    first, last = (np.searchsorted(keys[order], wanted, side=side) for side in ("left", "right"))
    row = np.repeat(np.arange(len(wanted)), last - first)
    contact = order[first[row] + np.arange(len(row)) - (np.cumsum(last - first) - (last - first))[row]]
    along = np.abs(cross(p["normal"][contact], normal[row])) <= PARALLEL**0.5
    least = (1 - SHORTER) * np.hypot(*(points[:, 1] - points[:, 0]).T) / 2
    along &= p["length"][contact] >= least[row]
    there = np.zeros((len(wanted), 2), dtype=bool)
    for end in range(2):
        at = np.hypot(*(p["point"][contact] - points[row, end]).T) <= SAME_PLACE * size
        there[row[along & at], end] = True
    bad = np.flatnonzero(~there.all(axis=1))
    if not len(bad):
        return []
    k = bad[0]
    return [f"the mechanism leaves out a contact between blocks {int(one[k])} and {int(other[k])}, which share a face"]


def corner_gaps(a: Arrays, p: Arrays, steepest: float) -> float:
    """Return what corners on edges without a face could take up, per force: where the mechanism closes or slides there.

    Blocks that meet at a corner of both have no contact there; a node between two edges in line is no corner.
    """
    near = TOUCHES * size_of(a) + 16 * np.finfo(float).eps * float(np.abs(a["vertices"]).max())
    known = {tuple(sorted(pair)) for pair in zip(p["block_a"].tolist(), p["block_b"].tolist(), strict=True)}
    lacks = 0.0
    for blocks in np.array_split(moving(p), max(1, -(-len(moving(p)) // BLOCKS_AT_ONCE))):
        one, other = pairs_near(a, p, blocks, near)
        for corner, edge in ((one, other), (other, one)):
            start = a["vertices"][edge]
            along = a["vertices"][a["following"][edge]] - start
            length = np.hypot(*along.T)
            t, off = along / length[:, None], a["vertices"][corner] - start
            station = (t * off).sum(axis=1)
            touches = (np.abs(cross(t, off)) <= near) & (station >= -near) & (station <= length + near)
            touches &= ((station > near) & (station < length - near)) | ((station >= length - near) & straight(a, edge))
            for k in np.flatnonzero(touches):
                pair = int(a["owner"][corner[k]]), int(a["owner"][edge[k]])
                if tuple(sorted(pair)) not in known:
                    lacks += lack_at(a, p, pair, a["vertices"][corner[k]], t[k], steepest)
    return lacks


def straight(a: Arrays, edge: Any) -> Any:
    """Return whether the next edges continue in line, (k,)."""
    here = a["vertices"][a["following"][edge]] - a["vertices"][edge]
    after = a["following"][edge]
    ahead = a["vertices"][a["following"][after]] - a["vertices"][after]
    return np.abs(np.arctan2(cross(here, ahead), (here * ahead).sum(axis=1))) <= STRAIGHT


def lack_at(a: Arrays, p: Arrays, pair: tuple[int, int], point: Any, t: Any, steepest: float) -> float:
    """Return by how much a corner on an edge along t opens too little for its slip to be free of friction."""
    v, centroid = p["velocity"], a["centroid"]
    speed = [v[b, :2] + v[b, 2] * turned_left((point - centroid[b])[None])[0] for b in pair]
    past = speed[0] - speed[1]
    opens, slips = float(past @ np.array([t[1], -t[0]])), abs(float(past @ t))
    return max(steepest * slips - opens, 0.0)


def bar_faults(a: Arrays, p: Arrays) -> list[str]:
    """Return which supports of blocks that move the mechanism has no bar for."""
    block = a["bar_block"]
    held = np.flatnonzero(p["velocity"][block].any(axis=1))
    turn = -a["position"][block, 2]
    x, y = (a["bar_point"] - a["at"][block]).T
    point = a["centroid"][block] + np.column_stack(
        [np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y]
    )
    for k in held:
        same = (p["bar_block"] == block[k]) & (p["bar_turns"] == a["bar_turns"][k])
        same &= np.abs(p["bar_direction"] - a["bar_direction"][k]).max(axis=1) <= PARALLEL
        if not a["bar_turns"][k]:
            same &= np.hypot(*(p["bar_point"] - point[k]).T) <= SAME_PLACE * size_of(a)
        if not same.any():
            return [f"the mechanism leaves out a support of block {int(block[k])}"]
    return []
