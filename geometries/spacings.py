"""How far apart the joints of a set are, and how long: a number, or a distribution."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.parameters import Checks

FloatArray = npt.NDArray[np.float64]
MOST_PLACES = 2_000_000
LEAST_SHARE = 0.05  # of the mean: no random spacing is smaller, or blocks would be slivers by chance alone


@runtime_checkable
class Spacing(Protocol):
    """A distribution of spacings."""

    @property
    def mean(self) -> float:
        """Mean spacing [m]."""

    def draw(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return `count` spacings [m]."""


@dataclass(frozen=True, slots=True)
class Constant:
    """The same spacing everywhere: the mean [m]."""

    mean: float

    def __post_init__(self) -> None:
        _check("Constant", mean=self.mean)

    def draw(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return `count` spacings [m]."""
        return np.full(count, float(self.mean))


@dataclass(frozen=True, slots=True)
class Normal:
    """Normally distributed spacings, cut below at a twentieth of the mean: mean and standard deviation [m]."""

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        _check("Normal", mean=self.mean, deviation=self.deviation)

    def draw(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return `count` spacings [m]."""
        return np.maximum(generator.normal(self.mean, self.deviation, count), LEAST_SHARE * self.mean)


@dataclass(frozen=True, slots=True)
class Lognormal:
    """Lognormal spacings by their own mean and standard deviation [m], not those of the logarithm.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.Lognormal(2.5, 0.5).mean
    2.5
    """

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        _check("Lognormal", mean=self.mean, deviation=self.deviation)

    def draw(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return `count` spacings [m]."""
        variance = math.log1p((self.deviation / self.mean) ** 2)
        drawn = generator.lognormal(math.log(self.mean) - variance / 2, math.sqrt(variance), count)
        return np.maximum(drawn, LEAST_SHARE * self.mean)


@dataclass(frozen=True, slots=True)
class Exponential:
    """Exponential spacings, those of joints at random (Priest and Hudson 1976): the mean [m].

    The least spacing is a twentieth of the mean; the rest is exponential, so that the mean holds.
    """

    mean: float

    def __post_init__(self) -> None:
        _check("Exponential", mean=self.mean)

    def draw(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return `count` spacings [m]."""
        return LEAST_SHARE * self.mean + generator.exponential((1 - LEAST_SHARE) * self.mean, count)


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """Lengths whose number falls as a power of the length: exponent above 1, least and greatest [m].

    The density of probability is proportional to ``length ** -exponent``: 2 to 3 in most mapped networks (Bonnet et al.
    2001).
    """

    exponent: float
    least: float
    greatest: float

    def __post_init__(self) -> None:
        checks = Checks("PowerLaw")
        if checks.positive("1", exponent=self.exponent) and self.exponent <= 1:
            checks.add(f"exponent = {self.exponent} must be above 1")
        if checks.positive(least=self.least, greatest=self.greatest) and self.greatest <= self.least:
            checks.add(f"greatest = {self.greatest} must be above least = {self.least}")
        checks.raise_faults()

    @property
    def mean(self) -> float:
        """Mean length [m]."""
        return self._moment(1) / self._moment(0)

    def _moment(self, power: int) -> float:
        k = power + 1 - self.exponent
        return math.log(self.greatest / self.least) if k == 0 else (self.greatest**k - self.least**k) / k

    def draw(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return `count` lengths [m], by inversion."""
        k = 1 - self.exponent
        share = generator.uniform(size=count)
        drawn: FloatArray = (self.least**k + share * (self.greatest**k - self.least**k)) ** (1 / k)
        return drawn


def places_across(
    thing: str, law: Spacing, middle: float, radius: float, start: float | None, generator: np.random.Generator
) -> FloatArray:
    """Return where the joints of a set cross the line across them [m], over `radius` to both sides of `middle`.

    Parameters
    ----------
    thing : str
        The set, for messages.
    law : Spacing
        Distances between neighbours.
    middle, radius : float [m]
        The part of the line.
    start : float, optional
        Place of one of the joints [m]; where not given `middle` for a constant spacing, an arbitrary place of others.
    generator : numpy.random.Generator
        Of the random numbers.

    Raises
    ------
    GeometryError
        If there would be more than two million of them.
    """
    if 2 * radius / law.mean > MOST_PLACES:
        raise GeometryError(
            f"{thing}: a spacing of {law.mean:g} m gives {2 * radius / law.mean:.3g} joints; "
            "give a wider spacing or a smaller model"
        )
    random = not isinstance(law, Constant)
    origin = middle + (generator.uniform(0, law.mean) if random else 0.0)
    origin = origin if start is None else start
    if not random:
        first, last = (math.ceil((middle + side * radius - origin) / law.mean) for side in (-1, 1))
        return (origin + np.arange(first, last) * law.mean).astype(np.float64)
    reach = abs(origin - middle) + radius
    count = int(2 * reach / law.mean) + 50
    up, down = (origin + sign * np.cumsum(law.draw(count, generator)) for sign in (1, -1))
    drawn: FloatArray = np.concatenate([down[::-1], [origin], up]).astype(np.float64)
    return drawn[np.abs(drawn - middle) <= radius]


def _check(name: str, **values: float) -> None:
    checks = Checks(name)
    checks.positive(**values)
    checks.raise_faults()
