"""Abaqus input (also of CalculiX, LS-PrePost, HyperMesh, Gmsh), by a reader of our own.

meshio 5.3.5 keeps the last of several *NODE blocks, knows few types of elements and these in capitals only, loses sets
that stand before their elements or hold others, reads no parts, instances and surfaces. Keywords that make, copy or
move the mesh are refused (`inp_keywords`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.meshes.cells import MeshCells, gather_cells
from bsm_mesh.converters.meshes.inp_bodies import Body, NodesOf, Part
from bsm_mesh.converters.meshes.inp_keywords import Block, read_blocks
from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.edges import LongArray

LIBRARY = ()
MOST_GENERATED = 10_000_000  # members of a set in a line
GREATEST = 2**53  # number of a node or element


@dataclass(slots=True)
class _Model:
    """Contents of a file; names of parts and instances in capitals."""

    parts: dict[str, Part] = field(default_factory=dict)
    assembly: Part = field(default_factory=Part)  # or the whole file
    instances: dict[str, tuple[str, FloatArray, Block]] = field(default_factory=dict)  # part, shift and keyword of each
    own: dict[str, Part] = field(default_factory=dict)  # what belongs to one instance alone

    @property
    def every(self) -> list[Part]:
        """All that have sets."""
        return [self.assembly, *self.parts.values(), *self.own.values()]

    def placed(self) -> Iterator[tuple[str, list[Part], FloatArray]]:
        """Yield the name of each instance, its data (the assembly last), and its shift."""
        for name, (part, shift, block) in self.instances.items():
            mesh = [self.parts.get(part, Part()), self.own[name]]
            if not any(layer.nodes for layer in mesh):
                raise block.fault(f"neither it nor its part '{block.options.get('PART', '')}' has nodes")
            yield name, [*mesh, self.assembly], shift
        if not self.instances:
            if self.assembly.nodes:
                yield "", [self.assembly], np.zeros(3)
            for layer in (part for part in self.parts.values() if part.nodes):
                yield "", [layer, self.assembly], np.zeros(3)


def read_inp(path: Path) -> MeshCells:
    """Return the elements, element sets, node sets and surfaces of an Abaqus input file.

    Node sets and surfaces become the sides of elements that they hold: those at the rim if there are any, else those
    between elements. Sets of parts keep their names; of several instances they are put together.

    Raises
    ------
    ModelError
        With the line, where something cannot be read, or a keyword makes, copies or moves nodes or elements.
    """
    model = _model(path)
    bodies: list[Body] = []
    for name, layers, shift in model.placed():
        bodies.append(Body.of(name, layers, shift, sum(len(body.points) for body in bodies), path))
    if not bodies:
        raise ModelError(f"{path}: no *NODE block: cannot read it as Abaqus input; it is damaged, or cut off")
    named = {kind: dict.fromkeys(n for part in model.every for n in part.sets[kind]) for kind in ("node", "element")}
    surfaces = dict.fromkeys(name for part in model.every for name in part.sides)
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


def _model(path: Path) -> _Model:
    """Return the contents of the keywords."""
    model, faults = _Model(), list[str]()
    now, around = model.assembly, dict[str, Block]()
    for block in read_blocks(path):
        options = block.options
        if refused := block.refused():
            faults += refused
        elif block.keyword == "PART":
            now = model.parts.setdefault(options.get("NAME", "").upper(), Part())
        elif block.keyword == "INSTANCE":
            name, part = (options.get(key, "").upper() for key in ("NAME", "PART"))
            model.instances[name] = (part, _shift(block), block)
            now = model.own.setdefault(name, Part())
        elif block.keyword in ("END PART", "END INSTANCE"):
            now = model.assembly
        elif block.keyword in ("NSET", "ELSET") and "INSTANCE" in options:
            around.setdefault(options["INSTANCE"].upper(), block)
            _keep(block, model.own.setdefault(options["INSTANCE"].upper(), Part()))
        else:
            _keep(block, now)
    faults += [
        f"{block.where}: *{block.keyword}: there is no instance '{block.options['INSTANCE']}'"
        f"{nearest(name, model.instances)}"
        for name, block in around.items()
        if name not in model.instances
    ]
    raise_faults(faults)
    return model


def _keep(block: Block, part: Part) -> None:
    """Keep a block's data on a part's nodes, elements, sets or surfaces."""
    options, name = block.options, block.options.get(block.keyword, "")
    if block.keyword == "NODE":
        rows = _nodes(block)
        part.nodes.append(rows)
        if "NSET" in options:
            part.sets["node"].setdefault(options["NSET"], []).append(rows[:, 0].astype(np.int64))
    elif block.keyword == "ELEMENT":
        elements = _elements(block)
        part.elements.append((options.get("TYPE", "").upper(), elements))
        if "ELSET" in options:
            part.sets["element"].setdefault(options["ELSET"], []).append(elements[:, 0])
    elif block.keyword == "ELSET":
        part.sets["element"].setdefault(name, []).extend(_members(block))
    elif block.keyword == "NSET":
        of = [NodesOf(options["ELSET"])] if "ELSET" in options else []
        part.sets["node"].setdefault(name, []).extend([*_members(block), *of])
    elif block.keyword == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
        part.sides.setdefault(options.get("NAME", ""), []).extend(_sides(block))
    elif block.keyword == "SURFACE" and options["TYPE"].upper() == "NODE":
        words = [line.split(",")[0] for line in block.lines]  # then the area of each
        members = _members(Block("NSET", {}, words, block.where))
        part.sets["node"].setdefault(options.get("NAME", ""), []).extend(members)


def _shift(block: Block) -> FloatArray:
    """Return the shift of an instance, (3,)."""
    values, shift = block.numbers(), np.zeros(3)
    if len(values) > 3:
        raise block.fault("is turned; turn the mesh itself (a translation alone is read)")
    shift[: len(values)] = values
    return shift


def _nodes(block: Block) -> FloatArray:
    """Return number and coordinates of the nodes, (n, 4)."""
    widths = {line.rstrip(", \t").count(",") + 1 for line in block.lines}
    values = block.numbers()
    width = max(widths, default=3)
    if len(widths) > 1 or width not in (3, 4) or len(values) != width * len(block.lines):
        raise block.fault("each line needs a number and two or three coordinates")
    rows = np.zeros((len(block.lines), 4))
    rows[:, :width] = values.reshape(-1, width)
    return rows


def _elements(block: Block) -> LongArray:
    """Return number and nodes of the elements, (m, 1 + k); a line that ends in a comma continues in the next one."""
    size = 0
    for line in block.lines:
        size += len([c for c in line.split(",") if c.strip()])
        if not line.endswith(","):
            break
    values = block.numbers()
    if size < 2 or len(values) % size:
        raise block.fault(f"{len(values)} numbers are no rows of {size}; the list is cut off or of several types")
    return values.astype(np.int64).reshape(-1, size)


def _members(block: Block) -> list[LongArray | str]:
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
                raise block.fault(f"'{line}' generates more numbers than any mesh has ({MOST_GENERATED:g}); correct it")
            ranges.append(np.arange(numbers.start, numbers.stop, numbers.step))
        return ranges
    words = block.words()
    whole = [word for word in words if word.lstrip("-").isdigit()]
    return [np.array(whole, dtype=np.int64), *(word for word in words if not word.lstrip("-").isdigit())]


def _sides(block: Block) -> list[tuple[str, int]]:
    """Return (element or set, side) of a surface; without a side: 0, all at the rim."""
    rows = [[word.strip() for word in line.split(",")] for line in block.lines]
    sides = {f"S{k}": k for k in range(1, 9)} | {f"E{k}": k for k in range(1, 9)}
    return [(row[0], sides.get(row[1].upper() if len(row) > 1 else "", 0)) for row in rows if row[0]]
