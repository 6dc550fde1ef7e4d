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
    length = bsm.station[bsm.first_node + 1] - bsm.station[bsm.first_node]
    rms = float(np.sqrt((length * ours**2).sum() / length.sum()))
    error = measure_difference("bolt forces", "N", ours, theirs, length, (rms, float(np.abs(ours).max())))
    return error, bsm.names[bsm.bolt[error.worst_block]]
