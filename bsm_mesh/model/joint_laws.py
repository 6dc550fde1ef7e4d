"""Joint laws: how much shear a contact bears under its pressure, and what it remembers.

A law is one small frozen class with `respond`: old state in; shear, tangent and new state out, vectorised over
contacts. It sees numbers, not the model. Evaluating it changes nothing; only an accepted step keeps a new state.
That is all that any scheme asks of a law. Limit analysis asks for `StraightLaw.strength_lines` besides. A law that has
`reduced(factor)` too is asked for itself at another strength; of one without, all shear forces are divided
(`bsm_mesh.model.strength`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, Protocol, TypeVar, runtime_checkable

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import placed, raise_faults
from bsm_mesh.model.quantities import COHESION, DILATION, FRICTION, STRENGTH_FACTOR
from bsm_mesh.model.values import Rules, plain_numbers

OfLines = TypeVar("OfLines", "Patton", "MohrCoulomb")

ROUNDING = 1e-9  # degrees: sums of angles round


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointResponse:
    """What a law answers.

    Attributes
    ----------
    shear : (m,) float64 [N/m]
        Shear force.
    by_pressure : (m,) float64
        Derivative of the shear force by the pressure; 0 while sticking.
    strength : (m,) float64 [N/m]
        Greatest shear force at this pressure; infinite where there is no limit.
    sticking : (m,) bool
        Whether the shear force is the trial one.
    failed : (m,) bool
        New state: fallen to the residual strength. Stays true.
    """

    shear: FloatArray
    by_pressure: FloatArray
    strength: FloatArray
    sticking: BoolArray
    failed: BoolArray


class JointLaw(Protocol):
    """A law for the shear force of contacts: what every scheme asks of it."""

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the response of contacts.

        Those that do not touch come with neither pressure nor trial shear: that must leave their state as it is.

        Parameters
        ----------
        pressure : (m,) float64 [N/m]
            Normal force, compression positive; negative where the contact bears tension.
        trial_shear : (m,) float64 [N/m]
            Shear force if the contact stuck.
        length : (m,) float64 [m]
            Length that each contact stands for.
        failed : (m,) bool
            Old state.
        """


