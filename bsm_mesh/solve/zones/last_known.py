"""Where a stage without equilibrium is shown: where forces last balanced, or where motion ended."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.zones.equilibrium import Equations, Iterate


def last_known(
    begun: Equations, ended: Equations, at: Iterate, u: FloatArray, start: FloatArray, *, collapses: bool
) -> tuple[Equations, Iterate]:
    """Return equations and forces of a stage without equilibrium, at displacements u (N,) up to which it is known.

    Iterations may end anywhere. Rock that yields in large displacement, and plastic collapse, stay where they ended:
    that shows how rock yields.

    Parameters
    ----------
    begun, ended : Equations
        At the displacements `start` (N,), and where the search ended.
    at : Iterate
        Forces there.
    """
    if collapses or (ended.large is not None and ended.plastic is not None):
        return ended, at
    of = begun if np.array_equal(u, start) else ended
    return of, of.at(u, of.free.none)
