"""Joint sets and single joints in space: planes and discs by dip and dip direction."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, SupportsFloat

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.orientations import upward_normals
from bsm_mesh.geometries.parameters import Checks
from bsm_mesh.geometries.spacings import MOST_PLACES, Constant, Spacing, places_across

FloatArray = npt.NDArray[np.float64]
MANY = 10_000  # radii are drawn to see how far discs reach


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Planes:
    """Planes of a joint, or discs in them.

    Attributes
    ----------
    normal : (n, 3) float64
        Upward unit normals.
    point : (n, 3) float64 [m]
        A point on each plane; the centre of a disc.
    radius : (n,) float64 [m]
        Radius of each disc; infinite for a whole plane.
    """

    normal: FloatArray
    point: FloatArray
    radius: FloatArray


class Joints(Protocol):
    """Anything that gives planes: a `JointSet`, a `JointPlane`, or a class of your own."""

    @property
    def name(self) -> str:
        """Name of the joint."""

    @property
    def persistence(self) -> float:
        """Part of the cells crossed by a plane that it cuts."""

    def planes(self, low: FloatArray, high: FloatArray, seed: int) -> Planes:
        """Return the planes in the box from `low` to `high` [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointPlane:
    """A single joint: a fault, a mapped joint, a disc.

    Attributes
    ----------
    name : str
        Name of the joint; several planes may have the same.
    dip, dip_direction : float
        Fall of the plane from the level, and its direction clockwise from north [degrees].
    point : (float, float, float) [m]
        A point on the plane; the centre of a disc.
    radius : float, optional [m]
        Of a disc; where not given the plane goes through the whole model.

    Examples
    --------
    >>> from bsm_mesh.geometries import three_d
    >>> three_d.JointPlane(name="F1", dip=35, dip_direction=210, point=(0, 8, 2)).dip
    35
    """

    name: str
    dip: float
    dip_direction: float
    point: Sequence[float]
    radius: float | None = None

    def __post_init__(self) -> None:
        checks = _checks_of("joint plane", self.name, self.dip, self.dip_direction)
        checks.vector(point=self.point)
        checks.positive_or_none(radius=self.radius)
        checks.raise_faults()

    @property
    def persistence(self) -> float:
        """1: a plane cuts every cell that it crosses."""
        return 1.0

    def planes(self, low: FloatArray, high: FloatArray, seed: int) -> Planes:
        """Return the one plane."""
        return Planes(
            normal=upward_normals(np.array([self.dip]), np.array([self.dip_direction])),
            point=np.array([self.point], dtype=np.float64),
            radius=np.array([np.inf if self.radius is None else self.radius]),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointSet:
    """A set of nearly parallel joints.

    By `spacing` it is planes through the whole model, of which `persistence` below 1 leaves parts. By `density` and
    `radius` it is discs around centres at random (Baecher, Lanney & Einstein 1977).

    Attributes
    ----------
    name : str
        Name of the joint.
    dip, dip_direction : float
        Mean orientation: fall of the planes from the level, and its direction clockwise from north [degrees].
    spacing : float or Spacing, optional
        Distance between neighbours, across them [m]: a number, or `Normal`, `Lognormal`, `Exponential`.
    density : float, optional
        Instead of it: area of joints a volume, P32 [m2/m3].
    radius : float or Spacing, optional
        With a density: radius of the discs [m], a number or a distribution.
    origin : (float, float, float), optional [m]
        A point on one of the planes; where not given, the centre of the model for a constant spacing and an arbitrary
        point of random sets.
    scatter : float, optional
        Fisher's constant of the orientations: 20 is wide, 200 narrow. Where not given the joints are parallel.
    persistence : float
        Part of the cells crossed by a plane that it cuts, above 0 up to 1; cells are chosen at random.

    Notes
    -----
    A disc cuts the cells whose sections have their centre inside it. Joints given first are cut first; give the
    persistent sets before those that end.

    Examples
    --------
    >>> from bsm_mesh.geometries import three_d
    >>> three_d.JointSet(name="J1", dip=60, dip_direction=160, spacing=2.0, scatter=80).spacing
    2.0
    """

    name: str
    dip: float
    dip_direction: float
    spacing: float | Spacing | None = None
    density: float | None = None
    radius: float | Spacing | None = None
    origin: Sequence[float] | None = None
    scatter: float | None = None
    persistence: float = 1.0

    def __post_init__(self) -> None:
        checks = _checks_of("joint set", self.name, self.dip, self.dip_direction)
        if (self.spacing is None) == (self.density is None):
            checks.add("give one of spacing [m] and density [m2/m3]")
        if (self.density is None) != (self.radius is None):
            checks.add("density [m2/m3] and radius [m] go together")
        checks.positive_or_none("m2/m3", density=self.density)
        checks.positive_or_none("1", scatter=self.scatter)
        for name, value in (("spacing", self.spacing), ("radius", self.radius)):
            if value is not None and not callable(getattr(value, "draw", None)):  # a law of the user's own draws
                checks.positive(**{name: value})
        if self.origin is not None:
            checks.vector(origin=self.origin)
        if checks.positive("1", persistence=self.persistence) and self.persistence > 1:
            checks.add(f"persistence = {self.persistence} must be above 0 and at most 1")
        if self.density is not None and (self.persistence != 1 or self.origin is not None):
            checks.add("persistence and origin belong to spacing, not to density")
        checks.raise_faults()

    def planes(self, low: FloatArray, high: FloatArray, seed: int) -> Planes:
        """Return the planes in the box from `low` to `high` [m].

        The random numbers depend on `seed` and the set's name alone: another set more changes nothing.

        Raises
        ------
        GeometryError
            If there would be more than two million of them.
        """
        generator = np.random.default_rng([seed, zlib.crc32(self.name.encode())])
        if self.density is not None:
            return self._discs(low, high, generator)
        mean = upward_normals(np.array([self.dip]), np.array([self.dip_direction]))[0]
        centre, reach = (low + high) / 2, float(np.abs(mean) @ (high - low)) / 2
        law = self.spacing if isinstance(self.spacing, Spacing) else Constant(float(self.spacing or 0))
        start = None if self.origin is None else float(mean @ np.asarray(self.origin, dtype=np.float64))
        middle = float(mean @ centre)
        if self.scatter is not None:
            reach = float(np.linalg.norm(high - low)) / 2  # planes that turn reach in from further away
        place = places_across(f"joint set '{self.name}'", law, middle, reach, start, generator)
        return Planes(
            normal=self._normals(len(place), generator),
            point=centre + (place - middle)[:, None] * mean,
            radius=np.full(len(place), np.inf),
        )

    def _discs(self, low: FloatArray, high: FloatArray, generator: np.random.Generator) -> Planes:
        """Return discs around centres at random; these lie beyond the box too, as far as discs reach into it."""
        assert self.density is not None
        law = self.radius if isinstance(self.radius, Spacing) else Constant(float(self.radius or 0))
        drawn = law.draw(MANY, generator)
        reach = float(drawn.max())
        expected = self.density * float(np.prod(high - low + 2 * reach)) / (np.pi * float(np.square(drawn).mean()))
        if expected > MOST_PLACES:
            raise GeometryError(
                f"joint set '{self.name}': density = {self.density:g} m2/m3 gives {expected:.3g} discs; give a lower "
                "density, wider discs or a smaller model"
            )
        count = int(generator.poisson(expected))
        return Planes(
            normal=self._normals(count, generator),
            point=low - reach + generator.uniform(size=(count, 3)) * (high - low + 2 * reach),
            radius=law.draw(count, generator),
        )

    def _normals(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return unit normals scattered about the mean by Fisher's (1953) distribution, (count, 3)."""
        mean = upward_normals(np.array([self.dip]), np.array([self.dip_direction]))[0]
        if self.scatter is None:
            return np.tile(mean, (count, 1))
        share, turn = generator.uniform(size=count), generator.uniform(0, 2 * np.pi, count)
        cosine = 1 + np.log(share + (1 - share) * np.exp(-2 * self.scatter)) / self.scatter
        first = np.cross(mean, np.eye(3)[np.argmin(np.abs(mean))])
        first /= np.linalg.norm(first)
        second = np.cross(mean, first)
        sine = np.sqrt(np.maximum(1 - cosine**2, 0))[:, None]
        across = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
        scattered: FloatArray = cosine[:, None] * mean + sine * across
        return scattered


def _checks_of(kind: str, name: object, dip: object, dip_direction: object) -> Checks:
    """Return checks of a named joint, of its name and orientation first."""
    checks = Checks.of_named(kind, name)
    if checks.number("degrees", dip=dip, dip_direction=dip_direction):
        assert isinstance(dip, SupportsFloat)
        if not 0 <= float(dip) <= 90:
            checks.add(f"dip = {float(dip):g} must lie from 0 to 90 degrees; the dip direction says to which side")
    return checks
