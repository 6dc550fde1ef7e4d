"""Kernels of the interior point method: complementarity products of contact and friction.

A contact has five unknowns, rows of a state (5, m): pressure, shear, opening, slip onwards and backwards. With its gap
``g``, trial shear ``T`` (elastic, from its history) and strength ``S`` at the pressure they obey

    opening = g + pressure / kn >= 0,          (pressure + tension) opening = barrier
    shear = T - ks (onwards - backwards),      onwards (S - shear) = backwards (S + shear) = barrier

which for ``barrier -> 0`` is the law: no force across an opening, no slip below the strength. A contact without a limit
of strength (kind `BONDED`) has linear springs.

Other rows: `now` (4, m): gap, trial shear, strength, strength per pressure; `spring` (3, m): kn, ks, tension;
`kind` (2, m): of pressure and of shear; `condensed` (5, m): as `condense` returns them.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit

ABSENT, LIMITED, BONDED = 0, 1, 2
BISECTIONS = 60


@njit(error_model="numpy")
def smoothed_pressure(
    now: FloatArray, spring: FloatArray, kind: IntArray, barrier: float
) -> FloatArray:  # pragma: no cover - compiled
    """Return a state (5, m) with pressure and opening that have their gap and the product `barrier`."""
    state = np.zeros((5, now.shape[1]))
    for k in range(now.shape[1]):
        kn, tension = spring[0, k], spring[2, k]
        if kind[0, k] == BONDED:
            state[0, k] = -kn * now[0, k]
        elif kind[0, k] == LIMITED:
            g = now[0, k] - tension / kn
            root = np.sqrt(g * g + 4.0 * barrier / kn)
            pressing = 0.5 * kn * (root - g) if g < 0.0 else 2.0 * barrier / (root + g)
            state[0, k] = pressing - tension
            state[2, k] = barrier / pressing
    return state


@njit(error_model="numpy")
def smoothed_shear(
    now: FloatArray, spring: FloatArray, kind: IntArray, barrier: float, state: FloatArray
) -> None:  # pragma: no cover - compiled
    """Set the shear and the slips of a state that have their trial shear and the products `barrier`."""
    for k in range(now.shape[1]):
        if kind[1, k] == BONDED:
            state[1, k] = now[1, k]
        elif kind[1, k] == LIMITED:
            strength = now[2, k]
            trial, soft = abs(now[1, k]) / strength, 2.0 * barrier * spring[1, k] / strength**2
            low, high = 0.0, 1.0
            for _ in range(BISECTIONS):
                part = 0.5 * (low + high)
                if trial - part - soft * part / max(1.0 - part * part, 1e-300) > 0.0:
                    low = part
                else:
                    high = part
            part = min(0.5 * (low + high), 1.0 - 1e-12)
            shear = part * strength if now[1, k] > 0.0 else -part * strength
            state[1, k] = shear
            state[3, k], state[4, k] = barrier / (strength - shear), barrier / (strength + shear)


@njit(error_model="numpy")
def condense(
    now: FloatArray, spring: FloatArray, kind: IntArray, state: FloatArray, barrier: float, second_order: FloatArray
) -> FloatArray:  # pragma: no cover - compiled
    """Return the linearised contacts with opening and slips eliminated (condensed), (5, m).

    Normal stiffness, shear force by gap, shear stiffness (as `fill_tangent` takes them), and the increments of
    pressure and shear without movement. `second_order` (3, m) is added to the target of the products.
    """
    condensed = np.zeros((5, now.shape[1]))
    for k in range(now.shape[1]):
        kn, ks, tension = spring[0, k], spring[1, k], spring[2, k]
        pressure, shear, opening = state[0, k], state[1, k], state[2, k]
        if kind[0, k] == BONDED:
            condensed[0, k], condensed[3, k] = kn, -kn * now[0, k] - pressure
        elif kind[0, k] == LIMITED:
            pressing = pressure + tension
            soft = opening + pressing / kn
            off = now[0, k] + pressure / kn - opening
            condensed[0, k] = pressing / soft
            condensed[3, k] = (barrier + second_order[0, k] - pressing * (opening + off)) / soft
        if kind[1, k] == BONDED:
            condensed[2, k], condensed[4, k] = ks, now[1, k] - shear
        elif kind[1, k] == LIMITED:
            left, right = now[2, k] - shear, now[2, k] + shear
            onwards, backwards = state[3, k] / left, state[4, k] / right
            slip = (barrier + second_order[1, k]) / left - state[3, k]
            slip -= (barrier + second_order[2, k]) / right - state[4, k]
            off = now[1, k] - ks * (state[3, k] - state[4, k]) - shear
            soft = 1.0 + ks * (onwards + backwards)
            dshear_dpressure = ks * (onwards - backwards) * now[3, k] / soft
            condensed[1, k], condensed[2, k] = -dshear_dpressure * condensed[0, k], ks / soft
            condensed[4, k] = (off - ks * slip) / soft + dshear_dpressure * condensed[3, k]
    return condensed


@njit(error_model="numpy")
def relative_movement(
    step: FloatArray, block_a: IntArray, block_b: IntArray, tangent: FloatArray, arm_a: FloatArray, arm_b: FloatArray
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return the changes of gap and tangential coordinate with a small movement of the blocks (n, 3)."""
    m = block_a.size
    gap, tangential = np.empty(m), np.empty(m)
    for k in range(m):
        a, b = block_a[k], block_b[k]
        ux = step[a, 0] - step[a, 2] * arm_a[k, 1] - step[b, 0] + step[b, 2] * arm_b[k, 1]
        uy = step[a, 1] + step[a, 2] * arm_a[k, 0] - step[b, 1] - step[b, 2] * arm_b[k, 0]
        tangential[k] = ux * tangent[k, 0] + uy * tangent[k, 1]
        gap[k] = ux * tangent[k, 1] - uy * tangent[k, 0]
    return gap, tangential


