"""Meshes of the unstable models, to be changed: nodes, and elements in groups with a name or without."""

from __future__ import annotations

import dataclasses
import math
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from tests.scenes.square_mesh import Group, msh_of

Point = tuple[float, float]


@dataclass(frozen=True)
class Section:
    """A mesh.

    Attributes
    ----------
    nodes : tuple of (x, y)
        In the unit of the mesh.
    groups : tuple of (dimension, name or None, elements)
        An element is the numbers of its nodes, counted from 0.
    """

    nodes: tuple[Point, ...]
    groups: tuple[Group, ...]

    def written(self, version: str) -> bytes:
        """Return the mesh as MSH 4.1 or 2.2."""
        return msh_of(self.nodes, self.groups, version).encode()

    def at(self, place: Callable[[Point], Point]) -> Section:
        """Return the mesh with its nodes elsewhere."""
        return dataclasses.replace(self, nodes=tuple(place(node) for node in self.nodes))

    def with_groups(self, number: int, *others: Group) -> Section:
        """Return the mesh with other groups in place of one."""
        groups = [*self.groups[:number], *others, *self.groups[number + 1 :]]
        return dataclasses.replace(self, groups=tuple(groups))

    @cached_property
    def shortest(self) -> dict[int, float]:
        """The shortest side of an element at each node."""
        found: dict[int, float] = {}
        for a, b in self._sides:
            length = math.dist(self.nodes[a], self.nodes[b])
            for node in (a, b):
                found[node] = min(found.get(node, length), length)
        return found

    @cached_property
    def inner(self) -> set[int]:
        """Nodes on no side that belongs to one element alone."""
        rim = {node for side, count in self._sides.items() if count == 1 for node in side}
        return set(self.shortest) - rim

    @cached_property
    def directions(self) -> dict[int, Point]:
        """Direction of a joint's element at each of the joint's nodes."""
        found: dict[int, Point] = {}
        for dimension, name, elements in self.groups:
            for a, b in elements if dimension == 1 and str(name).startswith("joint:") else ():
                (x, y), (u, v) = self.nodes[a], self.nodes[b]
                length = math.hypot(u - x, v - y)
                found.setdefault(a, ((u - x) / length, (v - y) / length))
                found.setdefault(b, ((u - x) / length, (v - y) / length))
        return found

    @cached_property
    def _sides(self) -> Counter[tuple[int, int]]:
        return Counter(
            (min(a, b), max(a, b))
            for dimension, _, elements in self.groups
            if dimension == 2
            for element in elements
            for a, b in zip(element, [*element[1:], element[0]], strict=True)
        )


def section_of(mesh: dict[str, Any], files: dict[str, bytes]) -> Section:
    """Return the mesh of a model file's table: of a mesh file, or of a geometry, which is built."""
    from bsm_mesh.modelfile.build_mesh import build_geometry

    with tempfile.TemporaryDirectory() as folder:
        for name, data in files.items():
            (Path(folder) / name).write_bytes(data)
        path = Path(folder) / mesh.get("file", "built.msh")
        if "geometry" in mesh:
            script = str(Path(folder) / mesh["geometry"])
            build_geometry(script if script.endswith(".py") else mesh["geometry"], path, mesh.get("parameters", {}))
        return _read(path)


def _read(path: Path) -> Section:
    from bsm_mesh.converters.meshes.from_msh import read_msh41

    cells = read_msh41(path)
    groups: list[Group] = []
    for group in cells.groups:
        if len(group.pieces):
            groups.append((1, group.name, _rows(cells.pieces[group.pieces])))
        if len(group.elements):
            corners = [cells.corners[cells.offsets[e] : cells.offsets[e + 1]] for e in group.elements]
            groups.append((2, group.name, _rows(corners)))
    nodes = tuple((float(x), float(y)) for x, y in cells.points[:, :2])
    return Section(nodes, tuple(groups))


def _rows(rows: Any) -> Sequence[Sequence[int]]:
    return [tuple(int(node) for node in row) for row in rows]
