"""Elements between joints put together to blocks: ``blocks = "regions"``.

Two elements with a common edge belong to one block unless a joint runs along the edge, or their rock or excavation
differs. A block may be concave. One whose outline would have a hole, or touch itself at a point, cannot be rigid
as one polygon; it is divided, again along edges of elements.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.meshes.report import MOST_LOST, Note, NoteKind, places
from bsm_mesh.converters.meshes.straight import Precision, straightened
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import LongArray

MOST_CUTS = 40  # of one region, each in half, before its elements stay as they are


def merge_regions(
    elements: Blocks, precision: Precision, laid: Collection[str] = ()
) -> tuple[Blocks, tuple[Note, ...]]:
    """Return the blocks that the elements form between joints, and notes on joints in them and on divided ones.

    Edges in one line to the digits of the coordinates are put on it. Corners between two such edges, with the same
    joint and boundaries on both, are left out.

    Parameters
    ----------
    elements : Blocks
        Every element a block.
    precision : Precision
        Of their coordinates.
    laid : collection of str
        Joints given by lines: of these, more than a hundredth without a block on both sides is lost.
    """
    one, other = elements.edge_table.pairs()
    joined = joined_pairs(elements, one, other)
    region = components(elements.count, elements.owner[one[joined]], elements.owner[other[joined]])
    region, split = _divide(elements, one[joined], other[joined], region)
    rim = rim_of(elements, one, other, region)
    elements = straightened(elements, rim, precision)
    blocks = outline_regions(elements, region, precision)
    inside = np.zeros(len(elements.vertices), dtype=np.bool_)
    inside[one], inside[other] = True, True
    inside[rim] = False
    return blocks, (*_dead_notes(elements, one[inside[one]], laid), *_split_notes(elements, region, split))


def outline_regions(elements: Blocks, region: LongArray, precision: Precision) -> Blocks:
    """Return one block a region, numbered as `region`, (n_elements,), says; each has a simple outline.

    Corners on the line between their neighbours, to rounding, are left out where joint and boundaries are the same on
    both sides.
    """
    chain, offsets = _chain(elements, rim_of(elements, *elements.edge_table.pairs(), region), region)
    return _assemble(elements, chain, offsets, _corners(elements, chain, offsets, precision.rounding), region)


def joined_pairs(elements: Blocks, one: LongArray, other: LongArray) -> BoolArray:
    """Return which pairs of edges have the same block on both sides."""
    a, b = elements.owner[one], elements.owner[other]
    joined: BoolArray = (elements.edge_joint[one] < 0) & (elements.edge_joint[other] < 0)
    joined &= elements.rock[a] == elements.rock[b]
    for ids in elements.excavations.values():
        inside = np.zeros(elements.count, dtype=np.bool_)
        inside[ids] = True
        joined &= inside[a] == inside[b]
    return joined


def components(count: int, one: IntArray, other: IntArray) -> LongArray:
    """Return the component of every element, numbered by its first element."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, other)), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first))
    numbered: LongArray = rank[inverse.reshape(-1)]
    return numbered


def rim_of(elements: Blocks, one: LongArray, other: LongArray, region: LongArray) -> LongArray:
    """Return the edges round the regions: those without the same region on the other side."""
    rim = np.ones(len(elements.vertices), dtype=np.bool_)
    same = region[elements.owner[one]] == region[elements.owner[other]]
    rim[one[same]] = rim[other[same]] = False
    return np.flatnonzero(rim)


