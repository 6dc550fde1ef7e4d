"""Lines laid over a mesh: elements that they cross are cut, and the edges along them get their joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.meshes.conform import conforming
from bsm_mesh.converters.meshes.line_cuts import REACH, cut_elements, grid_of
from bsm_mesh.converters.meshes.nodes_on_lines import lead_through, move_nodes
from bsm_mesh.converters.meshes.report import MOST_LOST, Note, NoteKind, places
from bsm_mesh.converters.meshes.segments import Segments
from bsm_mesh.errors import counted
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import LongArray

ROUNDING = 1e-6  # of a joint's length: a loss below is rounding


def lay_lines(blocks: Blocks, lines: Mapping[str, Sequence[FloatArray]]) -> tuple[Blocks, LongArray, list[Note]]:
    """Return blocks cut along lines, the given block of each, and notes.

    Lines stay where they are: nodes that lie near one move onto it. Where a line ends inside an element, the element
    is cut to its edge, without a joint beyond the end. Lines that cross are cut at their crossings; an edge along
    lines of several joints belongs to the first.

    Parameters
    ----------
    blocks : Blocks
        An element a block.
    lines : mapping of str to sequence of (n, 2) float64 [m]
        The lines of each joint.
    """
    drawn = Segments.of(lines)
    segments = drawn.around(blocks.vertices.min(axis=0), blocks.vertices.max(axis=0))
    if not len(segments.ends):
        return blocks, np.arange(blocks.count), []
    tolerance = REACH * grid_of(blocks)
    given, node, distance = move_nodes(conforming(blocks), segments)
    segments = lead_through(given, segments)
    made, parent = cut_elements(given, segments)
    made = conforming(made, tolerance)
    notes = _moved_notes(node, distance)
    ends = np.stack([made.vertices, made.vertices[made.following]], axis=1)
    for k, joint in enumerate(lines):
        mine = segments.ends[segments.joint == k]
        far = drawn.length_of(k) - segments.length_of(k)  # beyond what was cut off
        edges = np.flatnonzero(along_line(ends, mine, 2 * tolerance)) if len(mine) else np.empty(0, np.int64)
        made = with_joint(made, joint, edges)
        notes += _length_notes(made, joint, edges, mine, far)
    return made, parent, notes


def _moved_notes(node: LongArray, distance: FloatArray) -> list[Note]:
    if not node.size:
        return []
    text = f"{counted(node.size, 'node')} near lines of joints moved onto them, by {distance.max():.3g} m at most"
    return [Note(kind=NoteKind.SNAPPED, count=int(node.size), text=text)]


def _length_notes(blocks: Blocks, joint: str, edges: LongArray, lines: FloatArray, far: float) -> list[Note]:
    """Return notes on the parts of a joint's lines that are no edges with it: inside the rock, and outside.

    The lines are given by the ends of their segments, (n, 2, 2) [m], without a length `far` from the rock [m].
    """
    length, within = _lengths(lines, blocks)
    number = blocks.joint_names.index(joint) if joint in blocks.joint_names else len(blocks.joint_names)
    is_laid = blocks.edge_joint[edges] == number
    lost = within - _length_once(blocks, edges[is_laid])
    notes, name = [], f"joint:{joint}"
    if lost > MOST_LOST * within or not is_laid.all():
        middle = (blocks.vertices[edges] + blocks.vertices[blocks.following[edges]])[~is_laid] / 2
        where = f" ({places(np.unique(middle, axis=0))})" if len(middle) else ""
        text = f"{lost:.3g} of {within:.3g} m of the lines of '{name}' have another joint{where}"
        kind = NoteKind.LOST if lost > MOST_LOST * within else NoteKind.LOOSE
        notes.append(Note(kind=kind, name=name, count=1, text=text))
    length += far
    if length - within > ROUNDING * length:
        text = f"{length - within:.3g} of {length:.3g} m of the lines of '{name}' lie outside the rock"
        notes.append(Note(kind=NoteKind.OUTSIDE, name=name, count=1, text=text))
    return notes


def _length_once(blocks: Blocks, edges: LongArray) -> float:
    """Return the length of edges [m], of two between the same points that of one."""
    pairs = np.sort(np.stack([blocks.nodes[edges], blocks.nodes[blocks.following[edges]]], axis=1), axis=1)
    _, first = np.unique(pairs, axis=0, return_index=True)
    return float(np.hypot(*blocks.edge_vectors[edges[first]].T).sum())


def _lengths(lines: FloatArray, blocks: Blocks) -> tuple[float, float]:
    """Return the length of segments, and of their parts in the blocks, the rim with them [m].

    Segments that lie on each other, to the grid of the cuts, count once.
    """
    import shapely

    middle, grid = blocks.vertices.mean(axis=0), grid_of(blocks)
    drawn = shapely.union_all(shapely.linestrings(lines - middle), grid_size=grid)
    polygons = shapely.polygons(shapely.linearrings(blocks.vertices - middle, indices=blocks.owner))
    near = np.unique(shapely.STRtree(polygons).query(drawn, predicate="dwithin", distance=REACH * grid))
    around = shapely.buffer(shapely.union_all(polygons[near]), REACH * grid, join_style="mitre")
    return float(shapely.length(drawn)), float(shapely.length(shapely.intersection(drawn, around)))


def with_joint(blocks: Blocks, joint: str, edges: LongArray | IntArray) -> Blocks:
    """Return blocks with a joint on those of the edges that carry none."""
    free = edges[blocks.edge_joint[edges] < 0]
    if not free.size:
        return blocks
    names = blocks.joint_names if joint in blocks.joint_names else (*blocks.joint_names, joint)
    edge_joint = blocks.edge_joint.copy()
    edge_joint[free] = names.index(joint)
    return replace(blocks, edge_joint=edge_joint, joint_names=names)


def along_line(ends: FloatArray, lines: Sequence[FloatArray], off: FloatArray | float) -> BoolArray:
    """Return which edges, by their ends (k, 2, 2), lie along one of the lines, to a distance `off` [m]."""
    import shapely

    line = shapely.multilinestrings([shapely.linestrings(one) for one in lines])
    shapely.prepare(line)
    near: BoolArray = np.ones(len(ends), dtype=np.bool_)
    for share in (0.0, 0.5, 1.0):
        points = shapely.points((1 - share) * ends[:, 0] + share * ends[:, 1])
        near &= shapely.dwithin(line, points, np.broadcast_to(off, len(ends)))
    return near
