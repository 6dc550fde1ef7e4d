"""Explicit motion: blocks accelerated cycle by cycle by their residual.

The one method that needs no solution nearby and no factorization. A cycle has unit time; masses are the real ones in
a time that suits the stiffest of them (`real_masses`), or as small as stability allows (Underwood 1983). A part of each
force acts against the velocity (Cundall 1987): it takes nothing from what stands still. Contacts keep what slips and
breaks, bolts what yields, as it comes.

A *window* of cycles has one reference: forces and laws are worked out exactly there, their changes within (see
`contact_kernels`). It ends when a block has moved by an eighth of a step length.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.joint_laws import JointLaw, wear_length_of
from bsm_mesh.model.joint_laws.shear_stiffness import ShearCurve
from bsm_mesh.solve.contacts.forces import ContactSet, resolve_corner_corner, slipping
from bsm_mesh.solve.contacts.history import commit, slip_path_after, worn
from bsm_mesh.solve.motion.bolt_kernels import bolt_arrays
from bsm_mesh.solve.motion.contact_kernels import (
    BROKEN,
    CONTACTED,
    FAILED,
    FIRST_LASTS,
    GROWTH,
    SECOND_LASTS,
    SLIP,
    SPRING,
    STATE,
    RecordArray,
    SingleArray,
    frames,
)
from bsm_mesh.solve.motion.masses import Masses, MotionSettings, Weighed, projectors
from bsm_mesh.solve.motion.threads import Share, advance_window, strips
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.equations import Residual, StepEquations

UNLIMITED = 1e30  # strength of what cannot slip [N/m], in single precision
HIGH = 1e12  # a pressure above all others [N/m]


class ExplicitMotion:
    """Blocks in explicit motion from where a step starts.

    Parameters
    ----------
    step : StepEquations
        The equations; their regularisation plays no part.
    settings : MotionSettings
        How blocks are moved.
    velocity : (n, 3) float64 [sqrt(m), sqrt(m), rad / sqrt(m)], optional
        Where it begins: the root of twice the height of a fall to it.
    ramp : int
        Cycles in which the residual at the start is brought on; 0: it acts at once.

    Attributes
    ----------
    residual : Residual
        Where blocks are, and their residual there.
    contacts : ContactSet
        With what slipped and broke on the way.
    contacted : (m,) bool
        Contacts that were closed at any time since the last search.
    cycles, searches : int
        So far.
    diverged : bool
        Whether the last window ended nowhere; where blocks are is from before it.
    """

    def __init__(
        self, step: StepEquations, settings: MotionSettings, *, velocity: FloatArray | None = None, ramp: int = 0
    ) -> None:
        self._settings, self._ramp = settings, ramp
        self._step = step.with_regularization(0.0).with_system_of_its_own()
        self.system: BlockSystem = self._step.system
        self.cycles, self.searches, self.diverged = 0, 0, False
        self.residual: Residual = self._step.residual_at(step.anchor)
        self._searched = self.residual.position
        self.contacted = self.residual.at.closed.copy()
        self._ramped_load = self.residual.forces if ramp else np.zeros_like(step.start)
        self._strips = strips(self.system.outlines.centroid, step.factors.options.threads)
        self._rows, self._frame, self._spring, self._flags = self._near()
        given = np.zeros_like(step.start) if velocity is None else velocity
        self._masses = Masses(self._step, settings, self._weighed(), given)
        self._velocity = given / np.sqrt(self._masses.inverse_rate)
        self._prescribed, self._prescribed_cycles = self._prescribed_per_cycle(step)

    @property
    def equations(self) -> StepEquations:
        """The step's equations, regularisation apart, with the contacts as they are."""
        return self._step

    @property
    def contacts(self) -> ContactSet:
        """The contacts, with what slipped and broke so far."""
        return self._step.contacts

    @property
    def velocity(self) -> FloatArray:
        """Velocity (n, 3), its square twice the height of a free fall to it [sqrt(m), sqrt(m), rad / sqrt(m)]."""
        velocity: FloatArray = self._velocity * np.sqrt(self._masses.inverse_rate)
        return velocity

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the blocks, their masses and time those of cycles [N]."""
        return float(np.einsum("ij,ij,ij", self._masses.mass, self._velocity, self._velocity) / 2)

    @property
    def fall_cycles(self) -> float:
        """In how many cycles a block falls freely by a step length."""
        return float(np.sqrt(2 * self.system.d * self._masses.inverse_rate))

    @property
    def loading_cycles(self) -> int:
        """Cycles after which the ramp is over, and supports have arrived."""
        return max(self._ramp, self._prescribed_cycles)

    @property
    def is_loaded(self) -> bool:
        """Whether all loads act, and supports have arrived."""
        return self.cycles >= self.loading_cycles

    @property
    def passed(self) -> float:
        """How far blocks have passed each other, or moved, since contacts were searched for [m]."""
        moved = self.residual.position - self._searched
        return max(self._step.max_relative_movement(moved), self._step.movement(moved))

    def search(self) -> None:
        """Accept what slipped and broke, and search for contacts again."""
        step, position = self._step, self.residual.position
        history, _ = commit(step.contacts, self.residual.at, position, self.system.outlines.size)
        self._step = step.updated(self.system.gather(history, position, first=False), position)
        self.residual, self._searched = self._step.residual_at(position), position
        self.searches += 1
        self.contacted = self.residual.at.closed.copy()
        self._rows, self._frame, self._spring, self._flags = self._near()

    def advance(self, max_cycles: int | None = None) -> None:
        """Go through a window, of `max_cycles` at most, and keep what slips, breaks and yields in it."""
        self._masses.update(self._weighed())
        contacts, at, rows, supports = self.contacts, self.residual.at, self._rows, self._step.supports
        state = np.zeros(len(rows), STATE)
        state["shear"], state["tension"] = np.where(at.closed, at.shear, 0.0)[rows], contacts.tension[rows]
        self._spring["dashpot"] = self._masses.dashpots(self._weighed())
        candidates = contacts.candidates
        share = Share(
            block_a=candidates.block_a[rows],
            block_b=candidates.block_b[rows],
            frame=self._frame,
            spring=self._spring,
            state=state,
            events=self._flags.copy(),
            slips=self._slips(),
            growths=self._growths(),
        )
        cycles = min(self._settings.cycles, max_cycles or self._settings.cycles)
        # A window may end early: what its supports have not moved would be lost.
        if self.cycles < self._prescribed_cycles:
            cycles = min(cycles, self._prescribed_cycles - self.cycles)
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
        )
        self.cycles += went
        self.diverged = not np.isfinite(moved).all()
        if self.diverged:
            return
        self._keep(self.residual.position + moved, share)
        self._rows, self._frame, self._spring, self._flags = self._near()

    def _slips(self) -> RecordArray:
        """Return what slip does to the contacts that may close (k,), as kernels take it; none where it does nothing."""
        catalogue, contacts = self.system.catalogue, self.contacts
        slips = np.zeros(len(self._rows) if catalogue.wears or catalogue.dilates or catalogue.stiffens else 0, SLIP)
        if catalogue.dilates:
            opening, dilating = np.zeros((2, contacts.count)), contacts.dilating
            opening[:, dilating.rows] = dilating.slope, dilating.room(contacts.slip_path)
            slips["dilation"], slips["room"] = opening[:, self._rows]
        return slips

    def _growths(self) -> RecordArray:
        """Return the shear stiffness that grows of the contacts that may close (k,); none where none does."""
        contacts, growing, rows = self.contacts, self.contacts.growing, self._rows
        growths = np.zeros(len(rows) if len(growing.rows) else 0, GROWTH)
        if not len(growths):
            return growths
        number = np.full(contacts.count, -1)
        number[rows] = np.arange(len(rows))
        mine = growing.of(number)
        columns = dict(zip(ShearCurve._fields, mine.curve.T, strict=True))
        columns |= {"length": mine.length, "compliance": mine.compliance}
        for name, column in columns.items():
            growths[name][mine.rows] = column
        growths["pressure"] = self._spring["pressure"]
        growths["stiffness"] = self.residual.at.springs.stiffness[rows]
        growths["stiffest"] = np.maximum(self._spring["normal_stiffness"], growths["stiffness"])
        return growths

    def _window(self) -> float:
        """Return how far a block moves in a window at most [m]: less where slip would wear strength off meanwhile."""
        whole, contacts = self._settings.window * self.system.d, self.contacts
        if not self.system.catalogue.wears:
            return whole
        slides = np.zeros(contacts.count, dtype=bool)
        slides[self._rows] = ~self.residual.at.failed[self._rows]
        for law, rows in contacts.by_law:
            wear_length = wear_length_of(self.system.catalogue.laws[law])
            if wear_length is not None:
                room = wear_room(self._settings.window, wear_length, contacts.slip_path[rows][slides[rows]])
                whole = min(whole, float(room.min(initial=whole)))
        return whole

    def _weighed(self) -> Weighed:
        candidates, rows = self.contacts.candidates, self._rows
        return candidates.block_a[rows], candidates.block_b[rows], self._frame, self._spring

    def _near(self) -> tuple[IntArray, SingleArray, RecordArray, NDArray[np.uint8]]:
        """Return the contacts (k,) that may close within a window; frames, springs and flags as kernels take them."""
        contacts, at = self.contacts, self.residual.at
        margin = 3 * self._settings.window * self.system.d
        gap = at.gap - contacts.offset
        low, high = (
            -contacts.edge_overhang - at.tangential,
            contacts.candidates.edge_length + contacts.edge_overhang - at.tangential,
        )
        near = (gap < margin) & (low < margin) & (high > -margin) & (contacts.normal_stiffness > 0)
        if len(contacts.opposing) or len(contacts.entering):
            tangent = contacts.frames(at.position)[0]
            near &= resolve_corner_corner(contacts, at.position, at.gap, tangent, at.closed)
        rows = np.flatnonzero(at.closed | near)
        candidates = contacts.candidates
        frame = frames(at.position, candidates.block_a[rows], candidates.block_b[rows], contacts.geometry, rows)
        pressure = np.where(at.closed, at.pressure, 0.0)
        stiffening, share = contacts.hyperbolic.stiffening(pressure, at.normal_stiffness)
        columns = {
            "normal_stiffness": at.normal_stiffness,
            "stiffening": stiffening,
            "rock_share": share,
            "shear_stiffness": at.springs.stiffness,
            "trial_pressure": np.where(at.closed, at.pressure, -contacts.normal_stiffness * gap),
            "pressure": pressure,
            "shear": np.where(at.closed, at.shear, 0.0),
            "low": low,
            "high": high,
        }
        lines, lasting = strength_lines(contacts, self.system.catalogue.laws, pressure)
        spring = np.zeros(len(rows), SPRING)
        for name, column in (columns | lines).items():  # the dashpot follows the masses
            spring[name] = column[rows]
        return rows, frame, spring, lasting[rows]

    def _acting(self) -> FloatArray:
        """Return the forces at the reference without the bolts', (n, 3)."""
        acting: FloatArray = self.system.loads_at(self.residual.position) + self.residual.at.forces
        return acting

    def _unramped_fraction(self, cycles: int) -> FloatArray:
        """Return the part of the residual at the start that does not act yet in every cycle, (cycles,)."""
        if self.cycles >= self._ramp:
            return np.zeros(cycles)
        time = np.minimum(np.arange(self.cycles + 1, self.cycles + cycles + 1) / self._ramp, 1.0)
        unramped_fraction: FloatArray = 0.5 + 0.5 * np.cos(np.pi * time)
        return unramped_fraction

    def _prescribed_per_cycle(self, step: StepEquations) -> tuple[FloatArray, int]:
        """Return by what supports move their blocks in a cycle, (n, 3), and in how many: as fast as blocks fall."""
        prescribed = step.start - step.anchor
        size = step.movement(prescribed)
        if not step.supports_move or size == 0:
            return np.zeros_like(prescribed), 0
        cycles = max(1, int(2 * self.fall_cycles * size / self.system.d))
        return prescribed / cycles, cycles

    def _prescribed_in(self, cycles: int) -> FloatArray:
        left = min(cycles, max(self._prescribed_cycles - self.cycles, 0))
        return self._prescribed * (left / cycles)

    def _keep(self, position: FloatArray, share: Share) -> None:
        """Keep where blocks are, and what slipped, broke, failed and yielded on the way."""
        step, contacts, rows, events = self._step, self.contacts, self._rows, share.events
        before = self.residual.at
        self.contacted[rows] |= (events & CONTACTED) > 0
        failed, mated = contacts.failed.copy(), contacts.mated.copy()
        failed[rows] |= (events & (BROKEN | FAILED)) > 0
        mated[rows] &= (events & BROKEN) == 0
        left = np.where(mated, np.minimum(contacts.tension, contacts.residual_tension), 0.0)
        tension = np.where(failed, left, contacts.tension)
        shear, along = np.zeros(contacts.count), np.full(contacts.count, np.nan)
        shear[rows] = share.state["shear"]
        along[rows] = before.tangential[rows] + share.state["along"]
        touched = ~np.isnan(contacts.old_tangential)
        touched[rows] |= (events & CONTACTED) > 0
        pressure = np.full(contacts.count, np.nan)
        if len(share.growths):
            pressure[rows] = share.growths["pressure"]
        here = replace(
            contacts,
            old_shear=shear,
            old_pressure=pressure,
            old_tangential=np.where(touched, along, np.nan),
        )
        path = contacts.slip_path
        if len(share.slips):
            path = path.copy()
            path[rows] += share.slips["slid"]
            offset = contacts.dilating.opened(contacts.offset, contacts.slip_path, path)
            here = replace(here, slip_path=path, offset=offset, failed=failed, mated=mated, tension=tension)
        at = step.system.evaluate(here, position)
        if not len(share.slips):  # told, and nothing more
            path = slip_path_after(contacts, before.springs, at.closed, shear, along)
        # What is open has no shear to come back to, and is anchored where it closes.
        contacts = replace(
            here,
            old_shear=np.where(at.closed, shear, 0.0),
            old_pressure=at.pressure,
            old_tangential=np.where(at.closed & ~np.isnan(along), along, np.where(touched, at.tangential, np.nan)),
            failed=failed,
            mated=mated,
            slip_path=path,
            tension=tension,
        )
        if len(share.slips):  # by the last movement too, after which no cycle asked
            contacts = worn(contacts, at)
        bolts = self.system.bolts
        if len(bolts.alive):
            self.system.bolts = bolts.commit(bolts.evaluate(position))
        self._step = step.with_contacts(contacts)
        self.residual = self._step.residual_at(position)


