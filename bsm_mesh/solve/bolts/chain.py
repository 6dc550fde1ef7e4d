"""One bolt as a chain of elements: tensions and slips in exact equilibrium, by a finite algorithm.

A bolt is a chain of elements, each elastic between slack and yield, whose nodes are held by the rock up to the bond's
capacity. Its equilibrium is the minimum of a convex energy, where every bond force is within its capacity, every
tension follows from the stretch and the slips, and nodes slip where the capacity is reached: the limit of Wang's Eq.
5.13 when it is repeated. From the head on, the tension of an element is a rising, piecewise linear function of the
slip at its far node: a list of corners. A node adds its bond force at equal slip, an element its stretch at equal
tension. At the tip the tension is zero; going back gives all slips. Where all bonds are rigid and none gives way,
tensions follow from the stretch alone.

Slips are positive towards the tip; the bond force of a node is the difference of the tensions after and before it
(Wang Eq. 5.6), and acts on the rock towards the tip.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.compiled import njit

AT_LIMIT = 1e-12  # of a capacity, a yield force, E A, or the forces in a chain: nearer to a limit or to zero is there


@njit(allocates=True)
def solve_chain(
    stiffness: FloatArray,
    stretch: FloatArray,
    most_tension: float,
    capacity: FloatArray,
    bond_stiffness: FloatArray,
    anchor: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return the tension of every element and the slip of every node.

    Parameters
    ----------
    stiffness : (n - 1,) float64 [N/m]
        E A over length of every element.
    stretch : (n - 1,) float64 [m]
        Elongation of every element by the rock from zero tension, without slip.
    most_tension : float [N]
        Yield force of the steel.
    capacity : (n,) float64 [N]
        Greatest bond force of every node.
    bond_stiffness : (n,) float64 [N/m]
        Of the bond while it is elastic; infinite where it is rigid.
    anchor : (n,) float64 [m]
        Slip at zero force of each node's bond, from accepted steps.
    """
    n = capacity.size
    tension, slip = np.zeros(n - 1), anchor.copy()
    greatest = _trial(stiffness, stretch, most_tension, anchor, tension)
    bound = 2.0 * greatest  # no tension exceeds what the bonds impose where none of them gives way
    if greatest <= 0.0 or _holds(tension, capacity - AT_LIMIT * bound, bond_stiffness):
        return tension, slip
    most = min(most_tension, bound)
    w, t, size = np.empty((n, 2 * n)), np.empty((n, 2 * n)), np.zeros(n, np.int64)  # with the node's bond
    v, s, length = np.empty((n, 2 * n)), np.empty((n, 2 * n)), np.zeros(n, np.int64)  # after the element
    v[0, 0], s[0, 0], length[0] = anchor[0], 0.0, 1
    for i in range(n):
        m = length[i]
        size[i] = _add_bond(v[i, :m], s[i, :m], anchor[i], min(capacity[i], bound), bond_stiffness[i], w[i], t[i])
        if i < n - 1:
            m = size[i]
            length[i + 1] = _add_element(w[i, :m], t[i, :m], stiffness[i], stretch[i], most, v[i + 1], s[i + 1])
    m = size[n - 1]
    low, high = _level(w[n - 1, :m], t[n - 1, :m], 0.0)
    slip[n - 1] = min(max(anchor[n - 1], low), high)
    for i in range(n - 2, -1, -1):
        m = length[i + 1]
        found = _at(v[i + 1, :m], s[i + 1, :m], slip[i + 1])
        tension[i] = found
        elastic = slip[i + 1] - found / stiffness[i] + stretch[i]
        m = size[i]
        low, high = _level(w[i, :m], t[i, :m], found)
        slip[i] = _near_slip(anchor[i], low, high, elastic, found, most)
    _reset_rounding(tension, slip, capacity - AT_LIMIT * bound, bond_stiffness, anchor)
    return tension, slip


