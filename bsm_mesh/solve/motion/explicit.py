"""Explicit motion: blocks accelerated cycle by cycle by their residual.

The one method that needs no solution nearby and no factorization. A cycle has unit time; masses are the real ones in
a time that suits the stiffest of them (`real_masses`), or as small as stability allows (Underwood 1983). A part of each
force acts against the velocity (Cundall 1987): it takes nothing from what stands still. Contacts keep what slips and
breaks, bolts what yields, as it comes.

A *window* of cycles has one reference: forces and laws are worked out exactly there, their changes within (see
`contact_kernels`). It ends when a block has moved by an eighth of a step length.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.history import further_slip, worn
from bsm_mesh.solve.motion.bolt_kernels import bolt_arrays
from bsm_mesh.solve.motion.contact_columns import column_of
from bsm_mesh.solve.motion.cycles import Cycles
from bsm_mesh.solve.motion.masses import Weighed, projectors, spring_sums
from bsm_mesh.solve.motion.threads import Share, advance_window, strips
from bsm_mesh.solve.motion.window_columns import Columns, columns_of, near, share_of
from bsm_mesh.solve.step.block_system import BlockSystem


class ExplicitMotion(Cycles):
    """Polygons in explicit motion; parameters and attributes are those of `Cycles`."""

    system: BlockSystem
    _strips: list[IntArray] = []  # noqa: RUF012

    def _begin(self) -> None:
        """Set the contacts that may close within a window, and their columns."""
        self._strips = self._strips or strips(self.system.centroid, self._step.factors.options.threads)
        self._rows, self._columns = self._near(self._strength())

    def _near(self, lines: Mapping[str, FloatArray]) -> tuple[IntArray, Columns]:
        """Return the contacts (k,) that may close within a window, and their columns with lines of strength."""
        contacts, at, d = self.contacts, self.residual.at, self.system.d
        rows = near(contacts, at, 3 * self._settings.window * d)
        return rows, columns_of(contacts, at, lines, rows)

    def _sums(self) -> FloatArray:
        return spring_sums(self.system, self._weighed(), self._settings.heavier_bolts)

    def advance(self, max_cycles: int | None = None) -> None:
        """Go through a window, of `max_cycles` at most, and keep what slips, breaks and yields in it."""
        cycles = self._begin_window(self._cycles_of_window(max_cycles))
        contacts, at, rows, supports = self.contacts, self.residual.at, self._rows, self._step.supports
        a, b, given = self._weighed()
        columns = self._columns | {"dashpot": self._masses.dashpots(a, b, given["normal_stiffness"])}
        shaken = self._shaken()
        share = share_of(contacts, at, self.system.catalogue, rows, columns, works=shaken is not None)
        went, moved, self._velocity = advance_window(
            share,
            self._strips,
            cycles,
            self._window(),
            supports=(supports.block, projectors(supports, self._masses.mass), self._prescribed_in(cycles)),
            bolts=bolt_arrays(self.system, self.residual.position),
            loads=(self._acting(), self._ramped_load, self._unramped_fraction(cycles)),
            constants=(1 / self._masses.mass, self.system.scale, self._settings.damping),
            velocity=self._velocity,
            shaken=shaken,
            ends=self._ends(cycles),
        )
        self.cycles += went
        self.diverged = not np.isfinite(moved).all()
        if self.diverged:
            return
        self._keep(self.residual.position + moved, share)
        self._begin()

    def _shaken(self) -> tuple[FloatArray, FloatArray] | None:
        """Return drag (n, 3) and room for work (n, 5) of shaken blocks, as `move_shaken` takes them; or None."""
        return None

    def _ends(self, cycles: int) -> tuple[Any, ...] | None:
        """Return the ends of quiet boundaries in so many cycles, as `advance_window` takes them; or None."""
        return None

    def _may_wear(self) -> BoolArray:
        wears = np.zeros(self.contacts.count, dtype=bool)
        wears[self._rows] = ~self.residual.at.failed[self._rows]
        return wears

    def _weighed(self) -> Weighed:
        candidates, rows = self.contacts.candidates, self._rows
        return candidates.block_a[rows], candidates.block_b[rows], self._columns

    def _keep(self, position: FloatArray, share: Share) -> None:
        """Keep where blocks are, and what slipped, broke, failed and yielded on the way."""
        step, contacts, rows = self._step, self.contacts, self._rows
        before = self.residual.at
        contacted, failing, broken = (share.happened(name) for name in ("contacted", "failed", "broken"))
        self.contacted[rows] |= contacted
        failed, mated = contacts.failed.copy(), contacts.mated.copy()
        failed[rows] |= broken | failing
        mated[rows] &= ~broken
        left = np.where(mated, np.minimum(contacts.tension, contacts.residual_tension), 0.0)
        tension = np.where(failed, left, contacts.tension)
        shear, along = np.zeros(contacts.count), np.full(contacts.count, np.nan)
        shear[rows] = column_of(share.contacts, "carried", len(rows))
        along[rows] = before.tangential[rows] + column_of(share.contacts, "along", len(rows))
        touched = ~np.isnan(contacts.old_tangential)
        touched[rows] |= contacted
        pressure = np.full(contacts.count, np.nan)
        if len(share.growths):
            pressure[rows] = column_of(share.growths, "last_pressure", len(rows))
        here = replace(
            contacts,
            old_shear=shear,
            old_pressure=pressure,
            old_tangential=np.where(touched, along, np.nan),
        )
        if len(share.slips):
            slid = np.zeros(contacts.count)
            slid[rows] = column_of(share.slips, "slid", len(rows))
            changed = contacts.after_slip(slid)
            here = replace(here, failed=failed, mated=mated, tension=tension, **changed)
        at = step.system.evaluate(here, position)
        if not len(share.slips):  # told, and nothing more
            changed = contacts.after_slip(further_slip(contacts, before.springs, at.closed, shear, along))
        # What is open has no shear to come back to, and is anchored where it closes.
        contacts = replace(
            here,
            old_shear=np.where(at.closed, shear, 0.0),
            old_pressure=at.pressure,
            old_tangential=np.where(at.closed & ~np.isnan(along), along, np.where(touched, at.tangential, np.nan)),
            failed=failed,
            mated=mated,
            **changed,
            tension=tension,
        )
        if len(share.slips):  # by the last movement too, after which no cycle asked
            contacts = worn(contacts, at)
        bolts = self.system.bolts
        if len(bolts.alive):
            self.system.bolts = bolts.commit(bolts.evaluate(position))
        self._step = step.with_contacts(contacts)
        self.residual = self._step.residual_at(position)
