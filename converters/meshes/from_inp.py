"""Abaqus input (also of CalculiX, LS-PrePost, HyperMesh, Gmsh), by a reader of our own.

meshio 5.3.5 keeps the last of several *NODE blocks, knows few types of elements and these in capitals only, loses sets
that stand before their elements or hold others, reads no parts, instances and surfaces.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.meshes.cells import MeshCells, gather_cells
from bsm_mesh.errors import ModelError, counted
from bsm_mesh.model.edges import LongArray

LIBRARY = ()
LINE = re.compile(r"(T[23]D|B[23]|SAX|R2D2|RAX2|FRAME|GK2D|ACIN2D|MAX|SFMAX)")
VOLUME = re.compile(r"(F?C3D|SC|CSS|COH3D|AC3D|DC3D|EC3D|CIN3D)")
OF_NODES = {3: "triangle", 6: "triangle6", 4: "quad", 8: "quad8"}
MOST_GENERATED = 10_000_000  # members of a set in a line
GREATEST = 2**53  # number of a node or element
DEPTH = 20  # of files that include files


@dataclass(slots=True)
class _Part:
    """Nodes, elements and sets of a part, or of the whole file, which may have no parts; numbers are the file's."""

    name: str = ""
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))
    nodes: list[FloatArray] = field(default_factory=list)  # (n, 4): number, x, y, z
    elements: list[tuple[str, LongArray]] = field(default_factory=list)  # type; (m, 1 + k): number, nodes
    sets: dict[str, dict[str, list[LongArray | str]]] = field(default_factory=lambda: {"node": {}, "element": {}})
    sides: dict[str, list[tuple[str, int]]] = field(default_factory=dict)  # surface: element or set, side from 1


def read_inp(path: Path) -> MeshCells:
    """Return the elements, element sets, node sets and surfaces of an Abaqus input file.

    Node sets and surfaces become the sides of elements that they hold: those at the rim if there are any, else those
    between elements. Sets of parts keep their names; of several instances they are put together.

    Raises
    ------
    ModelError
        With the line, where something cannot be read.
    """
    parts, instances, assembly = _parts(path)
    bodies: list[_Body] = []
    for part, shift in instances or [(name, np.zeros(3)) for name, part in parts.items() if part.nodes]:
        if not parts.get(part, assembly).nodes:
            raise ModelError(f"{path}: *INSTANCE of the part '{part}', which has no nodes")
        first = sum(len(body.points) for body in bodies)
        bodies.append(_Body.of(parts[part], assembly, shift, first, path))
    if not bodies:
        raise ModelError(f"{path}: no *NODE block: cannot read it as Abaqus input; it is damaged, or cut off")
    named = {kind: dict.fromkeys(n for part in parts.values() for n in part.sets[kind]) for kind in ("node", "element")}
    surfaces = dict.fromkeys(name for part in parts.values() for name in part.sides)
    return gather_cells(
        str(path),
        np.concatenate([body.points for body in bodies]),
        [cell for body in bodies for cell in body.cells],
        sets={name: [rows for body in bodies for rows in body.elements_in(name)] for name in named["element"]},
        arrays={},
        node_sets={name: np.concatenate([body.nodes_in(name) for body in bodies]) for name in named["node"]},
        sides={name: np.concatenate([body.sides_of(name) for body in bodies]) for name in surfaces},
        notes=[],
    )


@dataclass(frozen=True, slots=True)
class _Block:
    """A keyword with its options and the data lines below it."""

    keyword: str
    options: Mapping[str, str]
    lines: Sequence[str]
    where: str

    def fault(self, text: str) -> ModelError:
        return ModelError(f"{self.where}: *{self.keyword}: {text}")

    def numbers(self) -> FloatArray:
        """Return all numbers of the data lines, one after the other."""
        try:
            values = np.array([c for line in self.lines for c in line.split(",") if c.strip()], dtype=np.float64)
        except ValueError as error:
            raise self.fault(f"{error}; numbers are needed") from None
        if not np.isfinite(values).all():
            raise self.fault("holds what is not finite; numbers are needed")
        return values


