"""Joint laws: how much shear a contact bears under its pressure, and what it remembers.

A law is one small frozen class with `respond`: old state in; shear, tangent and new state out, vectorised over
contacts. It sees numbers, not the model. Evaluating it changes nothing; only an accepted step keeps a new state.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.values import Rules, plain_numbers


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
        New state: asperities sheared off, cohesion lost. Stays true.
    """

    shear: FloatArray
    by_pressure: FloatArray
    strength: FloatArray
    sticking: BoolArray
    failed: BoolArray


class JointLaw(Protocol):
    """A law for the shear force of contacts."""

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
        Friction angle once the asperities are sheared off; None: `friction`.
    """

    friction: float
    dilation: float = 0.0
    cohesion: float = 0.0
    residual_friction: float | None = None

    def __post_init__(self) -> None:
        rules = Rules("law 'patton'")
        rules.number("friction", self.friction, "degrees", least=0, below=90)
        rules.number("dilation", self.dilation, "degrees", least=0, below=90)
        if not rules.faults and self.dilation > 0:
            rules.number("friction + dilation", self.friction + self.dilation, "degrees", below=90)
        rules.number("cohesion", self.cohesion, "Pa", least=0)
        rules.number("residual_friction", self.residual_friction, "degrees", least=0, below=90, optional=True)
        raise_faults(rules.faults)
        plain_numbers(self)

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


@dataclass(frozen=True, slots=True, kw_only=True)
class MohrCoulomb:
    """Mohr-Coulomb joint law: strength = cohesion + pressure * tan(friction).

    Attributes
    ----------
    friction : float [degrees]
        Friction angle.
    cohesion : float [Pa]
        Cohesion, lost once the joint has slipped or opened.
    residual_friction : float or None [degrees]
        Friction angle after that; None: `friction`.
    """

    friction: float
    cohesion: float = 0.0
    residual_friction: float | None = None

    def __post_init__(self) -> None:
        rules = Rules("law 'mohr_coulomb'")
        rules.number("friction", self.friction, "degrees", least=0, below=90)
        rules.number("cohesion", self.cohesion, "Pa", least=0)
        rules.number("residual_friction", self.residual_friction, "degrees", least=0, below=90, optional=True)
        raise_faults(rules.faults)
        plain_numbers(self)

    @property
    def residual(self) -> float:
        """Residual friction angle [degrees]."""
        return self.friction if self.residual_friction is None else self.residual_friction

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the peak line, or the residual one once failed."""
        pressing = np.maximum(pressure, 0.0)
        peak, residual = np.tan(np.radians(self.friction)), np.tan(np.radians(self.residual))
        if self.cohesion == 0 and peak == residual:  # the common case, in half the passes
            return _slide(trial_shear, peak * pressing, np.where(pressure > 0, peak, 0.0), failed.copy())
        strength = np.where(failed, residual * pressing, self.cohesion * length + peak * pressing)
        slope = np.where(pressure > 0, np.where(failed, residual, peak), 0.0)
        return _slide(trial_shear, strength, slope, failed | (np.abs(trial_shear) > strength))


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
