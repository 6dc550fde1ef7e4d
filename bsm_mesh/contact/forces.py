"""Contact forces at a position by the exact laws."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, Protocol

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.contact.feature import Curve, Movement, Springs
from bsm_mesh.contact.features import Features
from bsm_mesh.contact.force_kernels import (
    add_moving_forces,
    pressures_and_trial_shears,
    relative_positions,
)
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import ContactPairs, Outlines
from bsm_mesh.contact.state import ContactState
from bsm_mesh.errors import ModelError
from bsm_mesh.model.joint_laws import BEYOND_STRENGTH, JointLaw, JointResponse, memory_of, signed
from bsm_mesh.model.strength import law_name
from bsm_mesh.movements import turned

# Contacts whose response is evaluated in one go: temporary arrays stay in the cache. As many are worth a thread in
# explicit motion; with fewer, threads wait more than they work.
AT_ONCE = 15_000


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactSet(ContactState):
    """The contact candidates of a step with all that their forces depend on; constant within the step."""

    outlines: Outlines  # of all blocks
    candidates: ContactPairs
    joint: IntArray  # (m,) number in ``model.joints``; -1: unjointed rock
    law: IntArray  # (m,) number in `JointCatalogue.laws`
    geometry: FloatArray  # (m, 8) of the given geometry, as in `given_geometry`
    normal_stiffness: FloatArray  # (m,) per metre of thickness
    shear_stiffness: FloatArray
    tension: FloatArray  # (m,) N/m
    residual_tension: FloatArray  # (m,) N/m, that slip leaves of it
    old_shear: FloatArray
    old_pressure: FloatArray  # at which that shear force was; nan: it belongs to the present one
    old_tangential: FloatArray  # nan: no shear force before an accepted step with the contact closed
    edge_overhang: FloatArray  # (m,) how far beyond the edge's ends the contact may still be closed in this step
    within_tolerance: BoolArray
    opposing: IntArray  # (k,) corner-corner candidates that have an opposing one
    entering: IntArray  # (l,) candidates whose corner has an edge that enters the other block
    entering_direction: FloatArray  # (l, 2) that edge's unit direction from the corner, in a's frame
    features: Features
    by_law: tuple[tuple[int, IntArray | slice], ...]  # number of every law in use, and its rows

    @property
    def count(self) -> int:
        """Number of candidates."""
        return len(self.offset)

    def relative_positions(self, position: FloatArray) -> tuple[FloatArray, ...]:
        """Return gap and coordinate along the edge (m,), edge direction (m, 2), both arms to the corner (m, 2)."""
        blocks = self.candidates.block_a, self.candidates.block_b
        found: tuple[FloatArray, ...] = relative_positions(position, *blocks, self.geometry)
        return found

    def after_slip(self, further: FloatArray) -> dict[str, FloatArray]:
        """Return the state variables that slip changes, after a further slip (m,) [m]: it may open contacts."""
        changed = ContactState.after_slip(self, further)
        return changed | {"offset": self.features.opened(self.offset, self.slip_path, changed["slip_path"])}

    def frames(self, position: FloatArray) -> tuple[FloatArray, ...]:
        """Return edge direction and both arms to the corner, (m, 2) each."""
        return self.relative_positions(position)[2:]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Evaluation:
    """Contact forces at a position and their derivatives; evaluating changes no state.

    Several are kept while a step is solved. Edge directions and arms, half of the memory, are not among them: `frames`
    evaluates them again for a tangent, in a hundredth of the time of its factorization.
    """

    position: FloatArray
    gap: FloatArray
    tangential: FloatArray
    pressure: FloatArray
    shear: FloatArray
    normal_stiffness: FloatArray  # derivative of the pressure by the closure
    closed: BoolArray
    sticking: BoolArray
    strength: FloatArray
    dshear_dpressure: FloatArray
    failed: BoolArray
    forces: FloatArray
    springs: Springs
    slip: FloatArray  # (h,) of the dilating contacts in this step [m], not negative

    @property
    def bears(self) -> BoolArray:
        """Which contacts carry more than rounding of the greatest force, (m,)."""
        force = np.maximum(np.abs(self.pressure), np.abs(self.shear))
        more: BoolArray = self.closed & (force > ROUNDING * force.max(initial=0.0))
        return more

    @property
    def at_strength(self) -> BoolArray:
        """Which contacts carry their full shear strength, (m,): they slip, or are about to."""
        full: BoolArray = self.bears & ~(self.sticking & (np.abs(self.shear) < (1 - ROUNDING) * self.strength))
        return full


def evaluate(
    contacts: ContactSet,
    laws: tuple[JointLaw, ...],
    position: FloatArray,
) -> Evaluation:
    """Return the contact forces on the blocks at a position (n, 3) and their derivatives."""
    c = contacts.candidates
    gap, tangential, *frames = contacts.relative_positions(position)
    slip, offset = gap[:0], contacts.offset
    springs = Springs(contacts.shear_stiffness, contacts.old_shear, gap[:0], gap[:0])
    here = Movement(contacts, gap, tangential, partial(pressures_of, contacts), partial(strength_of, contacts, laws))
    for feature in contacts.features:
        springs = feature.springs(springs, here)
        slip, offset = feature.slips(slip, offset, springs, here)
    pressure, trial, closed, _ = pressures_and_trial_shears(
        gap,
        tangential,
        offset,
        c.edge_length,
        contacts.edge_overhang,
        contacts.normal_stiffness,
        springs.stiffness,
        contacts.tension,
        contacts.old_tangential,
        springs.old_shear,
    )
    if len(contacts.opposing) or len(contacts.entering):
        closed &= resolve_corner_corner(contacts, position, gap, frames[0], closed)
        pressure[~closed] = 0.0
    pressure, stiffness = contacts.features.pressures(offset - gap, pressure, contacts.normal_stiffness)
    answer = respond(contacts, laws, pressure, trial, closed)
    forces = np.zeros((len(position), 3))
    add_moving_forces(c.block_a, c.block_b, *frames, pressure, answer.shear, forces)
    return Evaluation(
        position=position,
        gap=gap,
        tangential=tangential,
        pressure=pressure,
        shear=answer.shear,
        normal_stiffness=stiffness,
        closed=closed,
        sticking=answer.sticking & ~np.isnan(contacts.old_tangential),
        strength=answer.strength,
        dshear_dpressure=answer.by_pressure,
        failed=answer.failed,
        forces=forces,
        springs=springs,
        slip=slip,
    )


def pressures_of(contacts: Any, rows: IntArray) -> Curve:
    """Return what gives the pressures of some rows (k,) at overlaps, and their derivatives."""
    number = np.full(contacts.count, -1)
    number[rows] = np.arange(len(rows))
    features, stiffness = contacts.features.of(number), contacts.normal_stiffness[rows]
    return lambda overlap: features.pressures(overlap, stiffness * overlap, stiffness)


def strength_of(contacts: Any, laws: tuple[JointLaw, ...], rows: IntArray) -> Curve:
    """Return what gives the strength of some rows (k,) at pressures, and its derivative, as slipping contacts have."""
    length = contacts.candidates.length[rows]
    parts = rows_by_law(contacts.law[rows])

    def strength(pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        found, slope = np.zeros(len(rows)), np.zeros(len(rows))
        for number, k in parts:
            slips = np.full_like(pressure[k], BEYOND_STRENGTH)
            law = laws[number]
            with _named(law, pressure[k]):
                answer = law.respond(pressure[k], slips, length[k], *memory_of(law, contacts, rows[k]))
            found[k], slope[k] = answer.strength, answer.by_pressure
        return found, slope

    return strength


class ByLaw(Protocol):
    """Contacts that laws are asked about, in the plane or in space, with the state variables that these name."""

    @property
    def candidates(self) -> Any:
        """Candidates with the `length` (m,) that each represents; in space the area."""

    @property
    def by_law(self) -> tuple[tuple[int, IntArray | slice], ...]:
        """Number of every law in use, and its rows."""

    @property
    def count(self) -> int:
        """Number of contacts."""


def respond(
    contacts: ByLaw,
    laws: tuple[JointLaw, ...],
    pressure: FloatArray,
    trial: FloatArray,
    in_friction: BoolArray,
) -> JointResponse:
    """Return every contact's response by its own law to pressures and trial shears (m,).

    Contacts that are not `in_friction` (m,) carry no shear. They are evaluated some at a time, so that temporary arrays
    stay in the processor's cache.
    """
    pieces = [(laws[law], k) for law, rows in contacts.by_law for k in _pieces(rows, contacts.count)]
    length = contacts.candidates.length
    names = [] if len(pieces) == 1 else [field.name for field in fields(JointResponse)]
    whole = {name: np.zeros(contacts.count, bool if name in ("sticking", "failed") else float) for name in names}
    for law, k in pieces:
        rubs = in_friction[k]
        pressed, tried = np.where(rubs, pressure[k], 0.0), np.where(rubs, trial[k], 0.0)
        with _named(law, pressed):
            answer = law.respond(pressed, np.abs(tried), length[k], *memory_of(law, contacts, k))
        strength, sticking = np.where(rubs, answer.strength, 0.0), answer.sticking & rubs
        answer = replace(signed(answer, tried), strength=strength, sticking=sticking)
        if len(pieces) == 1:
            return answer
        for name, values in whole.items():
            values[k] = getattr(answer, name)
    return JointResponse(**whole)


@contextmanager
def _named(law: JointLaw, pressure: FloatArray) -> Iterator[None]:
    """Raise a `ModelError` where a law of the user's own fails at pressures (m,)."""
    try:
        yield
    except Exception as error:
        raise ModelError(
            f"the law {law_name(law)}: respond failed at pressures of {pressure.min(initial=0.0):.3g} to "
            f"{pressure.max(initial=0.0):.3g} N/m: {type(error).__name__}: {error}"
        ) from error


