"""Columns of a window of cycles from the contacts at its reference: which may close, and their columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.feature import Springs
from bsm_mesh.contact.forces import ContactSet, Evaluation, resolve_corner_corner, slipping
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.model.joint_laws import JointLaw, JointResponse, remembered_by
from bsm_mesh.model.joint_laws.shear_stiffness import ShearCurve
from bsm_mesh.solve.motion.contact_columns import (
    CLOSURE,
    CONTACT,
    FRAME,
    GROWTH,
    SLIP,
    STRENGTH,
    WORK,
    ChunkArray,
    SingleArray,
    chunked,
    frames,
)
from bsm_mesh.solve.motion.threads import Share

UNLIMITED = 1e30  # strength of what cannot slip [N/m], in single precision
HIGH, FLOOR = 1e12, np.finfo(float).tiny  # pressures above all others, and below [N/m]
Columns = dict[str, SingleArray]  # (k,) each, by the names of CONTACT, STRENGTH and CLOSURE


def near(contacts: ContactSet, at: Evaluation, margin: float) -> IntArray:
    """Return the contacts (k,) that are closed, or so within a movement of `margin` [m]."""
    low, high = _range(contacts, at)
    near = (at.gap - contacts.offset < margin) & (low < margin) & (high > -margin) & (contacts.normal_stiffness > 0)
    if len(contacts.opposing) or len(contacts.entering):
        tangent = contacts.frames(at.position)[0]
        near &= resolve_corner_corner(contacts, at.position, at.gap, tangent, at.closed)
    return np.flatnonzero(at.closed | near)


def _range(contacts: ContactSet, at: Evaluation) -> tuple[FloatArray, FloatArray]:
    """Return least and greatest movement along the edge within which corners meet it, (m,) each [m]."""
    beyond = contacts.edge_overhang
    return -beyond - at.tangential, contacts.candidates.edge_length + beyond - at.tangential


def columns_of(contacts: ContactSet, at: Evaluation, lines: Mapping[str, FloatArray], rows: IntArray) -> Columns:
    """Return the columns of some of the contacts, `rows` (k,), with their strength; the dashpots follow the masses.

    `lines`: as `strength_lines` returns them.
    """
    candidates = contacts.candidates
    frame = frames(at.position, candidates.block_a[rows], candidates.block_b[rows], contacts.geometry, rows)
    pressure, (low, high) = np.where(at.closed, at.pressure, 0.0), _range(contacts, at)
    stiffening, share = contacts.features.closure.stiffening(pressure, at.normal_stiffness)
    shear = np.where(at.closed, at.shear, 0.0)
    trial = np.where(at.closed, at.pressure, -contacts.normal_stiffness * (at.gap - contacts.offset))
    columns = {
        **lines,
        "normal_stiffness": at.normal_stiffness,
        "stiffening": stiffening,
        "rock_share": share,
        "shear_stiffness": at.springs.stiffness,
        "trial_pressure": trial,
        "pressure": pressure,
        "shear": shear,
        "carried": shear,
        "tension": contacts.tension,
        "low": low,
        "high": high,
    }
    chosen = {name: column[rows].astype(np.float32) for name, column in columns.items()}
    return chosen | dict(zip(FRAME, frame, strict=True))


def share_of(
    contacts: ContactSet,
    at: Evaluation,
    catalogue: JointCatalogue,
    rows: IntArray,
    columns: Columns,
    *,
    works: bool = False,
) -> Share:
    """Return some of the contacts, `rows` (k,) with their columns, as kernels take them; `works`: with their work."""
    candidates, slips = contacts.candidates, works or catalogue.wears or catalogue.dilates or catalogue.stiffens
    return Share(
        block_a=candidates.block_a[rows].astype(np.uint32),  # unsigned: none counts from the end
        block_b=candidates.block_b[rows].astype(np.uint32),
        **chunks_of(contacts, at.springs, rows, columns, slips=slips, works=works),
    )


def chunks_of(
    contacts: Any, springs: Springs, rows: IntArray, columns: Columns, *, slips: bool, works: bool
) -> dict[str, Any]:
    """Return the chunks of some contacts, by the names of `Share`.

    Parameters
    ----------
    contacts : object
        With `count`, `features` and `slip_path`.
    springs : Springs
        Their shear springs.
    rows : (k,) int
        The contacts.
    columns : dict
        Theirs, by name.
    slips, works : bool
        Whether to count slip, and work.
    """
    count = len(rows)
    return {
        "contacts": _chunks(CONTACT, columns, count),
        "strengths": _chunks(STRENGTH, columns, count if _is_more_than_a_line(columns) else 0),
        "closures": _chunks(CLOSURE, columns, count if columns["stiffening"].any() else 0),
        "slips": _slips(contacts, rows) if slips else np.zeros(0, SLIP),
        "growths": _growths(contacts, springs, rows, columns),
        "works": _chunks(WORK, _of_work(columns), count) if works else None,
    }


def _chunks(kind: np.dtype[np.void], columns: Mapping[str, FloatArray | SingleArray], count: int) -> ChunkArray:
    """Return those of the columns that `kind` has of `count` contacts, in chunks: all, or none."""
    return chunked(kind, {name: columns[name][:count] for name in kind.names or () if name in columns}, count)


def _is_more_than_a_line(columns: Columns) -> bool:
    """Return whether the strength of a contact has two lines, or something to lose."""
    two = (columns["first"] != columns["second"]) | (columns["first_slope"] != columns["second_slope"])
    return bool((two | (columns["first_lasts"] > 0) | (columns["second_lasts"] > 0) | (columns["tension"] > 0)).any())


def _slips(contacts: Any, rows: IntArray) -> ChunkArray:
    """Return what slip does to some of the contacts."""
    opening = contacts.features.dilating.columns(contacts.slip_path)
    return _chunks(SLIP, dict(zip(("dilation", "room"), opening[:, rows], strict=True)), len(rows))


def _growths(contacts: Any, springs: Springs, rows: IntArray, columns: Columns) -> ChunkArray:
    """Return the shear stiffness that grows of some of the contacts; none where none does."""
    growing, count = contacts.features.growing, len(rows)
    if not len(growing.rows):
        return np.zeros(0, GROWTH)
    number = np.full(contacts.count, -1)
    number[rows] = np.arange(count)
    mine = growing.of(number)
    names = *ShearCurve._fields, "length", "compliance"
    grown = dict(zip(names, mine.spread(count, *mine.curve.T, mine.length, mine.compliance), strict=True))
    stiffness = springs.stiffness[rows]
    last = {"stiffness": stiffness, "stiffest": np.maximum(columns["normal_stiffness"], stiffness)}
    return _chunks(GROWTH, grown | last | {"last_pressure": columns["pressure"]}, count)


class ExtremeLines:
    """Tangents of the shear strength of contacts without pressure and at the highest, as `_tangent` returns them.

    Contacts are a `ByLaw`, a dataclass with `failed`.
    """

    def __init__(self, contacts: Any, laws: tuple[JointLaw, ...]) -> None:
        self._contacts, self._laws = contacts, laws
        none, most = np.full((2, contacts.count), [[FLOOR], [HIGH]])
        self.low = _tangent(slipping(contacts, laws, none), none)
        self.high = _tangent(slipping(contacts, laws, most), most)

    def hold_for(self, contacts: Any) -> bool:
        """Return whether they are those of contacts: neither these nor the state that laws ask for has changed."""
        before, names = self._contacts, {"failed"}.union(*map(remembered_by, self._laws))
        pairs = [(getattr(before, name), getattr(contacts, name)) for name in names]
        return before.candidates is contacts.candidates and all(a is b or np.array_equal(a, b) for a, b in pairs)


def strength_lines(contacts: Any, at: Any, laws: tuple[JointLaw, ...], extreme: ExtremeLines) -> dict[str, FloatArray]:
    """Return the shear strength of contacts by the names of their columns, (m,) each; `at` says `closed`, `pressure`.

    The tangent at the pressures there are, and the one without pressure, or at the highest where that is the same: of a
    bilinear law they are its two lines. Then the residual line, and where slip is for good that has not been.
    """
    pressure = np.where(at.closed, np.maximum(at.pressure, FLOOR), FLOOR)
    here, low, high = _tangent(slipping(contacts, laws, pressure), pressure), extreme.low, extreme.high
    alike = np.isclose(here[1], low[1])
    other = tuple(np.where(alike, b, a) for a, b in zip(low, high, strict=True))
    failed = replace(contacts, failed=np.ones_like(contacts.failed))
    residual = _tangent(slipping(failed, laws, pressure), pressure)
    lines = {"first": here, "second": other, "residual": residual}
    found = {name: line[0] for name, line in lines.items()} | {f"{name}_slope": line[1] for name, line in lines.items()}
    return found | {"first_lasts": here[2] * ~contacts.failed, "second_lasts": other[2] * ~contacts.failed}


def _tangent(answer: JointResponse, pressure: FloatArray) -> tuple[FloatArray, ...]:
    """Return intercept and slope of the strength's tangent at pressures (m,), and 1 where slip there is for good."""
    slope = np.where(np.isfinite(answer.by_pressure), answer.by_pressure, 0.0)
    intercept = np.minimum(answer.strength, UNLIMITED) - slope * pressure
    return intercept, slope, answer.failed.astype(float)


def _of_work(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of work at the begin of a window: dashpots along the edge have the lag of those across it."""
    stiffness = columns["normal_stiffness"].astype(np.float64)
    lag = np.divide(columns["dashpot"], stiffness, out=np.zeros(len(stiffness)), where=stiffness > 0)
    return {name: columns[name] for name in ("pressure", "last") if name in columns} | {"lag": lag}
