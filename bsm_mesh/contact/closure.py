"""Normal forces of contacts whose joints close by a hyperbola, in series with the rock on both sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.feature import Feature
from bsm_mesh.model.joint_laws import closure


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Hyperbolic(Feature):
    """The contacts that close by a hyperbola.

    Attributes
    ----------
    stiffness : (h,) float64 [N/m2]
        Of the joint without stress, times the contact's length.
    limit : (h,) float64 [m]
        Greatest closure of the joint.
    compliance : (h,) float64 [m2/N]
        Of the rock on both sides.
    """

    stiffness: FloatArray
    limit: FloatArray
    compliance: FloatArray

    @classmethod
    def among(cls, limit: FloatArray, stiffness: FloatArray, length: FloatArray, series: FloatArray) -> Hyperbolic:
        """Return those of contacts whose limit is finite.

        Parameters
        ----------
        limit : (m,) float64 [m]
            Greatest closure of every contact's joint; infinite: none.
        stiffness : (m,) float64 [Pa/m]
            Normal stiffness of the joints.
        length : (m,) float64 [m]
            That contacts represent.
        series : (m,) float64 [N/m2]
            Stiffness of joint and rock in series.
        """
        rows = np.flatnonzero(np.isfinite(limit))
        own = stiffness[rows] * length[rows]
        compliance = np.maximum(1 / series[rows] - 1 / own, 0.0)
        return cls(rows=rows, stiffness=own, limit=limit[rows], compliance=compliance)

    def pressures(
        self, overlap: FloatArray, pressure: FloatArray, stiffness: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return pressures and their derivatives (m,) by the hyperbola where it holds, and as given elsewhere."""
        if not len(self.rows):
            return pressure, stiffness
        pressure, stiffness, rows = pressure.copy(), stiffness.copy(), self.rows
        found, derivative = closure.pressure_at(overlap[rows], self.stiffness, self.limit, self.compliance)
        bears = pressure[rows] > 0
        pressure[rows] = np.where(bears, found, pressure[rows])
        stiffness[rows] = np.where(bears, derivative, stiffness[rows])
        return pressure, stiffness

    def energies(self, energy: FloatArray, pressure: FloatArray) -> FloatArray:
        """Return the energies of the normal springs (m,) [N], by the hyperbola where it holds."""
        if len(self.rows):
            given = self.stiffness, self.limit, self.compliance
            energy[self.rows] = closure.energy_at(pressure[self.rows], *given)
        return energy

    def overlaps(self, pressure: FloatArray, stiffness: FloatArray) -> FloatArray:
        """Return how far contacts are closed under pressures (m,) [m], by their springs (m,) or the hyperbola."""
        overlap: FloatArray = pressure / stiffness
        overlap[self.rows] = closure.overlap_at(pressure[self.rows], self.stiffness, self.limit, self.compliance)
        return overlap

    def stiffening(self, pressure: FloatArray, stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the stiffening of the contacts' springs, (m,) each, as explicit motion takes it.

        From a pressure P with the derivative k a movement by d / k changes it by ``2 d / (b + sqrt(b^2 + 4 d s r))``,
        ``b = 1 - d s``: s = 1 / (A v + P) [m/N], and r the rock's part of the compliance. Linear contacts have 0 and 1.
        """
        s, r, rows = np.zeros(len(pressure)), np.ones(len(pressure)), self.rows
        s[rows] = 1 / (self.stiffness * self.limit + np.maximum(pressure[rows], 0.0))
        r[rows] = np.minimum(self.compliance * stiffness[rows], 1.0)
        return s, r
