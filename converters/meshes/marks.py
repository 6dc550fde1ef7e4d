"""Joints and boundaries by place, not by the groups of a mesh: along lines, between rocks, on a side of the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.meshes.cells import MeshCells
from bsm_mesh.converters.meshes.curves import interior_notes
from bsm_mesh.converters.meshes.laid_lines import along_line, lay_lines, with_joint
from bsm_mesh.converters.meshes.report import Note, NoteKind, places
from bsm_mesh.errors import ModelError, counted, nearest, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import LongArray

BETWEEN_ROCKS = "rocks"  # the border of any two rocks
OFF_A_LINE = 0.01  # of an edge's length: how far its ends and its middle may lie off the line that it is along


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Place:
    """Where the edges of a boundary are: on the rim of the model, and where all that is given holds for both ends.

    A line also takes the edges on the faces of excavations.

    Attributes
    ----------
    below, above, left_of, right_of : float or None [m]
        Greatest y, least y, greatest x, least x.
    along : (n, 2) float64 or None [m]
        The line along which they lie, to a hundredth of their length.
    """

    below: float | None = None
    above: float | None = None
    left_of: float | None = None
    right_of: float | None = None
    along: FloatArray | None = None

    @property
    def said(self) -> str:
        """The input, as in the model file."""
        limits = {name: getattr(self, name) for name in ("below", "above", "left_of", "right_of")}
        given = [f"{name} = {value:g}" for name, value in limits.items() if value is not None]
        return ", ".join([*given, *(["along"] if self.along is not None else [])])


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Marks:
    """Joints and boundaries by place.

    Attributes
    ----------
    lines : mapping of str to sequence of (n, 2) float64 [m]
        Lines of each joint; elements that they cross are cut.
    borders : mapping of str to str or (str, str)
        The two sides of each joint: two names (rocks, groups of surfaces), or ``"rocks"`` for any two rocks. The name
        of an array of whole numbers is for any two values of it.
    boundaries : mapping of str to Place
        Where each boundary is.
    """

    lines: Mapping[str, Sequence[FloatArray]] = field(default_factory=dict)
    borders: Mapping[str, str | tuple[str, str]] = field(default_factory=dict)
    boundaries: Mapping[str, Place] = field(default_factory=dict)

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of rocks and groups that joints lie between."""
        return tuple(name for border in self.borders.values() if not isinstance(border, str) for name in border)


def mark(blocks: Blocks, marks: Marks, cells: MeshCells, block_of: LongArray) -> tuple[Blocks, tuple[Note, ...]]:
    """Return blocks with the joints and boundaries of `marks` added to their own, which stay.

    Parameters
    ----------
    blocks : Blocks
        An element a block.
    marks : Marks
        Joints and boundaries to add.
    cells : MeshCells
        The mesh, for the names of its groups and arrays.
    block_of : (n_elements,) int64
        Block of every element of the mesh, or -1.

    Raises
    ------
    ModelError
        With every name that is not there, and every boundary on which there is no edge.
    """
    notes: list[Note] = []
    parent: LongArray = np.arange(blocks.count)
    if marks.lines:
        blocks, parent, more = lay_lines(blocks, marks.lines)
        notes += more
    faults: list[str] = []
    for joint, border in marks.borders.items():
        try:
            edges = _on_border(blocks, _sides(blocks, border, cells, block_of, parent))
        except ModelError as error:
            faults += [f"joint '{joint}': {fault}" for fault in error.faults]
            continue
        blocks = with_joint(blocks, joint, edges)
        if not edges.size:
            text = f"joint '{joint}' lies nowhere: there is no edge between {_said(border)}"
            notes.append(Note(kind=NoteKind.LOST, name=f"joint:{joint}", count=0, text=text))
    found = {}
    for name, place in marks.boundaries.items():
        found[name], left_out = edges_at(blocks, place)
        if not found[name].size:
            where = "of the rim" if place.along is None else "of the rim or of an excavation's face"
            faults.append(f"boundary '{name}': {place.said}: no edge {where} lies there; {_extent(blocks)}")
        elif left_out.size:
            text = (
                f"boundary '{name}': {counted(left_out.size, 'block edge')} along its line "
                f"({places(blocks.vertices[left_out])}) not taken: rock on both sides, and no excavation on one of them"
            )
            notes.append(Note(kind=NoteKind.LOST, name=f"boundary:{name}", count=int(left_out.size), text=text))
    raise_faults(faults)
    notes += interior_notes(found, ~blocks.edge_table.unpaired(), blocks.vertices)
    for name, edges in found.items():
        both = np.union1d(blocks.boundaries.get(name, np.empty(0, np.int32)), edges).astype(np.int32)
        blocks = replace(blocks, boundaries={**blocks.boundaries, name: both})
    return blocks, tuple(notes)


