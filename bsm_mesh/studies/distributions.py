"""How a number scatters: distributions by the numbers an engineer knows, cut off at bounds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import nearest, raise_faults

LEAST_PROBABILITY = 1e-6  # between the bounds; with less there, quantiles are rounding
EULER = 0.5772156649015329

NEEDS = {
    "normal": ("mean", "deviation"),
    "lognormal": ("mean", "deviation"),
    "uniform": ("lower", "upper"),
    "triangular": ("lower", "mode", "upper"),
    "beta": ("mean", "deviation", "lower", "upper"),
    "exponential": ("mean",),
    "gamma": ("mean", "deviation"),
    "weibull": ("mean", "deviation"),
    "gumbel": ("mean", "deviation"),
}
POSITIVE = ("lognormal", "exponential", "gamma", "weibull")  # the families whose mean must be above 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """A distribution of numbers.

    Attributes
    ----------
    family : str
        Of `NEEDS`, which names the parameters of each.
    mean, deviation : float or None
        Mean and standard deviation of the number itself (of a lognormal one too), before bounds cut it off.
    mode : float or None
        The commonest value, of a triangular distribution.
    lower, upper : float or None
        Least and greatest value. Of the families that do not take them they cut it off: the rest is spread over the
        rest in its own shape.

    Raises
    ------
    ModelError
        If something is missing, does not belong to the family, or does not fit together.
    """

    family: str
    mean: float | None = None
    deviation: float | None = None
    mode: float | None = None
    lower: float | None = None
    upper: float | None = None

    def __post_init__(self) -> None:
        if self.family not in NEEDS:
            raise_faults([f"distribution '{self.family}' is not known{nearest(self.family, NEEDS)}"])
        needed = NEEDS[self.family]
        faults = [f"distribution '{self.family}' needs the key '{name}'" for name in needed if self._of(name) is None]
        known = {*needed, "lower", "upper"}
        faults += [
            f"distribution '{self.family}' has no '{name}'; it takes {', '.join(needed)}; remove it"
            for name in ("mean", "deviation", "mode")
            if name not in known and self._of(name) is not None
        ]
        raise_faults(faults)
        raise_faults(self._misfits())
        if math.nextafter(self._share()[1], 0) - self._share()[0] < LEAST_PROBABILITY:
            raise_faults([f"the bounds {self._bounds()} leave nothing of the distribution '{self.family}'; widen them"])

    def at(self, probability: FloatArray) -> FloatArray:
        """Return the values that are not exceeded with given probabilities, each in (0, 1), of the same shape."""
        low, high = self._share()
        values = np.asarray(self._frozen().ppf(low + probability * (high - low)), dtype=np.float64)
        lower, upper = self._bounds()
        within: FloatArray = np.clip(values, lower, upper)  # rounding
        return within

    def _of(self, name: str) -> float | None:
        value: float | None = getattr(self, name)
        return value

    def _bounds(self) -> tuple[float, float]:
        lower = -math.inf if self.lower is None else self.lower
        return lower, math.inf if self.upper is None else self.upper

    def _share(self) -> tuple[float, float]:
        """Return the probabilities at both bounds."""
        frozen, (lower, upper) = self._frozen(), self._bounds()
        return float(frozen.cdf(lower)), float(frozen.cdf(upper))

    def _misfits(self) -> list[str]:
        """Return what does not fit together, a sentence each."""
        lower, upper = self._bounds()
        if not lower < upper:
            return [f"lower = {lower:g} must be less than upper = {upper:g}"]
        if self.deviation is not None and not self.deviation > 0:
            return [f"deviation = {self.deviation:g} must be above 0; for a value that does not vary leave the key out"]
        if self.family in POSITIVE and self.mean is not None and not self.mean > 0:
            return [f"mean = {self.mean:g} must be above 0 for the distribution '{self.family}'; take 'normal'"]
        for name, value in (("mode", self.mode), ("mean", self.mean if self.family == "beta" else None)):
            if value is not None and not lower <= value <= upper:
                return [f"{name} = {value:g} must lie between lower = {lower:g} and upper = {upper:g}"]
        if self.family == "beta":
            most = math.sqrt((self.mean - lower) * (upper - self.mean))  # type: ignore[operator]
            if self.deviation >= most:  # type: ignore[operator]
                return [f"deviation = {self.deviation:g} is too much between these bounds; it is less than {most:.4g}"]
        return []

    def _frozen(self) -> Any:
        """Return SciPy's distribution, without bounds that cut it off."""
        given = [self._of(name) for name in NEEDS[self.family]]
        return _MAKERS[self.family](*given)


def _normal(mean: float, deviation: float) -> Any:
    from scipy import stats

    return stats.norm(mean, deviation)


def _lognormal(mean: float, deviation: float) -> Any:
    from scipy import stats

    variance = math.log1p((deviation / mean) ** 2)  # of the logarithm
    return stats.lognorm(math.sqrt(variance), scale=mean * math.exp(-variance / 2))


def _uniform(lower: float, upper: float) -> Any:
    from scipy import stats

    return stats.uniform(lower, upper - lower)


def _triangular(lower: float, mode: float, upper: float) -> Any:
    from scipy import stats

    return stats.triang((mode - lower) / (upper - lower), lower, upper - lower)


def _beta(mean: float, deviation: float, lower: float, upper: float) -> Any:
    from scipy import stats

    width = upper - lower
    middle = (mean - lower) / width
    size = middle * (1 - middle) * (width / deviation) ** 2 - 1
    return stats.beta(middle * size, (1 - middle) * size, lower, width)


def _exponential(mean: float) -> Any:
    from scipy import stats

    return stats.expon(scale=mean)


def _gamma(mean: float, deviation: float) -> Any:
    from scipy import stats

    return stats.gamma((mean / deviation) ** 2, scale=deviation**2 / mean)


def _weibull(mean: float, deviation: float) -> Any:
    from scipy import optimize, special, stats

    def excess(shape: float) -> float:  # of the logarithm of 1 + the squared coefficient of variation
        log_square = special.gammaln(1 + 2 / shape) - 2 * special.gammaln(1 + 1 / shape)
        return float(log_square - math.log1p((deviation / mean) ** 2))

    shape = float(optimize.brentq(excess, 0.05, 1e4, xtol=1e-12))
    return stats.weibull_min(shape, scale=mean / special.gamma(1 + 1 / shape))


def _gumbel(mean: float, deviation: float) -> Any:
    from scipy import stats

    scale = deviation * math.sqrt(6) / math.pi
    return stats.gumbel_r(mean - EULER * scale, scale)


_MAKERS: dict[str, Callable[..., Any]] = {
    "normal": _normal,
    "lognormal": _lognormal,
    "uniform": _uniform,
    "triangular": _triangular,
    "beta": _beta,
    "exponential": _exponential,
    "gamma": _gamma,
    "weibull": _weibull,
    "gumbel": _gumbel,
}
