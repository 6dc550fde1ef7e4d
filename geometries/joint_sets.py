"""Joint sets, faults and other lines in the rock, each a set of straight traces.

Angles are those of the trace from the x axis, counter-clockwise, in degrees: 60 rises to the right, -60 (or 120)
falls to the right.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.parameters import Checks
from bsm_mesh.geometries.spacings import MOST_PLACES as MOST_TRACES
from bsm_mesh.geometries.spacings import Constant, Exponential, Spacing, places_across

FloatArray = npt.NDArray[np.float64]
Points = Sequence[tuple[float, float]] | FloatArray
Ends = Literal["crossing", "t_ended", "en_echelon"]
LONGEST_BRIDGE = 1e6  # m
LONGEST_OF = 10_000  # lengths are drawn to see how far traces reach
FARTHEST_CENTRE = 20.0  # of the model's diagonal: traces longer than twice that are lines for it


class Joints(Protocol):
    """Anything that gives traces: a `JointSet`, a `Fault`, or a class of your own."""

    @property
    def name(self) -> str:
        """Name of the joint, without ``joint:``."""

    @property
    def extends(self) -> bool:
        """Whether dead ends continue to the next joint."""

    def traces(self, low: FloatArray, high: FloatArray, seed: int) -> FloatArray:
        """Return the traces in the box from `low` to `high`, (n, 2, 2) [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointSet:
    """A set of nearly parallel joints.

    By `spacing` it is lines through the whole model, parted by bridges where `persistence` is below 1. By `density` and
    ``length`` it is a network of traces around centres at random (Baecher, Lanney & Einstein 1977). By `density` alone
    it is lines at random (Poisson); with bridges of random length these are Veneziano's (1978) joints.

    Attributes
    ----------
    name : str
        Name of the joint in the mesh, ``joint:name``.
    dip : float
        Angle of the traces from the x axis, counter-clockwise [degrees].
    spacing : float or Spacing, optional
        Distance between neighbours, across them [m]: a number, `Normal`, `Lognormal` or `Exponential`.
    density : float, optional
        Instead of it: length of joints an area, P21 [m/m^2].
    length : float or Spacing, optional
        With a density: length of the traces [m], a number or a distribution (`Lognormal`, `Exponential`, `PowerLaw`).
    start : (float, float), optional
        A point on one of the joints [m]; where not given, the centre of the model for a constant spacing and
        an arbitrary point of random sets.
    scatter : float
        Standard deviation of the dip from joint to joint [degrees].
    persistence : float
        Jointed part of each line, above 0 up to 1.
    bridge : float or Spacing, optional
        Length of the intact bridges [m]; needed where `persistence` is below 1. Of a distribution bridges and the
        joints between them are random, the joints' mean length that which the persistence asks for.
    ends : str
        Ends at a bridge. ``crossing``: they end in the rock. ``t_ended``: they continue to the next joint.
        ``en_echelon``: they end in the rock, and every other line is shifted by half a period.
    within : (k, 2) array_like, optional
        Polygon that the set keeps to [m].
    abuts : sequence of str
        With a length: sets at whose joints these end, on both sides of their middle; the density is that before. No
        set may abut on one that in turn abuts on it.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.JointSet(name="J1", dip=-60, spacing=2.0).spacing
    2.0
    >>> g.JointSet(name="J2", dip=20, spacing=g.Lognormal(2.5, 0.5), persistence=0.8, bridge=0.5).persistence
    0.8
    """

    name: str
    dip: float
    spacing: float | Spacing | None = None
    density: float | None = None
    length: float | Spacing | None = None
    start: tuple[float, float] | None = None
    scatter: float = 0.0
    persistence: float = 1.0
    bridge: float | Spacing | None = None
    ends: Ends = "crossing"
    within: Points | None = None
    abuts: Sequence[str] = ()

    def __post_init__(self) -> None:
        checks = Checks.of_named("joint set", self.name)
        checks.number("degrees", dip=self.dip)
        self._check_density(checks)
        checks.within(0, 45, "degrees", scatter=self.scatter)
        if self.start is not None:
            checks.points(start=[self.start])
        if self.within is not None:
            checks.points(3, within=self.within)
        if isinstance(self.bridge, float | int) and checks.positive(bridge=self.bridge):
            checks.within(0, LONGEST_BRIDGE, "m", bridge=self.bridge)
        elif self.bridge is not None and not isinstance(self.bridge, Spacing):
            checks.positive(bridge=self.bridge)
        if checks.positive("1", persistence=self.persistence):
            if self.persistence > 1:
                checks.add(f"persistence = {self.persistence} must be above 0 and at most 1")
            elif self.persistence < 1 and self.bridge is None:
                checks.add(f"persistence = {self.persistence} needs a bridge, the length of the intact parts [m]")
        checks.one_of(get_args(Ends), ends=self.ends)
        checks.raise_faults()

    def _check_density(self, checks: Checks) -> None:
        if (self.spacing is None) == (self.density is None):
            checks.add("give one of spacing [m] and density [m/m^2]")
        if self.length is not None and (self.density is None or self.bridge is not None or self.start is not None):
            checks.add("length belongs to density, and with neither bridge nor start")
        on = self.abuts if isinstance(self.abuts, list | tuple) else (None,)
        if not all(isinstance(name, str) and name != self.name for name in on):
            checks.add(f"abuts = {self.abuts!r} must be names of other sets, such as ['J1']")
        elif on and self.length is None:
            checks.add("abuts belongs to a length")
        checks.positive_or_none("m/m^2", density=self.density)
        for name, value in (("spacing", self.spacing), ("length", self.length)):
            if value is not None and not callable(getattr(value, "draw", None)):  # a law of the user's own draws
                checks.positive(**{name: value})

    @property
    def extends(self) -> bool:
        """Whether dead ends continue to the next joint."""
        return self.ends == "t_ended"

    def traces(self, low: FloatArray, high: FloatArray, seed: int) -> FloatArray:
        """Return the traces in the box from `low` to `high`, (n, 2, 2) [m].

        The random numbers depend on `seed` and the set's name alone: another set more changes nothing.

        Raises
        ------
        GeometryError
            If there would be more than two million of them.
        """
        generator = np.random.default_rng([seed, zlib.crc32(self.name.encode())])
        if self.within is not None:
            polygon = np.asarray(self.within, dtype=np.float64)
            low, high = np.maximum(low, polygon.min(axis=0)), np.minimum(high, polygon.max(axis=0))
            if np.any(high <= low):
                return np.empty((0, 2, 2))
        if self.length is not None:
            drawn = self._around_centres(low, high, generator)
            return drawn if self.within is None else clip_traces(drawn, self.within)
        centre, radius = (low + high) / 2, float(np.hypot(*(high - low))) / 2
        along = _direction(self.dip)
        across = np.array([-along[1], along[0]])
        offset = self._offsets(centre @ across, radius, generator)
        foot = (centre @ along) * along + offset[:, None] * across  # of each joint, nearest to the centre
        turned = self.dip + (
            generator.normal(0.0, self.scatter, len(offset)) if self.scatter else np.zeros(len(offset))
        )
        lines = np.stack([foot, foot], axis=1)
        reach = 1.5 * radius
        first, last = self._stretches(len(offset), reach, generator)
        owner = np.repeat(np.arange(len(offset)), [len(part) for part in first])
        stations = np.stack([np.concatenate([*first, []]), np.concatenate([*last, []])], axis=1)
        directions = np.stack([np.cos(np.radians(turned)), np.sin(np.radians(turned))], axis=1)
        traces = lines[owner] + stations[:, :, None] * directions[owner][:, None]
        return traces if self.within is None else clip_traces(traces, self.within)

    def _around_centres(self, low: FloatArray, high: FloatArray, generator: np.random.Generator) -> FloatArray:
        """Return traces around centres at random; these lie beyond the box too, as far as traces reach into it."""
        assert self.length is not None
        assert self.density is not None
        law = self.length if isinstance(self.length, Spacing) else Constant(float(self.length))
        size = float(np.hypot(*(high - low)))
        reach = min(float(law.draw(LONGEST_OF, generator).max()) / 2, FARTHEST_CENTRE * size)
        area = float(np.prod(high - low + 2 * reach))
        expected = self.density * area / law.mean
        if expected > MOST_TRACES:
            raise GeometryError(
                f"joint set '{self.name}': density = {self.density:g} m/m^2 gives {expected:.3g} traces; give a lower "
                "density, longer traces or a smaller model"
            )
        count = int(generator.poisson(expected))
        centres = low - reach + generator.uniform(size=(count, 2)) * (high - low + 2 * reach)
        angle = np.radians(self.dip + generator.normal(0.0, 1.0, count) * self.scatter)
        half = law.draw(count, generator)[:, None] / 2 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.stack([centres - half, centres + half], axis=1)

    def _law_of_spacing(self) -> Spacing:
        if self.spacing is None:
            assert self.density is not None
            return Exponential(self.persistence / self.density)
        return self.spacing if isinstance(self.spacing, Spacing) else Constant(float(self.spacing))

    def _offsets(self, middle: float, radius: float, generator: np.random.Generator) -> FloatArray:
        """Return where the joints cross the line across them, over `radius` to both sides of `middle`."""
        start = None
        if self.start is not None:
            along = _direction(self.dip)
            start = float(np.array([-along[1], along[0]]) @ np.asarray(self.start, dtype=np.float64))
        return places_across(f"joint set '{self.name}'", self._law_of_spacing(), middle, radius, start, generator)

    def _stretches(
        self, count: int, reach: float, generator: np.random.Generator
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Return the begins and ends of the jointed stretches of each line, from its foot [m]."""
        if self.persistence == 1 or self.bridge is None:
            whole = np.array([reach])
            return [-whole] * count, [whole] * count
        law = self.bridge if isinstance(self.bridge, Spacing) else Constant(float(self.bridge))
        period = law.mean / (1 - self.persistence)
        if max(count, 1) * 2 * reach / period > MOST_TRACES:
            raise GeometryError(f"joint set '{self.name}': too many bridges; give longer ones or a smaller model")
        if isinstance(self.bridge, Spacing):
            return self._random_stretches(law, count, reach, generator)
        shift = generator.uniform(0, period, count)
        if self.ends == "en_echelon":
            shift = (period / 2 * (np.arange(count) % 2)).astype(np.float64)
        grid = np.arange(-math.ceil(reach / period) - 1, math.ceil(reach / period) + 1) * period
        first = [grid + s for s in shift]
        return first, [begin + self.persistence * period for begin in first]

    def _random_stretches(
        self, law: Spacing, count: int, reach: float, generator: np.random.Generator
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Return jointed stretches of exponential length between bridges of a distribution (Veneziano 1978)."""
        joint = law.mean * self.persistence / (1 - self.persistence)
        first, last = [], []
        for _ in range(count):
            number = int(1.5 * 2 * reach / (joint + law.mean)) + 40
            joints, bridges = generator.exponential(joint, number), law.draw(number, generator)
            begin = np.cumsum(joints + bridges) - joints - bridges
            begin -= reach + (8 + generator.uniform()) * (joint + law.mean)  # so that any place may be one of any kind
            first.append(begin)
            last.append(begin + joints)
        return first, last


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fault:
    """Single lines: a fault, a bedding plane, traces mapped in the field.

    Attributes
    ----------
    name : str
        Name of the joint in the mesh, ``joint:name``.
    lines : sequence of (k, 2) array_like
        Polylines [m].
    extends : bool
        Whether dead ends continue to the next joint.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.Fault(name="F1", lines=[[(0, 2), (10, 5)]]).name
    'F1'
    """

    name: str
    lines: Sequence[Points]
    extends: bool = False

    def __post_init__(self) -> None:
        checks = Checks.of_named("fault", self.name)
        checks.true_or_false(extends=self.extends)
        try:
            lines: list[object] = list(self.lines)
        except TypeError:
            lines = [self.lines]
        for number, line in enumerate(lines):
            checks.points(2, **{f"line {number}": line})
        checks.raise_faults()

    def traces(self, low: FloatArray, high: FloatArray, seed: int) -> FloatArray:
        """Return the straight pieces of the lines, (n, 2, 2) [m]."""
        pieces = [np.empty((0, 2, 2))]
        for line in self.lines:
            points = np.asarray(line, dtype=np.float64)
            pieces.append(np.stack([points[:-1], points[1:]], axis=1))
        return np.concatenate(pieces)


def bedding(name: str, dip: float, thickness: float | Spacing, **others: object) -> JointSet:
    """Return bedding: a persistent joint set by the thickness of its layers, measured across them [m].

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.bedding("bed", 20, 0.5).dip
    20
    """
    return JointSet(name=name, dip=dip, spacing=thickness, **others)  # type: ignore[arg-type]


def _direction(dip: float) -> FloatArray:
    return np.array([math.cos(math.radians(dip)), math.sin(math.radians(dip))])


def clip_traces(traces: FloatArray, polygon: Points) -> FloatArray:
    """Return the parts of the traces, (n, 2, 2) [m], in a polygon."""
    import shapely

    inside = shapely.get_parts(
        shapely.intersection(shapely.linestrings(traces), shapely.Polygon(np.asarray(polygon, dtype=np.float64)))
    )
    inside = inside[shapely.get_type_id(inside) == shapely.GeometryType.LINESTRING]
    inside = inside[shapely.get_num_coordinates(inside) == 2]
    clipped: FloatArray = shapely.get_coordinates(inside).reshape(-1, 2, 2)
    return clipped
