"""Forces of bolts by two methods."""

from __future__ import annotations

import numpy as np

from bsm_mesh.converters.continuum.differences import Difference, measure_difference
from bsm_mesh.results.bolts import BoltForces


def bolt_force_error(bsm: BoltForces, fem: BoltForces) -> tuple[Difference, str] | None:
    """Return how far the tensions of elements lie apart, and the bolt where it is most; None where there are none.

    Parameters
    ----------
    bsm, fem : BoltForces
        Of both methods, the same bolts with the same nodes.
    """
    ours, theirs = bsm.axial_force * bsm.alive, fem.axial_force * fem.alive
    if not (ours.any() or theirs.any()):
        return None
    bolt = np.repeat(np.arange(len(bsm.names)), np.diff(bsm.node_start) - 1)
    inner = np.ones(len(bsm.station), dtype=bool)
    inner[bsm.node_start[1:] - 1] = False
    first = np.flatnonzero(inner)
    length = bsm.station[first + 1] - bsm.station[first]
    rms = float(np.sqrt((length * ours**2).sum() / length.sum()))
    error = measure_difference("bolt forces", "N", ours, theirs, length, (rms, float(np.abs(ours).max())))
    return error, bsm.names[bolt[error.worst_block]]