def _blocks(path: Path, depth: int = 0) -> Iterator[_Block]:
    """Give the keyword blocks of a file, and of those that it includes."""
    if depth > DEPTH:
        raise ModelError(f"{path}: files include each other without end")
    keyword, where = "", ""
    options: dict[str, str] = {}
    lines: list[str] = []
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            continued = ""
            for number, raw in enumerate(file, start=1):
                line = continued + raw.strip()
                continued = ""
                if not line or line.startswith("**"):
                    continue
                if not line.startswith("*"):
                    lines.append(line)
                    continue
                if line.endswith(","):  # the options go on in the next line
                    continued = line
                    continue
                if keyword:
                    yield _Block(keyword, options, lines, where)
                words = [word.strip() for word in line[1:].split(",")]
                keyword, lines, where = " ".join(words[0].upper().split()), [], f"{path}, line {number}"
                options = {k.strip().upper(): v.strip().strip('"') for k, _, v in (w.partition("=") for w in words[1:])}
                if keyword == "INCLUDE":
                    yield from _blocks(path.parent / options.get("INPUT", ""), depth + 1)
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror or error})") from None
    if keyword:
        yield _Block(keyword, options, lines, where)


def _parts(path: Path) -> tuple[dict[str, _Part], list[tuple[str, FloatArray]], _Part]:
    """Return the parts by name, the instances (part, shift), and what belongs to the assembly."""
    parts: dict[str, _Part] = {"": _Part()}
    instances: list[tuple[str, FloatArray]] = []
    now = assembly = parts[""]
    for block in _blocks(path):
        options = block.options
        if block.keyword == "PART":
            now = parts.setdefault(options.get("NAME", "").upper(), _Part(name=options.get("NAME", "")))
        elif block.keyword == "END PART":
            now = assembly
        elif block.keyword == "INSTANCE":
            values = block.numbers()
            if len(values) > 3:
                raise block.fault("is turned; turn the mesh itself (a translation alone is read)")
            shift = np.zeros(3)
            shift[: len(values)] = values
            instances.append((options.get("PART", "").upper(), shift))
        elif block.keyword == "NODE":
            now.nodes.append(_nodes(block))
        elif block.keyword == "ELEMENT":
            rows = _elements(block)
            now.elements.append((options.get("TYPE", "").upper(), rows))
            if "ELSET" in options:
                now.sets["element"].setdefault(options["ELSET"], []).append(rows[:, 0])
        elif block.keyword in ("NSET", "ELSET"):
            kind = "node" if block.keyword == "NSET" else "element"
            now.sets[kind].setdefault(options.get(block.keyword, ""), []).extend(_members(block))
        elif block.keyword == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
            now.sides.setdefault(options.get("NAME", ""), []).extend(_sides(block))
    return parts, instances, assembly


