"""Mohr and Coulomb's law: perfectly plastic, brittle, or softening over a slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.joint_laws.law import JointResponse, cut_to_strength
from bsm_mesh.model.joint_laws.reduction import above_peak, at_strength, reduced_angle, reduced_angle_or_none
from bsm_mesh.model.quantities import FRICTION, JOINT_COHESION, SLIP
from bsm_mesh.model.values import Rules, plain_numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class MohrCoulomb:
    """Mohr-Coulomb joint law: strength = cohesion + pressure * tan(friction).

    Without residual values slip takes nothing away: the joint is perfectly plastic, as in limit equilibrium and in the
    plain Coulomb joints of other programs. With one of them a contact falls to both at its first slip; with
    `softening_slip` cohesion and tan(friction) fall to them linearly while it slides that far. A contact that has
    opened, or that arose after the start, has the residual values too, and no cohesion where none is given.

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
    softening_slip : float or None [m]
        Slip, elastic part apart, over which strength falls to the residual values; None: at the first slip.

    Raises
    ------
    ModelError
        With every value out of range, a residual value above its peak, or a softening slip without one.

    Examples
    --------
    Strength at 1 MPa over 2 m: 2 (0.1 + tan(35)) MN/m.

    >>> import numpy as np
    >>> import bsm_mesh as bsm
    >>> law = bsm.MohrCoulomb(friction=35, cohesion=0.1e6)
    >>> law.respond(np.array([2e6]), np.zeros(1), np.array([2.0]), np.array([False])).strength.round(-2).tolist()
    [1600400.0]
    """

    friction: Annotated[float, FRICTION]
    cohesion: Annotated[float, JOINT_COHESION] = 0.0
    residual_friction: Annotated[float, FRICTION] | None = None
    residual_cohesion: Annotated[float, JOINT_COHESION] | None = None
    softening_slip: Annotated[float, SLIP] | None = None

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
        if self.softening_slip is not None and not self.is_brittle:
            faults.append(
                f"{rules.thing}: softening_slip = {self.softening_slip:g} m never acts: slip takes nothing away; give "
                "residual_friction, residual_cohesion or both, or leave softening_slip out"
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

    @property
    def wear_length(self) -> float | None:
        """Slip over which strength falls [m]; None: not little by little."""
        return self.softening_slip

    def respond(
        self,
        pressure: FloatArray,
        trial_shear: FloatArray,
        length: FloatArray,
        failed: BoolArray,
        slip_path: FloatArray | None = None,
    ) -> JointResponse:
        """Return the peak line, the residual one once failed, or one between them after the slip so far."""
        pressing = np.maximum(pressure, 0.0)
        peak, residual = np.tan(np.radians(self.friction)), np.tan(np.radians(self.residual))
        if self.cohesion == 0 and not self.is_brittle:  # the common case, in half the passes
            return cut_to_strength(trial_shear, peak * pressing, np.where(pressure > 0, peak, 0.0), failed.copy())
        left = self.residual_cohesion or 0.0
        if self.softening_slip is not None:
            worn = np.zeros(len(failed)) if slip_path is None else np.minimum(slip_path / self.softening_slip, 1.0)
            worn = np.where(failed, 1.0, worn)
            cohesion, slope = self.cohesion + (left - self.cohesion) * worn, peak + (residual - peak) * worn
            gone = (worn >= 1.0) & (trial_shear != 0.0)
            strength = cohesion * length + slope * pressing
            return cut_to_strength(trial_shear, strength, np.where(pressure > 0, slope, 0.0), failed | gone)
        strength = np.where(failed, left * length + residual * pressing, self.cohesion * length + peak * pressing)
        slope = np.where(pressure > 0, np.where(failed, residual, peak), 0.0)
        slipped = trial_shear > strength if self.is_brittle else np.zeros(len(failed), dtype=bool)
        return cut_to_strength(trial_shear, strength, slope, failed | slipped)

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the peak line."""
        slope = np.full((len(length), 1), np.tan(np.radians(self.friction)))
        return slope, self.cohesion * length[:, None]

    def reduced(self, factor: float) -> MohrCoulomb:
        """Return the law whose peak and residual lines are divided by a factor; see `ReducibleLaw`."""
        return at_strength(
            self,
            factor,
            friction=reduced_angle(self.friction, factor),
            cohesion=self.cohesion / factor,
            residual_friction=reduced_angle_or_none(self.residual_friction, factor),
            residual_cohesion=None if self.residual_cohesion is None else self.residual_cohesion / factor,
        )
