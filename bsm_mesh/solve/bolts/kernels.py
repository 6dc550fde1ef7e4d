"""Kernels of bolts in the current geometry: forces on the blocks, and their tangent."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.bolts.chain import AT_LIMIT, chain_tangent, solve_chain


@njit()
def node_movements(
    position: FloatArray, block: IntArray, arm: FloatArray
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return how far the nodes moved, (n_nodes, 2), and the arms to them from the centroids."""
    moved, turned = np.empty((block.size, 2)), np.empty((block.size, 2))
    for k in range(block.size):
        b = block[k]
        cosine, sine = np.cos(position[b, 2]), np.sin(position[b, 2])
        turned[k, 0] = cosine * arm[k, 0] - sine * arm[k, 1]
        turned[k, 1] = sine * arm[k, 0] + cosine * arm[k, 1]
        moved[k, 0] = position[b, 0] + (turned[k, 0] - arm[k, 0])
        moved[k, 1] = position[b, 1] + (turned[k, 1] - arm[k, 1])
    return moved, turned


@njit()
def element_lines(
    point: FloatArray, moved: FloatArray, first: IntArray
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return length and unit direction of the elements from node `first` to the next, moved from where they were."""
    length, direction = np.empty(first.size), np.zeros((first.size, 2))
    for e in range(first.size):
        i = first[e]
        dx = (point[i + 1, 0] - point[i, 0]) + (moved[i + 1, 0] - moved[i, 0])
        dy = (point[i + 1, 1] - point[i, 1]) + (moved[i + 1, 1] - moved[i, 1])
        length[e] = np.hypot(dx, dy)
        if length[e] > 0.0:
            direction[e, 0], direction[e, 1] = dx / length[e], dy / length[e]
    return length, direction


@njit()
def solve_bolts(
    node_start: IntArray,
    alive: BoolArray,
    stiffness: FloatArray,
    stretch: FloatArray,
    yield_force: FloatArray,
    capacity: FloatArray,
    bond_stiffness: FloatArray,
    anchor: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return tension of every element and slip of every node."""
    tension, slip = np.zeros(stiffness.size), anchor.copy()
    for b, i, j in _runs(node_start, alive):
        run, nodes = slice(i - b, j - b), slice(i, j + 1)
        tension[run], slip[nodes] = solve_chain(
            stiffness[run], stretch[run], yield_force[b], capacity[nodes], bond_stiffness[nodes], anchor[nodes]
        )
    return tension, slip


@njit()
def _runs(node_start: IntArray, alive: BoolArray) -> IntArray:  # pragma: no cover - compiled
    """Return bolt, first and last node of every run of elements, (k, 3): a bolt is in parts where some are cut."""
    found, count = np.empty((alive.size, 3), np.int64), 0
    for b in range(node_start.size - 1):
        begin = node_start[b]
        for node in range(begin, node_start[b + 1]):
            if node == node_start[b + 1] - 1 or not alive[node - b]:
                if node > begin:
                    found[count, 0], found[count, 1], found[count, 2] = b, begin, node
                    count += 1
                begin = node + 1
    return found[:count]


@njit()
def add_bolt_forces(
    node_start: IntArray,
    block: IntArray,
    spacing: FloatArray,
    arm: FloatArray,
    direction: FloatArray,
    tension: FloatArray,
    total: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add force and moment of all elements on their blocks to `total` (n, 3) (Wang Eqs. 5.18, 5.20)."""
    for b in range(node_start.size - 1):
        for i in range(node_start[b], node_start[b + 1] - 1):
            e = i - b
            fx = tension[e] * direction[e, 0] / spacing[b]
            fy = tension[e] * direction[e, 1] / spacing[b]
            for node, sign in ((i, 1.0), (i + 1, -1.0)):
                k = block[node]
                total[k, 0] += sign * fx
                total[k, 1] += sign * fy
                total[k, 2] += sign * (arm[node, 0] * fy - arm[node, 1] * fx)


@njit()
def find_places(
    row_start: IntArray, column: IntArray, node_start: IntArray, block: IntArray
) -> IntArray:  # pragma: no cover - compiled
    """Return the place in the matrix of every pair of nodes of a bolt, bolt after bolt, row after row.

    -1 where the pattern, an upper triangle, does not have it.
    """
    count = 0
    for b in range(node_start.size - 1):
        count += (node_start[b + 1] - node_start[b]) ** 2
    place = np.empty(count, np.int32)
    k = 0
    for b in range(node_start.size - 1):
        for i in range(node_start[b], node_start[b + 1]):
            first, last = row_start[block[i]], row_start[block[i] + 1]
            for j in range(node_start[b], node_start[b + 1]):
                found = first + np.searchsorted(column[first:last], block[j])
                place[k] = found if found < last and column[found] == block[j] else -1
                k += 1
    return place


@njit()
def bolt_couplings(
    node_start: IntArray,
    alive: BoolArray,
    stiffness: FloatArray,
    stretch: FloatArray,
    yield_force: FloatArray,
    capacity: FloatArray,
    bond_stiffness: FloatArray,
    slip: FloatArray,
    tension: FloatArray,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the derivatives of the tensions of each bolt by the stretches of its elements.

    A matrix a bolt, row after row, bolt after bolt: slips are condensed out, so that all elements of a bolt are coupled
    where its bond gives way.
    """
    elements = np.diff(node_start) - 1
    start = np.concatenate((np.zeros(1, np.int64), np.cumsum(elements * elements)))
    coupling = np.zeros(start[-1])
    for b, i, j in _runs(node_start, alive):
        run, nodes, at = slice(i - b, j - b), slice(i, j + 1), i - node_start[b]
        element, bond = _moduli(
            stiffness[run],
            stretch[run],
            yield_force[b],
            capacity[nodes],
            bond_stiffness[nodes],
            slip[nodes],
            tension[run],
        )
        matrix = coupling[start[b] : start[b + 1]].reshape((elements[b], elements[b]))
        matrix[at : at + j - i, at : at + j - i] = chain_tangent(element, bond)
    return coupling


@njit()
def _moduli(
    stiffness: FloatArray,
    stretch: FloatArray,
    yield_force: float,
    capacity: FloatArray,
    bond_stiffness: FloatArray,
    slip: FloatArray,
    tension: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return the tangents of elements and bonds; an element on the verge of slack counts as taut."""
    n = slip.size
    element, bond = np.zeros(n - 1), np.zeros(n)
    for e in range(n - 1):
        trial = stiffness[e] * (stretch[e] + slip[e + 1] - slip[e])
        if trial >= 0.0 and tension[e] < yield_force * (1 - AT_LIMIT):
            element[e] = stiffness[e]
    for k in range(n):
        force = (tension[k] if k < n - 1 else 0.0) - (tension[k - 1] if k > 0 else 0.0)
        if abs(force) < capacity[k] * (1 - AT_LIMIT):
            bond[k] = bond_stiffness[k]
    return element, bond


@njit()
def couple(
    node_start: IntArray, coupling: FloatArray, stretch: FloatArray
) -> FloatArray:  # pragma: no cover - compiled
    """Return the tensions that stretches of the elements add, (n_elements,)."""
    tension = np.zeros_like(stretch)
    start = 0
    for b in range(node_start.size - 1):
        m, first = node_start[b + 1] - node_start[b] - 1, node_start[b] - b
        for e in range(m):
            for f in range(m):
                tension[first + e] += coupling[start + e * m + f] * stretch[first + f]
        start += m * m
    return tension


@njit()
def own_coupling(node_start: IntArray, coupling: FloatArray) -> FloatArray:  # pragma: no cover - compiled
    """Return the derivative of each element's tension by its own stretch, (n_elements,)."""
    own = np.empty(node_start[-1] - (node_start.size - 1))
    start = 0
    for b in range(node_start.size - 1):
        m, first = node_start[b + 1] - node_start[b] - 1, node_start[b] - b
        for e in range(m):
            own[first + e] = coupling[start + e * (m + 1)]
        start += m * m
    return own


@njit()
def add_bolt_tangent(
    node_start: IntArray,
    spacing: FloatArray,
    coupling: FloatArray,
    tension: FloatArray,
    arm: FloatArray,
    direction: FloatArray,
    length: FloatArray,
    place: IntArray,
    data: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add the tangent of minus the bolts' forces to the blocks `data` of the matrix (Wang Eq. 5.21).

    The turning of the elements under their tension (geometric stiffness) is included. The sum is symmetric.
    """
    at, start = 0, 0
    g = np.empty((2, 3))
    h = np.empty((2, 3))
    for b in range(node_start.size - 1):
        n = node_start[b + 1] - node_start[b]
        for e in range(n - 1):
            near = node_start[b] + e
            _length_derivatives(direction[near - b], arm[near], arm[near + 1], g)
            for f in range(n - 1):
                factor = coupling[start + e * (n - 1) + f] / spacing[b]
                if factor == 0.0:
                    continue
                _length_derivatives(direction[node_start[b] + f - b], arm[near - e + f], arm[near - e + f + 1], h)
                for side in range(2):
                    for other in range(2):
                        p = place[at + (e + side) * n + f + other]
                        if p >= 0:
                            for r in range(3):
                                for c in range(3):
                                    data[p, r, c] += factor * g[side, r] * h[other, c]
            if tension[near - b] > 0.0 and length[near - b] > 0.0:
                pull = tension[near - b] / spacing[b]
                _add_geometric(
                    pull,
                    length[near - b],
                    direction[near - b],
                    arm[near],
                    arm[near + 1],
                    place,
                    at + e * (n + 1),
                    n,
                    data,
                )
        at += n * n
        start += (n - 1) * (n - 1)


@njit()
def _length_derivatives(
    direction: FloatArray, near: FloatArray, far: FloatArray, g: FloatArray
) -> None:  # pragma: no cover - compiled
    """Put the derivatives of an element's length by the movements of its near and its far block into g (2, 3)."""
    dx, dy = direction[0], direction[1]
    g[0, 0], g[0, 1], g[0, 2] = -dx, -dy, -(near[0] * dy - near[1] * dx)
    g[1, 0], g[1, 1], g[1, 2] = dx, dy, far[0] * dy - far[1] * dx


@njit()
def _add_geometric(
    tension: float,
    length: float,
    direction: FloatArray,
    near: FloatArray,
    far: FloatArray,
    place: IntArray,
    at: int,
    n: int,
    data: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add tension times the second derivative of the element's length."""
    dx, dy = direction[0], direction[1]
    h = np.empty((2, 3))  # derivatives of the distance across the element
    h[0, 0], h[0, 1], h[0, 2] = dy, -dx, -(near[0] * dx + near[1] * dy)
    h[1, 0], h[1, 1], h[1, 2] = -dy, dx, far[0] * dx + far[1] * dy
    for side in range(2):
        for other in range(2):
            p = place[at + side * n + other]
            if p < 0:
                continue
            for r in range(3):
                for c in range(3):
                    data[p, r, c] += tension / length * h[side, r] * h[other, c]
            if side == other:
                a = near if side == 0 else far
                sign = 1.0 if side == 0 else -1.0
                data[p, 2, 2] += sign * tension * (a[0] * dx + a[1] * dy)
