"""Shear springs of contacts: constant, or of joints whose shear stiffness grows with pressure, in series with rock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.feature import Feature, Movement, Springs
from bsm_mesh.model.joint_laws.shear_stiffness import stiffness_at


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Growing(Feature):
    """The contacts whose shear stiffness grows with pressure.

    Attributes
    ----------
    curve : (h, 7) float64
        The joints' shear stiffness by the normal stress, as `ShearCurve`.
    length : (h,) float64 [m]
        Of the face, represented by each contact.
    compliance : (h,) float64 [m2/N]
        Of the rock on both sides, in shear.
    """

    curve: FloatArray
    length: FloatArray
    compliance: FloatArray

    @classmethod
    def among(cls, curve: FloatArray, own: FloatArray, length: FloatArray, series: FloatArray) -> Growing:
        """Return those of contacts (m,) that have a curve and are not smooth.

        Parameters
        ----------
        curve : (m, 7) float64
            Of every contact's joint; its factor is 0: none.
        own : (m,) float64 [Pa/m]
            Shear stiffness of the joints at the reference stress.
        length : (m,) float64 [m]
            That contacts represent.
        series : (m,) float64 [N/m2]
            Stiffness there of joint and rock in series; 0: smooth.
        """
        rows = np.flatnonzero((curve[:, 0] > 0) & (series > 0)) if len(curve) else np.zeros(0, dtype=np.int64)
        compliance = np.maximum(1 / series[rows] - 1 / (own[rows] * length[rows]), 0.0) if len(rows) else length[:0]
        return cls(rows=rows, curve=curve[rows], length=length[rows], compliance=compliance)

    def stiffness(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the shear stiffness [N/m2] and its derivative [1/m] at pressures (h,) [N/m]."""
        own, slope = stiffness_at(pressure / self.length, self.curve)
        own = own * self.length
        series = 1 / (self.compliance + 1 / own)
        return series, slope * (series / own) ** 2

    def springs(self, given: Springs, at: Movement) -> Springs:
        """Return the springs of all contacts at the pressures before slip in the step."""
        if not len(self.rows):
            return given
        contacts = at.contacts
        pressed = at.pressures(self.rows)(at.overlap(self.rows))
        return self.springs_at(given[:2], at.along - contacts.old_tangential, contacts.old_pressure, *pressed)

    def springs_at(
        self,
        given: tuple[FloatArray, FloatArray],
        moved: FloatArray,
        old_pressure: FloatArray,
        pressure: FloatArray,
        by_closure: FloatArray,
    ) -> Springs:
        """Return the springs of all contacts at pressures of these.

        Parameters
        ----------
        given : (m,), (m,) float64
            Shear stiffness [N/m2] and shear force at the last accepted step [N/m] of all contacts.
        moved : (m,) float64 [m]
            Movement along the edge since; not a number: it has not touched before.
        old_pressure : (m,) float64 [N/m]
            Pressure at the last accepted step; not a number: the shear force belongs to the present one.
        pressure, by_closure : (h,) float64 [N/m], [N/m2]
            Pressures of these contacts, and their derivatives.
        """
        stiffness, old_shear = (values.copy() for values in given)
        stiffer, trial = np.zeros_like(stiffness), np.zeros_like(stiffness)
        here, slope = self.stiffness(pressure)
        before = old_pressure[self.rows]
        before = np.where(np.isnan(before), here, self.stiffness(np.nan_to_num(before))[0])
        shear, falls = old_shear[self.rows], here < before
        stiffness[self.rows], old_shear[self.rows] = here, shear * np.where(falls, here / before, 1.0)
        stiffer[self.rows] = slope * by_closure
        trial[self.rows] = stiffer[self.rows] * (np.nan_to_num(moved[self.rows]) + np.where(falls, shear / before, 0.0))
        return Springs(stiffness, old_shear, stiffer, trial)