@njit(error_model="numpy")
def increments(
    now: FloatArray,
    spring: FloatArray,
    kind: IntArray,
    state: FloatArray,
    condensed: FloatArray,
    barrier: float,
    second_order: FloatArray,
    gap: FloatArray,
    tangential: FloatArray,
) -> tuple[FloatArray, float]:  # pragma: no cover - compiled
    """Return the change of the state (5, m) with a movement, and its largest part that keeps all products positive."""
    change = np.zeros_like(state)
    largest = np.inf
    for k in range(gap.size):
        pressure, shear = state[0, k], state[1, k]
        dp = condensed[3, k] - condensed[0, k] * gap[k]
        df = condensed[4, k] + condensed[1, k] * gap[k] + condensed[2, k] * tangential[k]
        change[0, k], change[1, k] = dp, df
        if kind[0, k] == LIMITED:
            change[2, k] = gap[k] + dp / spring[0, k] + now[0, k] + pressure / spring[0, k] - state[2, k]
            largest = min(largest, _part(pressure + spring[2, k], dp), _part(state[2, k], change[2, k]))
        if kind[1, k] == LIMITED:
            left, right = now[2, k] - shear, now[2, k] + shear
            d_left, d_right = now[3, k] * dp - df, now[3, k] * dp + df
            change[3, k] = (barrier + second_order[1, k] - state[3, k] * (left + d_left)) / left
            change[4, k] = (barrier + second_order[2, k] - state[4, k] * (right + d_right)) / right
            largest = min(largest, _part(left, d_left), _part(right, d_right))
            largest = min(largest, _part(state[3, k], change[3, k]), _part(state[4, k], change[4, k]))
    return change, largest


@njit(forceinline=True)
def _part(value: float, change: float) -> float:  # pragma: no cover - compiled
    """Return the part of a change that brings a positive value to zero."""
    return -value / change if change < 0.0 else np.inf


@njit(error_model="numpy")
def mean_product(
    now: FloatArray, spring: FloatArray, kind: IntArray, state: FloatArray, change: FloatArray, part: float
) -> float:  # pragma: no cover - compiled
    """Return the mean complementarity product after a part of a change: the barrier of that state."""
    total, count = 0.0, 0
    for k in range(now.shape[1]):
        if kind[0, k] == LIMITED:
            total += (state[0, k] + spring[2, k] + part * change[0, k]) * (state[2, k] + part * change[2, k])
            count += 1
        if kind[1, k] == LIMITED:
            dshear_dpressure = now[3, k] * change[0, k]
            left = now[2, k] - state[1, k] + part * (dshear_dpressure - change[1, k])
            right = now[2, k] + state[1, k] + part * (dshear_dpressure + change[1, k])
            total += (state[3, k] + part * change[3, k]) * left + (state[4, k] + part * change[4, k]) * right
            count += 2
    return total / max(count, 1)
