"""Repair of blocks on request: corners that nearly coincide, and slivers; every change is reported."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.meshes.conform import conforming
from bsm_mesh.converters.meshes.regions import components, not_simple, outline_regions, rim_of
from bsm_mesh.converters.meshes.straight import Precision
from bsm_mesh.errors import place
from bsm_mesh.merged_points import merge_points
from bsm_mesh.model.blocks import MERGE_TOLERANCE, Blocks
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.polygons import owner_of_corner

MAX_ROUNDS = 10  # a merged sliver may still be one

FindSlivers = Callable[[Blocks], IntArray]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Repaired:
    """Repaired blocks.

    Attributes
    ----------
    blocks : Blocks
        The blocks.
    changes : tuple of str
        Every change, a sentence each; blocks by their number before the round of repair that changed them.
    """

    blocks: Blocks
    changes: tuple[str, ...]


def repair_blocks(
    blocks: Blocks, find_slivers: FindSlivers, *, snap: float = 0.0, across_joints: bool = False
) -> Repaired:
    """Return blocks without slivers, and the changes.

    Parameters
    ----------
    blocks : Blocks
        The blocks.
    find_slivers : callable
        Gives the blocks to be rid of.
    snap : float [m]
        Corners nearer than this become one, at the place of one on a boundary, else of the first.
    across_joints : bool
        Merge a sliver with joints on all sides across the longest of them; else such slivers stay.

    Notes
    -----
    A sliver goes to the neighbour of the same rock and excavations with which it shares the greatest length of edges
    without a joint. It stays where the outline of both together would have a hole or touch itself.
    """
    changes: list[str] = []
    if snap > 0:
        blocks, changes = snap_corners(blocks, snap)
    for _ in range(MAX_ROUNDS):
        fine = conforming(blocks)
        label, merged = _merge(fine, find_slivers(blocks), across_joints)
        if not merged:
            break
        blocks = outline_regions(fine, label, Precision.of(fine.vertices))
        changes += merged
    left = find_slivers(blocks)
    if left.size:
        changes.append(
            f"{left.size} slivers are left: no neighbour of their rock across an edge "
            + ("that leaves a simple outline" if across_joints else "without a joint; --across-joints gives up joints")
        )
    return Repaired(blocks=blocks, changes=tuple(changes))


def snap_corners(blocks: Blocks, distance: float) -> tuple[Blocks, list[str]]:
    """Return the blocks with corners nearer than `distance` made one, and the changes.

    Blocks that are left with fewer than three corners, or no area, vanish.
    """
    node = merge_points(blocks.vertices, distance)
    inner = np.ones(len(node), dtype=np.bool_)
    for edges in blocks.boundaries.values():
        inner[edges] = inner[blocks.following[edges]] = False
    order = np.lexsort([np.arange(len(node)), inner, node])
    _, at = np.unique(node[order], return_index=True)
    first = order[at]
    target = blocks.vertices[first[node]]
    moved = np.hypot(*(target - blocks.vertices).T)
    if not moved.any():
        return blocks, []
    stays = node != node[blocks.following]
    sizes = np.add.reduceat(stays.astype(np.int64), blocks.offsets[:-1])
    alive = sizes >= 3
    kept = stays & alive[blocks.owner]
    number = np.cumsum(alive) - 1
    new_edge = np.cumsum(kept) - 1
    changed = np.unique(node[moved > 0])
    changes = [
        f"corners near {place(blocks.vertices[first[k]])} become one: "
        f"{len(np.unique(blocks.nodes[node == k]))} points, moved by {moved[node == k].max():.3g} m at most"
        for k in changed.tolist()
    ]
    changes += [
        f"block {b} near {place((x, y))} vanishes: its corners are nearer to each other than {distance:g} m"
        for b, (x, y) in zip(np.flatnonzero(~alive).tolist(), blocks.moments.centroid[~alive].tolist(), strict=True)
    ]
    boundaries = {name: new_edge[ids[kept[ids]]].astype(np.int32) for name, ids in blocks.boundaries.items()}
    excavations = {name: number[ids[alive[ids]]].astype(np.int32) for name, ids in blocks.excavations.items()}
    snapped = dataclasses.replace(
        blocks,
        vertices=target[kept],
        offsets=np.concatenate([[0], np.cumsum(sizes[alive])]).astype(np.int32),
        nodes=merge_points(target[kept], MERGE_TOLERANCE),
        rock=blocks.rock[alive],
        edge_joint=blocks.edge_joint[kept],
        boundaries=boundaries,
        excavations=excavations,
    )
    return snapped, changes


def _merge(fine: Blocks, slivers: IntArray, across_joints: bool) -> tuple[LongArray, list[str]]:
    """Return the merged block of each block, and the merged ones; `fine` conforms."""
    own = np.arange(fine.count)
    if slivers.size == 0:
        return own, []
    is_sliver = np.zeros(fine.count, dtype=np.bool_)
    is_sliver[slivers] = True
    one, other = fine.edge_table.pairs()
    sliver, neighbour, shared, joint = _best_neighbours(
        fine, np.concatenate([one, other]), np.concatenate([other, one]), is_sliver, across_joints
    )
    while sliver.size:
        label = components(fine.count, sliver, neighbour)
        bad = not_simple(fine, rim_of(fine, one, other, label), label)
        refused = np.isin(label[sliver], bad)
        if not refused.any():
            break
        sliver, neighbour, joint = sliver[~refused], neighbour[~refused], joint[~refused]
        shared = shared[~refused]
    if sliver.size == 0:
        return own, []
    area, centre = fine.moments.area, fine.moments.centroid
    changes = [
        f"block {s} ({area[s]:.3g} m2, near {place(centre[s])}) is merged into block {n} across "
        f"{length:.3g} m " + ("without a joint" if j < 0 else f"of joint '{fine.joint_names[j]}'")
        for s, n, length, j in zip(sliver.tolist(), neighbour.tolist(), shared.tolist(), joint.tolist(), strict=True)
    ]
    return label, changes


def _best_neighbours(
    fine: Blocks, edge: LongArray, opposite: LongArray, is_sliver: BoolArray, across_joints: bool
) -> tuple[LongArray, LongArray, FloatArray, LongArray]:
    """Return every sliver that has one, its neighbour, the length that they share, and the joint along it or -1."""
    owner = owner_of_corner(fine.offsets)
    a, b = owner[edge], owner[opposite]
    joint = np.maximum(fine.edge_joint[edge], fine.edge_joint[opposite]).astype(np.int64)
    good = is_sliver[a] & (a != b) & (fine.rock[a] == fine.rock[b])
    for ids in fine.excavations.values():
        inside = np.zeros(fine.count, dtype=np.bool_)
        inside[ids] = True
        good &= inside[a] == inside[b]
    if not across_joints:
        good &= joint < 0
    a, b, joint = a[good], b[good], joint[good]
    length = np.hypot(*fine.edge_vectors[edge[good]].T)
    key, row = np.unique(np.stack([a, b, joint], axis=1), axis=0, return_inverse=True)
    total = np.bincount(row.reshape(-1), length, minlength=len(key))
    order = np.lexsort([total, key[:, 2] < 0, key[:, 0]])  # last of each sliver: without a joint, then the longest
    last = np.append(key[order][1:, 0] != key[order][:-1, 0], True) if len(key) else np.empty(0, np.bool_)
    best = order[last]
    return key[best, 0], key[best, 1], total[best].astype(np.float64), key[best, 2]
