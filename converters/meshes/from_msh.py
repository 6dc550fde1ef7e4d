"""Gmsh's MSH 4.1, text and binary, with every physical group of every entity.

meshio 5.3.5 reads this format too, but drops the curves that a physical group holds in reversed
direction, refuses files in which some entity is in no group (``Mesh.SaveAll``), and refuses
parametric nodes; so this one format is read here. Element numbers are Gmsh's element tags.

References
----------
Gmsh reference manual, section "MSH file format".
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.meshes.cells import PHYSICAL, MeshCells, gather_cells
from bsm_mesh.converters.meshes.msh_sections import BinaryNumbers, Kind, Numbers, TextNumbers, TruncatedError
from bsm_mesh.errors import ModelError
from bsm_mesh.model.edges import LongArray

LINE_NODES = {1: 2, 8: 3, 26: 4, 27: 5, 28: 6, 62: 7, 63: 8, 64: 9, 65: 10, 66: 11}
TRIANGLE_NODES = {2: 3, 9: 6, 20: 9, 21: 10, 22: 12, 23: 15, 24: 15, 25: 21, 42: 28, 43: 36, 44: 45, 45: 55, 46: 66}
QUAD_NODES = {3: 4, 10: 9, 16: 8, 36: 16, 37: 25, 38: 36, 39: 12, 40: 16, 41: 20, 47: 49, 48: 64, 49: 81, 50: 100}
ELEMENTS = {  # Gmsh's element type: what it is, and its number of nodes
    15: ("vertex", 1),
    **{gmsh: ("line" if n == 2 else f"line{n}", n) for gmsh, n in LINE_NODES.items()},
    **{gmsh: ("triangle" if n == 3 else f"triangle{n}", n) for gmsh, n in TRIANGLE_NODES.items()},
    **{gmsh: ("quad" if n == 4 else f"quad{n}", n) for gmsh, n in QUAD_NODES.items()},
}
HEADER = re.compile(rb"\s*\$MeshFormat\s+(\S+)\s+([01])\s+([48])[ \t]*\r?\n")
NODES_40 = re.compile(rb"\$Nodes[ \t]*\r?\n[ \t]*\d+[ \t]+\d+[ \t]*\r?\n")  # two numbers, of 4.1 four
SOLIDS = {  # volume elements, of first and of higher order; the corners are the first nodes
    **dict.fromkeys((4, 11, 29, 30, 31), "tetra"),
    **dict.fromkeys((5, 12, 17, 92, 93), "hexahedron"),
    **dict.fromkeys((6, 13, 18, 90, 91), "wedge"),
    **dict.fromkeys((7, 14, 19), "pyramid"),
}
SOLID_NODES = {4: 4, 11: 10, 29: 20, 30: 35, 31: 56, 5: 8, 12: 27, 17: 20, 92: 64, 93: 125}
SOLID_NODES |= {6: 6, 13: 18, 18: 15, 90: 40, 91: 75, 7: 5, 14: 14, 19: 13}
Entity = tuple[int, int]  # dimension, tag


@dataclass(slots=True)
class MshContent:
    """Contents of the sections of a file of MSH 4.1.

    Attributes
    ----------
    solid : bool
        Whether volume elements are read; if not they are refused.
    names : dict
        Names of groups by dimension and number.
    physicals : dict
        Numbers of the groups of every entity of the geometry.
    tags, points : array
        Numbers of the nodes, and their coordinates (n, 3).
    elements : list
        Entity, kind of element, and rows of the element's number and its nodes' numbers.
    """

    solid: bool = False
    names: dict[Entity, str] = field(default_factory=dict)  # of (dimension, physical tag)
    physicals: dict[Entity, list[int]] = field(default_factory=dict)
    tags: LongArray = field(default_factory=lambda: np.empty(0, np.int64))
    points: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    elements: list[tuple[Entity, str, LongArray]] = field(default_factory=list)  # rows: tag, nodes


def is_msh41(path: Path) -> bool:
    """Return whether a file begins as MSH 4.1 does."""
    with path.open("rb") as file:
        header = HEADER.match(file.read(200))
    return header is not None and header[1] in (b"4.1", b"4")


def is_msh40(path: Path) -> bool:
    """Return whether a file is MSH 4.0, as Gmsh wrote it in 2018; a few programs write "4" and mean 4.1."""
    data = path.read_bytes()
    header = HEADER.match(data)
    return header is not None and header[1] in (b"4", b"4.0") and NODES_40.search(data) is not None


def read_msh41(path: Path) -> MeshCells:
    """Return the elements and physical groups of an MSH 4.1 file.

    Groups without a name are found as the array ``gmsh:physical`` (``"gmsh:physical=3"``), surfaces and curves of the
    geometry as ``gmsh:geometrical``.

    Raises
    ------
    ModelError
        If the file is cut off or damaged, or holds volume elements.
    """
    return _as_cells(str(path), msh_content(path))


def msh_content(path: Path, *, solid: bool = False) -> MshContent:
    """Return the content of an MSH 4.1 file; volume elements are refused unless a `solid` mesh is asked for.

    Raises
    ------
    ModelError
        If the file is cut off or damaged, holds no elements, or volume elements that were not asked for.
    """
    content = MshContent(solid=solid)
    section, data = "MeshFormat", path.read_bytes()
    try:
        for section, numbers in _sections(data, content):
            if section == "Entities":
                _read_entities(numbers, content)
            elif section == "Nodes":
                _read_nodes(numbers, content)
            elif section == "Elements":
                _read_elements(numbers, content, str(path))
    except (TruncatedError, ValueError, OverflowError, MemoryError) as problem:
        if isinstance(problem, ModelError):
            raise
        if data[:64].split()[1:2] == [b"4"]:  # Gmsh 4.0 and 4.1 of 2018; a few programs write "4" and mean 4.1
            raise ModelError(f"{path}: is of MSH version 4.0; open it in Gmsh and save it as version 4.1") from None
        raise ModelError(
            f"{path}: section ${section} is cut off or damaged: the file was not written to its end; write it again"
        ) from None
    if not content.elements:
        order = 3 if solid else 2
        raise ModelError(
            f"{path}: holds no elements; generate the mesh (in Gmsh: generate({order})) before it is written"
        )
    return content


def _sections(data: bytes, content: MshContent) -> Iterator[tuple[str, Numbers]]:
    """Yield the sections with numbers; names of groups go straight into `content`."""
    header = HEADER.match(data)
    if header is None:
        raise TruncatedError
    binary, size_bytes, position = header[2] == b"1", int(header[3]), header.end()
    byte_order = "<" if data[position : position + 4] == b"\x01\x00\x00\x00" else ">"
    position = _end_of(data, "MeshFormat", position)
    opening = re.compile(rb"\s*\$(\w+)[ \t]*\r?\n")
    while found := opening.match(data, position):
        name, position = found[1].decode("ascii"), found.end()
        if name in ("Entities", "Nodes", "Elements") and binary:
            numbers = BinaryNumbers(data, position, byte_order, size_bytes)
            yield name, numbers
            position = numbers.position
        end = _end_of(data, name, position)
        if name == "PhysicalNames":
            content.names |= names_in(data[position:end].decode("utf-8", "replace"))
        elif name in ("Entities", "Nodes", "Elements") and not binary:
            yield name, TextNumbers.of(data[position : data.rindex(b"$End", position, end)])
        elif name == "PartitionedEntities":
            raise ModelError("a partitioned mesh; save it without partitions (in Gmsh: unpartition the mesh)")
        position = end


def _end_of(data: bytes, name: str, position: int) -> int:
    """Return where the line ``$End<name>`` ends."""
    closing = re.compile(rb"\$End" + name.encode() + rb"[ \t]*(\r?\n|\Z)").search(data, position)
    if closing is None:
        raise TruncatedError
    return closing.end()


def names_in(text: str) -> dict[Entity, str]:
    """Return the names in a section ``$PhysicalNames`` by dimension and number; several numbers may have one name."""
    names = {}
    for line in text.splitlines()[1:]:
        parts = shlex.split(line) if line.lstrip()[:1].isdigit() else []
        if len(parts) >= 3:
            names[int(parts[0]), int(parts[1])] = " ".join(parts[2:])
    return names


def _read_entities(numbers: Numbers, content: MshContent) -> None:
    for dimension, count in enumerate(numbers.take(Kind.SIZE, 4)):
        for _ in range(int(count)):  # one entity a pass, of the geometry, not of the mesh
            tag = int(numbers.take(Kind.INT, 1)[0])
            numbers.take(Kind.DOUBLE, 3 if dimension == 0 else 6)
            physicals = numbers.take(Kind.INT, int(numbers.take(Kind.SIZE, 1)[0]))
            content.physicals[dimension, tag] = [abs(int(p)) for p in physicals]  # negative: reversed
            if dimension:
                numbers.take(Kind.INT, int(numbers.take(Kind.SIZE, 1)[0]))


def _read_nodes(numbers: Numbers, content: MshContent) -> None:
    tags, points = [content.tags], [content.points]
    for _ in range(int(numbers.take(Kind.SIZE, 4)[0])):
        dimension, _, parametric = numbers.take(Kind.INT, 3)
        count = int(numbers.take(Kind.SIZE, 1)[0])
        width = 3 + (int(dimension) if parametric else 0)
        tags.append(numbers.take(Kind.SIZE, count))
        points.append(numbers.take(Kind.DOUBLE, count * width).reshape(count, width)[:, :3])
    content.tags, content.points = np.concatenate(tags), np.concatenate(points)


def _read_elements(numbers: Numbers, content: MshContent, source: str) -> None:
    for _ in range(int(numbers.take(Kind.SIZE, 4)[0])):
        dimension, tag, element = (int(value) for value in numbers.take(Kind.INT, 3))
        count = int(numbers.take(Kind.SIZE, 1)[0])
        if dimension == 3 and not content.solid:
            raise ModelError(
                f"{source}: a three-dimensional mesh, but blocks are plane; mesh one cross-section and save "
                "only its surfaces and curves (in Gmsh: generate(2))"
            )
        if dimension == 3 and element not in SOLIDS:
            raise ModelError(
                f"{source}: Gmsh element type {element} is not known; use tetrahedra, hexahedra, prisms or pyramids"
            )
        if dimension < 3 and element not in ELEMENTS:
            raise ModelError(f"{source}: Gmsh element type {element} is not known; use triangles or quadrilaterals")
        kind, n_nodes = ELEMENTS[element] if dimension < 3 else (SOLIDS[element], SOLID_NODES[element])
        rows = numbers.take(Kind.SIZE, count * (1 + n_nodes)).reshape(count, 1 + n_nodes)
        content.elements.append(((dimension, tag), kind, rows))


def _as_cells(source: str, content: MshContent) -> MeshCells:
    groups: dict[str, list[Entity]] = {name: [] for name in content.names.values()}
    for (dimension, tag), physicals in content.physicals.items():
        for physical in physicals:
            if (name := content.names.get((dimension, physical))) is not None:
                groups[name].append((dimension, tag))
    blocks_of: dict[Entity, list[int]] = {}
    for k, (entity, _, _) in enumerate(content.elements):
        blocks_of.setdefault(entity, []).append(k)
    sets: dict[str, list[Any]] = {name: [None] * len(content.elements) for name in groups}
    for name, entities in groups.items():
        for k in (k for entity in entities for k in blocks_of.get(entity, ())):
            sets[name][k] = np.arange(len(content.elements[k][2]))
    lines = [k for k, (entity, _, _) in enumerate(content.elements) if entity[0] == 1]
    for k in lines:
        entity = content.elements[k][0]
        for physical in content.physicals.get(entity, ()):
            if (1, physical) not in content.names:
                members = sets.setdefault(f"{PHYSICAL}={physical}", [None] * len(content.elements))
                members[k] = np.arange(len(content.elements[k][2]))
    unnamed = [
        next((p for p in content.physicals.get(entity, ()) if (entity[0], p) not in content.names), 0)
        for entity, _, _ in content.elements
    ]
    number = node_numbers(content)
    rows = [row for _, _, row in content.elements]
    arrays = {
        PHYSICAL: [np.full(len(row), p) for row, p in zip(rows, unnamed, strict=True)],
        "gmsh:geometrical": [np.full(len(row), entity[1]) for entity, _, row in content.elements],
    }
    return gather_cells(
        source,
        content.points,
        [(kind, number(row[:, 1:])) for _, kind, row in content.elements],
        sets=sets,
        arrays=arrays if any(unnamed) else {"gmsh:geometrical": arrays["gmsh:geometrical"]},
        numbers=[row[:, 0] for row in rows],
    )


def node_numbers(content: MshContent) -> Any:
    """Return the function from node tags to rows of `points`; -1 for tags that do not exist."""
    tags = content.tags
    if tags.size and tags.min() >= 0 and tags.max() <= 4 * tags.size + 1000:
        row = np.full(int(tags.max()) + 2, -1, dtype=np.int64)
        row[tags] = np.arange(len(tags))
        return lambda wanted: row[np.clip(wanted, 0, len(row) - 1)]
    if not tags.size:
        return lambda wanted: np.full(wanted.shape, -1, dtype=np.int64)
    order = np.argsort(tags)

    def find(wanted: npt.NDArray[np.int64]) -> LongArray:
        at = np.clip(np.searchsorted(tags, wanted, sorter=order), 0, len(tags) - 1)
        found: LongArray = np.where(tags[order[at]] == wanted, order[at], -1)
        return found

    return find