@njit()
def _trial(
    stiffness: FloatArray, stretch: FloatArray, most_tension: float, anchor: FloatArray, tension: FloatArray
) -> float:  # pragma: no cover - compiled
    """Set the tensions (n - 1,) that elements have if no node slips; return the greatest if no steel yields either."""
    greatest = 0.0
    for i in range(stretch.size):
        trial = stiffness[i] * (stretch[i] + anchor[i + 1] - anchor[i])
        greatest = max(greatest, trial)
        tension[i] = min(max(trial, 0.0), most_tension)
    return greatest


@njit()
def _holds(tension: FloatArray, below: FloatArray, bond_stiffness: FloatArray) -> bool:  # pragma: no cover - compiled
    """Return whether all bonds are rigid, and their forces under these tensions `below` that (n,): no node slips."""
    n = below.size
    for i in range(n):
        before = tension[i - 1] if i > 0 else 0.0
        after = tension[i] if i < n - 1 else 0.0
        if bond_stiffness[i] != np.inf or not abs(after - before) < below[i]:
            return False
    return True


@njit()
def _near_slip(
    anchor: float, low: float, high: float, elastic: float, tension: float, most: float
) -> float:  # pragma: no cover - compiled
    """Return the slip of an element's near node: `elastic`, unless it is slack or yields; then nearest to the anchor.

    `low` and `high` are the least and the greatest slip at which the tension before the element is in equilibrium.
    """
    if tension <= 0.0:
        return min(max(anchor, low, elastic), max(high, elastic))
    if tension >= most:
        return max(min(anchor, high, elastic), min(low, elastic))
    return elastic


@njit()
def _reset_rounding(
    tension: FloatArray, slip: FloatArray, below: FloatArray, bond_stiffness: FloatArray, anchor: FloatArray
) -> None:  # pragma: no cover - compiled
    """Reset the slip of nodes with an intact rigid bond, whose force is `below` that: rounding is no slip."""
    n = slip.size
    for i in range(n):
        before = tension[i - 1] if i > 0 else 0.0
        after = tension[i] if i < n - 1 else 0.0
        if bond_stiffness[i] == np.inf and abs(after - before) < below[i]:
            slip[i] = anchor[i]


@njit()
def _at(w: FloatArray, t: FloatArray, x: float) -> float:  # pragma: no cover - compiled
    """Return the value at x of the function with the corners (w, t), constant beyond its ends."""
    n = w.size
    if x <= w[0]:
        return float(t[0])
    if x >= w[n - 1]:
        return float(t[n - 1])
    i = np.searchsorted(w, x)
    return float(t[i - 1] + (t[i] - t[i - 1]) * (x - w[i - 1]) / (w[i] - w[i - 1]))


@njit()
def _level(w: FloatArray, t: FloatArray, value: float) -> tuple[float, float]:  # pragma: no cover - compiled
    """Return the least and the greatest slip at which the rising function has a value within its range."""
    n = w.size
    low, high = -np.inf, np.inf
    if t[0] < value:
        i = 1
        while i < n - 1 and t[i] < value:
            i += 1
        low = w[i] if t[i] <= value else w[i - 1] + (w[i] - w[i - 1]) * (value - t[i - 1]) / (t[i] - t[i - 1])
    if t[n - 1] > value:
        i = n - 2
        while i > 0 and t[i] > value:
            i -= 1
        high = w[i] if t[i] >= value else w[i] + (w[i + 1] - w[i]) * (value - t[i]) / (t[i + 1] - t[i])
    return low, high


