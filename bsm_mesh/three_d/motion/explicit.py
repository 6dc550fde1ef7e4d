"""Explicit motion of polyhedra: windows of compiled cycles.

A window has one reference: the strength of every contact is the tangent of its law there. Positions, forces and
friction are exact within. It ends when a block has moved by an eighth of a step length.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.forces import slipping
from bsm_mesh.solve.motion.cycles import Cycles
from bsm_mesh.solve.motion.masses import bolt_sums, projectors
from bsm_mesh.three_d.bolts.kernels import bolt_arrays
from bsm_mesh.three_d.contacts.contact_set import ContactSet
from bsm_mesh.three_d.contacts.forces import Evaluation
from bsm_mesh.three_d.contacts.rotations import swings, turned_on, turns_of
from bsm_mesh.three_d.motion.kernels import BROKEN, CLOSED, SLID, advance


class ExplicitMotion(Cycles):
    """Polyhedra in explicit motion; parameters and attributes are those of `Cycles`."""

    def _begin(self) -> None:
        """Do nothing: all contact points take part in every window."""

    def _sums(self) -> FloatArray:
        """Return the stiffness sums of contacts, (n, 6): the stiffer spring of each, by its arm squared for turns."""
        contacts, at, n = self.contacts, self.residual.at, len(self.residual.position)
        c, stiffness = contacts.candidates, np.maximum(at.normal_stiffness, contacts.shear_stiffness)
        sums = np.zeros((n, 6))
        for block, arm in ((c.block_a, contacts.geometry[:, :3]), (c.block_b, contacts.geometry[:, 3:6])):
            sums[:, :3] += np.bincount(block, stiffness, n)[:, None]
            sums[:, 3:] += np.bincount(block, stiffness * (arm**2).sum(axis=1), n)[:, None]
        sums += bolt_sums(self.system, self._settings.heavier_bolts)
        return sums

    def advance(self, max_cycles: int | None = None) -> None:
        """Go through a window, of `max_cycles` at most, and keep what slips, breaks and fails in it."""
        cycles = self._begin_window(self._cycles_of_window(max_cycles))
        contacts, at, position = self.contacts, self.residual.at, self.residual.position
        c, supports = contacts.candidates, self._step.supports
        springs, shear, place = self._springs(contacts, at), at.shear.copy(), at.place.copy()
        marks = at.closed.astype(np.int8) * CLOSED
        shift, matrix = position[:, :3].copy(), swings(position[:, 3:])
        before, moved = matrix.copy(), np.zeros_like(position)
        free = np.ones(len(position), dtype=bool)
        free[supports.block] = False
        self.cycles += advance(
            cycles,
            self._window(),
            (c.block_a, c.block_b),
            contacts.geometry,
            springs,
            shear,
            place,
            marks,
            (supports.block, projectors(supports, self._masses.mass), self._prescribed_in(cycles)),
            np.flatnonzero(free),
            (self.system.loads_at(position), self._ramped_load, self._unramped_fraction(cycles)),
            bolt_arrays(self.system.bolts),
            (1 / self._masses.mass, self.system.scale, self._settings.damping),
            self._velocity,
            moved,
            shift,
            matrix,
            (np.empty_like(position), np.empty((7, 6))),
        )
        self.diverged = not (np.isfinite(shift).all() and np.isfinite(matrix).all())
        if not self.diverged:
            turn = turned_on(position[:, 3:], turns_of(before, matrix))
            self._keep(np.hstack([shift, turn]), springs[:, 9], shear, place, marks)

    def _springs(self, contacts: ContactSet, at: Evaluation) -> FloatArray:
        """Return the columns of contacts that `advance` takes as springs, (m, 14)."""
        c, strength = contacts.candidates, self._strength()
        # By the tangent of a joint's hyperbola: the gap at which it presses nothing.
        offset = np.where(at.closed, at.gap + at.pressure / at.normal_stiffness, contacts.offset)
        columns = (
            at.normal_stiffness,
            contacts.shear_stiffness,
            offset,
            contacts.tension,
            self._masses.dashpots(c.block_a, c.block_b, at.normal_stiffness),
            strength["first"],
            strength["first_slope"],
            contacts.reach,
            at.gap,
            np.zeros(contacts.count),
            strength["second"],
            strength["second_slope"],
            *contacts.features.dilating.columns(contacts.slip_path),
        )
        return np.column_stack(columns)

    def _may_wear(self) -> BoolArray:
        wears: BoolArray = ~self.contacts.failed
        return wears

    def _keep(
        self, position: FloatArray, slid: FloatArray, shear: FloatArray, place: FloatArray, marks: IntArray
    ) -> None:
        """Keep where blocks are, and what slid (m,), broke and failed on the way."""
        contacts, laws = self.contacts, self.system.catalogue.laws
        closed, broken, slides = ((marks & bit) > 0 for bit in (CLOSED, BROKEN, SLID))
        self.contacted |= closed
        full = slipping(contacts, laws, np.maximum(self.residual.at.pressure, 0.0))
        failed = contacts.failed | broken | (slides & full.failed)
        mated = contacts.mated & ~broken
        left = np.where(mated, contacts.residual_tension, 0.0)
        path = contacts.slip_path + slid
        touched = closed | ~np.isnan(contacts.old_place[:, 0])
        first = np.where(closed[:, None] & np.isnan(contacts.first_place), place, contacts.first_place)
        here = replace(
            contacts,
            old_shear=shear,
            old_place=np.where(touched[:, None], place, np.nan),
            first_place=first,
            failed=failed,
            mated=mated,
            tension=np.where(failed, np.minimum(contacts.tension, left), contacts.tension),
            slip_path=path,
            offset=contacts.features.opened(contacts.offset, contacts.slip_path, path),
        )
        bolts = self.system.bolts
        if len(bolts.alive):
            self.system.bolts = bolts.commit(bolts.evaluate(position))
        self._step = self._step.with_contacts(here)
        self.residual = self._step.residual_at(position)
