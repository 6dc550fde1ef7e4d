"""Parts and instances of Abaqus input: nodes, elements, sets that hold others, surfaces by sides of elements."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError, counted
from bsm_mesh.model.edges import LongArray

LINE = re.compile(r"(T[23]D|B[23]|SAX|R2D2|RAX2|FRAME|GK2D|ACIN2D|MAX|SFMAX)")
VOLUME = re.compile(r"(F?C3D|SC|CSS|COH3D|AC3D|DC3D|EC3D|CIN3D)")
OF_NODES = {3: "triangle", 6: "triangle6", 4: "quad", 8: "quad8"}


class NodesOf(str):
    """Name of an element set whose nodes are in a node set."""


Members = dict[str, list[LongArray | str]]  # numbers, and names of other sets


@dataclass(slots=True)
class Part:
    """Nodes, elements and sets of a part, or of the whole file, which may have no parts; numbers are the file's."""

    nodes: list[FloatArray] = field(default_factory=list)  # (n, 4): number, x, y, z
    elements: list[tuple[str, LongArray]] = field(default_factory=list)  # type; (m, 1 + k): number, nodes
    sets: dict[str, Members] = field(default_factory=lambda: {"node": {}, "element": {}})
    sides: dict[str, list[tuple[str, int]]] = field(default_factory=dict)  # surface: element or set, side from 1


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Body:
    """An instance of a part, its nodes numbered from `first`; its own sets and the assembly's hold its numbers too."""

    name: str
    parts: list[Part]
    points: FloatArray
    known: LongArray  # the file's numbers of its nodes, sorted
    node: LongArray  # the node of each of them
    cells: list[tuple[str, LongArray]]
    rows: list[LongArray]  # the file's numbers of the elements and of their nodes, a block each

    @classmethod
    def of(cls, name: str, layers: list[Part], shift: FloatArray, first: int, path: Path) -> Body:
        """Return the body of parts, the assembly last; its first node has the number `first`."""
        own = layers[:-1] or layers  # the assembly has sets alone
        nodes = np.concatenate([rows for part in own for rows in part.nodes])
        elements = [block for part in own for block in part.elements]
        order = np.argsort(nodes[:, 0], kind="stable")
        known, cells = nodes[order, 0].astype(np.int64), []
        twice = (known[1:] == known[:-1]) & (nodes[order[1:], 1:] != nodes[order[:-1], 1:]).any(axis=1)
        if twice.any():
            raise ModelError(
                f"{path}: node {known[1:][twice][0]} is given twice, at different places "
                f"({counted(int(twice.sum()), 'node')} in all); leave one out"
            )
        for kind, rows in elements:
            at = np.searchsorted(known, rows[:, 1:]).clip(max=len(known) - 1)
            lost = rows[:, 1:][known[at] != rows[:, 1:]]
            if lost.size:
                raise ModelError(
                    f"{path}: {counted(lost.size, 'node')} of elements of the type {kind} are not there, such as "
                    f"{lost[0]}; the file is cut off or was edited"
                )
            cells.append((_kind(kind, rows.shape[1] - 1), order[at] + first))
        return cls(
            name=name,
            parts=layers,
            points=nodes[:, 1:] + shift,
            known=known,
            node=order + first,
            cells=cells,
            rows=[rows for _, rows in elements],
        )

    def numbers_in(self, kind: str, name: str, seen: tuple[str, ...] = ()) -> LongArray:
        """Return the numbers in a set of a kind, those of sets in it too; names do not care for capitals.

        ``W-1.base`` is the set of the instance W-1, and nothing to others.
        """
        instance, _, rest = name.partition(".")
        word = rest if self.name and instance.upper() == self.name else name
        found = [np.empty(0, np.int64)]
        same = [sets for part in self.parts for key, sets in part.sets[kind].items() if key.upper() == word.upper()]
        for member in (m for members in same for m in members if word.upper() not in seen):
            if isinstance(member, NodesOf):
                inside = self.numbers_in("element", member)
                found += [rows[np.isin(rows[:, 0], inside), 1:].ravel() for rows in self.rows]
            elif isinstance(member, str):
                found.append(self.numbers_in(kind, member, (*seen, word.upper())))
            else:
                found.append(member)
        if not same and word.isdigit():
            found.append(np.array([int(word)]))
        return np.unique(np.concatenate(found))

    def elements_in(self, name: str) -> list[LongArray]:
        """Return the elements in a set, counted from 0 in each block."""
        inside = self.numbers_in("element", name)
        return [np.flatnonzero(np.isin(rows[:, 0], inside)) for rows in self.rows]

    def nodes_in(self, name: str) -> LongArray:
        """Return the nodes in a set."""
        return self.node[np.isin(self.known, self.numbers_in("node", name))]

    def sides_of(self, name: str) -> LongArray:
        """Return the ends of the sides of elements that a surface holds, (k, 2)."""
        found = [np.empty((0, 2), np.int64)]
        for what, side in (row for part in self.parts for row in part.sides.get(name, [])):
            inside = self.numbers_in("element", what)
            for (kind, nodes), rows in zip(self.cells, self.rows, strict=True):
                corners = nodes[np.isin(rows[:, 0], inside)][:, : 3 if kind.startswith("triangle") else 4]
                if kind.startswith(("triangle", "quad")) and side <= corners.shape[1]:
                    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
                    found.append((ends if side == 0 else ends[:, side - 1 : side]).reshape(-1, 2))
        return np.concatenate(found)


def _kind(kind: str, n_nodes: int) -> str:
    """Return meshio's name for an element type of so many nodes."""
    if LINE.match(kind):
        return "line" if n_nodes == 2 else f"line{n_nodes}"
    if VOLUME.match(kind):
        return {4: "tetra", 5: "pyramid", 6: "wedge", 10: "tetra10", 15: "wedge15", 20: "hexahedron20"}.get(
            n_nodes, "hexahedron"
        )
    return "vertex" if n_nodes == 1 else "line" if n_nodes == 2 else OF_NODES.get(n_nodes, kind)
