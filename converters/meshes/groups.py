"""Groups of a mesh by their meaning: names of the grammar ``kind:name``, renamed where the user says so."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.converters.meshes.cells import PHYSICAL, CellGroup, MeshCells
from bsm_mesh.converters.meshes.report import Note, NoteKind
from bsm_mesh.errors import MAX_SHOWN, ModelError, counted, listing, nearest, raise_faults
from bsm_mesh.geometries.physical_groups import GroupKind, GroupName, parse_group_name
from bsm_mesh.model.edges import LongArray

UNNAMED = f"{PHYSICAL}="  # names of groups of curves that have a number of Gmsh's, and no name, begin so
ONE_NAME = ". Gmsh keeps a name for one group only: give all curves of a joint to one addPhysicalGroup"
REST = "*"  # the key that represents all elements in no rock
NO_GROUPS = '; "*" = "rock:NAME" takes all elements, [boundary.NAME] and [joint.NAME] name edges by their place'
ALL = 200  # names that are shown where one is not found
MOST_VALUES = 64  # an array with more values numbers elements, not groups


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class NamedGroup:
    """A group whose meaning is known.

    Attributes
    ----------
    name : GroupName
        Its meaning.
    source : str
        Its name in the mesh.
    elements, pieces : (k,) int64
        Its surface and line elements.
    """

    name: GroupName
    source: str
    elements: LongArray
    pieces: LongArray

    @property
    def said(self) -> str:
        """The name, with the mesh's own where that differs."""
        return f"'{self.name}'" if self.source == str(self.name) else f"'{self.name}' (in the mesh: '{self.source}')"


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class NamedGroups:
    """All groups whose meaning is known.

    Attributes
    ----------
    groups : tuple of NamedGroup
        In the order of the mesh.
    rest : str or None
        Rock of the elements in no rock, where the user named one.
    notes : tuple of Note
        Groups that are not used.
    """

    groups: tuple[NamedGroup, ...]
    rest: str | None
    notes: tuple[Note, ...]

    def of(self, kind: GroupKind) -> dict[str, list[NamedGroup]]:
        """Return the groups of one kind by name; several groups of the mesh may share one."""
        found: dict[str, list[NamedGroup]] = {}
        for group in self.groups:
            if group.name.kind is kind:
                found.setdefault(group.name.name, []).append(group)
        return found


def name_groups(cells: MeshCells, renaming: Mapping[str, str], used: Collection[str] = ()) -> NamedGroups:
    """Return the groups of a mesh by meaning.

    Parameters
    ----------
    cells : MeshCells
        The mesh.
    renaming : mapping of str to str
        From the mesh's names to ``kind:name``. A name is that of a group, or ``"ARRAY=VALUE"``: cells with that value
        in an array of whole numbers. ``"*"`` are surface elements in no rock.
    used : collection of str
        Names of groups that are used besides.

    Raises
    ------
    ModelError
        If a key is not in the mesh, or a value is not of the form ``kind:name``.
    """
    known = {group.name: group for group in cells.groups}
    faults: list[str] = []
    groups: list[NamedGroup] = []
    rest = None
    for key, text in renaming.items():
        target = parse_group_name(text)
        if target is None:
            faults.append(
                f"groups: '{key}' = '{text}' is not of the form kind:name with kind one of "
                f"{', '.join(kind.value for kind in GroupKind)}, for example 'rock:granite'"
            )
        elif key == REST:
            rest = target.name
            if target.kind is not GroupKind.ROCK:
                faults.append(f"groups: '*' represents the elements in no rock; '{text}' must be rock:name")
        elif key in known and not (key.startswith(UNNAMED) and target.kind.dimension == 2):  # a number of surfaces
            groups.append(_named(target, known[key]))
        else:
            found = _of_value(cells, key, target.kind.dimension)
            if found is None:
                names = [*known, *value_names(cells, of_pieces=True)]
                advice = "" if names else NO_GROUPS
                faults.append(f"{cells.source}: has no group '{key}'{nearest(key, names, ALL)}{advice}")
            else:
                groups.append(_named(target, found))
    raise_faults(faults)
    others = [(group, parse_group_name(group.name)) for group in cells.groups if group.name not in renaming]
    groups += [_named(parsed, group) for group, parsed in others if parsed is not None]
    notes = _unknown([group for group, parsed in others if parsed is None and group.name not in used])
    notes += [_empty(group) for group in groups if group.elements.size + group.pieces.size == 0]
    filled = tuple(group for group in groups if group.elements.size + group.pieces.size)
    return NamedGroups(groups=filled, rest=rest, notes=tuple(notes))


