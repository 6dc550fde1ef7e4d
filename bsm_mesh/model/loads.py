"""Loads as they are given, and the point forces on blocks that they represent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from bsm_mesh import space
from bsm_mesh.arrays import FloatArray, IntArray, Portable, own_array
from bsm_mesh.errors import ModelError, as_given, raise_faults
from bsm_mesh.given import Given, by_default
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.earth_pressure import EarthPressure
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.quantities import BLOCK, FORCE, STRESS, STRESS_GRADIENT
from bsm_mesh.model.values import Rules, parts_of, plain_numbers

LinearField: TypeAlias = tuple[float, ...]
"""Coefficients (c, a_x, a_y) of ``c + a_x * x + a_y * y``; in space (c, a_x, a_y, a_z)."""
AnyField: TypeAlias = float | Sequence[float]
"""A constant, or those coefficients."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PointLoad:
    """A force on one block.

    Attributes
    ----------
    block : int
        Number of the block.
    point : (x, y) [m]
        Where the force acts; it must lie in the block or on its outline. In space (x, y, z).
    force : (fx, fy) [N/m]
        Force per metre of thickness. In space (fx, fy, fz) [N].

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.PointLoad(block=1, point=(1, 1.5), force=(1e3, 0)).force
    (1000.0, 0.0)
    """

    block: int
    point: tuple[float, ...]
    force: tuple[float, ...]

    def __post_init__(self) -> None:
        rules = Rules(f"point load on block {as_given(self.block)}")
        rules.number("block", self.block, BLOCK)
        object.__setattr__(self, "point", rules.place("point", self.point))
        object.__setattr__(self, "force", rules.place("force", self.force, FORCE))
        if not rules.faults and len(self.point) != len(self.force):
            rules.faults.append(f"{rules.thing}: give point and force both two numbers, or both three in space")
        raise_faults(rules.faults)
        plain_numbers(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pressure:
    """A pressure on a boundary, positive into the blocks.

    Attributes
    ----------
    boundary : str
        Name of the boundary.
    pressure : float or (c, a_x, a_y) [Pa, Pa/m]
        Constant, or linear in the coordinates: ``c + a_x * x + a_y * y``. In space (c, a_x, a_y, a_z).

    Examples
    --------
    Water up to y = 40 m: 392.4 kPa - 9.81 kN/m3 y.

    >>> import bsm_mesh as bsm
    >>> bsm.Pressure(boundary="upstream", pressure=(392.4e3, 0, -9810)).pressure
    (392400.0, 0.0, -9810.0)
    """

    boundary: str
    pressure: Given[LinearField, AnyField] = by_default(field())

    def __post_init__(self) -> None:
        place = _on_boundary(self.boundary)
        object.__setattr__(self, "pressure", _any_field(self.pressure, f"{place}: pressure"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Traction:
    """A traction on a boundary, force per area in x and y, in space in z too.

    Attributes
    ----------
    boundary : str
        Name of the boundary.
    traction : pair of float or (c, a_x, a_y) [Pa, Pa/m]
        Components (t_x, t_y), each constant or linear in the coordinates. In space there are three components, each
        constant or (c, a_x, a_y, a_z).

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Traction(boundary="top", traction=(0, -20e3)).boundary
    'top'
    """

    boundary: str
    traction: Given[tuple[LinearField, ...], Sequence[AnyField]] = by_default(field())

    def __post_init__(self) -> None:
        name = f"{_on_boundary(self.boundary)}: traction"
        parts = parts_of(self.traction)
        if parts is None or len(parts) not in (2, 3):
            raise ModelError(
                f"{name} = {as_given(self.traction)} needs two components (t_x, t_y), in space three (t_x, t_y, t_z)"
            )
        fields = tuple(_any_field(part, f"{name} {axis}") for part, axis in zip(parts, "xyz", strict=False))
        object.__setattr__(self, "traction", fields)


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class EdgeTractions(Portable):
    """A traction that is given edge by edge, linear along each edge.

    Attributes
    ----------
    boundary : str
        Name of the boundary.
    values : (n_edges, 2, 2) float64 [Pa]
        Traction (last axis: x, y) at the first and the second end of each edge, in the order of
        ``blocks.boundaries[boundary]``.
    """

    boundary: str
    values: FloatArray

    def __post_init__(self) -> None:
        place = _on_boundary(self.boundary)
        own_array(self, "values", np.float64, (None, 2, 2))
        beyond = ~(np.abs(self.values) <= STRESS.most)
        if beyond.any():
            raise ModelError(f"{place}: values: {self.values[beyond][0]:g} {STRESS.unit} {STRESS.rule}")


@dataclass(frozen=True, slots=True, kw_only=True)
class InSituTraction:
    """The traction on a boundary that balances the in-situ stress field of the model.

    Attributes
    ----------
    boundary : str
        Name of the boundary.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.InSituTraction(boundary="right").boundary
    'right'
    """

    boundary: str

    def __post_init__(self) -> None:
        _on_boundary(self.boundary)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PointForces:
    """Forces at points of blocks, one row a force.

    Attributes
    ----------
    block : (k,) int32
        Block on which the force acts.
    point : (k, 2) float64 [m]
        Where.
    force : (k, 2) float64 [N/m]
        Force per metre of thickness.
    """

    block: IntArray
    point: FloatArray
    force: FloatArray


BoundaryLoad: TypeAlias = Pressure | Traction | EarthPressure | EdgeTractions
ActingLoad: TypeAlias = PointLoad | BoundaryLoad | PointForces
GIVEN_LOADS = (PointLoad, Pressure, Traction, EarthPressure, EdgeTractions, InSituTraction)
Load: TypeAlias = ActingLoad | InSituTraction
"""Loads on blocks: as they are given, or point forces that were worked out before."""


def _on_boundary(name: object) -> str:
    """Return where a load acts, for messages; raise for a value that is no name."""
    rules = Rules("load")
    rules.text("boundary", name)
    raise_faults(rules.faults)
    return f"load on '{name}'"


def _any_field(value: float | Sequence[float], name: str) -> LinearField:
    """Return the coefficients of a field of the plane, or of space by four numbers; three of a constant."""
    several = parts_of(value)
    found = linear_field(value, name, axes=3 if several is not None and len(several) == 4 else 2)
    return found if any(found[1:]) else found[:3]


def refuse_misfit(load: Pressure | Traction, axes: int) -> None:
    """Raise a `ModelError` for a load whose components or coefficients are those of another number of axes."""
    fields = (load.pressure,) if isinstance(load, Pressure) else load.traction
    needed = ("two components (t_x, t_y)", "three components (t_x, t_y, t_z)")[axes - 2]
    if isinstance(load, Traction) and len(fields) != axes:
        raise ModelError(f"load on '{load.boundary}': traction has {len(fields)} components; it needs {needed}")
    if any(len(field) != 1 + axes and any(field[1:]) for field in fields):
        form = ("[c, a_x, a_y]", "[c, a_x, a_y, a_z]")[axes - 2]
        raise ModelError(f"load on '{load.boundary}': give each component as one number or as {form}")


def linear_field(value: float | Sequence[float], name: str, *, axes: int = 2) -> tuple[float, ...]:
    """Return the coefficients (c, a_x, a_y), in space with a_z too, of a constant or linear field."""
    several = parts_of(value)
    parts = [value] if several is None else several
    rules = Rules(name)
    if len(parts) not in (1, 1 + axes):
        form = ("three [c, a_x, a_y]", "four [c, a_x, a_y, a_z]")[axes - 2]
        rules.faults.append(f"{name}: give one number, or {form}; has {len(parts)}")
    for part, quantity in zip(parts[: 1 + axes], (STRESS, *[STRESS_GRADIENT] * axes), strict=False):
        rules.number("value", part, quantity)
    raise_faults(rules.faults)
    return tuple([*map(float, parts), *[0.0] * axes][: 1 + axes])


def point_forces_of(loads: Sequence[ActingLoad], blocks: Blocks) -> PointForces:
    """Return the forces of all loads; a traction becomes two forces an edge, with its resultant and moment.

    A component that runs linearly from q1 to q2 along an edge of length l becomes l (2 q1 + q2) / 6 and
    l (q1 + 2 q2) / 6 at the two ends: exact in force, moment and average stress.
    """
    if in_space(blocks):
        return space.forces_in_space(loads, blocks)
    nothing = np.zeros((0, 2))
    parts: list[tuple[npt.NDArray[np.generic], FloatArray, FloatArray]] = [(np.zeros(0, np.int32), nothing, nothing)]
    for load in loads:
        if isinstance(load, PointForces):
            parts.append((load.block, load.point, load.force))
            continue
        if isinstance(load, PointLoad):
            parts.append((np.array([load.block]), np.array([load.point]), np.array([load.force])))
            continue
        edges, ends, traction = edge_tractions(load, blocks)
        along = ends[:, 1] - ends[:, 0]
        length = np.hypot(*along.T)[:, None]
        first = length * (2 * traction[:, 0] + traction[:, 1]) / 6
        second = length * (traction[:, 0] + 2 * traction[:, 1]) / 6
        force = np.stack([first, second], axis=1).reshape(-1, 2)
        parts.append((np.repeat(blocks.owner[edges], 2), ends.reshape(-1, 2), force))
    block, point, force = (np.concatenate(column) for column in zip(*parts, strict=True))
    return PointForces(block=block.astype(np.int32), point=point, force=force)


def edge_tractions(load: BoundaryLoad, blocks: Blocks) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the loaded edges, their ends (k, 2 ends, 2) [m] and the tractions there (k, 2 ends, 2) [Pa].

    Between the ends of an edge the traction runs linearly.

    Raises
    ------
    ModelError
        If there is no such boundary, or the load is given for another number of edges, or for space.
    """
    if isinstance(load, Pressure | Traction):
        refuse_misfit(load, axes=2)
    edges = blocks.boundary_edges(load.boundary)
    along = blocks.edge_vectors[edges]
    ends = np.stack([blocks.vertices[edges], blocks.vertices[blocks.following[edges]]], axis=1)
    if isinstance(load, EdgeTractions):
        if len(load.values) != len(ends):
            raise ModelError(
                f"load on '{load.boundary}': values for {len(load.values)} edges; the boundary has {len(ends)}"
            )
        return edges, ends, load.values
    if isinstance(load, EarthPressure):
        return edges, ends, load.tractions(ends)
    if isinstance(load, Traction):
        return edges, ends, np.stack([values_of(field, ends) for field in load.traction], axis=2)
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    return edges, ends, values_of(load.pressure, ends)[:, :, None] * inward[:, None, :]


def values_of(field: LinearField, points: FloatArray) -> FloatArray:
    """Return the values of a linear field at points (..., axes)."""
    value: FloatArray = np.full(points.shape[:-1], field[0])
    for axis, slope in zip(range(points.shape[-1]), field[1:], strict=False):
        value += slope * points[..., axis]
    return value
