"""Supports as they are given, and the single bars (Wang Fig. 3.13) that they represent."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Annotated, TypeAlias

import numpy as np

from bsm_mesh import space
from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError, gathered, listing, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.locate import blocks_at
from bsm_mesh.model.quantities import BLOCK, DIRECTION, DISPLACEMENT
from bsm_mesh.model.values import Rules, plain_numbers
from bsm_mesh.movements import cross

Point: TypeAlias = tuple[float, float]

RIGID = 1e-6  # least eigenvalue of unit bars on a block, rotations times its radius of gyration, that hold it


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Where a support holds: exactly one of blocks, a boundary's edges, or a point.

    Attributes
    ----------
    blocks : tuple of int or None
        Block numbers.
    boundary : str or None
        Name of a boundary; both ends of each of its edges are held.
    point : (x, y) or None [m]
        A point in a block, or a corner: then every block with that corner is held there.
    """

    blocks: Sequence[int] | None = None
    boundary: str | None = None
    point: Point | None = None

    def __post_init__(self) -> None:
        given = [n for n in ("blocks", "boundary", "point") if getattr(self, n) is not None]
        rules = Rules(f"support {type(self).__name__}")
        rules.text("boundary", self.boundary, optional=True)
        if self.blocks is not None:
            object.__setattr__(self, "blocks", _block_numbers(self.blocks, rules))
        if self.point is not None:
            object.__setattr__(self, "point", rules.point("point", self.point))
        if len(given) != 1:
            rules.faults.append(
                f"{rules.thing}: give exactly one of blocks, boundary, point; given: {', '.join(given) or 'none'}"
            )
        rules.numbers(self)
        raise_faults(rules.faults)
        plain_numbers(self)


def _block_numbers(value: object, rules: Rules) -> tuple[int, ...]:
    """Return block numbers; note the fault with them."""
    try:
        numbers = np.atleast_1d(np.asarray(value))
    except ValueError:  # lists of unequal lengths
        numbers = np.zeros((1, 0))
    if numbers.shape == (0,):
        rules.faults.append(f"{rules.thing}: blocks is empty: it holds nothing; give block numbers, or no support")
        return ()
    if numbers.ndim != 1 or not np.issubdtype(numbers.dtype, np.integer):  # a mask would hold the blocks 0 and 1
        rules.faults.append(f"{rules.thing}: blocks must be block numbers; of a mask give np.flatnonzero(mask)")
        return ()
    beyond = numbers[numbers > BLOCK.most]
    if beyond.size:
        rules.number("blocks", int(beyond[0]), BLOCK)
    return tuple(numbers.tolist())