def _named(name: GroupName, group: CellGroup) -> NamedGroup:
    return NamedGroup(name=name, source=group.name, elements=group.elements, pieces=group.pieces)


def _of_value(cells: MeshCells, key: str, dimension: int) -> CellGroup | None:
    """Return the cells of ``ARRAY=VALUE``; those of the other dimension only if there are none of the right one."""
    array, equals, text = key.rpartition("=")
    if not equals or array not in cells.arrays:
        return None
    try:
        value = int(text)
    except ValueError:
        return None
    elements, pieces = (np.flatnonzero(values == value) for values in cells.arrays[array])
    none = np.empty(0, np.int64)
    if dimension == 2 and elements.size:
        pieces = none
    if dimension == 1 and pieces.size:
        elements = none
    if elements.size + pieces.size == 0:
        return None
    return CellGroup(name=key, elements=elements, pieces=pieces)


def value_names(cells: MeshCells, *, of_pieces: bool = False) -> list[str]:
    """Return the ``ARRAY=VALUE`` names of surface elements, or of line elements too, for arrays with few values."""
    names = []
    for array, (elements, pieces) in cells.arrays.items():
        values = np.unique(np.concatenate([elements, pieces]) if of_pieces else elements)
        if len(values) <= MOST_VALUES:
            names += [f"{array}={value}" for value in values]
    return names


def _unknown(groups: Sequence[CellGroup]) -> list[Note]:
    """Return a note each on the surface groups, the curve groups, and those of no name, that mean nothing."""
    surfaces = {group.name: group.elements.size for group in groups if group.elements.size}
    curves = {group.name: group.pieces.size for group in groups if not group.elements.size}
    unnamed = {name: size for name, size in curves.items() if name.startswith(UNNAMED)}
    named = {name: size for name, size in curves.items() if name not in unnamed}
    kinds = ("joint", "boundary")
    return [
        *_unused("surface groups", ("rock",), surfaces, NoteKind.UNKNOWN_GROUP),
        *_unused("curve groups", kinds, named, NoteKind.UNKNOWN_GROUP),
        *_unused("curve groups without a name", kinds, unnamed, NoteKind.UNNAMED_GROUP, ONE_NAME),
    ]


def _unused(what: str, kinds: Sequence[str], sizes: Mapping[str, int], kind: NoteKind, advice: str = "") -> list[Note]:
    """Return a note on groups that are not used, of so many elements each; nothing without any."""
    if not sizes:
        return []
    names = list(sizes)
    shown = ", ".join(f"'{name}' ({counted(size, 'element')})" for name, size in list(sizes.items())[:MAX_SHOWN])
    more = f" and {len(names) - MAX_SHOWN} more" if len(names) > MAX_SHOWN else ""
    target = "name" if names[0].startswith(UNNAMED) else names[0].rpartition(":")[2] or "name"
    examples = " or ".join(f'"{each}:{target}"' for each in kinds)
    text = (
        f"{what} that are not used: {shown}{more}; to use one, name it kind:name, or under [groups] "
        f'for example "{names[0]}" = {examples}{advice}'
    )
    return [Note(kind=kind, name=", ".join(names), count=int(sum(sizes.values())), text=text)]


def _empty(group: NamedGroup) -> Note:
    return Note(kind=NoteKind.EMPTY_GROUP, name=str(group.name), count=0, text=f"group {group.said} holds no elements")


