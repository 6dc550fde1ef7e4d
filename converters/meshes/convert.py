"""Blocks from a mesh, in a file or in memory."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.meshes.cell_faults import CellArrays, CellSets
from bsm_mesh.converters.meshes.cells import MeshCells, gather_cells
from bsm_mesh.converters.meshes.curves import (
    LoosePieces,
    cover_edges,
    edges_on_curves,
    interior_notes,
    joint_of_edges,
    loose_notes,
)
from bsm_mesh.converters.meshes.files import read_cells
from bsm_mesh.converters.meshes.groups import NamedGroups, Rocks, assign_rocks, name_groups, settle_dimensions
from bsm_mesh.converters.meshes.marks import Marks, mark
from bsm_mesh.converters.meshes.outlines import Outlines, outline_elements
from bsm_mesh.converters.meshes.regions import merge_regions
from bsm_mesh.converters.meshes.report import MeshReport, Note, NoteKind, places
from bsm_mesh.errors import MeshWarning, ModelError, as_given, counted, listing, one_line, raise_faults
from bsm_mesh.geometries.physical_groups import GroupKind
from bsm_mesh.model.blocks import MERGE_TOLERANCE, Blocks
from bsm_mesh.model.edges import EdgeTable, LongArray
from bsm_mesh.model.overlap import Overlaps, find_overlaps
from bsm_mesh.model.values import is_number

BlocksFrom = Literal["elements", "regions"]


def read_blocks(
    path: str | os.PathLike[str],
    *,
    groups: Mapping[str, str] | None = None,
    unit_scale: float = 1.0,
    merge_tolerance: float = MERGE_TOLERANCE,
    blocks: BlocksFrom = "elements",
    marks: Marks | None = None,
) -> Blocks:
    """Return the blocks of a mesh file, with joints, boundaries and excavations; warn of all that was corrected.

    See `read_mesh` for the parameters and the errors.

    Warns
    -----
    MeshWarning
        For every repair and omission.
    """
    found, report = read_mesh(
        path, groups=groups, unit_scale=unit_scale, merge_tolerance=merge_tolerance, blocks=blocks, marks=marks
    )
    for note in report.notes:
        warnings.warn(one_line(f"{report.source}: {note.text}"), MeshWarning, stacklevel=2)
    return found


def read_mesh(
    path: str | os.PathLike[str],
    *,
    groups: Mapping[str, str] | None = None,
    unit_scale: float = 1.0,
    merge_tolerance: float = MERGE_TOLERANCE,
    blocks: BlocksFrom = "elements",
    marks: Marks | None = None,
) -> tuple[Blocks, MeshReport]:
    """Return the blocks of a mesh file and the report of findings, corrections and omissions.

    Parameters
    ----------
    path : path
        A file in any format that meshio or VTK reads. A mesh in the xy plane keeps its axes; of one in the xz or yz
        plane, z is up.
    groups : mapping of str to str
        Meanings of the mesh's own groups, ``{"Schist": "rock:schist"}``; ``"*"`` represents the surface elements in
        no rock, and ``"MaterialIDs=3"`` for the elements where that array has that value.
    unit_scale : float [m]
        The mesh's unit of length: 0.001 for millimetres.
    merge_tolerance : float [m]
        Nodes nearer than this are one point, so that a mesh with doubled nodes along its joints conforms.
    blocks : str
        ``elements``: every surface element is a block; ``regions``: the elements between joints are one block, which
        may be concave.
    marks : Marks, optional
        Joints and boundaries by place, added to those of the mesh.

    Raises
    ------
    ModelError
        If the file cannot be read, holds no plane mesh, no rock, or elements that overlap.
    """
    return _blocks_of(read_cells(path), groups or {}, unit_scale, merge_tolerance, blocks, marks)


def convert_mesh(
    points: npt.ArrayLike,
    cells: Sequence[tuple[str, npt.ArrayLike]],
    cell_sets: CellSets | None = None,
    *,
    cell_data: CellArrays | None = None,
    groups: Mapping[str, str] | None = None,
    unit_scale: float = 1.0,
    merge_tolerance: float = MERGE_TOLERANCE,
    blocks: BlocksFrom = "elements",
    marks: Marks | None = None,
    source: str = "mesh",
) -> tuple[Blocks, MeshReport]:
    """Return the blocks of a mesh in memory, and the report.

    Parameters
    ----------
    points : (n, 2 or 3) array_like
        Coordinates of the nodes.
    cells : sequence of (str, (m, k) array_like)
        Element type by meshio's names (``triangle``, ``quad``, ``polygon``, ``line``, ...) and node numbers from 0.
    cell_sets : mapping of str to a sequence of arrays
        For every group, one entry for each entry of `cells`: the elements in it, counted from 0; or None.
    cell_data : mapping of str to a sequence of arrays
        Whole numbers of the elements, an array for each entry of `cells`.
    groups, unit_scale, merge_tolerance, blocks, marks
        As for `read_mesh`.
    source : str
        What messages call the mesh.

    Raises
    ------
    ModelError
        As `read_mesh` does.

    Examples
    --------
    >>> points = [(0, 0), (1, 0), (1, 1), (0, 1)]
    >>> blocks, report = convert_mesh(
    ...     points, [("triangle", [(0, 1, 2), (0, 2, 3)])], {"rock:granite": [[0, 1]]}
    ... )
    >>> blocks.count, blocks.rock_names, report.notes
    (2, ('granite',), ())
    """
    gathered = gather_cells(source, points, cells, sets=cell_sets or {}, arrays=cell_data or {})
    return _blocks_of(gathered, groups or {}, unit_scale, merge_tolerance, blocks, marks)


def convert_meshio(
    mesh: Any,
    *,
    groups: Mapping[str, str] | None = None,
    unit_scale: float = 1.0,
    merge_tolerance: float = MERGE_TOLERANCE,
    blocks: BlocksFrom = "elements",
    marks: Marks | None = None,
    source: str = "mesh",
) -> tuple[Blocks, MeshReport]:
    """Return the blocks of a ``meshio.Mesh``, and the report; parameters and errors as for `convert_mesh`."""
    from bsm_mesh.converters.meshes.from_meshio import cells_of_meshio

    return _blocks_of(cells_of_meshio(mesh, source), groups or {}, unit_scale, merge_tolerance, blocks, marks)


def _blocks_of(
    cells: MeshCells,
    renaming: Mapping[str, str],
    unit_scale: float,
    merge_tolerance: float,
    blocks_from: BlocksFrom,
    marks: Marks | None,
) -> tuple[Blocks, MeshReport]:
    if not (is_number(unit_scale) and unit_scale > 0):
        raise ModelError(f"unit_scale {as_given(unit_scale)}: must be a length above 0 m")
    if not (is_number(merge_tolerance) and merge_tolerance >= 0):
        raise ModelError(f"merge_tolerance {as_given(merge_tolerance)}: must be 0 m or more")
    if not isinstance(blocks_from, str) or blocks_from not in get_args(BlocksFrom):
        raise ModelError(f"blocks = {as_given(blocks_from)}: must be one of {', '.join(get_args(BlocksFrom))}")
    if not isinstance(renaming, Mapping) or not all(
        isinstance(text, str) for entry in renaming.items() for text in entry
    ):
        raise ModelError("groups: the names of groups and their meanings must be texts: {'Schist': 'rock:schist'}")
    named = name_groups(cells, renaming, () if marks is None else marks.groups)
    outlines = outline_elements(cells, unit_scale=unit_scale, merge_tolerance=merge_tolerance)
    named = settle_dimensions(named, outlines.piece_of)
    rocks = assign_rocks(cells, named, outlines.outline_of, len(outlines.offsets) - 1)
    if blocks_from == "elements":
        outlines = outlines.straightened()
    elements, block_of, bolts, loose, notes = _assemble(cells, named, outlines, rocks)
    if marks is not None:
        elements, more = mark(elements, marks, cells, block_of)
        notes = (*notes, *more)
    if blocks_from == "regions":
        lost = [note.text for note in notes if note.kind is NoteKind.UNNAMED_GROUP]
        raise_faults([f'{cells.source}: blocks = "regions": {text}' for text in lost])
        overlaps = elements.overlaps
        elements, more = merge_regions(elements, outlines.precision, () if marks is None else marks.lines)
        vars(elements)["overlaps"] = overlaps  # none, which takes long to find out again
        notes = (*notes, *more)
    notes = (*notes, *loose_notes(loose, elements.vertices, elements.offsets))
    return elements, _report(cells, elements, blocks_from, bolts, notes)


def _assemble(
    cells: MeshCells,
    named: NamedGroups,
    outlines: Outlines,
    rocks: Rocks,
) -> tuple[Blocks, LongArray, dict[str, FloatArray], tuple[LoosePieces, ...], tuple[Note, ...]]:
    """Return blocks of the outlines that have a rock, the block of every element, bolts, loose pieces, and notes."""
    placed = rocks.index >= 0
    block = np.where(placed, np.cumsum(placed) - 1, -1)
    block_of = np.where(outlines.outline_of >= 0, block[outlines.outline_of], -1)  # of every element
    sizes = np.diff(outlines.offsets)
    corners = outlines.corners[np.repeat(placed, sizes)]
    offsets = np.concatenate([[0], np.cumsum(sizes[placed])]).astype(np.int32)
    vertices = outlines.points[corners]
    nodes, number = _renumber(corners, len(outlines.points))
    table = EdgeTable.of(nodes, offsets)
    overlaps = find_overlaps(vertices, offsets, nodes, table)
    _refuse_overlaps(cells, block_of, overlaps)
    ends = outlines.points[outlines.pieces]
    coverage = cover_edges(number[outlines.pieces].astype(np.int64), ends, table, vertices, offsets, outlines.tolerance)
    joints, boundaries = (
        edges_on_curves(named.of(kind), coverage, ends) for kind in (GroupKind.JOINT, GroupKind.BOUNDARY)
    )
    joint_names, edge_joint = joint_of_edges(joints.edges, vertices, len(vertices))
    blocks = Blocks(
        vertices=vertices,
        offsets=offsets,
        nodes=nodes,
        rock=rocks.index[placed].astype(np.int32),
        rock_names=rocks.names,
        edge_joint=edge_joint,
        joint_names=tuple(joint_names),
        boundaries=boundaries.edges,
        excavations=_excavations(cells.source, named, block_of),
    )
    bolts = {
        name: ends[np.unique(np.concatenate([part.pieces for part in parts]))]
        for name, parts in named.of(GroupKind.BOLT).items()
    }
    notes = (
        *cells.notes,
        *named.notes,
        *outlines.notes,
        *_no_rock_notes(cells, outlines, block_of),
        *interior_notes(boundaries.edges, coverage.paired, vertices),
    )
    vars(blocks)["overlaps"] = overlaps  # none, which takes long to find out again
    return blocks, block_of, bolts, (*joints.loose, *boundaries.loose), notes


def _renumber(corners: IntArray, n_points: int) -> tuple[IntArray, IntArray]:
    """Return the corners in numbers of the points that blocks use, and the new number of every point or -1."""
    used = np.zeros(n_points, dtype=np.bool_)
    used[corners] = True
    number = np.where(used, np.cumsum(used) - 1, -1).astype(np.int32)
    return number[corners], number


def _refuse_overlaps(cells: MeshCells, block_of: LongArray, overlaps: Overlaps) -> None:
    if len(overlaps.pairs):
        numbers = np.empty(int(block_of.max()) + 1, dtype=np.int64)
        numbers[block_of[block_of >= 0]] = cells.numbers[block_of >= 0]
        raise ModelError([f"{cells.source}: {fault}" for fault in overlaps.faults(numbers, "elements")])


def _excavations(source: str, named: NamedGroups, block_of: LongArray) -> dict[str, IntArray]:
    """Return the blocks of every excavation.

    Raises
    ------
    ModelError
        If an excavation has surfaces, and none of them is in a rock: each must be in two groups.
    """
    found, faults = {}, []
    for name, parts in named.of(GroupKind.EXCAVATION).items():
        elements = np.concatenate([part.elements for part in parts])
        blocks = np.unique(block_of[elements])
        if np.any(blocks >= 0):
            found[name] = blocks[blocks >= 0].astype(np.int32)
        elif elements.size:
            faults.append(
                f"{source}: 'excavation:{name}': none of its {counted(elements.size, 'element')} is in a rock; add the "
                "surfaces to a group rock:NAME too, and save as MSH 4.1 (MSH 2.2 keeps one group of each surface)"
            )
    raise_faults(faults)
    return found


def _no_rock_notes(cells: MeshCells, outlines: Outlines, block_of: LongArray) -> list[Note]:
    without = np.flatnonzero((outlines.outline_of >= 0) & (block_of < 0))
    if without.size == 0:
        return []
    where = places(outlines.points[outlines.corners[outlines.offsets[outlines.outline_of[without]]]])
    text = (
        f"{without.size} elements are in no rock and are left out "
        f"(elements {listing(cells.numbers[without])}, {where}); "
        'to keep them, name their rock, or under [groups] "*" = "rock:..."'
    )
    return [Note(kind=NoteKind.NO_ROCK, count=int(without.size), text=text)]


def _report(
    cells: MeshCells, blocks: Blocks, blocks_from: str, bolts: Mapping[str, FloatArray], notes: tuple[Note, ...]
) -> MeshReport:
    in_rock = np.bincount(blocks.rock, minlength=len(blocks.rock_names))
    on_joint = np.bincount(blocks.edge_joint[blocks.edge_joint >= 0], minlength=len(blocks.joint_names))
    groups = {f"rock:{name}": int(count) for name, count in zip(blocks.rock_names, in_rock, strict=True)}
    groups |= {f"excavation:{name}": len(ids) for name, ids in blocks.excavations.items()}
    groups |= {f"joint:{name}": int(count) for name, count in zip(blocks.joint_names, on_joint, strict=True)}
    groups |= {f"boundary:{name}": len(edges) for name, edges in blocks.boundaries.items()}
    groups |= {f"bolt:{name}": len(ends) for name, ends in bolts.items()}
    return MeshReport(
        source=cells.source,
        nodes=len(cells.points),
        elements=cells.count,
        pieces=len(cells.pieces),
        blocks=blocks.count,
        blocks_from=blocks_from,
        groups=groups,
        bolts=bolts,
        notes=notes,
    )