@dataclass(frozen=True, slots=True, kw_only=True)
class Fixed(Target):
    """No displacement at all: blocks neither move nor rotate; both components at edge ends and points.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Fixed(boundary="bottom").boundary, bsm.Fixed(blocks=[0, 7]).blocks
    ('bottom', (0, 7))
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class Roller(Target):
    """No displacement in one direction, in both senses (Wang Fig. 3.13).

    Attributes
    ----------
    direction : float [degrees]
        Direction that is held, from the x axis, counter-clockwise.

    Examples
    --------
    Held along x, free along y:

    >>> import bsm_mesh as bsm
    >>> bsm.Roller(boundary="left", direction=0).direction
    0
    """

    direction: Annotated[float, DIRECTION]


@dataclass(frozen=True, slots=True, kw_only=True)
class NormalRoller(Target):
    """No displacement normal to each edge of a boundary.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.NormalRoller(boundary="left").boundary
    'left'
    """

    def __post_init__(self) -> None:
        Target.__post_init__(self)
        if self.boundary is None:
            raise ModelError("support NormalRoller: needs a boundary; blocks and points have no normal")


@dataclass(frozen=True, slots=True, kw_only=True)
class PrescribedDisplacement(Target):
    """A given displacement in one direction (Wang Eqs. 3.28-3.35, without the stiff bar).

    Attributes
    ----------
    direction : float [degrees]
        Direction, from the x axis, counter-clockwise.
    displacement : float [m]
        Displacement in that direction.

    Examples
    --------
    A wall pushed by 2 mm to the right:

    >>> import bsm_mesh as bsm
    >>> bsm.PrescribedDisplacement(boundary="left", direction=0, displacement=2e-3).displacement
    0.002
    """

    direction: Annotated[float, DIRECTION]
    displacement: Annotated[float, DISPLACEMENT]


GivenSupport: TypeAlias = Fixed | Roller | NormalRoller | PrescribedDisplacement


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Bars:
    """Single constraints, one row a bar: ``direction . u(point) = value``, or ``theta = value``.

    Attributes
    ----------
    block : (k,) int32
        Block that the bar holds.
    point : (k, 2) float64 [m]
        Where it holds the block.
    direction : (k, 2) float64
        Unit vector of the held displacement; zero for a bar that holds the rotation.
    holds_rotation : (k,) bool
        Whether the bar holds the block's rotation instead of a displacement.
    value : (k,) float64 [m or rad]
        Prescribed displacement or rotation.
    support : (k,) int32
        Number of the support in the model's list.
    edge : (k,) int32
        The boundary's edge at whose end it holds; -1 where it holds a block or a point.
    """

    block: IntArray
    point: FloatArray
    direction: FloatArray
    holds_rotation: BoolArray
    value: FloatArray
    support: IntArray
    edge: IntArray

    def held_blocks(self, blocks: Blocks) -> BoolArray:
        """Return which blocks the bars hold in every direction and against rotation, (n,)."""
        arm = self.point - blocks.moments.centroid[self.block]
        along = self.rows(arm / blocks.moments.gyration[self.block, None])
        stiffness = np.zeros((blocks.count, blocks.axes, blocks.axes))
        np.add.at(stiffness, self.block, along[:, :, None] * along[:, None, :])
        return np.asarray(np.linalg.matrix_rank(stiffness, tol=RIGID, hermitian=True) == blocks.axes)

    def rows(self, arm: FloatArray) -> FloatArray:
        """Return what of a movement each bar holds, (k, axes), from its arm (k, 2 or 3) from the centroid.

        In space a bar that holds a rotation has the axis of that as its direction.
        """
        if arm.shape[1] == 2:
            moment = arm[:, 0] * self.direction[:, 1] - arm[:, 1] * self.direction[:, 0] + self.holds_rotation
            return np.column_stack([self.direction, moment])
        turns = self.holds_rotation[:, None]
        moment = np.where(turns, self.direction, cross(arm, self.direction))
        return np.hstack([np.where(turns, 0.0, self.direction), moment])


GIVEN_SUPPORTS = (Fixed, Roller, NormalRoller, PrescribedDisplacement)
Support: TypeAlias = GivenSupport | Bars
"""Supports of blocks: as they are given, or bars that were worked out before."""


def bars_of(supports: Sequence[Support], blocks: Blocks) -> Bars:
    """Return the bars of all supports, in their order.

    Raises
    ------
    ModelError
        For a boundary or block that does not exist, or a point outside every block.
    """
    faults: list[str] = []
    parts: list[Bars] = []
    for number, support in enumerate(supports):
        if isinstance(support, Bars):
            parts.append(support)
            continue
        with gathered(faults, f"support {number + 1} ({type(support).__name__})"):
            parts.extend(_bars_of_one(support, number, blocks))
    raise_faults(faults)
    if len(parts) == 1:
        return parts[0]
    nowhere = np.zeros((0, blocks.moments.centroid.shape[1]))
    empty = _bars(0, np.zeros(0, np.int32), nowhere, np.zeros(0, np.int32), nowhere)
    columns = {
        field.name: np.concatenate([getattr(part, field.name) for part in (empty, *parts)]) for field in fields(Bars)
    }
    return Bars(**columns)


def _bars_of_one(support: GivenSupport, number: int, blocks: Blocks) -> Iterator[Bars]:
    if in_space(blocks):
        yield from space.bars_in_space(support, number, blocks)
        return
    block, point, normal, edge = _held_points(support, blocks)
    directions, displacement = held_directions(support, normal)
    for direction in directions:
        yield _bars(number, block, point, edge, direction, displacement)
    if isinstance(support, Fixed) and support.blocks is not None:
        yield replace(_bars(number, block, point, edge, np.zeros_like(point)), holds_rotation=np.ones(len(block), bool))


def _bars(
    number: int, block: IntArray, point: FloatArray, edge: IntArray, direction: FloatArray, value: float = 0.0
) -> Bars:
    return Bars(
        block=block,
        point=point,
        direction=direction,
        holds_rotation=np.zeros(len(block), dtype=bool),
        value=np.full(len(block), value),
        support=np.full(len(block), number, dtype=np.int32),
        edge=edge,
    )


def _held_points(support: Target, blocks: Blocks) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
    """Return block (k,), point (k, 2), outward edge normal (k, 2) and edge (k,) of every held point.

    Where there is no edge the normal is zero and the edge -1.
    """
    if support.boundary is not None:
        edges = blocks.boundary_edges(support.boundary)
        along = blocks.edge_vectors[edges]
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        ends = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1).reshape(-1, 2)
        return np.repeat(blocks.owner[edges], 2), ends, np.repeat(normal, 2, axis=0), np.repeat(edges, 2)
    if support.blocks is not None:
        ids = np.array(support.blocks, dtype=np.int64)
        outside = ids[(ids < 0) | (ids >= blocks.count)]
        if outside.size:
            raise ModelError(f"there is no block {listing(outside)}; blocks are numbered 0 to {blocks.count - 1}")
        return ids.astype(np.int32), blocks.moments.centroid[ids], np.zeros((len(ids), 2)), no_edge(ids)
    assert support.point is not None
    found = blocks_at(blocks, support.point)
    if found.size == 0:
        raise ModelError(f"the point ({support.point[0]:g}, {support.point[1]:g}) lies in no block")
    return found, np.tile(support.point, (len(found), 1)), np.zeros((len(found), 2)), no_edge(found)


def no_edge(blocks: IntArray) -> IntArray:
    """Return -1 for every block: it is held elsewhere than at an edge."""
    return np.full(len(blocks), -1, dtype=np.int32)


def held_directions(support: GivenSupport, normal: FloatArray) -> tuple[list[FloatArray], float]:
    """Return the held directions, (k, 2) each, and the displacement prescribed along them."""
    if isinstance(support, NormalRoller):
        return [normal], 0.0
    if isinstance(support, Fixed):
        return [np.tile(axis, (len(normal), 1)) for axis in ((1.0, 0.0), (0.0, 1.0))], 0.0
    along = np.tile(unit_vector(support.direction), (len(normal), 1))
    return [along], support.displacement if isinstance(support, PrescribedDisplacement) else 0.0


def unit_vector(degrees: float) -> FloatArray:
    """Return the unit vector at an angle from the x axis; exact along the axes."""
    quarter, rest = divmod(degrees, 90.0)
    if rest == 0:
        return np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][int(quarter) % 4])
    angle = np.radians(degrees)
    return np.array([np.cos(angle), np.sin(angle)])


def points_down(degrees: float) -> bool:
    """Return whether an angle from the x axis is that of straight down, -90 or 270."""
    return tuple(unit_vector(degrees)) == (0.0, -1.0)