def settle_dimensions(named: NamedGroups, piece_of: LongArray) -> NamedGroups:
    """Return the groups, each with elements of its own dimension only.

    Interface elements of zero thickness in a group of curves become pieces of that curve.

    Parameters
    ----------
    named : NamedGroups
        The groups.
    piece_of : (n_elements,) int64
        Piece that represents each interface element; -1 for all other elements.

    Raises
    ------
    ModelError
        If a group of surfaces holds curves, or a group of curves holds surfaces.
    """
    faults, groups = [], []
    for group in named.groups:
        if group.name.kind.dimension == 2:
            if group.pieces.size:
                faults.append(_wrong_dimension(group, int(group.pieces.size), "line elements", "surfaces"))
            groups.append(group)
            continue
        pieces = piece_of[group.elements]
        if np.any(pieces < 0):
            faults.append(_wrong_dimension(group, int((pieces < 0).sum()), "surface elements", "curves"))
        pieces = np.concatenate([group.pieces, pieces[pieces >= 0]])
        groups.append(dataclasses.replace(group, elements=np.empty(0, np.int64), pieces=pieces))
    raise_faults(faults)
    return dataclasses.replace(named, groups=tuple(groups))


def _wrong_dimension(group: NamedGroup, count: int, wrong: str, right: str) -> str:
    return (
        f"group {group.said}: holds {count} {wrong}, and {group.name.kind.value}:NAME is for {right}; "
        "give it another kind, under [groups] or in the mesh"
    )


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Rocks:
    """The rock of every outline.

    Attributes
    ----------
    names : tuple of str
        Names of the rocks.
    index : (n_outlines,) int64
        Index in `names`; -1 for outlines in no rock.
    """

    names: tuple[str, ...]
    index: LongArray


def assign_rocks(cells: MeshCells, named: NamedGroups, outline_of: LongArray, n_outlines: int) -> Rocks:
    """Return the rock of every outline.

    Parameters
    ----------
    cells : MeshCells
        The mesh, for messages.
    named : NamedGroups
        Its groups.
    outline_of : (n_elements,) int64
        Outline of every element; -1 for elements left out.
    n_outlines : int
        How many outlines there are.

    Raises
    ------
    ModelError
        If an element is in two rocks, or no element in any.
    """
    index = np.full(n_outlines, -1, dtype=np.int64)
    rocks = named.of(GroupKind.ROCK)
    names = list(rocks)
    faults = []
    for k, parts in enumerate(rocks.values()):
        elements = np.unique(np.concatenate([part.elements for part in parts]))
        elements = elements[outline_of[elements] >= 0]
        other = index[outline_of[elements]]
        for j in np.unique(other[other >= 0]):
            both = elements[other == j]
            faults.append(
                f"{cells.source}: {both.size} elements are in 'rock:{names[j]}' and in 'rock:{names[k]}' "
                f"(elements {listing(cells.numbers[both])}); an element has one rock"
            )
        index[outline_of[elements]] = k
    raise_faults(faults)
    if named.rest is not None:
        if named.rest not in names:
            names.append(named.rest)
        index[index < 0] = names.index(named.rest)
    if not np.any(index >= 0):
        raise ModelError(f"{cells.source}: {_no_rock(cells)}")
    return _used_only(names, index, index >= 0)


def _used_only(names: Iterable[str], index: LongArray, placed: BoolArray) -> Rocks:
    used, packed = np.unique(index[placed], return_inverse=True)
    index = index.copy()
    index[placed] = packed
    all_names = list(names)
    return Rocks(names=tuple(all_names[k] for k in used), index=index)


def _no_rock(cells: MeshCells) -> str:
    found = [
        f"{group.name} ({counted(group.elements.size, 'element')})" for group in cells.groups if group.elements.size
    ]
    values = value_names(cells)
    names = [group.name for group in cells.groups if group.elements.size] or values
    example = f'"{names[0]}" = "rock:granite"' if names else '"*" = "rock:granite"'
    lost = [note.text for note in cells.notes if note.kind is NoteKind.EMPTY_GROUP]
    if lost:
        return f"no element is in a rock; {'; '.join(lost)}; or map values under [groups] ({', '.join(values[:12])})"
    seen = "surface groups found: " + ", ".join(found) if found else "it has no named surface groups"
    if values and not found:
        seen += "; values found: " + ", ".join(values[:12])
    return (
        f"no element is in a rock; {seen}; name the surfaces rock:name in the mesh, or map them under [groups], "
        f"for example {example}" + (' ("*" = "rock:granite" takes all elements)' if names else "")
    )
