"""Chapter 5 of the thesis: forces of bolts, their failure, and their part of the equations."""

from __future__ import annotations

import math

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.solve.algebra.block_matrix import whole_pattern
from bsm_mesh.solve.bolts.chain import solve_chain
from tests.scenes.models import installed_bolts
from tests.scenes.shapes import rectangle
from verification.case import Answer, Case
from verification.thesis_matrices import Array, matrix_b, vector_c

EXACT = 1e-12
ROW = bsm.Blocks.from_polygons([rectangle(i, 0, i + 1, 1) for i in range(3)], rock="rock")
LINE = {"start": (0.0, 0.2), "end": (3.0, 0.9), "diameter": 0.022}
EA = 200e9 * math.pi * 0.022**2 / 4
NODES = np.array([(0.0, 0.2), (1.5, 0.55), (3.0, 0.9)])  # head, middle of the second block's part, tip (5.3.2)
STIFFNESS = EA / np.hypot(*np.diff(NODES, axis=0).T)
ANGLE = math.degrees(math.atan2(0.7, 3.0))
SMALL = 1e-7  # m: the program's elongations are exact, the thesis's of first order


def end_anchored() -> Answer:
    """Compare tension of a bolt of stiffness K under stretches from slack to failure: by yield, and by anchorage."""
    stretch, exact, found = np.array([-1e-3, 0.0, 1e-4, 4e-4, 1e-2]), [], []
    for yields, anchors in ((5e4, 9e4), (9e4, 7e4)):
        for dl in stretch:
            tension = max(1e8 * dl, 0.0)
            exact.append(min(tension, yields, anchors))
            capacity = np.full(2, anchors)
            found.append(
                solve_chain(np.array([1e8]), np.array([dl]), yields, capacity, np.full(2, np.inf), np.zeros(2))[0][0]
            )
    return np.array(exact), np.array(found)


def axial_stiffness() -> Answer:
    """Compare stiffness of an end-anchored bolt, from anchor to anchor."""
    bolt = bsm.Bolt(kind="end_anchored", **LINE)
    found = installed_bolts([bolt], ROW, np.zeros((3, 3))).stiffness
    return np.array([EA / math.hypot(3.0, 0.7)]), found


def _grouted(size: float = SMALL, **keys: float) -> tuple[Array, object, object]:
    """Return displacements of three blocks, the grouted bolt through them, and its forces."""
    U = np.random.default_rng(55).normal(size=(3, 3)) * size
    U[:, 0] += np.arange(3) * 10 * size  # it is stretched everywhere
    installed = installed_bolts([bsm.Bolt(**LINE, **keys)], ROW, np.zeros((3, 3)))
    return U, installed, installed.evaluate(U)


def _tensions(U: Array) -> Array:
    """Return T = K {c}^T [D]ij {U}ij of both elements."""
    centroid, c = ROW.moments.centroid, vector_c(ANGLE)
    stretch = [c @ (matrix_b(centroid[k + 1], NODES[k + 1]) @ U[k + 1] - matrix_b(centroid[k], NODES[k]) @ U[k])
               for k in (0, 1)]  # fmt: skip
    return STIFFNESS * np.array(stretch)


def tensions() -> Answer:
    """Compare tensions of the elements of a grouted bolt, from the movements of the blocks that it passes."""
    U, _, at = _grouted()
    return _tensions(U), at.tension


def bond_forces() -> Answer:
    """Compare force on the rock at each node: the difference of the tensions beside it."""
    U, _, at = _grouted()
    T = _tensions(U)
    return np.diff(np.concatenate([[0.0], T, [0.0]])), at.bond_force


def forces_on_blocks() -> Answer:
    """Compare force and moment of a bolt on the centroids of the blocks."""
    U, _, at = _grouted()
    T, c, centroid = _tensions(U), vector_c(ANGLE), ROW.moments.centroid
    pull = [T[0], T[1] - T[0], -T[1]]
    return np.array([matrix_b(centroid[k], NODES[k]).T @ c * pull[k] for k in range(3)]), at.forces


def stiffness_matrix() -> Answer:
    """Compare [Kb] of both elements, summed into the matrix of the blocks; the program's is the thesis's times -1."""
    _, installed, at = _grouted()
    pattern = whole_pattern(3, *installed.pairs)
    data = np.zeros((len(pattern.column), 3, 3))
    installed.add_tangent(at, installed.places(pattern), data, turning=False)
    found = np.zeros((9, 9))
    for row in range(3):
        for p in range(pattern.row_start[row], pattern.row_start[row + 1]):
            found[3 * row : 3 * row + 3, 3 * pattern.column[p] : 3 * pattern.column[p] + 3] = data[p]
    exact, centroid, c = np.zeros((9, 9)), ROW.moments.centroid, vector_c(ANGLE)
    for k in (0, 1):
        both = np.hstack([-matrix_b(centroid[k], NODES[k]), matrix_b(centroid[k + 1], NODES[k + 1])])
        rows = np.r_[3 * k : 3 * k + 6]
        exact[np.ix_(rows, rows)] += STIFFNESS[k] * both.T @ np.outer(c, c) @ both
    return exact, found


def bond_strength() -> Answer:
    """Compare least of both interfaces, per length of bolt."""
    exact, found = [], []
    for steel, rock in ((2e6, 1e6), (1e6, 4e6)):
        exact.append(min(math.pi * 0.022 * steel, math.pi * 0.04 * rock))
        bolt = bsm.Bolt(**LINE, hole_diameter=0.04, bond_steel_grout=steel, bond_grout_rock=rock)
        found.append(bolt.bond_capacity)
    return np.array(exact), np.array(found)


