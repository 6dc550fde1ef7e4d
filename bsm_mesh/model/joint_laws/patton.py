"""Patton's bilinear law: asperities that are climbed, or sheared off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.joint_laws.law import JointResponse, cut_to_strength
from bsm_mesh.model.joint_laws.reduction import above_peak, at_strength, reduced_angle, reduced_angle_or_none
from bsm_mesh.model.quantities import DILATION, FRICTION, JOINT_COHESION
from bsm_mesh.model.values import Rules, plain_numbers

ROUNDING = 1e-9  # degrees: sums of angles round


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

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Patton(friction=30, dilation=10, cohesion=0.5e6, residual_friction=30).dilation
    10
    """

    friction: Annotated[float, FRICTION]
    dilation: Annotated[float, DILATION] = 0.0
    cohesion: Annotated[float, JOINT_COHESION] = 0.0
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
        if self.cohesion and self.cohesion > slopes * JOINT_COHESION.most:
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
        sheared_off = ~failed & ~on_first & (trial_shear > strength) & (self.cohesion + peak - residual > 0)
        return cut_to_strength(trial_shear, strength, slope, failed | sheared_off)

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return lines 1 and 2 (Wang Eqs. 4.1, 4.2)."""
        angles = np.tan(np.radians([self.friction + self.dilation, self.residual]))
        return np.tile(angles, (len(length), 1)), np.stack([np.zeros(len(length)), self.cohesion * length], axis=1)

    def reduced(self, factor: float) -> Patton:
        """Return the law whose lines 1 to 3 are divided by a factor; see `ReducibleLaw`."""
        friction = reduced_angle(self.friction, factor)
        return at_strength(
            self,
            factor,
            friction=friction,
            dilation=reduced_angle(self.friction + self.dilation, factor) - friction,
            cohesion=self.cohesion / factor,
            residual_friction=reduced_angle_or_none(self.residual_friction, factor),
        )