def not_simple(elements: Blocks, rim: LongArray, region: LongArray) -> LongArray:
    """Return the regions whose rim is not one ring through each of its points once."""
    of_edge = region[elements.owner[rim]]
    start, end = elements.nodes[rim], elements.nodes[elements.following[rim]]
    base = int(elements.nodes.max()) + 1
    keys = of_edge * base + start
    unique, count = np.unique(keys, return_counts=True)
    twice = unique[count > 1] // base
    at = np.searchsorted(unique, keys)
    to = np.searchsorted(unique, of_edge * base + end)
    ring = components(len(unique), at, to)
    of_ring = np.unique(np.stack([unique // base, ring], axis=1), axis=0)[:, 0]
    several = np.unique(of_ring[1:][of_ring[1:] == of_ring[:-1]])
    bad: LongArray = np.union1d(twice, several).astype(np.int64)
    return bad


def _divide(elements: Blocks, one: LongArray, other: LongArray, region: LongArray) -> tuple[LongArray, LongArray]:
    """Return regions with simple outlines, and the elements of those that were divided.

    A region with a hole or a pinch is cut in half at the median of its elements' centroids, across its longer side.
    """
    divided = np.zeros(elements.count, dtype=np.bool_)
    a, b = elements.owner[one], elements.owner[other]
    cut = np.zeros(len(one), dtype=np.bool_)
    pairs = elements.edge_table.pairs()
    for _ in range(MOST_CUTS):
        bad = not_simple(elements, rim_of(elements, *pairs, region), region)
        if bad.size == 0:
            break
        inside = np.isin(region, bad)
        divided |= inside
        half = _halves(elements.moments.centroid, region, inside)
        cut |= inside[a] & (region[a] == region[b]) & (half[a] != half[b])
        region = components(elements.count, a[~cut], b[~cut])
    return region, np.flatnonzero(divided)


def _halves(centroid: FloatArray, region: LongArray, inside: BoolArray) -> BoolArray:
    """Return which elements lie beyond the middle of their region, along its longer side."""
    which = np.flatnonzero(inside)
    _, group = np.unique(region[which], return_inverse=True)
    group = group.reshape(-1)
    low, high = np.full((group.max() + 1, 2), np.inf), np.full((group.max() + 1, 2), -np.inf)
    np.minimum.at(low, group, centroid[which])
    np.maximum.at(high, group, centroid[which])
    axis = np.argmax(high - low, axis=1)
    middle = ((low + high) / 2)[np.arange(len(axis)), axis]
    half = np.zeros(len(inside), dtype=np.bool_)
    half[which] = centroid[which, axis[group]] > middle[group]
    return half


def _chain(elements: Blocks, rim: LongArray, region: LongArray) -> tuple[LongArray, IntArray]:
    """Return the rim edges in order round each region, region after region, and where each region begins."""
    of_edge = region[elements.owner[rim]]
    base = int(elements.nodes.max()) + 1
    start = of_edge * base + elements.nodes[rim]
    order = np.argsort(start, kind="stable")
    successor = order[np.searchsorted(start[order], of_edge * base + elements.nodes[elements.following[rim]])]
    position, count = _positions(successor, of_edge)
    begin = np.concatenate([[0], np.cumsum(count)]).astype(np.int32)
    chain = np.empty(len(rim), dtype=np.int64)
    chain[begin[of_edge] + position] = rim
    return chain, begin


def _positions(successor: LongArray, ring: LongArray) -> tuple[LongArray, LongArray]:
    """Return the place of every edge on its ring, from the ring's first edge on, and the rings' sizes.

    Pointer doubling: after k rounds every edge knows how far it is from the first one over 2^k steps.
    """
    size = np.bincount(ring)
    _, first = np.unique(ring, return_index=True)
    last = np.zeros(len(ring), dtype=np.bool_)
    predecessor = np.empty(len(ring), dtype=np.int64)
    predecessor[successor] = np.arange(len(ring))
    last[first] = True
    jump = np.where(last, np.arange(len(ring)), predecessor)
    steps = np.where(last, 0, 1)
    while True:
        further = steps + steps[jump]
        if np.array_equal(further, steps):
            return steps, size
        steps, jump = further, jump[jump]


def _corners(elements: Blocks, chain: LongArray, offsets: IntArray, tolerance: float) -> BoolArray:
    """Return which edges of the chain begin at a corner of the region."""
    following = np.arange(1, len(chain) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    previous = np.empty(len(chain), dtype=np.int64)
    previous[following] = np.arange(len(chain))
    here = elements.vertices[chain]
    before, after = here[previous], here[following]
    vector = after - before
    gap = here - before
    length = np.maximum(np.hypot(*vector.T), np.finfo(np.float64).tiny)
    off = np.abs(vector[:, 0] * gap[:, 1] - vector[:, 1] * gap[:, 0]) / length
    ahead = np.einsum("nj,nj->n", gap, here[following] - here) > 0
    alike = elements.edge_joint[chain] == elements.edge_joint[chain[previous]]
    for edges in elements.boundaries.values():
        on = np.zeros(len(elements.vertices), dtype=np.bool_)
        on[edges] = True
        alike &= on[chain] == on[chain[previous]]
    corner: BoolArray = ~(alike & ahead & (off <= tolerance))
    return corner


def _assemble(elements: Blocks, chain: LongArray, offsets: IntArray, kept: BoolArray, region: LongArray) -> Blocks:
    sizes = np.add.reduceat(kept.astype(np.int64), offsets[:-1])
    edges = chain[kept]
    new_edge = np.full(len(elements.vertices), -1, dtype=np.int64)
    # An edge that begins at no corner has become part of the last one before it that does.
    run = np.cumsum(kept) - 1
    wrapped = run < np.repeat(np.cumsum(sizes) - sizes, np.diff(offsets))
    run[wrapped] = np.repeat(np.cumsum(sizes) - 1, np.diff(offsets))[wrapped]
    new_edge[chain] = run
    _, first = np.unique(region, return_index=True)
    _, nodes = np.unique(elements.nodes[edges], return_inverse=True)
    boundaries = {name: np.unique(new_edge[ids][new_edge[ids] >= 0]) for name, ids in elements.boundaries.items()}
    return Blocks(
        vertices=elements.vertices[edges],
        offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        nodes=nodes.reshape(-1).astype(np.int32),
        rock=elements.rock[first],
        rock_names=elements.rock_names,
        edge_joint=elements.edge_joint[edges],
        joint_names=elements.joint_names,
        boundaries={name: ids.astype(np.int32) for name, ids in boundaries.items() if ids.size},
        excavations={name: np.unique(region[ids]).astype(np.int32) for name, ids in elements.excavations.items()},
    )


def _dead_notes(elements: Blocks, inner: LongArray, laid: Collection[str]) -> list[Note]:
    """Return a note on each joint with pieces that have the same block on both sides."""
    notes = []
    whole = lengths_of_joints(elements)
    joint = elements.edge_joint[inner]
    for number in np.unique(joint[joint >= 0]):
        edges = inner[joint == number]
        ends = np.stack([elements.vertices[edges], elements.vertices[elements.following[edges]]], axis=1)
        length = np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum()
        is_lost = elements.joint_names[number] in laid and length > MOST_LOST * whole[number]
        name = f"joint:{elements.joint_names[number]}"
        text = (
            f"{len(edges)} pieces of '{name}', {length:.6g} m in all, end in the rock with the same block on both "
            f"sides and bound none ({places(ends.mean(axis=1))})"
        )
        if is_lost:
            text += f", of {whole[number]:.6g} m laid; let its lines end at other joints or at the rim"
        kind = NoteKind.LOST if is_lost else NoteKind.DEAD_END
        notes.append(Note(kind=kind, name=name, count=len(edges), text=text))
    return notes


def lengths_of_joints(blocks: Blocks) -> FloatArray:
    """Return the length of every joint in `joint_names` [m]; an edge between two blocks counts once."""
    one, other = blocks.edge_table.pairs()
    weight = np.ones(len(blocks.vertices))
    weight[one] = weight[other] = 0.5
    weight *= np.hypot(*blocks.edge_vectors.T)
    jointed = blocks.edge_joint >= 0
    length: FloatArray = np.bincount(
        blocks.edge_joint[jointed], weight[jointed], minlength=len(blocks.joint_names)
    ).astype(np.float64)
    return length


def _split_notes(elements: Blocks, region: LongArray, split: LongArray) -> list[Note]:
    if split.size == 0:
        return []
    _, first = np.unique(region[split], return_index=True)
    parts = split[first]
    text = (
        f"regions with a hole, or that touch themselves at a point, are divided into {len(parts)} blocks along edges "
        f"of elements, without a joint between them ({places(elements.moments.centroid[parts])})"
    )
    return [Note(kind=NoteKind.DIVIDED, count=len(parts), text=text)]
