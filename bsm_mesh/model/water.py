"""Groundwater as it is given: tables, and pressures on chosen joints (Wang chapter 6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, get_args

import numpy as np

from bsm_mesh.arrays import FloatArray, ReadOnlyMapping
from bsm_mesh.errors import as_given, raise_faults
from bsm_mesh.given import Given, by_default
from bsm_mesh.model.quantities import COORDINATE, DIRECTION, HEAD_DIP, PRESSURE, WATER_WEIGHT
from bsm_mesh.model.values import Points, Rules, is_number, line, parts_of

Head = Literal["vertical", "parallel"]
WATER = 9810.0  # N/m3


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadPlane:
    """A plane of groundwater in space: pressure grows with the vertical depth below it.

    Attributes
    ----------
    point : (x, y, z) [m]
        A point on it.
    dip, dip_direction : float [degrees]
        Its fall from the level, and to which side, clockwise from north.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Water(plane=bsm.HeadPlane(point=(0, 0, 12), dip=5, dip_direction=90)).plane.dip
    5
    """

    point: tuple[float, float, float]
    dip: Annotated[float, HEAD_DIP] = 0.0
    dip_direction: Annotated[float, DIRECTION] = 0.0

    def __post_init__(self) -> None:
        rules = Rules("plane of head")
        parts = parts_of(self.point) or []
        if len(parts) != 3:
            rules.faults.append(f"plane of head: point = {as_given(self.point)} must be three numbers (x, y, z) [m]")
        for part in parts:
            rules.number("point", part, COORDINATE)
        rules.numbers(self)
        raise_faults(rules.faults)
        object.__setattr__(self, "point", tuple(float(part) for part in parts))

    @property
    def up(self) -> FloatArray:
        """Normal of the plane with an upward component of 1, (3,)."""
        dip, way = np.radians([self.dip, self.dip_direction])
        return np.array([np.tan(dip) * np.sin(way), np.tan(dip) * np.cos(way), 1.0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Water:
    """Water tables, and the weight of the water beneath them.

    Attributes
    ----------
    table : sequence of (x, y), or of such lines [m]
        The table from left to right, level beyond its ends. Of several tables each holds between its own ends, the
        highest where they overlap, and gaps between them are bridged straight. None at all: no water.
    unit_weight : float [N/m3]
        Of the water.
    head : {"vertical", "parallel"}
        Pressure head below the table: the vertical depth (Wang Eq. 6.1), or that times cos^2 of the table's slope,
        for seepage parallel to it.
    joint_pressure : mapping of str to float [Pa]
        Pressure in all faces of a joint, instead of the table's.
    plane : HeadPlane or None
        Of polyhedra instead of a table.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Water(table=[(0, 12), (40, 7)], joint_pressure={"J1": 50e3}).unit_weight
    9810.0
    """

    table: Given[tuple[Points, ...], Sequence[Sequence[Any]]] = by_default(())
    unit_weight: Annotated[float, WATER_WEIGHT] = WATER
    head: Head = "vertical"
    joint_pressure: Mapping[str, float] = field(default_factory=dict)
    plane: HeadPlane | None = field(default=None, metadata={"in_hash": "given"})

    def __post_init__(self) -> None:
        rules = Rules("water")
        object.__setattr__(self, "table", _tables(self.table, rules))
        if len(self.table) > 1 and min(map(len, self.table)) == 1:
            rules.faults.append("water: a table of one point is level everywhere; give it alone, or two points or more")
        rules.numbers(self)
        rules.choice("head", self.head, get_args(Head))
        rules.a_thing("plane", self.plane, HeadPlane, optional=True)
        pressures = rules.mapping("joint_pressure", self.joint_pressure)
        for name, pressure in pressures.items():
            rules.number(f"joint_pressure of '{name}'", pressure, PRESSURE)
        raise_faults(rules.faults)
        object.__setattr__(self, "unit_weight", float(self.unit_weight))
        given = {str(name): float(value) for name, value in pressures.items()}
        object.__setattr__(self, "joint_pressure", ReadOnlyMapping(given))

    def scaled(self, share: float) -> Water:
        """Return water that weighs a share of what this does."""
        return replace(self, unit_weight=share * self.unit_weight)

    def surface(self) -> WaterSurface:
        """Return the tables as one line made of straight pieces."""
        return _surface(self.table, self.head)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class WaterSurface:
    """The water's surface: between two breaks, and beyond the first and the last, it is straight.

    Attributes
    ----------
    breaks : (k,) float64 [m]
        Where a straight piece ends, rising.
    level, slope : (k + 1,) float64 [m, -]
        The piece before each break (and after the last) is ``level + slope * x``; a level of -inf: no water.
    factor : (k + 1,) float64
        Pressure head over vertical depth.
    """

    breaks: FloatArray
    level: FloatArray
    slope: FloatArray
    factor: FloatArray

    def at(self, x: FloatArray) -> FloatArray:
        """Return the level of the water at abscissas x [m]."""
        piece = np.searchsorted(self.breaks, x)
        found: FloatArray = self.level[piece] + self.slope[piece] * x
        return found

    def between(self, left: float, right: float) -> tuple[FloatArray, FloatArray]:
        """Return both ends of the straight pieces over a range of x, (k, 2, 2) [m], and their factors, (k,).

        None where there is no water.
        """
        inside = self.breaks[(self.breaks > left) & (self.breaks < right)]
        x = np.concatenate([[left], inside, [right]])
        piece = np.searchsorted(self.breaks, (x[1:] + x[:-1]) / 2)
        level, slope = self.level[piece], self.slope[piece]
        ends = np.stack([np.stack([at, level + slope * at], axis=1) for at in (x[:-1], x[1:])], axis=1)
        wet = np.isfinite(level)
        return ends[wet], self.factor[piece][wet]


def _tables(value: Any, rules: Rules) -> tuple[Points, ...]:
    parts = parts_of(value)
    if parts is None:
        rules.faults.append(f"water: table = {as_given(value)} must be points [[x, y], ...] from left to right [m]")
        return ()
    if not parts:
        return ()
    first = parts_of(parts[0]) or []
    one = not first or is_number(first[0]) or isinstance(first[0], str)
    return tuple(line(part, "table", rules) for part in ([parts] if one else parts))


def _surface(tables: tuple[Points, ...], head: Head) -> WaterSurface:
    if not tables:
        return WaterSurface(breaks=np.zeros(0), level=np.full(1, -np.inf), slope=np.zeros(1), factor=np.ones(1))
    lines = [np.array(table) for table in tables]
    breaks = np.unique(np.concatenate([points[:, 0] for points in lines]))
    breaks = np.unique(np.concatenate([breaks, _crossings(lines, breaks)]))
    middle = (breaks[1:] + breaks[:-1]) / 2
    best_level, best_slope = np.full(len(middle), -np.inf), np.zeros(len(middle))
    highest = np.full(len(middle), -np.inf)
    for points in lines:  # a few tables
        covered = (middle > points[0, 0]) & (middle < points[-1, 0])
        level, slope = _pieces(points, middle)
        better = covered & (level + slope * middle > highest)
        best_level[better], best_slope[better] = level[better], slope[better]
        highest[better] = (level + slope * middle)[better]
    best_level, best_slope = _bridged(breaks, best_level, best_slope)
    left = max(points[0, 1] for points in lines if points[0, 0] == breaks[0])
    right = max(points[-1, 1] for points in lines if points[-1, 0] == breaks[-1])
    slope = np.concatenate([[0.0], best_slope, [0.0]])
    return WaterSurface(
        breaks=breaks,
        level=np.concatenate([[left], best_level, [right]]),
        slope=slope,
        factor=1 / (1 + slope**2) if head == "parallel" else np.ones(len(slope)),
    )


def _pieces(points: FloatArray, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return level and slope of the piece of one table at each x."""
    if len(points) == 1:
        return np.full(len(x), points[0, 1]), np.zeros(len(x))
    piece = np.clip(np.searchsorted(points[:, 0], x) - 1, 0, len(points) - 2)
    slope = np.diff(points[:, 1]) / np.diff(points[:, 0])
    level: FloatArray = points[piece, 1] - slope[piece] * points[piece, 0]
    return level, slope[piece]


def _crossings(lines: list[FloatArray], breaks: FloatArray) -> FloatArray:
    """Return where two tables cross between breaks."""
    found = [np.zeros(0)]
    middle = (breaks[1:] + breaks[:-1]) / 2
    for k, one in enumerate(lines):  # a few tables
        for other in lines[k + 1 :]:
            (a, s), (b, t) = _pieces(one, middle), _pieces(other, middle)
            with np.errstate(divide="ignore", invalid="ignore"):
                x = (b - a) / (s - t)
            found.append(x[(x > breaks[:-1]) & (x < breaks[1:])])
    return np.concatenate(found)


def _bridged(breaks: FloatArray, level: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the pieces with gaps between tables closed by straight lines from end to end."""
    for k in np.flatnonzero(np.isneginf(level)):  # gaps lie between the ends of two tables, one piece each
        y0 = level[k - 1] + slope[k - 1] * breaks[k]
        y1 = level[k + 1] + slope[k + 1] * breaks[k + 1]
        slope[k] = (y1 - y0) / (breaks[k + 1] - breaks[k])
        level[k] = y0 - slope[k] * breaks[k]
    return level, slope
