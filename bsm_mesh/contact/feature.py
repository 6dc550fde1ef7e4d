"""A feature of some contacts: their behaviour besides springs without stress and a law of strength.

A feature has rows among all contacts, and a method for every place where contacts are used. A method changes nothing
unless the feature overrides it: callers ask all features in turn, and none by name. A new one is a class with a field
in `features.Features`, as `closure`, `shear_springs` and `dilation` have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, Self, TypeAlias

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray

Curve: TypeAlias = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Pressures at overlaps (below 0 in tension), or strengths at pressures, (h,) each, and their derivatives."""


class Springs(NamedTuple):
    """Shear springs of all contacts within a step.

    Attributes
    ----------
    stiffness : (m,) float64 [N/m2]
        At the pressures before slip in the step opens a joint.
    old_shear : (m,) float64 [N/m]
        Remaining shear forces of the last accepted step.
    by_closure, trial_by_closure : (m,) float64 [N/m3], [N/m2]
        Derivatives of stiffness and trial shear by the closure; empty where no stiffness grows.
    """

    stiffness: FloatArray
    old_shear: FloatArray
    by_closure: FloatArray
    trial_by_closure: FloatArray


class Tangent(NamedTuple):
    """Derivatives of the contact forces, as `fill_tangent` takes them.

    Attributes
    ----------
    normal, by_gap, shear : (m,) float64 [N/m2]
        Of the pressure by the closure; of the shear force by the gap, and by the movement along the edge.
    by_along : (m,) float64 [N/m2]
        Of the pressure by the movement along the edge; empty where there is none.
    """

    normal: FloatArray
    by_gap: FloatArray
    shear: FloatArray
    by_along: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Movement:
    """Contacts at a position within a step, as features ask for them.

    Attributes
    ----------
    contacts : ContactSet
        All contacts, with the last accepted step.
    gap, along : (m,) float64 [m]
        Gaps, and coordinates along the edges.
    pressures, strength : callable
        Return the `Curve` of some contacts by their rows (h,); strengths are those of slipping contacts.
    """

    contacts: Any
    gap: FloatArray
    along: FloatArray
    pressures: Callable[[IntArray], Curve]
    strength: Callable[[IntArray], Curve]

    def overlap(self, rows: IntArray) -> FloatArray:
        """Return the closure of some contacts before slip in the step opens them, (h,) [m]."""
        overlap: FloatArray = self.contacts.offset[rows] - self.gap[rows]
        return overlap

    def trial(self, rows: IntArray, springs: Springs) -> FloatArray:
        """Return their shear force if they stuck, (h,) [N/m]; 0 where there was no contact before."""
        moved: FloatArray = self.along[rows] - self.contacts.old_tangential[rows]
        return np.where(np.isnan(moved), 0.0, springs.old_shear[rows] + springs.stiffness[rows] * moved)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Feature:
    """Some of all contacts; every field has a value of each.

    Attributes
    ----------
    rows : (h,) int64
        Theirs among all contacts.
    """

    rows: IntArray

    def of(self, number: IntArray) -> Self:
        """Return those that get a number (m,) of 0 or more, under it."""
        rows = number[self.rows]
        kept = rows >= 0
        values = {field.name: getattr(self, field.name)[kept] for field in fields(self)}
        return replace(self, **{**values, "rows": rows[kept]})

    def spread(self, count: int, *values: FloatArray) -> FloatArray:
        """Return values (h,) of these among all contacts, (k, count): 0 of the others."""
        found = np.zeros((len(values), count))
        for row, column in zip(found, values, strict=True):
            row[self.rows] = column
        return found

    def pressures(
        self, overlap: FloatArray, pressure: FloatArray, stiffness: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return pressures and their derivatives (m,), changed for these.

        Parameters
        ----------
        overlap : (m,) float64 [m]
            Closure of the contacts.
        pressure, stiffness : (m,) float64 [N/m], [N/m2]
            By their springs without stress; contacts that are open have no pressure, and keep it so.
        """
        return pressure, stiffness

    def springs(self, given: Springs, at: Movement) -> Springs:
        """Return the shear springs of all contacts, changed for these."""
        return given

    def slips(
        self, slip: FloatArray, offset: FloatArray, springs: Springs, at: Movement
    ) -> tuple[FloatArray, FloatArray]:
        """Return the slip in the step of contacts that open by it (h,) [m], and all offsets (m,) [m] opened by it."""
        return slip, offset

    def tangent(self, given: Tangent, at: Any, slip_path: FloatArray) -> Tangent:
        """Return the derivatives of the forces at an `Evaluation`, changed for these; slip path (m,) [m] before."""
        return given

    def opened(self, offset: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Return the offsets (m,) [m] of contacts after slip paths continued from `before` to `after`, (m,) [m]."""
        return offset

    def energies(self, energy: FloatArray, pressure: FloatArray) -> FloatArray:
        """Return the energies of the normal springs (m,) [N] at pressures (m,) [N/m], changed for these."""
        return energy