@njit()
def _add_bond(
    v: FloatArray, s: FloatArray, anchor: float, capacity: float, stiffness: float, w: FloatArray, t: FloatArray
) -> int:  # pragma: no cover - compiled
    """Put the corners of the tension after the node into (w, t): that before it plus the bond force. Return how many.

    The two corners of the bond's own law are new; where it is rigid they are at one slip, one above the other.
    """
    reach = 0.0 if stiffness == np.inf else capacity / stiffness
    left, right = anchor - reach, anchor + reach
    count, i, n = 0, 0, v.size
    while i < n and v[i] < left:
        w[count], t[count] = v[i], s[i] - capacity
        count += 1
        i += 1
    w[count], t[count] = left, _at(v, s, left) - capacity
    count += 1
    while i < n and v[i] <= right:
        if left < v[i] < right:
            w[count], t[count] = v[i], s[i] + stiffness * (v[i] - anchor)
            count += 1
        i += 1
    w[count], t[count] = right, _at(v, s, right) + capacity
    count += 1
    while i < n:
        w[count], t[count] = v[i], s[i] + capacity
        count += 1
        i += 1
    return count


@njit()
def _add_element(
    w: FloatArray, t: FloatArray, stiffness: float, stretch: float, most: float, v: FloatArray, s: FloatArray
) -> int:  # pragma: no cover - compiled
    """Put the corners of the tension against the slip at the element's far node into (v, s). Return how many."""
    n = w.size
    top = min(most, t[n - 1])
    left = _level(w, t, 0.0)[1] if t[n - 1] > 0.0 else w[n - 1]
    v[0], s[0] = left - stretch, 0.0
    count = 1
    if top <= 0.0:
        return count
    for i in range(n):
        if 0.0 < t[i] < top and w[i] >= left:
            v[count], s[count] = w[i] + t[i] / stiffness - stretch, t[i]
            count += 1
    right = _level(w, t, top)[0]
    v[count], s[count] = right + top / stiffness - stretch, top
    return count + 1


@njit(allocates=True)
def chain_tangent(stiffness: FloatArray, bond_stiffness: FloatArray) -> FloatArray:  # pragma: no cover - compiled
    """Return the derivatives of all tensions by all stretches, (n - 1, n - 1), slips condensed out.

    Parameters
    ----------
    stiffness : (n - 1,) float64 [N/m]
        Tangent of every element: 0 where it is slack or yields.
    bond_stiffness : (n,) float64 [N/m]
        Tangent of every bond: infinite where it is rigid and holds, 0 where it slips.

    Notes
    -----
    Slips obey ``M dw = -G^T k d(stretch)``, tensions ``dT = k (d(stretch) + G dw)``; M is tridiagonal and positive
    semi-definite, and a zero pivot belongs to a node that nothing holds and nothing pulls.
    """
    n = bond_stiffness.size
    pivot, factor, dw = np.empty(n), np.zeros(n), np.empty(n)
    result = np.zeros((n - 1, n - 1))
    for i in range(n):
        before = stiffness[i - 1] if i > 0 else 0.0
        after = stiffness[i] if i < n - 1 else 0.0
        if bond_stiffness[i] == np.inf:
            pivot[i] = np.inf
            continue
        full = before + after + bond_stiffness[i]
        factor[i] = 0.0 if i == 0 or pivot[i - 1] == np.inf or pivot[i - 1] == 0.0 else before / pivot[i - 1]
        pivot[i] = full - factor[i] * before
        if pivot[i] <= 1e-14 * full:
            pivot[i] = 0.0
    for e in range(n - 1):
        if stiffness[e] == 0.0:
            continue
        for i in range(n):  # right side: the element pulls its near node on, its far node back
            pull = stiffness[e] if i == e else (-stiffness[e] if i == e + 1 else 0.0)
            dw[i] = pull + (factor[i] * dw[i - 1] if i > 0 else 0.0)
            if pivot[i] == np.inf:
                dw[i] = 0.0
        for i in range(n - 1, -1, -1):
            if pivot[i] == np.inf or pivot[i] == 0.0:
                dw[i] = 0.0
                continue
            after = stiffness[i] if i < n - 1 else 0.0
            dw[i] = (dw[i] + (after * dw[i + 1] if i < n - 1 else 0.0)) / pivot[i]
        for j in range(n - 1):
            own = 1.0 if j == e else 0.0
            result[j, e] = stiffness[j] * (own + dw[j + 1] - dw[j])
    return result
