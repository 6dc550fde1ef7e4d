"""Findings, corrections and omissions of the conversion of a mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from bsm_mesh.arrays import FloatArray, ReadOnlyMapping
from bsm_mesh.errors import counted, place


class NoteKind(StrEnum):
    """Subject of a note."""

    READER = "remark of the file reader"
    PLANE = "plane other than xy"
    CELL_TYPE = "elements of a type that is not used"
    REDUCED = "higher-order elements reduced to their corners"
    UNUSED = "nodes in no element"
    MERGED = "nodes merged"
    CORNERS = "elements with repeated corners"
    FLAT = "elements of no area left out"
    INTERFACE = "zero-thickness interface elements left out"
    FLIPPED = "clockwise elements turned round"
    JOINED = "elements given more than once"
    NO_ROCK = "elements in no rock left out"
    OUTSIDE = "parts of lines outside the rock"
    SNAPPED = "nodes moved onto lines"
    LOOSE = "curve pieces that bound no block"
    LOST = "joints and boundaries that are shorter than asked for"
    INTERIOR = "boundary pieces with rock on both sides"
    DEAD_END = "joint pieces with the same block on both sides"
    DIVIDED = "regions that are no simple polygon divided"
    UNKNOWN_GROUP = "group that is not used"
    UNNAMED_GROUP = "curve groups without a name"
    EMPTY_GROUP = "group without elements"


MOST_LOST = 0.01  # of the length in the rock of a joint or a boundary: less may be rounding, or a corner cut off


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """A repair or an omission.

    Attributes
    ----------
    kind : NoteKind
        Its subject.
    name : str
        The group, element type or the like that it concerns; empty if it is none in particular.
    count : int
        How many elements, nodes or pieces.
    text : str
        The whole sentence.
    """

    kind: NoteKind
    name: str = ""
    count: int
    text: str


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class MeshReport:
    """The outcome of a mesh.

    Attributes
    ----------
    source : str
        The file, or the caller's name for it.
    nodes : int
        Nodes in the mesh.
    elements : int
        Surface elements in the mesh, as given.
    pieces : int
        Line elements in the mesh, as given.
    blocks : int
        Blocks made.
    blocks_from : str
        ``elements``: every element is a block; ``regions``: every region between joints is one.
    groups : mapping of str to int
        Groups used, ``kind:name``, with the number of blocks or edges in each.
    bolts : mapping of str to (n, 2, 2) float64 [m]
        Both ends of every piece of each ``bolt:`` group.
    notes : tuple of Note
        Repairs and omissions.
    """

    source: str
    nodes: int
    elements: int
    pieces: int
    blocks: int
    blocks_from: str
    groups: Mapping[str, int]
    bolts: Mapping[str, FloatArray] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        for name in ("groups", "bolts"):
            object.__setattr__(self, name, ReadOnlyMapping(getattr(self, name)))

    @property
    def sizes(self) -> str:
        """Numbers of nodes, elements and blocks, and whether elements or regions are blocks."""
        return (
            f"{counted(self.nodes, 'node')}, {counted(self.elements, 'surface element')}, "
            f"{counted(self.pieces, 'line element')}; {counted(self.blocks, 'block')} (blocks = '{self.blocks_from}')"
        )

    def about(self, kind: NoteKind) -> Mapping[str, int]:
        """Return the counts of all notes of one kind, by name."""
        return {note.name: note.count for note in self.notes if note.kind is kind}

    def count(self, kind: NoteKind) -> int:
        """Return how many elements, nodes or pieces the notes of one kind speak of."""
        return sum(self.about(kind).values())

    def __str__(self) -> str:
        """Return the report as text."""
        return "\n".join(self.lines())

    def lines(self) -> list[str]:
        """Return the report as text, a line a thing."""
        return [
            f"{self.source}: {self.sizes}",
            *(f"  {name}: {counted(count, _thing(name))}" for name, count in self.groups.items()),
            *(f"  note: {note.text}" for note in self.notes),
        ]


def _thing(group: str) -> str:
    kind = group.partition(":")[0]
    return {"rock": "block", "excavation": "block", "bolt": "piece"}.get(kind, "block edge")


def places(points: Sequence[FloatArray] | FloatArray, most: int = 3) -> str:
    """Return ``"near (1, 2), (3, 4), ..."`` for the first few of some points [m]."""
    shown = ", ".join(place(point) for point in points[:most])
    return f"near {shown}" + (", ..." if len(points) > most else "")
