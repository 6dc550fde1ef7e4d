"""Transfer of contact history: from the in-situ field to the first stage, and from stage to stage."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.contact_set import gather_contacts
from bsm_mesh.contact.fitted_fill import are_supported, fitted_fill
from bsm_mesh.contact.forces import ContactSet, Evaluation, evaluate
from bsm_mesh.contact.history import LEAST, History, active_contacts
from bsm_mesh.contact.in_situ import beyond_strength
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.search import ActiveContacts, Outlines, key_of, numbers_of
from bsm_mesh.contact.state import state_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.stress_field import StressField
from bsm_mesh.model.submodel import SubModel

BAND = 0.075  # of the contact search, over the block size: far beyond the tolerance within which contacts are set
_VARIABLES = tuple(field.name for field in fields(History) if field.name != "active")


def in_situ_history(model: Model) -> tuple[History, tuple[str, ...]]:
    """Return contacts with the forces of the in-situ field in the given geometry, and notes on it.

    The closure of a contact under the field is taken as past: its offset is the closure by the field's pressure.
    """
    outlines, catalogue, position, found = _as_given(model)
    normal, shear = _field_forces(model, found)
    at = evaluate(found, catalogue.laws, position)
    history = _history(found, at, position, np.flatnonzero(found.within_tolerance), normal, shear)
    set_up = gather_contacts(model, outlines, catalogue, history, position, BAND * outlines.size, first=True)
    at = evaluate(set_up, catalogue.laws, position)
    point = outlines.placed(position)[set_up.candidates.block_a, :2] + set_up.frames(position)[1]
    pressure = set_up.normal_stiffness * (set_up.offset - at.gap)
    pressure, _ = set_up.features.pressures(set_up.offset - at.gap, pressure, set_up.normal_stiffness)
    within_tolerance = set_up.within_tolerance
    peak = np.where(at.closed, at.strength, np.inf)  # tension beyond the strength is reported as such
    rows = (point, pressure, set_up.old_shear, peak, set_up.tension)
    return history, beyond_strength(*(values[within_tolerance] for values in rows))


def with_filled_blocks(
    history: History, model: Model, comes: BoolArray, there: BoolArray, moved: FloatArray
) -> tuple[History, FloatArray]:
    """Return a history with the contacts of filled blocks (n,) to those present (n,), and the movements (n, 3).

    Filled blocks fit the present position of their neighbours; supported ones are where they were given. Their
    contacts are closed without force, whatever gap is left. As all contacts that arise later they have no cohesion
    and no tensile strength; only faces of unlimited strength keep it.
    """
    outlines, catalogue, position, found = _as_given(model)
    c = found.candidates
    new = (comes[c.block_a] & there[c.block_b]) | (comes[c.block_b] & there[c.block_a])
    chosen = np.flatnonzero(found.within_tolerance & new)
    sides = c.block_a[chosen], c.block_b[chosen]
    point = outlines.centroid[sides[0]] + found.frames(position)[1][chosen]
    moved = fitted_fill(moved, comes & ~are_supported(model), sides, point, c.length[chosen], outlines.centroid)
    at = evaluate(found, catalogue.laws, moved)
    nothing = np.zeros(found.count)
    filled = _history(found, at, moved, chosen, nothing, nothing)
    parts = history, replace(filled, failed=np.isfinite(found.tension[chosen]))
    active = {f.name: np.concatenate([getattr(p.active, f.name) for p in parts]) for f in fields(ActiveContacts)}
    columns = {name: np.concatenate([getattr(p, name) for p in parts]) for name in _VARIABLES}
    both, pair = History(active=ActiveContacts(**active), **columns), active["pair"]
    return _rows(both, np.argsort(pair, kind="stable"), pair, active["key"]), moved


def _as_given(model: Model) -> tuple[Outlines, JointCatalogue, FloatArray, ContactSet]:
    """Return outlines, laws, positions and contacts of the given geometry."""
    blocks = model.blocks
    outlines, catalogue = Outlines.of(blocks, np.zeros(blocks.count, dtype=bool)), JointCatalogue(model)
    position = np.zeros((blocks.count, 3))
    band = BAND * outlines.size
    found = gather_contacts(model, outlines, catalogue, History.none(), position, band, first=True)
    return outlines, catalogue, position, found


def _field_forces(model: Model, found: ContactSet) -> tuple[FloatArray, FloatArray]:
    """Return normal and shear force of the closed contacts on faces from the field, (m,) each; zero for others."""
    blocks, c = model.blocks, found.candidates
    on_face = np.flatnonzero(found.within_tolerance & (c.parallel_edge >= 0))
    corner, edge, other = c.corner[on_face], c.edge[on_face], c.parallel_edge[on_face]
    along = blocks.edge_vectors
    unit = along[other] / np.hypot(*along[other].T)[:, None]
    away = np.where((other == corner)[:, None], unit, -unit)  # along a's edge, away from the corner
    start = blocks.vertices[corner]
    end = start + 2 * c.length[on_face][:, None] * away
    direction = along[edge] / np.hypot(*along[edge].T)[:, None]
    n = np.stack([direction[:, 1], -direction[:, 0]], axis=1)
    field = StressField(model)
    sides = (c.block_a[on_face], c.block_b[on_face])
    force = field.end_forces(start, end, n, sides, found.joint[on_face])[:, 0]
    normal, shear = np.zeros(found.count), np.zeros(found.count)
    normal[on_face] = (force * n).sum(axis=1)
    shear[on_face] = (force * direction).sum(axis=1)
    return normal, shear


def _history(
    found: ContactSet,
    at: Evaluation,
    position: FloatArray,
    kept: IntArray,
    normal: FloatArray,
    shear: FloatArray,
) -> History:
    """Return the history of some contacts with given forces, (m,) each, at the current position."""
    c = found.candidates
    offset = at.gap + found.features.closure.overlaps(-normal, found.normal_stiffness)  # to the last digit no residual
    return History(
        active=active_contacts(found, at, position, kept, np.maximum(-normal[kept], LEAST)),
        shear=shear[kept],
        tangential=at.tangential[kept],
        length=c.length[kept],
        parallel_edges=c.parallel_edges[kept],
        joint=found.joint[kept],
        **state_of(found, kept) | {"first_tangential": at.tangential[kept], "offset": offset[kept]},
    )


def between(history: History, stays: BoolArray) -> History:
    """Return the contacts between blocks that stay, (n,)."""
    low, high = numbers_of(history.active.pair)
    return _rows(history, np.flatnonzero(stays[low] & stays[high]), history.active.pair, history.active.key)


def in_part(history: History, part: SubModel) -> History:
    """Return a history of the whole in the numbers of a part; its blocks must be in the part."""
    if part.present.all():
        return history
    pair, key = history.active.pair, history.active.key
    low, high = (np.searchsorted(part.block, block) for block in numbers_of(pair))
    corner, edge = (np.searchsorted(part.corner, corner) for corner in numbers_of(key))
    return _rows(history, np.arange(len(pair)), key_of(low, high), key_of(corner, edge))


def in_whole(history: History, part: SubModel) -> History:
    """Return a history of a part in the numbers of the whole."""
    if part.present.all():
        return history
    pair, key = history.active.pair, history.active.key
    blocks = key_of(*(part.block[block] for block in numbers_of(pair)))
    corners = key_of(*(part.corner[corner] for corner in numbers_of(key)))
    return _rows(history, np.arange(len(pair)), blocks, corners)


def _rows(history: History, chosen: IntArray, pair: IntArray, key: IntArray) -> History:
    old = history.active
    active = ActiveContacts(
        pair=pair[chosen],
        key=key[chosen],
        pressure=old.pressure[chosen],
        point=old.point[chosen],
        normal=old.normal[chosen],
    )
    return History(active=active, **{name: getattr(history, name)[chosen] for name in _VARIABLES})
