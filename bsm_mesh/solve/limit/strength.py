"""Limits of the forces of limit analysis, in contacts and bolts: numbers, parts of them, rows of a linear program."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csr_array

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.strength import contact_strength
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.model.bolt_layout import BoltLayout
from bsm_mesh.model.model import Model
from bsm_mesh.solve.bolts.dowels import Dowels


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Strength:
    """Greatest forces of contacts and bolts, over the bolts' spacing; infinite: no bound.

    Attributes
    ----------
    slope, intercept : (m, k) float64 [-, N/m]
        Of the straight lines that bound the contacts' shear by their pressure.
    tension : (m,) float64 [N/m]
        Of the contacts.
    yield_force : (e,) float64 [N/m]
        Tension of the bolts' elements.
    capacity : (n_nodes,) float64 [N/m]
        Of the bolts' bonds at their nodes.
    dowel : (d,) float64 [N/m]
        Shear of the bolts across joints.
    node : (e,) int32
        First node of every element; the second is the next one.
    """

    slope: FloatArray
    intercept: FloatArray
    tension: FloatArray
    yield_force: FloatArray
    capacity: FloatArray
    dowel: FloatArray
    node: IntArray

    @classmethod
    def of(cls, model: Model, contacts: ContactTable, bolts: BoltLayout, dowels: Dowels) -> Strength:
        """Return the strength of a model."""
        of_contacts = contact_strength(model, contacts)
        slope, intercept = of_contacts.lines()
        return cls(
            slope=slope,
            intercept=intercept,
            tension=of_contacts.tension,
            yield_force=(bolts.yield_force / bolts.spacing)[bolts.bolt_of_element],
            capacity=bolts.capacity / bolts.spacing[bolts.bolt_of_node],
            dowel=dowels.strength / dowels.spacing,
            node=bolts.first_node,
        )

    @property
    def hull(self) -> FloatArray:
        """Intercepts of the convex hull, (m, k): with tension the strength, friction under pressure only, has none."""
        tension = np.where(np.isfinite(self.tension), self.tension, 0.0)
        return self.intercept + self.slope * tension[:, None]

    @property
    def unlimited(self) -> BoolArray:
        """Contacts of unlimited strength, (m,)."""
        unlimited: BoolArray = np.isinf(self.intercept).all(axis=1) & np.isinf(self.tension)
        return unlimited

    @property
    def is_cone(self) -> bool:
        """Whether forces within it stay so when multiplied: no cohesion, no tension, bolts without limits."""
        bounds = np.concatenate([self.hull.reshape(-1), self.tension, self.yield_force, self.capacity, self.dowel])
        return bool(((bounds == 0) | np.isinf(bounds)).all())

    def times(self, part: float, contacts: BoolArray, *, bolts: bool) -> Strength:
        """Return the strength in which chosen contacts (m,), and the bolts or not, have a part of theirs."""
        of_contacts, of_bolts = np.where(contacts, part, 1.0), part if bolts else 1.0
        return replace(
            self,
            slope=self.slope * of_contacts[:, None],
            intercept=self.intercept * of_contacts[:, None],
            tension=self.tension * of_contacts,
            yield_force=self.yield_force * of_bolts,
            capacity=self.capacity * of_bolts,
            dowel=self.dowel * of_bolts,
        )

    def rows(self, first_bolt: int, unknowns: int) -> tuple[csr_array, FloatArray]:
        """Return rows and bounds of a linear program whose unknowns are forces, ``rows x <= bounds``.

        ``+-shear - slope * pressure <= intercept`` line by line, ``-pressure <= tension``, tensions of bolts not below
        0 nor above yield, shears across joints, and last ``+-bond force <= capacity``, the bond force being the tension
        after a node less that before it.

        Parameters
        ----------
        first_bolt : int
            Place of the first tension among the unknowns, of which pressures and shears of the contacts come first,
            shears of bolts across joints last.
        unknowns : int
            How many there are.
        """
        m, e, d = len(self.tension), len(self.yield_force), len(self.dowel)
        found = _Rows(unknowns)
        contact, tension, shear = np.arange(m), first_bolt + np.arange(e), unknowns - d + np.arange(d)
        for slope, intercept in zip(self.slope.T, self.hull.T, strict=True):
            for sign in (1.0, -1.0):
                found.add(intercept, (contact, -slope), (m + contact, np.full(m, sign)))
        found.add(self.tension, (contact, np.full(m, -1.0)))
        found.add(np.zeros(e), (tension, np.full(e, -1.0)))
        found.add(self.yield_force, (tension, np.ones(e)))
        for sign in (1.0, -1.0):
            found.add(self.dowel, (shear, np.full(d, sign)))
        after, before = np.full(len(self.capacity), -1), np.full(len(self.capacity), -1)
        after[self.node], before[self.node + 1] = tension, tension
        for sign in (1.0, -1.0):
            found.add(
                self.capacity,
                (np.maximum(after, 0), np.where(after >= 0, sign, 0.0)),
                (np.maximum(before, 0), np.where(before >= 0, -sign, 0.0)),
            )
        return found.matrix, np.concatenate(found.bounds)


class _Rows:
    """Rows of a linear program, those without a bound left out."""

    def __init__(self, unknowns: int) -> None:
        self.unknowns, self.count = unknowns, 0
        self.bounds: list[FloatArray] = []
        self.entries: list[tuple[IntArray, IntArray, FloatArray]] = []

    def add(self, bound: FloatArray, *terms: tuple[IntArray, FloatArray]) -> None:
        """Add rows with their bounds (r,); terms give columns and values (r,) each."""
        kept = np.flatnonzero(np.isfinite(bound))
        row = self.count + np.arange(len(kept))
        self.entries += [(row, column[kept], value[kept]) for column, value in terms]
        self.bounds.append(bound[kept])
        self.count += len(kept)

    @property
    def matrix(self) -> csr_array:
        row, column, value = (np.concatenate(part) for part in zip(*self.entries, strict=True))
        found = coo_array((value, (row, column)), shape=(self.count, self.unknowns)).tocsr()
        found.eliminate_zeros()
        return found
