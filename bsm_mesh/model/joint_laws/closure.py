"""Hyperbolic closure of a joint: the nearer to its limit, the stiffer.

Goodman (1976), Methods of Geological Engineering in Discontinuous Rocks; Bandis, Lumsden and Barton (1983), Int. J.
Rock Mech. Min. Sci. 20, 249-268: ``s = Kni v / (1 - v / vm)`` under a stress s, with the stiffness Kni without stress
and the greatest closure vm. Unloading goes back on the same curve.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray

NEAREST = 0.99  # of the closure limit: nearer to it the hyperbola continues as its tangent


def pressure_at(
    overlap: FloatArray, stiffness: FloatArray, limit: FloatArray, compliance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return pressure [N/m] and its derivative [N/m2] of joints in series with rock, closed by an overlap.

    Parameters
    ----------
    overlap : (h,) float64 [m]
        Closure of joint and rock together; below 0, in tension, the joint is as stiff as without stress.
    stiffness : (h,) float64 [N/m2]
        Stiffness of the joint without stress, times its length.
    limit : (h,) float64 [m]
        Greatest closure of the joint.
    compliance : (h,) float64 [m2/N]
        Of the rock on both sides; 0: rigid.
    """
    closing = np.maximum(overlap, 0.0)
    most = stiffness * limit * NEAREST / (1 - NEAREST)
    end = compliance * most + NEAREST * limit
    inside = np.minimum(closing, end)
    # The pressure P solves  c = f P + P v / (A v + P).
    b = limit * (1 + compliance * stiffness) - inside
    root = np.sqrt(b**2 + 4 * compliance * stiffness * limit * inside)
    pressure = 2 * stiffness * limit * inside / (b + root)
    derivative = 1 / (compliance + stiffness * limit**2 / (stiffness * limit + pressure) ** 2)
    pressure = pressure + derivative * (closing - inside)
    in_tension = 1 / (compliance + 1 / stiffness)
    return np.where(overlap > 0, pressure, in_tension * overlap), np.where(overlap > 0, derivative, in_tension)


def overlap_at(pressure: FloatArray, stiffness: FloatArray, limit: FloatArray, compliance: FloatArray) -> FloatArray:
    """Return the overlap (h,) [m] under pressures (h,) [N/m]; the inverse of `pressure_at`."""
    most = stiffness * limit * NEAREST / (1 - NEAREST)
    pressing = np.clip(pressure, 0.0, most)
    closure = compliance * pressing + pressing * limit / (stiffness * limit + pressing)
    last = compliance + stiffness * limit**2 / (stiffness * limit + most) ** 2
    beyond = np.maximum(pressure - most, 0.0) * last
    overlap: FloatArray = closure + beyond + np.minimum(pressure, 0.0) * (compliance + 1 / stiffness)
    return overlap


def energy_at(pressure: FloatArray, stiffness: FloatArray, limit: FloatArray, compliance: FloatArray) -> FloatArray:
    """Return the elastic energy [N] of joint and rock under pressures (h,) [N/m]: that of `overlap_at`, integrated.

    Under the hyperbola ``v = P vm / (A + P)``, A = stiffness times limit, the work is
    ``A vm (ln(1 + P / A) - P / (A + P))``.
    """
    full = stiffness * limit
    most = full * NEAREST / (1 - NEAREST)
    pressing = np.clip(pressure, 0.0, most)
    part = pressing / full
    joint = full * limit * (np.log1p(part) - part / (1 + part))
    last = compliance + limit * full / (full + most) ** 2
    beyond = np.maximum(pressure - most, 0.0)
    pulling = np.minimum(pressure, 0.0) ** 2 * (compliance + 1 / stiffness) / 2
    energy: FloatArray = compliance * pressing**2 / 2 + joint + last * beyond * (most + beyond / 2) + pulling
    return energy
