"""Barton and Bandis's law: roughness JRC, wall strength JCS, scale, and roughness that wears off with slip.

Strength after Barton and Choubey (1977), Rock Mechanics 10, 1-54; scale and displacement at the peak after Barton and
Bandis (1982), 23rd U.S. Symposium on Rock Mechanics, 739-760; roughness that is left behind the peak after Barton,
Bandis and Bakhtar (1985), Int. J. Rock Mech. Min. Sci. 22, 121-140.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import as_given, raise_faults
from bsm_mesh.model.joint_laws.law import JointResponse, cut_to_strength
from bsm_mesh.model.quantities import JOINT_LENGTH, JRC, RESIDUAL_FRICTION, WALL_STRENGTH
from bsm_mesh.model.values import Rules, plain_numbers

STEEPEST = 70.0  # degrees: greatest angle of strength that Barton and Choubey take for design
SAMPLE = 0.1  # m: length of the samples that JRC and JCS are measured on
WORN = np.array([(1.0, 1.0), (2.0, 0.85), (4.0, 0.70), (10.0, 0.50), (100.0, 0.0)])
"""Displacement over that at the peak, and the part of JRC that is left behind it (Barton, Bandis and Bakhtar 1985)."""
LEAST = 1e-5  # of JCS: stress below which strength is bounded by the steepest line and one tangent alone
TANGENTS = 16  # straight lines for limit analysis


@dataclass(frozen=True, slots=True, kw_only=True)
class BartonBandis:
    """Barton-Bandis joint law: strength = s tan(residual_friction + JRCn log10(JCSn / s)) at an effective stress s.

    JRCn = JRC (L / 0.1 m)^(-0.02 JRC) and JCSn = JCS (L / 0.1 m)^(-0.03 JRC) are those of a joint of length L. The
    angle is 70 degrees at most, and not below the residual one. A contact that has opened, or that arose after the
    start, has the residual friction.

    Attributes
    ----------
    jrc : float
        Joint roughness coefficient of a sample 0.1 m long, 0 to 20.
    jcs : float [Pa]
        Joint wall compressive strength of such a sample.
    residual_friction : float [degrees]
        Residual friction angle.
    joint_length : float [m]
        Length of the joint, or of the blocks along it; 0.1 m: as the sample.
    roughness_wears : bool
        Whether slip beyond the peak wears roughness off as Barton et al. (1985) have it, to nothing at 100 times the
        displacement at the peak. If not, slip takes nothing away.

    Raises
    ------
    ModelError
        With every value out of range.

    Examples
    --------
    Of a joint 1 m long JRC 8 is 8 (1 / 0.1)^(-0.16).

    >>> import bsm_mesh as bsm
    >>> law = bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28, joint_length=1.0)
    >>> law.jrc, law.residual_friction
    (8, 28)
    """

    jrc: Annotated[float, JRC]
    jcs: Annotated[float, WALL_STRENGTH]
    residual_friction: Annotated[float, RESIDUAL_FRICTION]
    joint_length: Annotated[float, JOINT_LENGTH] = SAMPLE
    roughness_wears: bool = False

    def __post_init__(self) -> None:
        rules = Rules("law 'barton_bandis'")
        rules.numbers(self)
        if not isinstance(self.roughness_wears, bool | np.bool_):
            rules.faults.append(
                f"{rules.thing}: roughness_wears = {as_given(self.roughness_wears)} must be true or false"
            )
        raise_faults(rules.faults)
        plain_numbers(self)

    @property
    def roughness(self) -> float:
        """JRCn (Barton and Bandis 1982, Eq. 6)."""
        return float(self.jrc * (self.joint_length / SAMPLE) ** (-0.02 * self.jrc))

    @property
    def wall_strength(self) -> float:
        """JCSn [Pa] (Barton and Bandis 1982, Eq. 7)."""
        return float(self.jcs * (self.joint_length / SAMPLE) ** (-0.03 * self.jrc))

    @property
    def peak_displacement(self) -> float:
        """Shear displacement at the peak, L / 500 (JRCn / L)^0.33 with L in metres [m] (Barton and Bandis 1982)."""
        return float(self.joint_length / 500 * (self.roughness / self.joint_length) ** 0.33)

    @property
    def wear_length(self) -> float | None:
        """Displacement at the peak, behind which roughness wears off [m]; None: it does not."""
        return self.peak_displacement if self.roughness_wears and self.jrc > 0 else None

    def roughness_after(self, slip_path: FloatArray) -> FloatArray:
        """Return the mobilised JRC (m,) after slip (m,) [m] beyond the peak."""
        displacement = 1 + slip_path / self.peak_displacement  # the elastic part brings it to the peak
        left: FloatArray = self.roughness * np.interp(displacement, *WORN.T)
        return left

    def respond(
        self,
        pressure: FloatArray,
        trial_shear: FloatArray,
        length: FloatArray,
        failed: BoolArray,
        slip_path: FloatArray | None = None,
    ) -> JointResponse:
        """Return Barton's strength with the roughness that is left; residual friction once failed."""
        pressing = np.maximum(pressure, 0.0)
        wears = slip_path is not None and self.wear_length is not None
        rough = self.roughness_after(slip_path) if wears and slip_path is not None else self.roughness
        rough = np.where(failed, 0.0, rough)
        stress = np.maximum(pressing / length, np.finfo(float).tiny)
        above = rough * np.maximum(np.log10(self.wall_strength) - np.log10(stress), 0.0)
        curved = (above > 0.0) & (above < STEEPEST - self.residual_friction)
        angle = np.radians(np.minimum(self.residual_friction + above, STEEPEST))
        slope = np.tan(angle) - np.where(curved, np.radians(rough) / math.log(10.0) / np.cos(angle) ** 2, 0.0)
        strength = np.tan(angle) * pressing
        return cut_to_strength(trial_shear, strength, np.where(pressure > 0, slope, 0.0), failed.copy())

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the steepest line, and tangents: they lie above the strength at every pressure.

        The last of them is as steep as residual friction, for that is how steep the strength is beyond JCS.
        """
        last = math.tan(math.radians(self.residual_friction))
        bend = math.radians(self.roughness) / math.log(10.0)  # slope of the strength: tan a - bend (1 + tan^2 a)
        steepest = math.tan(math.radians(STEEPEST))
        if bend == 0.0:
            slopes, stresses = np.array([last]), np.zeros(1)
            return np.tile(slopes, (len(length), 1)), np.outer(length, stresses)
        room = 1 - 4 * bend * (bend + last)
        end = min((1 - math.sqrt(room)) / (2 * bend), steepest) if room >= 0 else steepest
        most = math.radians(min(self.residual_friction - self.roughness * math.log10(LEAST), STEEPEST))
        tangent = np.tan(np.linspace(most, min(math.atan(end), most), TANGENTS))
        degrees = np.degrees(np.arctan(tangent))
        stress = self.wall_strength * 10 ** (-(degrees - self.residual_friction) / self.roughness)
        slope = np.maximum(tangent - bend * (1 + tangent**2), last)  # the last one, but for rounding, is as steep
        slopes, intercepts = np.append(steepest, slope), np.append(0.0, stress * (tangent - slope))
        return np.tile(slopes, (len(length), 1)), np.outer(length, intercepts)
