"""Mohr-Coulomb rock with a tension cut-off: its yield surface in principal stresses.

With N = (1 + sin phi) / (1 - sin phi) rock yields where ``N s1 - s3 = 2 c sqrt(N)`` (shear) or ``s1 = T`` (tension).
Both are planes. On every plane, edge and corner the return is a linear map of the trial stress, and so is its
derivative. Plastic strain follows the dilation angle in shear (N_psi in the place of N) and the normal of the plane in
tension.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import inf, radians, sin, sqrt
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.zones.yield_surface import End, Return, YieldSurface

SETS = ((0,), (3,), (0, 1), (0, 2), (0, 3), (3, 4), (0, 3, 4), (0, 2, 3), (3, 4, 5))  # of planes of `Yielding.planes`


class _Map(NamedTuple):
    """The return to some planes: ``matrix @ trial + shift``; multipliers ``factor @ (planes @ trial - bound)``."""

    matrix: FloatArray
    shift: FloatArray
    factor: FloatArray
    planes: FloatArray
    bound: FloatArray


@dataclass(frozen=True)
class Yielding(YieldSurface):
    """The strength of a rock by Mohr and Coulomb.

    Attributes
    ----------
    lame, shear : float [Pa]
        Lame's constant and shear modulus.
    cohesion : float [Pa]
        Cohesion.
    friction, dilation : float [degrees]
        Angles.
    tension : float [Pa]
        Tensile strength; where the cone ends below it, that of the cone's tip.
    """

    lame: float
    shear: float
    cohesion: float
    friction: float
    dilation: float
    tension: float

    @cached_property
    def planes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Normals (6, 3), bounds (6,) [Pa] and flow directions (6, 3) of three planes of shear and three of tension."""
        N, flow = (_passive(angle) for angle in (self.friction, self.dilation))
        k = 2 * self.cohesion * sqrt(N)
        tension = min(self.tension, k / (N - 1) if N > 1 else inf)

        def normals(n: float) -> FloatArray:
            return np.concatenate([[(n, 0.0, -1.0), (0.0, n, -1.0), (n, -1.0, 0.0)], np.eye(3)])

        return normals(N), np.array([k, k, k, tension, tension, tension]), normals(flow)

    @cached_property
    def maps(self) -> tuple[_Map, ...]:
        """The returns to all `SETS`."""
        normals, bounds, flows = self.planes
        found = []
        for chosen in map(list, SETS):
            a, b = normals[chosen], self.elasticity @ flows[chosen].T
            factor: FloatArray = np.linalg.inv(a @ b).astype(np.float64)
            matrix = np.eye(3) - b @ factor @ a
            if len(chosen) == 3:
                matrix = np.zeros((3, 3))
            found.append(_Map(matrix, b @ factor @ bounds[chosen], factor, a, bounds[chosen]))
        return tuple(found)

    @property
    def strength(self) -> float:
        """Greatest finite bound [Pa]."""
        bounds = self.planes[1]
        return float(np.abs(bounds[np.isfinite(bounds)]).max(initial=0.0))

    def excess(self, stress: FloatArray) -> FloatArray:
        """Return by how much principal stresses (n, 3) in order are beyond the planes, (n,) [Pa]; negative within."""
        normals, bounds, _ = self.planes
        most: FloatArray = (stress @ normals.T - bounds).max(axis=1)
        return most

    def ends(self, trial: FloatArray, slack: FloatArray) -> Iterator[End]:
        """Yield where stresses (n, 3) in order end on all `SETS`; `slack` (n,) [Pa] is rounding."""
        slack = slack * abs(self.planes[0]).max()
        for one in self.maps:
            to = trial @ one.matrix.T + one.shift
            multipliers = (trial @ one.planes.T - one.bound) @ one.factor.T
            yield End(to, multipliers, self.excess(to) <= slack, np.zeros(len(to)))

    def by_trial(self, found: Return, rows: IntArray) -> FloatArray:
        """Return the derivatives (k, 3, 3) of principal stresses by those of the trial, both in order."""
        matrices: FloatArray = np.stack([np.eye(3), *(one.matrix for one in self.maps)])[found.set[rows]]
        return matrices


def _passive(degrees: float) -> float:
    s = sin(radians(degrees))
    return (1 + s) / (1 - s)