def _swept(stiffness: Array, tension: Array, capacity: Array) -> Array:
    """Return the tensions after Eq. 5.13 at node after node, again and again, until nothing changes.

    A node that has slipped is let back as far as its bond can hold: Eq. 5.13 by itself only ever reduces.
    """
    n, T, slip = len(capacity), tension.copy(), np.zeros(len(capacity))
    for _ in range(100_000):
        greatest = 0.0
        for k in range(n):
            before, after = (stiffness[k - 1] if k else 0.0), (stiffness[k] if k < n - 1 else 0.0)
            S = (T[k] if k < n - 1 else 0.0) - (T[k - 1] if k else 0.0)  # Eq. 5.6
            without_slip = S + (before + after) * slip[k]
            excess = without_slip - np.clip(without_slip, -capacity[k], capacity[k])  # Eq. 5.8
            change = excess - (before + after) * slip[k]
            slip[k] = excess / (before + after)
            if k:
                T[k - 1] += before / (before + after) * change  # Eqs. 5.9 to 5.13
            if k < n - 1:
                T[k] -= after / (before + after) * change
            greatest = max(greatest, abs(change))
        if greatest < 1e-10 * np.abs(tension).max():
            break
    return T


def redistribution() -> Answer:
    """Compare bolts whose bond fails at random nodes: Eq. 5.13 repeated to its end."""
    rng, exact, found = np.random.default_rng(513), [], []
    for _ in range(20):
        n = int(rng.integers(3, 8))
        stiffness, stretch = 10 ** rng.uniform(7.8, 8.2, n - 1), rng.uniform(0, 2e-3, n - 1)
        capacity = 10 ** rng.uniform(3.5, 5.0, n)
        exact.append(_swept(stiffness, stiffness * stretch, capacity))
        found.append(solve_chain(stiffness, stretch, np.inf, capacity, np.full(n, np.inf), np.zeros(n))[0])
    return np.concatenate(exact), np.concatenate(found)


def least_energy() -> Answer:
    """Compare three equal elements whose middle one is asked for 300 kN, nodes of 10 kN: 10, 20, 10 kN."""
    from scipy.optimize import lsq_linear

    K, stretch, capacity = 1e8, np.array([0.0, 3e-3, 0.0]), np.full(4, 1e4)
    D = np.zeros((4, 3))  # bond forces of tensions, Eq. 5.6; least energy, slack variables for the bounds of the bond
    D[[0, 1, 2], [0, 1, 2]], D[[1, 2, 3], [0, 1, 2]] = 1.0, -1.0
    weight = 1e4
    A = np.vstack([np.hstack([np.eye(3), np.zeros((3, 4))]), weight * np.hstack([D, -np.eye(4)])])
    b = np.concatenate([K * stretch, np.zeros(4)])
    bounds = (np.r_[np.zeros(3), -capacity], np.r_[np.full(3, np.inf), capacity])
    exact = lsq_linear(A, b, bounds, method="bvls", tol=1e-14).x[:3]
    found = solve_chain(np.full(3, K), stretch, np.inf, capacity, np.full(4, np.inf), np.zeros(4))[0]
    return exact, found


def pretension() -> Answer:
    """Compare the tension of a tensioned bolt is its pretension and what the blocks add."""
    U, _, at = _grouted(pretension=3e4)
    return 3e4 + _tensions(U), at.tension


CASES = (
    Case(name="end-anchored", what="tension of an end-anchored bolt, slack, elastic, yielding, slipping", source="wang",
         quantity="tension [N]", compute=end_anchored, tolerance=EXACT, equations=("5.1", "5.3", "5.4")),
    Case(name="axial-stiffness", what="stiffness of a bolt", source="wang", quantity="E A / L [N/m]",
         compute=axial_stiffness, tolerance=EXACT, equations=("5.2",)),
    Case(name="element-tensions", what="tensions of a grouted bolt through three blocks", source="wang",
         quantity="tension [N]", compute=tensions, tolerance=1e-7,
         equations=("5.5", "5.14", "5.15", "5.16", "5.17")),
    Case(name="bond-forces", what="its forces on the rock", source="wang", quantity="force [N]", compute=bond_forces,
         tolerance=1e-7, equations=("5.6",)),
    Case(name="bond-strength", what="bond by the weaker of two interfaces", source="wang",
         quantity="force per length [N/m]", compute=bond_strength, tolerance=EXACT, equations=("5.7",)),
    Case(name="redistribution", what="20 bolts whose bond fails: Eq. 5.13 repeated until it is balanced",
         source="wang", quantity="tension [N]", compute=redistribution, tolerance=1e-8,
         equations=("5.8", "5.9", "5.10", "5.11", "5.12", "5.13")),
    Case(name="least-energy", what="one such bolt as the state of least energy", source="bounded",
         quantity="tension [N]", compute=least_energy, tolerance=1e-6, equations=("5.13",)),
    Case(name="bolt-on-blocks", what="force and moment of the bolt on three blocks", source="wang",
         quantity="force [N/m], moment [N]", compute=forces_on_blocks, tolerance=1e-6,
         equations=("5.18", "5.19", "5.20")),
    Case(name="bolt-matrix", what="stiffness matrix of the bolt", source="wang", quantity="stiffness [N/m2]",
         compute=stiffness_matrix, tolerance=1e-6, equations=("5.21",)),
    Case(name="pretension", what="tensions of a tensioned bolt", source="wang", quantity="tension [N]",
         compute=pretension, tolerance=1e-9, equations=("5.22",)),
)  # fmt: skip