def edges_at(blocks: Blocks, place: Place) -> tuple[IntArray, IntArray]:
    """Return the edges at a place, (k,), and those along its line that it does not take: within the rock."""
    ends = np.stack([blocks.vertices, blocks.vertices[blocks.following]], axis=1)
    x, y = ends[..., 0], ends[..., 1]
    inside = np.ones(len(ends), dtype=np.bool_)
    for value, limit in ((y, place.below), (-y, _minus(place.above)), (x, place.left_of), (-x, _minus(place.right_of))):
        if limit is not None:
            inside &= (value <= limit).all(axis=1)
    if place.along is not None:
        inside[inside] = along_line(
            ends[inside], [place.along], OFF_A_LINE * np.hypot(*np.diff(ends[inside], axis=1)[:, 0].T)
        )
    taken = blocks.edge_table.unpaired()
    if place.along is not None:
        taken = taken | _on_faces(blocks)
    return np.flatnonzero(inside & taken).astype(np.int32), np.flatnonzero(inside & ~taken).astype(np.int32)


def _on_faces(blocks: Blocks) -> BoolArray:
    """Return which edges lie on the face of an excavation: one of their two blocks is in it."""
    one, other = blocks.edge_table.pairs()
    found = np.zeros(len(blocks.vertices), dtype=np.bool_)
    for ids in blocks.excavations.values():
        dug = np.zeros(blocks.count, dtype=np.bool_)
        dug[ids] = True
        at = dug[blocks.owner[one]] != dug[blocks.owner[other]]
        found[one[at]] = found[other[at]] = True
    return found


def _minus(value: float | None) -> float | None:
    return None if value is None else -value


Membership = tuple[BoolArray, BoolArray] | LongArray  # of blocks: in the one, in the other; or a value


def _sides(
    blocks: Blocks, border: str | tuple[str, str], cells: MeshCells, block_of: LongArray, parent: LongArray
) -> Membership:
    """Return the rocks or groups of the blocks on the two sides of a border."""
    if border == BETWEEN_ROCKS:
        return blocks.rock.astype(np.int64)
    given = np.flatnonzero(block_of >= 0)
    if isinstance(border, str):
        if border not in cells.arrays:
            known = [BETWEEN_ROCKS, *cells.arrays]
            raise ModelError(f"between = '{border}' is no array of whole numbers{nearest(border, known)}")
        value = np.zeros(int(block_of.max()) + 1, dtype=np.int64)
        value[block_of[given]] = cells.arrays[border][0][given]
        of_blocks: LongArray = value[parent]
        return of_blocks
    groups = {group.name: group.elements for group in cells.groups if group.elements.size}
    one, other = (_inside(name, blocks, groups, block_of, parent) for name in border)
    return one, other


def _inside(
    name: str, blocks: Blocks, groups: Mapping[str, LongArray], block_of: LongArray, parent: LongArray
) -> BoolArray:
    if name in blocks.rock_names:
        in_rock: BoolArray = blocks.rock == blocks.rock_names.index(name)
        return in_rock
    if name not in groups:
        raise ModelError(f"between: '{name}' is no rock and no group{nearest(name, [*blocks.rock_names, *groups])}")
    inside = np.zeros(int(block_of.max()) + 1, dtype=np.bool_)
    mine = block_of[groups[name]]
    inside[mine[mine >= 0]] = True
    of_blocks: BoolArray = inside[parent]
    return of_blocks


def _on_border(blocks: Blocks, sides: Membership) -> LongArray:
    """Return the edges on both sides of a border."""
    one, other = blocks.edge_table.pairs()
    a, b = blocks.owner[one], blocks.owner[other]
    if isinstance(sides, tuple):
        first, second = sides
        across: BoolArray = (first[a] & second[b]) | (first[b] & second[a])
    else:
        across = sides[a] != sides[b]
    return np.concatenate([one[across], other[across]])


def _said(border: str | tuple[str, str]) -> str:
    return f"two values of '{border}'" if isinstance(border, str) else " and ".join(f"'{name}'" for name in border)


def _extent(blocks: Blocks) -> str:
    low, high = blocks.vertices.min(axis=0), blocks.vertices.max(axis=0)
    return f"the blocks lie from x = {low[0]:g} to {high[0]:g}, y = {low[1]:g} to {high[1]:g} m"
