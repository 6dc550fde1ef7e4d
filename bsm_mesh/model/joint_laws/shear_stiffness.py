"""Shear stiffness that grows with the normal stress, and what shear force is left where that falls.

By a power of the stress, ``ks = shear_stiffness (s / reference_stress)^m``, as UDEC's and 3DEC's continuously yielding
joint has it (Cundall and Lemos 1990); or such that the peak is reached after a displacement that no stress changes
(Goodman 1976), for Barton and Bandis's law ``ks = strength(s) / peak_displacement`` (Bandis, Lumsden and Barton 1983).

A stiffness that depends on the normal stress alone gives energy: sheared under a high stress and led back under a low
one, a joint returns more than it took. So the shear force falls with the stiffness as stress is taken off, and stays as
stress comes on (Elata and Berryman 1996; Agnolin and Roux 2007): with the energy ``T^2 / (2 ks)`` nothing is gained on
any path, and as stress is taken off the force is that of the stiffness there is, whatever came before.

References
----------
Elata & Berryman (1996), Mechanics of Materials 24, 229-240. Agnolin & Roux (2007), Phys. Rev. E 76, 061302.
Goodman (1976), Methods of Geological Engineering in Discontinuous Rocks. Cundall & Lemos (1990), Rockbursts and
Seismicity in Mines, 173-182. Bandis, Lumsden & Barton (1983), Int. J. Rock Mech. Min. Sci. 20, 249-268.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.joint_laws.barton_bandis import STEEPEST, BartonBandis
from bsm_mesh.model.joint_laws.law import JointLaw

REACH = 1e3  # times the reference stress, and a part of it: beyond both the stiffness is constant


class ShearCurve(NamedTuple):
    """Shear stiffness by the normal stress s: ``factor s^exponent tan(angle + roughness log10(wall / s))``.

    Attributes
    ----------
    factor : float [Pa/m / Pa^exponent]
        Its factor.
    exponent : float
        Of the stress.
    angle, roughness : float [degrees]
        Of Barton's strength; 45 and 0: the tangent is 1.
    wall : float [Pa]
        Strength of the walls.
    least, most : float [Pa]
        Stresses below and above which the stiffness is constant.
    """

    factor: float
    exponent: float
    angle: float
    roughness: float
    wall: float
    least: float
    most: float

    @classmethod
    def power(cls, stiffness: float, stress: float, exponent: float) -> ShearCurve:
        """Return the power law that has a stiffness [Pa/m] at a reference stress [Pa]."""
        factor = stiffness / stress**exponent
        return cls(factor, exponent, 45.0, 0.0, stress, stress / REACH, stress * REACH)

    @classmethod
    def barton(cls, law: BartonBandis, stress: float) -> ShearCurve:
        """Return Barton and Bandis's: the peak strength over the displacement at the peak."""
        reach = stress / REACH, stress * REACH
        return cls(1 / law.peak_displacement, 1.0, law.residual_friction, law.roughness, law.wall_strength, *reach)

    def at(self, stress: float) -> float:
        """Return the stiffness at a normal stress [Pa/m]."""
        return float(stiffness_at(np.array([stress]), np.array([self]))[0][0])


def barton_of(law: JointLaw | None) -> BartonBandis | None:
    """Return Barton and Bandis's law where a joint has it, at its strength or another; None: it has not."""
    own = getattr(law, "law", law)  # of one whose strength is divided; stiffness is not
    return own if isinstance(own, BartonBandis) else None


def stiffness_at(stress: FloatArray, curve: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shear stiffness [Pa/m] and its derivative [1/m] at stresses (h,) [Pa] by curves (h, 7) of `ShearCurve`."""
    factor, exponent, angle, roughness, wall, least, most = curve.T
    s = np.clip(stress, least, most)
    above = roughness * np.maximum(np.log10(wall / s), 0.0)
    curved = (above > 0.0) & (angle + above < STEEPEST)
    tangent = np.tan(np.radians(np.minimum(angle + above, STEEPEST)))
    turns = np.where(curved, np.radians(roughness) / math.log(10.0) * (1 + tangent**2), 0.0)
    by_stress = factor * s ** (exponent - 1) * (exponent * tangent - turns)
    return factor * s**exponent * tangent, np.where((stress > least) & (stress < most), by_stress, 0.0)


def stiffness_faults(
    shear_stiffness: float | None, exponent: float | None, stress: float | None, law: JointLaw | None
) -> list[str]:
    """Return the faults of how a joint's shear stiffness [Pa/m] grows, from a reference stress [Pa]."""
    if stress is None and exponent is None:
        return []
    if stress is None:
        return [
            f"shear_stiffness_exponent = {exponent:g}: at which normal stress is the joint as stiff as "
            "shear_stiffness? Give reference_stress"
        ]
    if shear_stiffness is not None and exponent is None:
        return [
            f"reference_stress = {stress:g} Pa never acts: shear_stiffness is constant; give shear_stiffness_exponent, "
            "or leave shear_stiffness out where barton_bandis gives it, or leave reference_stress out"
        ]
    if shear_stiffness is None and exponent is not None:
        return [
            f"shear_stiffness_exponent = {exponent:g} needs shear_stiffness, which the joint has at reference_stress"
        ]
    barton = barton_of(law)
    if shear_stiffness is None and barton is None:
        return [
            "reference_stress without shear_stiffness asks for the peak strength over the displacement at the peak, "
            "which the law barton_bandis knows; give that law, or shear_stiffness and shear_stiffness_exponent"
        ]
    if barton is not None and shear_stiffness is None and not barton.jrc > 0:
        return ["a joint without roughness has no displacement at the peak; give shear_stiffness, or jrc above 0"]
    return []
