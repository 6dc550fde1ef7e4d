"""Joint forces of two methods, summed between every pair of blocks."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.continuum.differences import Difference, measure_difference
from bsm_mesh.results.records import ContactForces


def joint_force_error(
    bsm: ContactForces, fem: ContactForces, held: BoolArray
) -> tuple[Difference, tuple[int, int]] | None:
    """Return how far joint forces lie apart, and the pair of blocks where it is most; None if there are none.

    Parameters
    ----------
    bsm, fem : ContactForces
        Of both methods.
    held : (n,) bool
        Blocks with a support. Forces between two of them are left out, for the blocks do not know them.
    """
    count = len(held)
    (ours, of_ours), (theirs, of_theirs) = (_between_pairs(contacts, held) for contacts in (bsm, fem))
    keys = np.union1d(ours, theirs)
    if not keys.size:
        return None
    one, other = np.zeros((len(keys), 2)), np.zeros((len(keys), 2))
    one[np.searchsorted(keys, ours)] = of_ours
    other[np.searchsorted(keys, theirs)] = of_theirs
    error = measure_difference("joint forces", "N/m", one, other, np.ones(len(keys)))
    pair = int(keys[error.worst_block])
    return error, (pair // count, pair % count)


def _between_pairs(contacts: ContactForces, held: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return pairs of blocks as numbers (k,), and the force on the higher block of each (k, 2)."""
    a, b = contacts.block_a, contacts.block_b
    rows = (contacts.joint >= 0) & ~(held[a] & held[b])
    low, high = np.minimum(a, b)[rows].astype(np.int64), np.maximum(a, b)[rows]
    force = contacts.force[rows] * np.where(b[rows] == high, 1.0, -1.0)[:, None]
    pair, place = np.unique(low * len(held) + high, return_inverse=True)
    total: FloatArray = np.stack([np.bincount(place, part, minlength=len(pair)) for part in force.T], axis=1).astype(
        np.float64
    )
    return pair, total
