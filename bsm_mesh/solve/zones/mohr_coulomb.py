"""Mohr-Coulomb rock with a tension cut-off: return to the yield surface in principal stresses, and its tangent.

Principal stresses are s1 >= s2 >= s3, tension positive, and N = (1 + sin phi) / (1 - sin phi). Rock yields where
``N s1 - s3 = 2 c sqrt(N)`` (shear) or ``s1 = T`` (tension). Both are planes. On every plane, edge and corner the return
is a linear map of the trial stress, and so is its derivative. Plastic strain follows the dilation angle in shear (N_psi
in the place of N) and the normal of the plane in tension.

References
----------
Clausen, Damkilde & Andersen (2006), Efficient return algorithms for associated plasticity with multiple yield planes,
Int. J. Numer. Meth. Engng 66, 1036-1059.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf, radians, sin, sqrt
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import ROUNDING, FloatArray, IntArray

SETS = ((0,), (3,), (0, 1), (0, 2), (0, 3), (3, 4), (0, 3, 4), (0, 2, 3), (3, 4, 5))  # of planes of `Yielding.planes`


class Return(NamedTuple):
    """Where trial stresses end.

    Attributes
    ----------
    stress : (n, 4) float64 [Pa]
        xx, yy, xy, zz.
    set : (n,) int
        Number of the planes that are active in `SETS`, from 1; 0: elastic.
    principal : (n, 3) float64 [Pa]
        Both principal stresses in the plane, and zz.
    order : (n, 3) int
        Which of these is the greatest, the middle, the least.
    angle, radius : (n,) float64
        Of the trial stress: twice the angle of the first principal stress in the plane, and half their difference.
    """

    stress: FloatArray
    set: IntArray
    principal: FloatArray
    order: IntArray
    angle: FloatArray
    radius: FloatArray


class _Map(NamedTuple):
    """The return to some planes: ``matrix @ trial + shift``; multipliers ``factor @ (planes @ trial - bound)``."""

    matrix: FloatArray
    shift: FloatArray
    factor: FloatArray
    planes: FloatArray
    bound: FloatArray


@dataclass(frozen=True)
class Yielding:
    """The strength of a rock, with the elasticity by which stresses return to it.

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
    def elasticity(self) -> FloatArray:
        """Stiffness (3, 3) [Pa] from principal strains to principal stresses."""
        return self.lame * np.ones((3, 3)) + 2 * self.shear * np.eye(3)

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

    def returned(self, trial: FloatArray) -> Return:
        """Return trial stresses (n, 4) [Pa] to the yield surface where they are beyond it."""
        xx, yy, xy, zz = trial.T
        middle, half = (xx + yy) / 2, (xx - yy) / 2
        radius, angle = np.hypot(half, xy), np.arctan2(xy, half)
        own = np.stack([middle + radius, middle - radius, zz], axis=1)
        order = np.argsort(-own, axis=1, kind="stable")
        in_order = np.take_along_axis(own, order, axis=1)
        number, found = self._in_order(in_order)
        principal = np.empty_like(found)
        np.put_along_axis(principal, order, found, axis=1)
        a, b, c = principal.T
        d, e = (a - b) / 2 * np.cos(angle), (a - b) / 2 * np.sin(angle)
        back = np.stack([(a + b) / 2 + d, (a + b) / 2 - d, e, c], axis=1)
        stress = np.where((number > 0)[:, None], back, trial)
        return Return(stress, number, principal, order, angle, radius)

    def _in_order(self, trial: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the number of the set and the stress of principal stresses (n, 3) in order."""
        normals, bounds, _ = self.planes
        scale = np.maximum(np.abs(trial).max(axis=1, initial=0.0), np.abs(bounds[np.isfinite(bounds)]).max(initial=0.0))

        def excess(stress: FloatArray) -> FloatArray:
            most: FloatArray = (stress @ normals.T - bounds).max(axis=1)
            return most

        rows = np.flatnonzero(excess(trial) > -ROUNDING * scale)  # on the surface too: there the next stress yields
        number, stress = np.zeros(len(trial), dtype=np.int64), trial.copy()
        given, scale = trial[rows], scale[rows]
        chosen, best = np.zeros(len(rows), dtype=np.int64), given.copy()
        least = np.full(len(rows), inf)
        slack = ROUNDING * scale * abs(normals).max()
        for which, one in enumerate(self.maps, 1):
            to = given @ one.matrix.T + one.shift
            multipliers = (given @ one.planes.T - one.bound) @ one.factor.T
            allowed = (excess(to) <= slack) & (to[:, 1] - to[:, 0] <= slack) & (to[:, 2] - to[:, 1] <= slack)
            flows = allowed & (multipliers >= -slack[:, None] / self.shear).all(axis=1)
            moved = given - to  # of what is allowed but flows nowhere the nearest, in energy
            energy = np.einsum("ni,ni->n", moved, np.linalg.solve(self.elasticity, moved.T).T)
            energy = np.where(allowed, energy, inf)
            better = np.where(flows, least > -inf, energy < least)
            chosen, best = np.where(better, which, chosen), np.where(better[:, None], to, best)
            least = np.where(flows & better, -inf, np.where(better, energy, least))
        number[rows], stress[rows] = chosen, best
        return number, stress

    def tangent(self, found: Return, rows: IntArray) -> FloatArray:
        """Return the derivatives (k, 3, 3) [Pa] of xx, yy, xy by the strains xx, yy and 2 xy, of some points."""
        lame, G = self.lame, self.shear
        by_trial = np.stack([np.eye(3), *(one.matrix for one in self.maps)])[found.set[rows]]
        order, count = found.order[rows], len(rows)
        own = np.empty_like(by_trial)
        at = np.arange(count)[:, None, None]
        own[at, order[:, :, None], order[:, None, :]] = by_trial
        elastic = np.array([(lame + 2 * G, lame), (lame, lame + 2 * G), (lame, lame)])
        local = np.zeros((count, 3, 3))
        local[:, :2, :2] = (own @ elastic)[:, :2]
        a, b, _ = found.principal[rows].T
        radius = found.radius[rows]
        wide = radius > ROUNDING * np.abs(found.principal[rows]).max(axis=1, initial=0.0)
        along = (own[:, 0, 0] - own[:, 0, 1] - own[:, 1, 0] + own[:, 1, 1]) / 2
        local[:, 2, 2] = G * np.where(wide, (a - b) / (2 * np.where(wide, radius, 1.0)), along)
        c, s = np.cos(found.angle[rows] / 2), np.sin(found.angle[rows] / 2)
        turn = np.stack([c * c, s * s, c * s, s * s, c * c, -c * s, -2 * c * s, 2 * c * s, c * c - s * s], axis=1)
        turn = turn.reshape(-1, 3, 3)
        tangent: FloatArray = turn.transpose(0, 2, 1) @ local @ turn
        return tangent


def _passive(degrees: float) -> float:
    s = sin(radians(degrees))
    return (1 + s) / (1 - s)
