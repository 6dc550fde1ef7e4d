"""The table of bolts of a stage, a row a bolt, for the report."""

from __future__ import annotations

import numpy as np

from bsm_mesh.results.bolts import BoltForces, BoltStatus
from bsm_mesh.text.tables import engineering, most_used

BOLT_HEADER = ("bolt", "state", "greatest force", "utilisation", "force at the head", "support pressure")


def bolt_table(bolts: BoltForces) -> list[tuple[str, ...]]:
    """Return the rows of `BOLT_HEADER`; forces are those of one bolt, and a bolt that is not there has none.

    No rows where none is there.
    """
    if (bolts.status == BoltStatus.ABSENT).all():
        return []
    used = [most_used(bolts, k) for k in range(bolts.count)]
    greatest, head, pressure = bolts.greatest_force, bolts.head_force, bolts.support_pressure
    rows: list[tuple[str, ...]] = []
    for k, name in enumerate(bolts.names):
        numbers = ("-", "-", "-", "-")
        if bolts.status[k] != BoltStatus.ABSENT and not bolts.alone[k]:
            on_wall = "-" if np.isnan(pressure[k]) else engineering(float(pressure[k]), "Pa")
            most, at_head = (engineering(float(force[k]), "N") for force in (greatest, head))
            numbers = (most, used[k], at_head, on_wall)
        rows.append((name, bolts.states[k], *numbers))
    return rows
