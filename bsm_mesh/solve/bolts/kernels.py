"""Kernels of bolts in the current geometry: forces on the blocks, and their tangent."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.solve.bolts.chain import AT_LIMIT, chain_tangent, solve_chain


@njit(allocates=True)
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


@njit(allocates=True)
def element_lines(
    point: FloatArray, moved: FloatArray, first: IntArray
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return length and unit direction of the elements from node `first` to the next, moved from where they were."""
    coordinates = point.shape[1]
    length, direction = np.empty(first.size), np.zeros((first.size, coordinates))
    for e in range(first.size):
        i = first[e]
        for axis in range(coordinates):
            direction[e, axis] = (point[i + 1, axis] - point[i, axis]) + (moved[i + 1, axis] - moved[i, axis])
        length[e] = np.hypot(direction[e, 0], direction[e, 1])
        if coordinates > 2:
            length[e] = np.hypot(length[e], direction[e, 2])
        for axis in range(coordinates):
            direction[e, axis] = direction[e, axis] / length[e] if length[e] > 0.0 else 0.0
    return length, direction


@njit(allocates=True)
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


@njit(allocates=True)
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


@njit(allocates=True)
def add_bolt_forces(
    node_start: IntArray,
    block: IntArray,
    spacing: FloatArray,
    arm: FloatArray,
    direction: FloatArray,
    tension: FloatArray,
    total: FloatArray,
) -> None:  # pragma: no cover - compiled
    """Add force and moment of all elements on their blocks to `total` (n, axes) (Wang Eqs. 5.18, 5.20)."""
    push = np.empty(arm.shape[1])
    for b in range(node_start.size - 1):
        for i in range(node_start[b], node_start[b + 1] - 1):
            e = i - b
            for axis in range(push.size):
                push[axis] = tension[e] * direction[e, axis] / spacing[b]
            for node, sign in ((i, 1.0), (i + 1, -1.0)):
                add_action(sign, arm[node], push, total[block[node]])


@njit(nogil=True)
def add_action(
    sign: float, arm: FloatArray, force: FloatArray, total: FloatArray
) -> None:  # pragma: no cover - compiled
    """Add a force, or minus it, and its moment at an arm to the row (3,) or (6,) of a block."""
    n = arm.size
    for axis in range(n):
        total[axis] += sign * force[axis]
    if n == 2:
        total[2] += sign * (arm[0] * force[1] - arm[1] * force[0])
        return
    for u in range(3):
        v, w = (u + 1) % 3, (u + 2) % 3
        total[3 + u] += sign * (arm[v] * force[w] - arm[w] * force[v])


@njit(allocates=True)
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


@njit(allocates=True)
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


@njit(allocates=True)
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


@njit(allocates=True)
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


@njit(allocates=True)
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


@njit(allocates=True)
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
    at, start, axes = 0, 0, data.shape[1]
    g = np.empty((2, axes))
    h = np.empty((2, axes))
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
                            for r in range(axes):
                                for c in range(axes):
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
    """Put the derivatives of an element's length by the movements of its near and its far block into g (2, axes)."""
    g[:] = 0.0
    add_action(-1.0, near, direction, g[0])
    add_action(1.0, far, direction, g[1])


@njit(allocates=True)
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
    if direction.size > 2:
        _add_geometric_in_space(tension, length, direction, near, far, place, at, n, data)
        return
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


@njit(allocates=True)
def _add_geometric_in_space(
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
    """Add tension times the second derivative of the element's length by movements about instant axes.

    Across the element its ends are displaced by ``u + w x arm``; along it ``w x (w x arm) / 2`` is of second order.
    """
    across = np.zeros((2, 3, 6))  # derivatives of the displacement of either end across the element, far less near
    for side in range(2):
        arm, sign = (near, -1.0) if side == 0 else (far, 1.0)
        for u in range(3):
            v, w = (u + 1) % 3, (u + 2) % 3
            across[side, u, u] = sign
            across[side, u, 3 + v], across[side, u, 3 + w] = sign * arm[w], -sign * arm[v]
        for c in range(6):
            along = 0.0
            for u in range(3):
                along += direction[u] * across[side, u, c]
            for u in range(3):
                across[side, u, c] -= along * direction[u]
    for side in range(2):
        for other in range(2):
            p = place[at + side * n + other]
            if p < 0:
                continue
            for r in range(6):
                for c in range(6):
                    for u in range(3):
                        data[p, r, c] += tension / length * across[side, u, r] * across[other, u, c]
            if side == other:
                arm, sign = (near, -1.0) if side == 0 else (far, 1.0)
                work = arm[0] * direction[0] + arm[1] * direction[1] + arm[2] * direction[2]
                for u in range(3):
                    data[p, 3 + u, 3 + u] -= sign * tension * work
                    for v in range(3):
                        mean = (direction[u] * arm[v] + direction[v] * arm[u]) / 2
                        data[p, 3 + u, 3 + v] += sign * tension * mean
