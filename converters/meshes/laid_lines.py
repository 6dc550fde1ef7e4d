"""Lines laid over a mesh: elements that they cross are cut, and the edges along them get their joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.meshes.conform import conforming
from bsm_mesh.converters.meshes.marks import along_line, with_joint
from bsm_mesh.converters.meshes.report import MOST_LOST, Note, NoteKind, places
from bsm_mesh.model.blocks import Blocks, merge_points
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.polygons import owner_of_corner

BENT = 0.05  # of the median edge: nearer to a corner the line is bent to pass through it, so that no sliver is cut off
ROUNDING = 1e-9  # of the model's size: how far computed crossings may lie off a line
SLIVER = 1e-9  # of the element's area: a part below is rounding

Geometries = npt.NDArray[np.object_]


def lay_lines(blocks: Blocks, lines: Mapping[str, Sequence[FloatArray]]) -> tuple[Blocks, LongArray, list[Note]]:
    """Return blocks cut along lines, the given block of each, and notes.

    Where a line ends inside an element, the element is cut up to there only if the cut divides it. Lines of several
    joints that cross are cut at their crossings; an edge along two of them belongs to the first.

    Parameters
    ----------
    blocks : Blocks
        An element a block, conforming.
    lines : mapping of str to sequence of (n, 2) float64 [m]
        The lines of each joint.
    """
    import shapely

    size = float(np.ptp(blocks.vertices, axis=0).max())
    edge = float(np.median(np.hypot(*blocks.edge_vectors.T)))
    corners = shapely.multipoints(blocks.vertices)
    bent = {
        joint: shapely.snap(shapely.multilinestrings([shapely.linestrings(one) for one in some]), corners, BENT * edge)
        for joint, some in lines.items()
    }
    cut = _cut(blocks, shapely.get_parts(shapely.node(shapely.union_all([*bent.values()]))))
    tolerance = ROUNDING * size
    made, parent = _divided(blocks, cut, tolerance) if cut.parts.size else (blocks, cut.parent)
    made = conforming(made, tolerance)
    polygons = shapely.polygons(shapely.linearrings(made.vertices, indices=made.owner))
    tree, notes = shapely.STRtree(polygons), []
    for joint, line in bent.items():
        ends = np.stack([made.vertices, made.vertices[made.following]], axis=1)
        parts = [shapely.get_coordinates(part) for part in shapely.get_parts(line)]
        edges = np.flatnonzero(along_line(ends, parts, 10 * tolerance))
        made = with_joint(made, joint, edges)
        around = shapely.union_all(polygons[np.unique(tree.query(line, predicate="intersects"))])
        notes += _left_out(made, joint, shapely.intersection(line, around), float(shapely.length(line)), 20 * tolerance)
    return made, parent, notes


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class _Cut:
    """What lines divide blocks into: the parts, the block of each; and the given block of every new one."""

    parts: Geometries
    owner: LongArray
    parent: LongArray


def _cut(blocks: Blocks, lines: Geometries) -> _Cut:
    """Return the parts of the blocks that lines divide."""
    import shapely

    rings = shapely.linearrings(blocks.vertices, indices=blocks.owner)
    polygons = shapely.polygons(rings)
    line, block = shapely.STRtree(polygons).query(lines, predicate="intersects")
    inside = shapely.intersection(polygons[block], lines[line])
    inside, block = inside[shapely.length(inside) > 0], block[shapely.length(inside) > 0]
    order = np.argsort(block, kind="stable")
    crossed, index = np.unique(block[order], return_inverse=True)
    pieces, at = shapely.get_parts(inside[order], return_index=True)
    of_line = shapely.get_type_id(pieces) == 1
    within = shapely.multilinestrings(pieces[of_line], indices=index.reshape(-1)[at[of_line]])
    noded = shapely.union(rings[crossed], within)
    parts, owner = shapely.get_parts(shapely.polygonize(noded[:, None]), return_index=True)
    area = shapely.area(polygons)[crossed]
    real = shapely.area(parts) > SLIVER * area[owner]
    parts, owner = parts[real], owner[real]
    divided = np.bincount(owner, minlength=len(crossed)) > 1
    parts, owner = parts[divided[owner]], crossed[owner[divided[owner]]]
    kept = np.setdiff1d(np.arange(blocks.count), owner)
    return _Cut(parts=parts, owner=owner, parent=np.sort(np.concatenate([kept, owner])))


def _divided(blocks: Blocks, cut: _Cut, tolerance: float) -> tuple[Blocks, LongArray]:
    """Return the blocks with the parts in place of those that are cut, and the given block of each.

    Parts of an edge keep what it bears.
    """
    import shapely

    polygons = shapely.polygons(shapely.linearrings(blocks.vertices, indices=blocks.owner))
    kept = np.setdiff1d(np.arange(blocks.count), cut.owner)
    outlines = np.concatenate([polygons[kept], shapely.orient_polygons(cut.parts)])
    order = np.argsort(np.concatenate([kept, cut.owner]), kind="stable")
    coordinates, ring = shapely.get_coordinates(shapely.get_exterior_ring(outlines[order]), return_index=True)
    last = np.append(ring[1:] != ring[:-1], True)  # the first corner again
    vertices, nodes, offsets, kept = _without_repeats(coordinates[~last], ring[~last], tolerance)
    parent = cut.parent[kept]
    source = _source(blocks, vertices, offsets, parent, tolerance)
    on_edge = source >= 0
    made = replace(
        blocks,
        vertices=vertices,
        offsets=offsets,
        nodes=nodes,
        rock=blocks.rock[parent],
        edge_joint=np.where(on_edge, blocks.edge_joint[source], -1).astype(np.int32),
        boundaries={
            name: np.flatnonzero(on_edge & np.isin(source, edges)).astype(np.int32)
            for name, edges in blocks.boundaries.items()
        },
        excavations={
            name: np.flatnonzero(np.isin(parent, ids)).astype(np.int32) for name, ids in blocks.excavations.items()
        },
    )
    return made, parent


def _without_repeats(
    corners: FloatArray, owner: LongArray, tolerance: float
) -> tuple[FloatArray, IntArray, IntArray, LongArray]:
    """Return corners, their points, offsets and which outlines are left, corners within the tolerance being one.

    Where a line ends or bends on an edge two crossings may lie a rounding apart.
    """
    nodes = merge_points(corners, tolerance)
    first = np.append(True, owner[1:] != owner[:-1])
    ends = np.append(np.flatnonzero(first)[1:], len(owner)) - 1
    before = np.arange(-1, len(owner) - 1)
    before[first] = ends
    distinct = nodes != nodes[before]
    left = np.bincount(owner[distinct], minlength=int(owner[-1]) + 1)
    distinct &= left[owner] >= 3
    place = np.empty((int(nodes.max()) + 1, 2))
    place[nodes[::-1]] = corners[::-1]  # that of the first corner there
    offsets = np.concatenate([[0], np.cumsum(left[left >= 3])]).astype(np.int32)
    return place[nodes[distinct]], nodes[distinct].astype(np.int32), offsets, np.flatnonzero(left >= 3)


def _source(blocks: Blocks, vertices: FloatArray, offsets: IntArray, parent: LongArray, tolerance: float) -> Any:
    """Return the given edge on which each edge lies; -1 for those inside a given block."""
    import shapely

    following = np.arange(1, len(vertices) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    middle = shapely.points((vertices + vertices[following]) / 2)
    given = shapely.linestrings(np.stack([blocks.vertices, blocks.vertices[blocks.following]], axis=1))
    new, old = shapely.STRtree(given).query(middle, predicate="dwithin", distance=tolerance)
    same = blocks.owner[old] == parent[owner_of_corner(offsets)[new]]
    source = np.full(len(vertices), -1, dtype=np.int64)
    source[new[same]] = old[same]
    return source


def _left_out(blocks: Blocks, joint: str, inside: Any, length: float, off: float) -> list[Note]:
    """Return notes on the parts of a joint's lines that are no edges with it: inside the rock, and outside."""
    import shapely

    name = f"joint:{joint}"
    number = blocks.joint_names.index(joint) if joint in blocks.joint_names else -2
    edges = np.flatnonzero(blocks.edge_joint == number)
    ends = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
    laid = shapely.buffer(shapely.union_all(shapely.linestrings(ends)), off)
    lost = shapely.get_parts(shapely.difference(inside, laid))
    lost = lost[shapely.get_type_id(lost) == shapely.GeometryType.LINESTRING]
    left, within = float(shapely.length(lost).sum()), float(shapely.length(inside))
    notes = []
    if left > 1e-6 * length:
        where = places(shapely.get_coordinates(shapely.line_interpolate_point(lost, 0.5, normalized=True)))
        text = (
            f"{left:.3g} of {within:.3g} m of the lines of '{name}' bear another joint or end inside elements ({where})"
        )
        kind = NoteKind.LOST if left > MOST_LOST * within else NoteKind.LOOSE
        notes.append(Note(kind=kind, name=name, count=1, text=text))
    if length - within > 1e-6 * length:
        text = f"{length - within:.3g} of {length:.3g} m of the lines of '{name}' lie outside the rock"
        notes.append(Note(kind=NoteKind.OUTSIDE, name=name, count=1, text=text))
    return notes
