"""Faces that are parallel within rounding made parallel: limit analysis distinguishes a wedge from a plane.

Between two faces that are not parallel by a hair a block wedges, under a force that is as great as the hair is thin.
Coordinates of a map leave a nanometre to a double, and a mechanism that closes a contact by so little is no proof.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray, rounding_of
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.model import Model


def with_parallel_faces(model: Model, contacts: ContactTable) -> ContactTable:
    """Return contacts whose normals are the same where they differ by what rounding of coordinates leaves."""
    if not contacts.count:
        return contacts
    length = np.hypot(*model.blocks.edge_vectors[contacts.edge].T)
    off = np.maximum(rounding_of(model.blocks.vertices) / length, np.finfo(np.float64).eps)  # of the angle
    angle = np.arctan2(contacts.normal[:, 1], contacts.normal[:, 0])
    turned = angle - _widest_gap(angle % np.pi)  # no faces are parallel across the gap
    group = _groups(turned % np.pi, off)
    sign = np.where(turned % (2 * np.pi) < np.pi, 1.0, -1.0)[:, None]
    weighted = sign * contacts.normal / off[:, None] ** 2
    total: FloatArray = np.column_stack([np.bincount(group, weighted[:, k]).astype(np.float64) for k in (0, 1)])
    mean = total / np.hypot(*total.T)[:, None]
    alone = np.bincount(group)[group] == 1
    return replace(contacts, normal=np.where(alone[:, None], contacts.normal, mean[group] * sign))


def _widest_gap(angle: FloatArray) -> float:
    """Return the middle of the widest gap between angles (m,) from 0 to pi."""
    ordered = np.sort(angle)
    gap = np.diff(ordered, append=ordered[0] + np.pi)
    widest = int(gap.argmax())
    return float(ordered[widest] + gap[widest] / 2)


def _groups(angle: FloatArray, off: FloatArray) -> LongArray:
    """Return a number for every angle (m,), the same for neighbours that differ by no more than either is off twice."""
    order = np.argsort(angle)
    apart = np.diff(angle[order]) > 2 * np.minimum(off[order][1:], off[order][:-1])  # a short edge links no directions
    group = np.empty(len(angle), dtype=np.int64)
    group[order] = np.concatenate([[0], np.cumsum(apart)])
    return group
