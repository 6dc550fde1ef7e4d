"""A mesh as read: nodes, surface elements by their corners, line elements, groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.meshes.cell_faults import (
    CellArrays,
    CellSets,
    group_faults,
    no_surfaces,
    refuse_missing_nodes,
    refuse_volumes,
)
from bsm_mesh.converters.meshes.node_sets import set_pieces
from bsm_mesh.converters.meshes.report import Note, NoteKind
from bsm_mesh.errors import ModelError, as_given, raise_faults
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.values import parts_of

CORNERS = {
    "triangle": 3,
    "VTK_LAGRANGE_TRIANGLE": 3,
    "VTK_BEZIER_TRIANGLE": 3,
    "quad": 4,
    "VTK_LAGRANGE_QUADRILATERAL": 4,
    "VTK_BEZIER_QUADRILATERAL": 4,
}
LINES = ("line", "VTK_LAGRANGE_CURVE", "VTK_BEZIER_CURVE")
POINTS = ("vertex", "empty")
PHYSICAL = "gmsh:physical"  # the array of the numbers of Gmsh's groups
LARGEST = 2**53  # whole numbers below it are exact in float64


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class CellGroup:
    """A named set of elements.

    Attributes
    ----------
    name : str
        As in the mesh.
    elements : (k,) int64
        Its surface elements.
    pieces : (k,) int64
        Its line elements.
    """

    name: str
    elements: LongArray
    pieces: LongArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class MeshCells:
    """A mesh as read, higher-order elements reduced to their corners.

    Attributes
    ----------
    source : str
        The file, or the caller's name for it.
    points : (n_points, 2 or 3) float64
        Coordinates of the nodes, in the mesh's own unit and axes.
    corners : (n_corners,) int64
        Nodes of the surface elements, element after element.
    offsets : (n_elements + 1,) int32
        Element e owns ``corners[offsets[e]:offsets[e + 1]]``.
    numbers : (n_elements,) int64
        Number of each element in the file.
    pieces : (n_pieces, 2) int64
        End nodes of the line elements.
    groups : tuple of CellGroup
        The named groups.
    arrays : mapping of str to (elements' values, pieces' values)
        Integer data whose values may represent groups, such as ``MaterialIDs``.
    notes : tuple of Note
        Reductions and omissions so far.
    """

    source: str
    points: FloatArray
    corners: LongArray
    offsets: IntArray
    numbers: LongArray
    pieces: LongArray
    groups: tuple[CellGroup, ...]
    arrays: Mapping[str, tuple[LongArray, LongArray]]
    notes: tuple[Note, ...]

    @property
    def count(self) -> int:
        """Number of surface elements."""
        return len(self.offsets) - 1


def _pairs(source: str, cells: Any) -> list[tuple[str, npt.ArrayLike]]:
    """Return the type and the nodes of every block of elements; raise a `ModelError` where they are none."""
    pairs = [tuple(parts_of(pair) or ()) for pair in parts_of(cells) or [()]]
    if not all(len(pair) == 2 and isinstance(pair[0], str) for pair in pairs):
        raise ModelError(f"{source}: cells = {as_given(cells)} must be pairs, as in [('triangle', [[0, 1, 2]])]")
    return pairs


def gather_cells(
    source: str,
    points: npt.ArrayLike,
    cells: Sequence[tuple[str, npt.ArrayLike]],
    *,
    sets: CellSets,
    arrays: CellArrays,
    numbers: Sequence[LongArray] | None = None,
    node_sets: Mapping[str, LongArray] | None = None,
    sides: Mapping[str, LongArray] | None = None,
    notes: Sequence[Note] = (),
) -> MeshCells:
    """Return surface and line elements gathered from blocks of elements of one type each.

    Parameters
    ----------
    source : str
        Named in messages.
    points : (n, 2 or 3) array_like
        Coordinates of the nodes.
    cells : sequence of (str, (m, k) array_like)
        Element type by meshio's names and node numbers, one entry a block.
    sets : mapping of str to a sequence of arrays
        For every group and block of elements: which of the block's elements belong to the group.
    arrays : mapping of str to a sequence of arrays
        Cell data, an array a block; those that hold whole numbers are kept.
    numbers : sequence of (m,) int64, optional
        Number of every element in the file; also the order in which blocks will be numbered.
    node_sets, sides : mapping of str to array, optional
        Sets of nodes, and of sides of elements by their ends. They become line elements in groups of these names.
    notes : sequence of Note
        Notes of the reader.

    Raises
    ------
    ModelError
        If there are volume elements, no surface elements, or nodes that do not exist.
    """
    array = _coordinates(source, points)
    every = [(kind, _node_rows(source, kind, nodes)) for kind, nodes in _pairs(source, cells)]
    raise_faults([f"{source}: {fault}" for fault in group_faults(sets, arrays, [len(nodes) for _, nodes in every])])
    kept = [k for k, (_, nodes) in enumerate(every) if len(nodes)]
    data = [every[k] for k in kept]
    refuse_volumes(source, data)
    refuse_missing_nodes(source, data, len(array))
    start = np.concatenate([[0], np.cumsum([len(nodes) for _, nodes in data])]).astype(np.int64)
    number = np.concatenate([numbers[k] for k in kept]) if numbers is not None and kept else np.arange(start[-1])
    surfaces = [k for k, (kind, _) in enumerate(data) if _corner_columns(kind, 4) is not None]
    lines = [k for k, (kind, _) in enumerate(data) if kind.startswith(LINES)]
    corners, offsets, element_cell = _flat_outlines(data, surfaces, start, number)
    if len(offsets) == 1:
        raise ModelError(f"{source}: {no_surfaces(data)}")
    piece_cell = _cells_of(lines, start)
    position = np.full(int(start[-1]), -1, dtype=np.int64)  # of each cell among its kind
    position[element_cell] = np.arange(len(element_cell))
    position[piece_cell] = np.arange(len(piece_cell))
    surface = np.zeros(int(start[-1]), dtype=np.bool_)
    surface[element_cell] = True
    pieces = np.concatenate([np.empty((0, 2), np.int64), *(data[k][1][:, :2] for k in lines)])
    groups = [_group(name, _members(members, kept, start), position, surface) for name, members in sets.items()]
    added = set_pieces(array, corners, offsets, node_sets or {}, sides or {})
    return MeshCells(
        source=source,
        points=array,
        corners=corners,
        offsets=offsets,
        numbers=number[element_cell],
        pieces=np.concatenate([pieces, *added.values()]),
        groups=with_pieces(groups, added, len(pieces)),
        arrays=_whole_numbers(arrays, kept, element_cell, piece_cell),
        notes=(*notes, *_type_notes(data), *_unused_nodes(data, len(array))),
    )


def _coordinates(source: str, points: npt.ArrayLike) -> FloatArray:
    try:
        array = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise ModelError(f"{source}: nodes are no array of numbers; (n, 2) or (n, 3) coordinates are needed") from None
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ModelError(f"{source}: nodes have shape {array.shape}; (n, 2) or (n, 3) coordinates are needed")
    return array


def _node_rows(source: str, kind: str, nodes: npt.ArrayLike) -> LongArray:
    try:
        rows = np.asarray(nodes)
        if rows.size and (rows.ndim != 2 or rows.dtype.kind not in "iu"):
            raise ValueError
    except ValueError:
        raise ModelError(
            f"{source}: a block of {kind} elements is no (m, k) array of node numbers; "
            "give polygons of each number of corners as a block of their own"
        ) from None
    if not rows.size:
        return np.empty((0, 2), np.int64)
    least = 2 if kind.startswith(LINES) else next((n for name, n in CORNERS.items() if kind.startswith(name)), 0)
    if rows.shape[1] < least:
        raise ModelError(f"{source}: {kind} elements of {rows.shape[1]} nodes; they need {least} at least")
    return rows.astype(np.int64)


def _corner_columns(kind: str, width: int) -> LongArray | None:
    """Return which columns of an element's nodes are its corners, in order; None if it is no surface."""
    if kind == "pixel":  # VTK numbers a pixel's nodes row by row
        return np.array([0, 1, 3, 2])
    if kind == "quadratic_polygon":
        return np.arange(width // 2)
    if kind.startswith("polygon"):
        return np.arange(width)
    for prefix, corners in CORNERS.items():
        if kind.startswith(prefix):
            return np.arange(corners)
    return None


def _cells_of(blocks: Sequence[int], start: LongArray) -> LongArray:
    return np.concatenate([np.empty(0, np.int64), *(np.arange(start[k], start[k + 1]) for k in blocks)])


def _flat_outlines(
    data: Sequence[tuple[str, LongArray]], surfaces: Sequence[int], start: LongArray, number: LongArray
) -> tuple[LongArray, IntArray, LongArray]:
    """Return corners and offsets of all surface elements in the order of the file, and the cell of each."""
    outlines = []
    for k in surfaces:
        kind, nodes = data[k]
        outlines.append(nodes[:, _corner_columns(kind, nodes.shape[1])])
    cell = _cells_of(surfaces, start)
    corners = np.concatenate([np.empty(0, np.int64), *(nodes.ravel() for nodes in outlines)])
    sizes = np.concatenate([np.empty(0, np.int64), *(np.full(len(n), n.shape[1]) for n in outlines)])
    if np.any(np.diff(number[cell]) < 0):
        order = np.argsort(number[cell], kind="stable")
        begin = (np.cumsum(sizes) - sizes)[order]
        sizes, cell = sizes[order], cell[order]
        corners = corners[np.arange(len(corners)) + np.repeat(begin - (np.cumsum(sizes) - sizes), sizes)]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    return corners, offsets, cell


def _members(members: Sequence[npt.ArrayLike | None], kept: Sequence[int], start: LongArray) -> LongArray:
    parts = [np.empty(0, np.int64)]
    for position, k in enumerate(kept):
        inside = members[k] if k < len(members) else None
        if inside is not None and np.size(inside):
            parts.append(np.asarray(inside, dtype=np.int64) + start[position])
    return np.concatenate(parts)


def _group(name: str, cells: LongArray, position: LongArray, surface: BoolArray) -> CellGroup:
    cells = cells if np.all(cells[1:] > cells[:-1]) else np.unique(cells)
    inside, at = surface[cells], position[cells]
    return CellGroup(name=name, elements=at[inside], pieces=at[~inside & (at >= 0)])


def with_pieces(groups: Sequence[CellGroup], added: Mapping[str, LongArray], first: int) -> tuple[CellGroup, ...]:
    """Return groups with those of added line elements, numbered from `first`; a name there already is distinguished."""
    names, found = {group.name for group in groups}, list(groups)
    for name, ends in added.items():
        inside = np.arange(first, first + len(ends))
        known = name if name not in names else f"{name} (nodes)"
        found.append(CellGroup(name=known, elements=np.empty(0, np.int64), pieces=inside))
        first += len(ends)
    return tuple(found)


def _whole_numbers(
    arrays: CellArrays, kept: Sequence[int], element_cell: LongArray, piece_cell: LongArray
) -> dict[str, tuple[LongArray, LongArray]]:
    """Return the arrays that hold one whole number a cell."""
    found = {}
    for name, blocks in arrays.items():
        parts = [np.asarray(blocks[k]) for k in kept]
        if not parts or any(part.ndim != 1 or part.dtype.kind not in "iuf" for part in parts):
            continue
        values = np.concatenate(parts)
        if not np.all(np.abs(values) < LARGEST):  # also what is not a number; such values represent no group
            continue
        if values.dtype.kind == "f" and np.any(values != np.round(values)):
            continue
        whole = values.astype(np.int64)
        found[name] = (whole[element_cell], whole[piece_cell])
    return found


def _type_notes(data: Sequence[tuple[str, LongArray]]) -> list[Note]:
    reduced: dict[str, int] = {}
    unused: dict[str, int] = {}
    for kind, nodes in data:
        columns = _corner_columns(kind, nodes.shape[1])
        if columns is not None:
            if nodes.shape[1] > len(columns):
                reduced[kind] = reduced.get(kind, 0) + len(nodes)
        elif kind not in POINTS and not kind.startswith(LINES):
            unused[kind] = unused.get(kind, 0) + len(nodes)
    notes = [
        Note(
            kind=NoteKind.REDUCED,
            name=kind,
            count=count,
            text=f"{count} {kind} elements are reduced to their corners: curved sides become straight",
        )
        for kind, count in reduced.items()
    ]
    for kind, count in unused.items():
        text = f"{count} {kind} elements are left out: blocks are made of triangles, quadrilaterals and polygons"
        notes.append(Note(kind=NoteKind.CELL_TYPE, name=kind, count=count, text=text))
    return notes


def _unused_nodes(data: Sequence[tuple[str, LongArray]], n_points: int) -> list[Note]:
    used = np.zeros(n_points, dtype=np.bool_)
    for _, nodes in data:
        used[nodes.ravel()] = True
    count = int(n_points - used.sum())
    return [Note(kind=NoteKind.UNUSED, count=count, text=f"{count} nodes belong to no element")] if count else []
