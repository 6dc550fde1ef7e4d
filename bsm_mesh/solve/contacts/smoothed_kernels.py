"""Kernels of the smoothed contact laws: no kink at opening, none at slip.

With ``mu`` [N] pressure and opening of a contact have the product ``mu`` (Chen, Harker, Kanzow and Smale's
function), and its shear goes over into its strength the same way; for ``mu -> 0`` these are the laws themselves.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.compiled import njit


@njit(error_model="numpy")
def smooth_pressures(
    gap: FloatArray,
    tangential: FloatArray,
    offset: FloatArray,
    edge_length: FloatArray,
    edge_overhang: FloatArray,
    normal_stiffness: FloatArray,
    tension: FloatArray,
    mu: float,
) -> tuple[FloatArray, BoolArray]:  # pragma: no cover - compiled
    """Return pressure, and which corners are over the edge, (m,) each; the pressure is that of a corner over it."""
    m = gap.size
    pressure, in_range = np.empty(m), np.empty(m, np.bool_)
    for k in range(m):
        in_range[k] = (tangential[k] >= -edge_overhang[k]) & (tangential[k] <= edge_length[k] + edge_overhang[k])
        kn, bound = normal_stiffness[k], tension[k]
        if np.isinf(bound):
            pressure[k] = -kn * (gap[k] - offset[k])
            continue
        g = gap[k] - offset[k] - bound / kn
        root = np.sqrt(g * g + 4.0 * mu / kn)
        pressing = 0.5 * kn * (root - g) if g < 0.0 else 2.0 * mu / (root + g)
        pressure[k] = pressing - bound
    return pressure, in_range


@njit(error_model="numpy")
def smooth_shears(
    closed: BoolArray,
    pressure: FloatArray,
    trial: FloatArray,
    strength: FloatArray,
    dshear_dpressure: FloatArray,
    normal_stiffness: FloatArray,
    shear_stiffness: FloatArray,
    tension: FloatArray,
    mu: float,
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return shear (m,), and derivatives (5, m) of pressure and shear; open contacts have neither.

    The derivatives are: normal stiffness, shear force by gap, shear stiffness (as `fill_tangent` takes them), and
    pressure and shear by mu.
    """
    m = pressure.size
    shear, rates = np.zeros(m), np.zeros((5, m))
    for k in range(m):
        if not closed[k]:
            continue
        kn, ks = normal_stiffness[k], shear_stiffness[k]
        if np.isinf(tension[k]):
            rates[0, k] = kn
        else:
            pressing = pressure[k] + tension[k]
            root = pressing / kn + mu / pressing
            rates[0, k], rates[3, k] = pressing / root, 1.0 / root
        if np.isnan(trial[k]) or strength[k] == 0.0:
            continue
        if np.isinf(strength[k]):
            shear[k], rates[2, k] = trial[k], ks
            continue
        t, s, soft = trial[k], strength[k], 4.0 * mu * ks
        a, b = np.sqrt((t + s) * (t + s) + soft), np.sqrt((t - s) * (t - s) + soft)
        shear[k] = 2.0 * t * s / (a + b)
        by_strength = 0.5 * ((t + s) / a + (t - s) / b) * dshear_dpressure[k]
        rates[1, k] = -by_strength * rates[0, k]
        rates[2, k] = 0.5 * ks * ((t + s) / a - (t - s) / b)
        rates[4, k] = ks * (1.0 / a - 1.0 / b) + by_strength * rates[3, k]
    return shear, rates
