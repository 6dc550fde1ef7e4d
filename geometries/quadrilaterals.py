"""Meshes of given quadrilateral blocks: walls, arches, columns, slopes of layers.

The corners of a block count anticlockwise; its side k goes from corner k to the next one. A block
may touch the middle of another's side; no node is needed there.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bsm_mesh.geometries import physical_groups
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.session import gmsh_session, name_groups, write_mesh

Point = tuple[float, float]
Quadrilateral = tuple[Point, Point, Point, Point]
Side = tuple[int, int]

LINE, QUADRANGLE = 1, 3  # Gmsh's numbers of element types
ROUNDING = 9  # decimals of a metre: corners that agree in them are one node
MOST_BLOCKS = 500_000


def rectangle(left: float, bottom: float, right: float, top: float) -> Quadrilateral:
    """Return a block with its sides 0 to 3 at the bottom, right, top and left."""
    return (left, bottom), (right, bottom), (right, top), (left, top)


def sides_of(blocks: Sequence[int] | range, sides: Sequence[int] = (0, 1, 2, 3)) -> list[Side]:
    """Return these sides of these blocks, for a group of `write_quadrilaterals`."""
    return [(block, side) for block in blocks for side in sides]


def turn(blocks: Sequence[Quadrilateral], dip: float) -> list[Quadrilateral]:
    """Return the blocks turned about the origin, so that level lines dip to the right.

    Parameters
    ----------
    blocks : sequence of Quadrilateral
        The blocks.
    dip : float
        Angle [degrees].
    """
    c, s = math.cos(math.radians(dip)), math.sin(math.radians(dip))

    def turned(point: Point) -> Point:
        return c * point[0] + s * point[1], c * point[1] - s * point[0]

    return [(turned(p), turned(q), turned(r), turned(t)) for p, q, r, t in blocks]


def write_quadrilaterals(
    path: str | os.PathLike[str],
    blocks: Sequence[Quadrilateral],
    rocks: Sequence[str],
    *,
    joints: Mapping[str, Sequence[Side]],
    boundaries: Mapping[str, Sequence[Side]] | None = None,
    name: str = "quadrilaterals",
) -> Path:
    """Write one quadrangle a block, in the order given, and lines for joints and boundaries.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    blocks : sequence of Quadrilateral
        Corners of the blocks [m], anticlockwise.
    rocks : sequence of str
        Name of each block's rock, or one name for all.
    joints, boundaries : mapping of str to sequence of Side
        Sides (block, side) under the name of their joint set or boundary. A side that two blocks
        share needs to be given once only.
    name : str
        Name of the geometry, for messages.

    Raises
    ------
    GeometryError
        For blocks that are not convex and anticlockwise, and for sides that there are not.

    Examples
    --------
    >>> two = [rectangle(0, 0, 2, 1), rectangle(0, 1, 1, 2)]
    >>> joints = {"bed": [(1, 0)]}
    >>> write_quadrilaterals("two.msh", two, ["rock"], joints=joints)  # doctest: +SKIP
    """
    names = list(rocks) * len(blocks) if len(rocks) == 1 else list(rocks)
    groups = {physical_groups.joint(key): sides for key, sides in joints.items()}
    groups |= {physical_groups.boundary(key): sides for key, sides in (boundaries or {}).items()}
    _check(name, blocks, names, groups)
    with gmsh_session(name) as gmsh:
        nodes, connections = _number_nodes(blocks)
        surfaces = _add_blocks(gmsh, nodes, connections, names)
        curves = {key: [_add_lines(gmsh, connections, sides)] for key, sides in groups.items()}
        gmsh.model.mesh.reclassifyNodes()
        name_groups(surfaces | curves)
        return write_mesh(path)


def _check(
    name: str, blocks: Sequence[Quadrilateral], names: Sequence[str], groups: Mapping[str, Sequence[Side]]
) -> None:
    faults = []
    if not 0 < len(blocks) <= MOST_BLOCKS:
        faults.append(f"{name}: {len(blocks)} blocks; give from 1 to {MOST_BLOCKS}")
    if len(names) != len(blocks):
        faults.append(f"{name}: {len(blocks)} blocks and {len(names)} rocks; name one rock, or one for each block")
    for number, block in enumerate(blocks):
        if any(_turns_right(block[k - 2], block[k - 1], block[k]) for k in range(4)):
            faults.append(f"{name}: block {number} is not convex with its corners anticlockwise: {block}")
    for key, sides in groups.items():
        wrong = [(b, s) for b, s in sides if not (0 <= b < len(blocks) and 0 <= s < 4)]
        if wrong:
            faults.append(f"{name}: group '{key}': there is no side {wrong[0][1]} of a block {wrong[0][0]}")
    if faults:
        raise GeometryError(faults)


def _turns_right(a: Point, b: Point, c: Point) -> bool:
    return not (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0.0


def _number_nodes(blocks: Sequence[Quadrilateral]) -> tuple[list[Point], list[list[int]]]:
    """Return the distinct corners, and the four of each block by number from 1."""
    numbers: dict[Point, int] = {}
    nodes: list[Point] = []
    connections = []
    for block in blocks:
        row = []
        for x, y in block:
            key = (round(x, ROUNDING) + 0.0, round(y, ROUNDING) + 0.0)
            if key not in numbers:
                nodes.append((x, y))
                numbers[key] = len(nodes)
            row.append(numbers[key])
        connections.append(row)
    return nodes, connections


def _add_blocks(
    gmsh: Any, nodes: Sequence[Point], connections: Sequence[Sequence[int]], names: Sequence[str]
) -> dict[str, list[int]]:
    """Add a surface for each run of blocks of one rock, which keeps their order in the file."""
    surfaces: dict[str, list[int]] = {}
    first = 0
    for rock, run in itertools.groupby(names):
        count = len(list(run))
        surface = gmsh.model.addDiscreteEntity(2)
        if first == 0:
            coordinates = [c for x, y in nodes for c in (x, y, 0.0)]
            gmsh.model.mesh.addNodes(2, surface, range(1, len(nodes) + 1), coordinates)
        corners = [node for row in connections[first : first + count] for node in row]
        gmsh.model.mesh.addElementsByType(surface, QUADRANGLE, [], corners)
        surfaces.setdefault(physical_groups.rock(rock), []).append(surface)
        first += count
    return surfaces


def _add_lines(gmsh: Any, connections: Sequence[Sequence[int]], sides: Sequence[Side]) -> int:
    pairs: dict[tuple[int, int], tuple[int, int]] = {}
    for block, side in sides:
        ends = connections[block][side], connections[block][(side + 1) % 4]
        pairs.setdefault((min(ends), max(ends)), ends)
    curve: int = gmsh.model.addDiscreteEntity(1)
    gmsh.model.mesh.addElementsByType(curve, LINE, [], [node for ends in pairs.values() for node in ends])
    return curve