def wear_room(window: float, wear_length: float, slip_path: FloatArray) -> FloatArray:
    """Return how far contacts that have slid (k,) [m] slide in a window at most, (k,) [m].

    As of a step length, so of the slip in which strength changes markedly.
    """
    return window * (wear_length + slip_path)


def strength_lines(
    contacts: ContactSet, laws: tuple[JointLaw, ...], pressure: FloatArray
) -> tuple[dict[str, FloatArray], NDArray[np.uint8]]:
    """Return the shear strength of contacts by the names of `SPRING`, (m,) each, and where slip is for good, (m,).

    The tangent at the pressures (m,), and the one without pressure, or at the highest where that is the same: of a
    bilinear law they are its two lines. Then the residual line.
    """
    floor = np.finfo(float).tiny
    here = _tangent(contacts, laws, np.maximum(pressure, floor))
    low = _tangent(contacts, laws, np.full_like(pressure, floor))
    high = _tangent(contacts, laws, np.full_like(pressure, HIGH))
    other = tuple(np.where(np.isclose(here[1], low[1]), b, a) for a, b in zip(low, high, strict=True))
    residual = _tangent(replace(contacts, failed=np.ones_like(contacts.failed)), laws, np.maximum(pressure, floor))
    lines = {"first": here, "second": other, "residual": residual}
    found = {name: line[0] for name, line in lines.items()} | {f"{name}_slope": line[1] for name, line in lines.items()}
    return found, (FIRST_LASTS * here[2] + SECOND_LASTS * other[2]).astype(np.uint8)


def _tangent(contacts: ContactSet, laws: tuple[JointLaw, ...], pressure: FloatArray) -> tuple[FloatArray, ...]:
    """Return intercept and slope of the strength's tangent at pressures (m,), and 1 where slip there is for good."""
    answer = slipping(contacts, laws, pressure)
    slope = np.where(np.isfinite(answer.by_pressure), answer.by_pressure, 0.0)
    intercept = np.minimum(answer.strength, UNLIMITED) - slope * pressure
    return intercept, slope, answer.failed.astype(float)