def _nodes(block: _Block) -> FloatArray:
    """Return number and coordinates of the nodes, (n, 4)."""
    width = len([c for c in block.lines[0].split(",") if c.strip()]) if block.lines else 3
    values = block.numbers()
    if width not in (3, 4) or len(values) % width:
        raise block.fault("each line needs a number and two or three coordinates")
    rows = np.zeros((len(values) // width, 4))
    rows[:, :width] = values.reshape(-1, width)
    return rows


def _elements(block: _Block) -> LongArray:
    """Return number and nodes of the elements, (m, 1 + k); a line that ends in a comma goes on in the next one."""
    size = 0
    for line in block.lines:
        size += len([c for c in line.split(",") if c.strip()])
        if not line.endswith(","):
            break
    values = block.numbers()
    if size < 2 or len(values) % size:
        raise block.fault(f"{len(values)} numbers are no rows of {size}; the list is cut off or of several types")
    return values.astype(np.int64).reshape(-1, size)


def _members(block: _Block) -> list[LongArray | str]:
    """Return the numbers in a set, and names of other sets in it."""
    if "GENERATE" in block.options:
        ranges: list[LongArray | str] = []
        for line in block.lines:
            try:
                first, last, *step = (int(c) for c in line.split(",") if c.strip())
                numbers = range(first, last + 1, *(step or [1]))
            except (ValueError, TypeError):
                raise block.fault(f"'{line}' must be first, last, step") from None
            if abs(last - first) > MOST_GENERATED * abs(numbers.step) or max(abs(first), abs(last)) > GREATEST:
                raise block.fault(f"'{line}' generates more numbers than any mesh has ({MOST_GENERATED:g}); mend it")
            ranges.append(np.arange(numbers.start, numbers.stop, numbers.step))
        return ranges
    words = [word.strip().strip('"') for line in block.lines for word in line.split(",") if word.strip()]
    whole = [word for word in words if word.lstrip("-").isdigit()]
    return [np.array(whole, dtype=np.int64), *(word for word in words if not word.lstrip("-").isdigit())]


def _sides(block: _Block) -> list[tuple[str, int]]:
    """Return (element or set, side) of a surface; without a side: 0, all at the rim."""
    rows = [[word.strip() for word in line.split(",")] for line in block.lines]
    sides = {f"S{k}": k for k in range(1, 9)} | {f"E{k}": k for k in range(1, 9)}
    return [(row[0], sides.get(row[1].upper() if len(row) > 1 else "", 0)) for row in rows if row[0]]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class _Body:
    """An instance of a part, its nodes numbered from `first`; the assembly's sets hold its numbers too."""

    parts: tuple[_Part, ...]
    points: FloatArray
    known: LongArray  # the file's numbers of its nodes, sorted
    node: LongArray  # the node of each of them
    cells: list[tuple[str, LongArray]]
    numbers: list[LongArray]  # the file's numbers of the elements, a block each

    @classmethod
    def of(cls, part: _Part, assembly: _Part, shift: FloatArray, first: int, path: Path) -> _Body:
        nodes = np.concatenate(part.nodes)
        order = np.argsort(nodes[:, 0], kind="stable")
        known, cells = nodes[order, 0].astype(np.int64), []
        for kind, rows in part.elements:
            at = np.searchsorted(known, rows[:, 1:]).clip(max=len(known) - 1)
            lost = rows[:, 1:][known[at] != rows[:, 1:]]
            if lost.size:
                raise ModelError(
                    f"{path}: {counted(lost.size, 'node')} of elements of the type {kind} are not there, such as "
                    f"{lost[0]}; the file is cut off or was edited"
                )
            cells.append((_kind(kind, rows.shape[1] - 1), order[at] + first))
        return cls(
            parts=(part,) if part is assembly else (part, assembly),
            points=nodes[:, 1:] + shift,
            known=known,
            node=order + first,
            cells=cells,
            numbers=[rows[:, 0] for _, rows in part.elements],
        )

    def numbers_in(self, kind: str, name: str) -> LongArray:
        """Return the numbers in a set of a kind."""
        return np.unique(np.concatenate([_resolve(part.sets[kind], name) for part in self.parts]))

    def elements_in(self, name: str) -> list[LongArray]:
        """Return the elements in a set, counted from 0 in each block."""
        inside = self.numbers_in("element", name)
        return [np.flatnonzero(np.isin(ids, inside)) for ids in self.numbers]

    def nodes_in(self, name: str) -> LongArray:
        """Return the nodes in a set."""
        return self.node[np.isin(self.known, self.numbers_in("node", name))]

    def sides_of(self, name: str) -> LongArray:
        """Return the ends of the sides of elements that a surface holds, (k, 2)."""
        found = [np.empty((0, 2), np.int64)]
        for what, side in (row for part in self.parts for row in part.sides.get(name, [])):
            inside = np.array([int(what)]) if what.isdigit() else self.numbers_in("element", what)
            for (kind, nodes), ids in zip(self.cells, self.numbers, strict=True):
                corners = nodes[np.isin(ids, inside)][:, : 3 if kind.startswith("triangle") else 4]
                if kind.startswith(("triangle", "quad")) and side <= corners.shape[1]:
                    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
                    found.append((ends if side == 0 else ends[:, side - 1 : side]).reshape(-1, 2))
        return np.concatenate(found)


def _resolve(sets: Mapping[str, list[LongArray | str]], name: str, seen: tuple[str, ...] = ()) -> LongArray:
    """Return the numbers in a set, those of sets in it too; names do not care for capitals."""
    found = [np.empty(0, np.int64)]
    for key, members in sets.items():
        if key.upper() == name.upper() and name.upper() not in seen:
            for member in members:
                more = _resolve(sets, member, (*seen, name.upper())) if isinstance(member, str) else member
                found.append(more)
    return np.unique(np.concatenate(found))


def _kind(kind: str, n_nodes: int) -> str:
    """Return meshio's name for an element type of so many nodes."""
    if LINE.match(kind):
        return "line" if n_nodes == 2 else f"line{n_nodes}"
    if VOLUME.match(kind):
        return {4: "tetra", 5: "pyramid", 6: "wedge", 10: "tetra10", 15: "wedge15", 20: "hexahedron20"}.get(
            n_nodes, "hexahedron"
        )
    return "vertex" if n_nodes == 1 else "line" if n_nodes == 2 else OF_NODES.get(n_nodes, kind)
