"""Histories: the record at every step, of points, extensometers, blocks, joints and bolts."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from bsm_mesh import space
from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import as_given, nearest, raise_faults
from bsm_mesh.given import Given, by_default
from bsm_mesh.model.beside import Beside, faults_beside, values_beside
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.locate import blocks_at
from bsm_mesh.model.quantities import BLOCK
from bsm_mesh.model.values import Rules, parts_of, plain_numbers

FILE_NAME = re.compile(r"\w[\w.+-]{0,99}")  # the name is a part of a file's name
KINDS = ("point", "line", "block", "joint", "bolt")


@dataclass(frozen=True, kw_only=True)
class History:
    """The record at every step under a name; exactly one of the other fields says of what.

    Attributes
    ----------
    name : str
        Letters, digits and ``_ . + -``: the file is ``history_NAME.csv``.
    point : (x, y) or (x, y, z) [m], optional
        Displacement of a point, where the blocks were given; on an outline that of the block with the lowest number.
    line : sequence of (x, y) or (x, y, z) [m], optional
        An extensometer: by how much the distance of each further point from the first one has grown.
    block : int, optional
        Displacement of a block's centroid, and its rotation.
    joint : str, optional
        Of a joint or joint set: mean slip and opening, share of the length at strength, share that is open.
    bolt : str, optional
        Greatest axial force in a bolt, by its name.
    measured : sequence of Beside
        The values compared with it in pictures and the report, measured or of another program; it changes nothing else.

    Raises
    ------
    ModelError
        If the name can be in no file's name, or not exactly one thing is named.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.History("crown", point=(0, 4.1)).name
    'crown'
    """

    name: str = field(kw_only=False)
    point: tuple[float, ...] | None = None
    line: Given[tuple[tuple[float, ...], ...] | None, Sequence[Sequence[float]] | None] = by_default(None)
    block: int | None = None
    joint: str | None = None
    bolt: str | None = None
    measured: Sequence[Beside] = field(default=(), metadata={"in_hash": False})

    def __post_init__(self) -> None:
        rules = Rules("history", self.name)
        rules.name(self.name)
        if not rules.faults and not FILE_NAME.fullmatch(self.name):
            rules.faults.append(
                f"history {as_given(self.name)}: the name is a part of a file's name; use letters, digits and _ . + -"
            )
        given = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            told = "has " + " and ".join(given) if given else "has none"
            rules.faults.append(f"{rules.thing}: needs exactly one of {', '.join(KINDS)}; it {told}")
        if self.point is not None:
            object.__setattr__(self, "point", rules.place("point", self.point))
        if self.line is not None:
            object.__setattr__(self, "line", _line(rules, self.line))
        rules.number("block", self.block, BLOCK, optional=True)
        rules.text("joint", self.joint, optional=True)
        rules.text("bolt", self.bolt, optional=True)
        object.__setattr__(self, "measured", values_beside(rules, self.measured))
        if not rules.faults:
            rules.faults += faults_beside(self.name, self.kind, self.measured, self.length)
        raise_faults(rules.faults)
        plain_numbers(self)

    @property
    def kind(self) -> str:
        """Which of the fields is given."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @property
    def points(self) -> tuple[tuple[float, ...], ...]:
        """The points of a point or a line; none of the others."""
        return (self.point,) if self.point is not None else self.line or ()

    @property
    def length(self) -> float:
        """From the first point of a line to the most distant one [m]; 0 of the others."""
        first, *others = self.points or ((0.0, 0.0),)
        return max((math.dist(first, other) for other in others), default=0.0)

    def blocks(self, blocks: Blocks) -> IntArray:
        """Return the block of each of its `points`, (k,) int32; -1 where there is none."""
        found = [_blocks_at(blocks, point) for point in self.points]
        return np.array([at[0] if len(at) else -1 for at in found], dtype=np.int32)


def _blocks_at(blocks: Blocks, point: tuple[float, ...]) -> IntArray:
    """Return the blocks at a point of the plane or of space, in rising order."""
    if in_space(blocks):
        return space.polyhedra_at(blocks, np.array(point))
    x, y = point
    return blocks_at(blocks, (x, y))


def _line(rules: Rules, value: object) -> tuple[tuple[float, ...], ...]:
    """Return the points of a line; faults are added where it is none."""
    parts = parts_of(value)
    if parts is None or len(parts) < 2:
        rules.faults.append(f"{rules.thing}: line = {as_given(value)} must be two points or more [[x, y], ...] [m]")
        return ()
    line = tuple(rules.place(f"line: point {number + 1}", part) for number, part in enumerate(parts))
    if not rules.faults and line[0] in line[1:]:
        rules.faults.append(f"{rules.thing}: line: a further point lies on the first one; a distance needs two points")
    return line


def _shown(point: Sequence[float]) -> str:
    """Return a point in words.

    Examples
    --------
    >>> _shown((1.0, 2.5))
    '(1, 2.5)'
    """
    return f"({', '.join(f'{part:g}' for part in point)})"


def history_faults(
    histories: Sequence[History], blocks: Blocks, joint_names: Sequence[str], bolt_names: Sequence[str]
) -> Iterable[str]:
    """Return a sentence for everything in the histories that a model cannot record."""
    seen: dict[str, str] = {}
    for history in histories:
        key = history.name.casefold()  # where files of A and a are one
        if key in seen:
            yield f"history '{history.name}' is defined more than once ('{seen[key]}'); rename all but one"
        seen.setdefault(key, history.name)
    low, high = blocks.vertices.min(axis=0).tolist(), blocks.vertices.max(axis=0).tolist()
    for history in histories:
        if any(len(point) != len(low) for point in history.points):
            yield f"history '{history.name}': a point of this model has {len(low)} coordinates"
            continue
        for point, block in zip(history.points, history.blocks(blocks).tolist(), strict=True):
            if block < 0:
                yield (
                    f"history '{history.name}': the point {_shown(point)} lies in no block; the blocks reach from "
                    f"{_shown(low)} to {_shown(high)}: move it into one of them"
                )
        if history.block is not None and history.block >= blocks.count:
            yield (
                f"history '{history.name}': there is no block {history.block}; blocks are numbered 0 to "
                f"{blocks.count - 1}"
            )
        for kind, name, names in (("joint", history.joint, joint_names), ("bolt", history.bolt, bolt_names)):
            if name is not None and name not in names:
                yield f"history '{history.name}': there is no {kind} '{name}'{nearest(name, names)}"