def _pieces(rows: IntArray | slice, count: int) -> Iterator[IntArray | slice]:
    """Return some of the rows at a time; all of `count` where they are a slice."""
    if not isinstance(rows, slice):
        return (rows[k : k + AT_ONCE] for k in range(0, len(rows), AT_ONCE))
    return (slice(k, k + AT_ONCE) for k in range(0, count, AT_ONCE))


def slipping(contacts: ByLaw, laws: tuple[JointLaw, ...], pressure: FloatArray) -> JointResponse:
    """Return the response with every contact slipping at pressures (m,): its strength, and whether it fails."""
    everywhere = np.ones(contacts.count, dtype=bool)
    return respond(contacts, laws, pressure, np.full_like(pressure, BEYOND_STRENGTH), everywhere)


def rows_by_law(law: IntArray) -> tuple[tuple[int, IntArray | slice], ...]:
    """Return the number of every law in use, and its rows among the laws of contacts (m,)."""
    used = np.flatnonzero(np.bincount(law))  # much quicker than unique
    if len(used) == 1:
        return ((int(used[0]), slice(None)),)
    return tuple((int(number), np.flatnonzero(law == number)) for number in used)


def resolve_corner_corner(
    contacts: ContactSet, position: FloatArray, gap: FloatArray, tangent: FloatArray, closed: BoolArray
) -> BoolArray:
    """Return which candidates may be closed at a position, (m,).

    Of two opposing corner-corner candidates keep the one that has been closed since the last accepted step, else the
    one with the smaller penetration: with both, the next search would drop one of them, and steps would flip between
    the two for ever. Of a corner with an entering edge keep none until the blocks have rotated.

    Parameters
    ----------
    contacts : ContactSet
        All candidates.
    position : (n, 3) float64 [m, m, rad]
        Where blocks are.
    gap, tangent : (m,) float64 [m], (m, 2) float64
        There.
    closed : (m,) bool
        Which are pressed, of those that may be and of the others.
    """
    allowed = np.ones(contacts.count, dtype=bool)
    allowed[contacts.opposing] = _is_the_way_out(contacts.candidates, contacts.opposing, gap, closed)
    allowed[contacts.entering] &= _no_longer_entering(contacts, position, tangent)
    return allowed


def _is_the_way_out(candidates: ContactPairs, rows: IntArray, gap: FloatArray, closed: BoolArray) -> BoolArray:
    """Return which rows go before their opposing candidate, (k,); of equally deep ones the first."""
    other = candidates.opposing_candidate[rows]
    smaller = (gap[rows] > gap[other]) | ((gap[rows] == gap[other]) & (rows < other))
    other_bears = (candidates.history[other] >= 0) & closed[other]
    first: BoolArray = smaller & ~other_bears
    return first


def _no_longer_entering(contacts: ContactSet, position: FloatArray, tangent: FloatArray) -> BoolArray:
    """Return which rows with an entering edge have none any more after the rotations, (l,)."""
    edge = turned(contacts.entering_direction, position[contacts.candidates.block_a[contacts.entering], 2])
    t = tangent[contacts.entering]
    away: BoolArray = edge[:, 1] * t[:, 0] - edge[:, 0] * t[:, 1] <= RULES.entrance
    return away