@runtime_checkable
class StraightLaw(JointLaw, Protocol):
    """A law whose strength is bounded by straight lines: what limit analysis asks of it besides."""

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return slope [-] and intercept [N/m] of k lines for contacts that have not failed, (m, k) each.

        The shear strength at a pressure p is the least of ``intercept + slope * p``. A curved strength has tangents,
        which lie above it, and lines through points that follow each other, which lie below it between them.

        Parameters
        ----------
        length : (m,) float64 [m]
            Length that each contact stands for.
        """


@runtime_checkable
class ReducibleLaw(JointLaw, Protocol):
    """A law that knows itself at another strength."""

    def reduced(self, factor: float) -> JointLaw:
        """Return the law with the tangent of every friction angle, and every cohesion, divided by a factor.

        Parameters
        ----------
        factor : float
            More than 1 weakens, less strengthens.
        """


@dataclass(frozen=True, slots=True)
class Elastic:
    """No limit of strength."""

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the trial shear."""
        whole = np.ones(len(pressure), dtype=bool)
        return JointResponse(
            shear=trial_shear,
            by_pressure=np.zeros_like(pressure),
            strength=np.full_like(pressure, np.inf),
            sticking=whole,
            failed=failed.copy(),
        )

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return no line."""
        return np.zeros((len(length), 0)), np.zeros((len(length), 0))

    def reduced(self, factor: float) -> Elastic:
        """Return the law itself: it has no strength to divide."""
        return self


@dataclass(frozen=True, slots=True, kw_only=True)
class Patton:
    """Patton's bilinear joint law (Wang Eqs. 4.1, 4.2, 4.8).

    Attributes
    ----------
    friction : float [degrees]
        Basic friction angle, to which `dilation` is added below the transition stress.
    dilation : float [degrees]
        Asperity angle i; strength only, no opening with slip.
    cohesion : float [Pa]
        Intercept of the second line.
    residual_friction : float or None [degrees]
        Friction angle of the second line, and once the asperities are sheared off; None: `friction`.

    Raises
    ------
    ModelError
        With every value out of range; where one of the two lines can never govern, so that a value given is without
        effect; where the residual friction exceeds the peak, `friction` + `dilation`.
    """

    friction: Annotated[float, FRICTION]
    dilation: Annotated[float, DILATION] = 0.0
    cohesion: Annotated[float, COHESION] = 0.0
    residual_friction: Annotated[float, FRICTION] | None = None

    def __post_init__(self) -> None:
        rules = Rules("law 'patton'")
        rules.numbers(self)
        if not rules.faults and self.dilation > 0:
            rules.number("friction + dilation", self.friction + self.dilation, FRICTION)
        raise_faults(rules.faults)
        raise_faults([f"{rules.thing}: {text}" for text in self._misfits()])
        plain_numbers(self)

    def _misfits(self) -> list[str]:
        """Return what does not fit together: of two lines each must govern at some pressure, or both be one."""
        peak, residual = self.friction + self.dilation, self.residual
        slopes = np.tan(np.radians(peak)) - np.tan(np.radians(residual))
        if residual > peak + ROUNDING:
            return [above_peak(residual, "friction + dilation", peak)]
        # With the lines crossing beyond any pressure in rock, or nowhere:
        if self.cohesion and self.cohesion > slopes * COHESION.most:
            return [
                f"cohesion = {self.cohesion:g} Pa never acts: line 1, friction + dilation = {peak:g} degrees, governs "
                "at every pressure; where cohesion carries shear from the start choose mohr_coulomb (bsm.MohrCoulomb), "
                "else give the dilation of the asperities, or a residual_friction below friction"
            ]
        if self.cohesion == 0 and peak > residual + ROUNDING:
            return [
                f"friction + dilation = {peak:g} degrees never acts: without cohesion line 2, residual friction = "
                f"{residual:g} degrees, governs at every pressure; give the cohesion of the asperities, or that "
                "friction alone; where friction falls with the first slip choose mohr_coulomb (bsm.MohrCoulomb)"
            ]
        return []

    @property
    def residual(self) -> float:
        """Residual friction angle [degrees]."""
        return self.friction if self.residual_friction is None else self.residual_friction

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the lower of lines 1 and 2, or line 3 once the asperities are sheared off (Wang 4.3.1)."""
        pressing = np.maximum(pressure, 0.0)
        peak, residual = np.tan(np.radians(self.friction + self.dilation)), np.tan(np.radians(self.residual))
        first, second = peak * pressing, self.cohesion * length + residual * pressing
        on_first = (first <= second) & ~failed
        strength = np.where(failed, residual * pressing, np.minimum(first, second))
        slope = np.where(pressure > 0, np.where(on_first, peak, residual), 0.0)
        sheared_off = ~failed & ~on_first & (np.abs(trial_shear) > strength) & (self.cohesion + peak - residual > 0)
        return _slide(trial_shear, strength, slope, failed | sheared_off)

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return lines 1 and 2 (Wang Eqs. 4.1, 4.2)."""
        angles = np.tan(np.radians([self.friction + self.dilation, self.residual]))
        return np.tile(angles, (len(length), 1)), np.stack([np.zeros(len(length)), self.cohesion * length], axis=1)

    def reduced(self, factor: float) -> Patton:
        """Return the law whose lines 1 to 3 are divided by a factor; see `ReducibleLaw`."""
        friction = _reduced_angle(self.friction, factor)
        return _reduced(
            self,
            factor,
            friction=friction,
            dilation=_reduced_angle(self.friction + self.dilation, factor) - friction,
            cohesion=self.cohesion / factor,
            residual_friction=_reduced_or_none(self.residual_friction, factor),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class MohrCoulomb:
    """Mohr-Coulomb joint law: strength = cohesion + pressure * tan(friction).

    Without residual values slip takes nothing away: the joint is perfectly plastic, as in limit equilibrium and in the
    plain Coulomb joints of other programs. With one of them a contact falls to both at its first slip. A contact that
    has opened, or that arose after the start, has the residual values too, and no cohesion where none is given.

    Attributes
    ----------
    friction : float [degrees]
        Friction angle.
    cohesion : float [Pa]
        Cohesion.
    residual_friction : float or None [degrees]
        Friction angle that is left; None: `friction`.
    residual_cohesion : float or None [Pa]
        Cohesion that is left; None: all of it after slip if `residual_friction` is not given either, else none.

    Raises
    ------
    ModelError
        With every value out of range, or a residual value above its peak.
    """

    friction: Annotated[float, FRICTION]
    cohesion: Annotated[float, COHESION] = 0.0
    residual_friction: Annotated[float, FRICTION] | None = None
    residual_cohesion: Annotated[float, COHESION] | None = None

    def __post_init__(self) -> None:
        rules = Rules("law 'mohr_coulomb'")
        rules.numbers(self)
        raise_faults(rules.faults)
        faults = []
        if self.residual > self.friction:
            faults.append(f"{rules.thing}: {above_peak(self.residual, 'friction', self.friction)}")
        left = self.residual_cohesion or 0.0
        if left > self.cohesion:
            faults.append(
                f"{rules.thing}: residual_cohesion = {left:g} Pa is above cohesion = {self.cohesion:g} Pa: a joint "
                "grows no stronger by failing; exchange them, or leave residual_cohesion out"
            )
        raise_faults(faults)
        plain_numbers(self)

    @property
    def residual(self) -> float:
        """Residual friction angle [degrees]."""
        return self.friction if self.residual_friction is None else self.residual_friction

    @property
    def is_brittle(self) -> bool:
        """Whether a contact fails by slip."""
        return self.residual_friction is not None or self.residual_cohesion is not None

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the peak line, or the residual one once failed."""
        pressing = np.maximum(pressure, 0.0)
        peak, residual = np.tan(np.radians(self.friction)), np.tan(np.radians(self.residual))
        if self.cohesion == 0 and peak == residual:  # the common case, in half the passes
            return _slide(trial_shear, peak * pressing, np.where(pressure > 0, peak, 0.0), failed.copy())
        left = self.residual_cohesion or 0.0
        strength = np.where(failed, left * length + residual * pressing, self.cohesion * length + peak * pressing)
        slope = np.where(pressure > 0, np.where(failed, residual, peak), 0.0)
        slipped = np.abs(trial_shear) > strength if self.is_brittle else np.zeros(len(failed), dtype=bool)
        return _slide(trial_shear, strength, slope, failed | slipped)

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the peak line."""
        slope = np.full((len(length), 1), np.tan(np.radians(self.friction)))
        return slope, self.cohesion * length[:, None]

    def reduced(self, factor: float) -> MohrCoulomb:
        """Return the law whose peak and residual lines are divided by a factor; see `ReducibleLaw`."""
        return _reduced(
            self,
            factor,
            friction=_reduced_angle(self.friction, factor),
            cohesion=self.cohesion / factor,
            residual_friction=_reduced_or_none(self.residual_friction, factor),
            residual_cohesion=None if self.residual_cohesion is None else self.residual_cohesion / factor,
        )


@dataclass(frozen=True, slots=True)
class Weaker:
    """The weaker of two laws at the pressure: two rocks that meet without a joint."""

    one: MohrCoulomb
    other: MohrCoulomb

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the response of the law that bears less."""
        a = self.one.respond(pressure, trial_shear, length, failed)
        b = self.other.respond(pressure, trial_shear, length, failed)
        first = np.abs(a.shear) <= np.abs(b.shear)
        return JointResponse(
            shear=np.where(first, a.shear, b.shear),
            by_pressure=np.where(first, a.by_pressure, b.by_pressure),
            strength=np.minimum(a.strength, b.strength),
            sticking=a.sticking & b.sticking,
            failed=np.where(first, a.failed, b.failed),
        )

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lines of both laws."""
        of_both = zip(self.one.strength_lines(length), self.other.strength_lines(length), strict=True)
        slope, intercept = (np.concatenate(pair, axis=1) for pair in of_both)
        return slope, intercept

    def reduced(self, factor: float) -> Weaker:
        """Return the weaker of both laws divided by a factor."""
        return Weaker(self.one.reduced(factor), self.other.reduced(factor))


def refuse_factor(factor: float) -> None:
    """Raise a `ModelError` for a factor by which no strength can be divided."""
    rules = Rules("reduced strength")
    rules.number("factor", factor, STRENGTH_FACTOR)
    raise_faults(rules.faults)


def _reduced_angle(angle: float, factor: float) -> float:
    """Return the angle whose tangent is that of an angle, divided by a factor [degrees]."""
    refuse_factor(factor)
    return angle if factor == 1 else math.degrees(math.atan(math.tan(math.radians(angle)) / factor))


def _reduced_or_none(angle: float | None, factor: float) -> float | None:
    return None if angle is None else _reduced_angle(angle, factor)


def _reduced(law: OfLines, factor: float, **strength: Any) -> OfLines:
    """Return a law with other values; where one is out of range, say by what its strength was divided."""
    with placed(f"strength divided by {factor:g}"):
        return replace(law, **strength)


def above_peak(residual: float, name: str, peak: float) -> str:
    """Return the sentence on a residual friction that exceeds the peak [degrees]."""
    return (
        f"residual_friction = {residual:g} degrees is above {name} = {peak:g} degrees: the joint would grow stronger "
        "by failing; give less, or leave it out"
    )


def _slide(trial: FloatArray, strength: FloatArray, slope: FloatArray, failed: BoolArray) -> JointResponse:
    """Return the trial shear cut to the strength (return mapping)."""
    sticking = np.abs(trial) <= strength
    return JointResponse(
        shear=np.where(sticking, trial, np.copysign(strength, trial)),
        by_pressure=np.where(sticking, 0.0, np.copysign(slope, trial)),
        strength=strength,
        sticking=sticking,
        failed=failed,
    )
