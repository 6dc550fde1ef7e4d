"""Return of stresses to a yield surface in principal stresses, and its tangent.

Principal stresses are s1 >= s2 >= s3, tension positive. A surface of isotropic rock is given by them alone, and a
return keeps their directions. Stresses return to every face, edge and corner. The first is taken whose plastic strain
has the right sign.

References
----------
Clausen, Damkilde & Andersen (2006), Efficient return algorithms for associated plasticity with multiple yield planes,
Int. J. Numer. Meth. Engng 66, 1036-1059.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray


class Return(NamedTuple):
    """Where trial stresses end.

    Attributes
    ----------
    stress : (n, 4) float64 [Pa]
        xx, yy, xy, zz.
    set : (n,) int
        Number of the face, edge or corner, from 1; 0: elastic.
    principal : (n, 3) float64 [Pa]
        Both principal stresses in the plane, and zz.
    order : (n, 3) int
        Which of these is the greatest, the middle, the least.
    trial : (n, 3) float64 [Pa]
        Principal stresses of the trial, in order.
    place : (n,) float64
        Where on a curved face or edge they end; 0 elsewhere.
    angle, radius : (n,) float64
        Of the trial stress: twice the angle of the first principal stress in the plane, and half their difference.
    """

    stress: FloatArray
    set: IntArray
    principal: FloatArray
    order: IntArray
    trial: FloatArray
    place: FloatArray
    angle: FloatArray
    radius: FloatArray


class End(NamedTuple):
    """Where trial stresses end on one face, edge or corner.

    Attributes
    ----------
    stress : (n, 3) float64 [Pa]
        In order.
    multipliers : (n, m) float64
        Amounts of plastic strain, of the right sign where none is negative.
    within : (n,) bool
        Whether the stress is within the strength.
    place : (n,) float64
        As of `Return`.
    """

    stress: FloatArray
    multipliers: FloatArray
    within: BoolArray
    place: FloatArray


class YieldSurface(ABC):
    """The strength of a rock, with the elasticity by which stresses return to it.

    Attributes
    ----------
    lame, shear : float [Pa]
        Lame's constant and shear modulus.
    """

    lame: float
    shear: float

    @cached_property
    def elasticity(self) -> FloatArray:
        """Stiffness (3, 3) [Pa] from principal strains to principal stresses."""
        return self.lame * np.ones((3, 3)) + 2 * self.shear * np.eye(3)

    @property
    @abstractmethod
    def strength(self) -> float:
        """Greatest finite stress [Pa] of the surface, with which rounding is compared."""

    @abstractmethod
    def excess(self, stress: FloatArray) -> FloatArray:
        """Return by how much principal stresses (n, 3) in order are beyond the surface, (n,) [Pa]; negative within."""

    @abstractmethod
    def ends(self, trial: FloatArray, slack: FloatArray) -> Iterator[End]:
        """Yield where stresses (n, 3) in order end on every face, edge and corner; `slack` (n,) [Pa] is rounding."""

    @abstractmethod
    def by_trial(self, found: Return, rows: IntArray) -> FloatArray:
        """Return the derivatives (k, 3, 3) of principal stresses by those of the trial, both in order."""

    def returned(self, trial: FloatArray) -> Return:
        """Return trial stresses (n, 4) [Pa] to the yield surface where they are beyond it."""
        xx, yy, xy, zz = trial.T
        middle, half = (xx + yy) / 2, (xx - yy) / 2
        radius, angle = np.hypot(half, xy), np.arctan2(xy, half)
        own = np.stack([middle + radius, middle - radius, zz], axis=1)
        order = np.argsort(-own, axis=1, kind="stable")
        in_order = np.take_along_axis(own, order, axis=1)
        number, found, place = self._in_order(in_order)
        principal = np.empty_like(found)
        np.put_along_axis(principal, order, found, axis=1)
        a, b, c = principal.T
        d, e = (a - b) / 2 * np.cos(angle), (a - b) / 2 * np.sin(angle)
        back = np.stack([(a + b) / 2 + d, (a + b) / 2 - d, e, c], axis=1)
        stress = np.where((number > 0)[:, None], back, trial)
        return Return(stress, number, principal, order, in_order, place, angle, radius)

    def _in_order(self, trial: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return number, stress and place, as of `Return`, of principal stresses (n, 3) in order."""
        scale = np.maximum(np.abs(trial).max(axis=1, initial=0.0), self.strength)
        number, stress, place = np.zeros(len(trial), dtype=np.int64), trial.copy(), np.zeros(len(trial))
        beyond = self.excess(trial) > -ROUNDING * scale  # on the surface too: there the next stress yields
        rows = np.flatnonzero(beyond)
        given = trial[rows]
        chosen, best, where = np.zeros(len(rows), dtype=np.int64), given.copy(), np.zeros(len(rows))
        least = np.full(len(rows), inf)
        slack = ROUNDING * scale[rows]
        for which, (to, multipliers, within, at) in enumerate(self.ends(given, slack), 1):
            allowed = within & (to[:, 1] - to[:, 0] <= slack) & (to[:, 2] - to[:, 1] <= slack)
            flows = allowed & (multipliers >= -slack[:, None] / self.shear).all(axis=1)
            moved = given - to  # of what is allowed but flows nowhere the nearest, in energy
            energy = np.einsum("ni,ni->n", moved, np.linalg.solve(self.elasticity, moved.T).T)
            energy = np.where(allowed, energy, inf)
            better = np.where(flows, least > -inf, energy < least)
            chosen, where = np.where(better, which, chosen), np.where(better, at, where)
            best = np.where(better[:, None], to, best)
            least = np.where(flows & better, -inf, np.where(better, energy, least))
        number[rows], stress[rows], place[rows] = chosen, best, where
        return number, stress, place

    def tangent(self, found: Return, rows: IntArray) -> FloatArray:
        """Return the derivatives (k, 3, 3) [Pa] of xx, yy, xy by the strains xx, yy and 2 xy, of some points."""
        lame, G = self.lame, self.shear
        order, count = found.order[rows], len(rows)
        by_trial = self.by_trial(found, rows)
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
