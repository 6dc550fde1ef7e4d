"""The record of the bolts' forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.model.bolts import Bolt
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.bolts.state import bolt_status, utilisation


def bolt_forces(bolts: Sequence[Bolt], installed: InstalledBolts, at: BoltEvaluation) -> BoltForces:
    """Return the record of the bolts' forces; the rock's displacement at the nodes is left zero.

    Parameters
    ----------
    bolts : sequence of Bolt
        As given, for their names.
    installed : InstalledBolts
        In the numbers of the whole.
    at : BoltEvaluation
        Their forces.
    """
    layout, dowels = installed.layout, installed.dowels
    shear, point, across = np.zeros(len(at.tension)), np.zeros_like(at.direction), np.zeros_like(at.direction)
    shear[dowels.element], point[dowels.element] = at.dowels.force, at.dowels.point
    across[dowels.element] = at.dowels.across
    used, limit = utilisation(installed, at)
    return BoltForces(
        names=tuple(bolt.name or f"bolt {k + 1}" for k, bolt in enumerate(bolts)),
        node_start=layout.node_start,
        block=layout.block,
        station=layout.station,
        original=layout.point,
        point=at.point,
        displacement=np.zeros_like(at.point),
        spacing=layout.spacing,
        status=bolt_status(installed, at),
        alive=installed.alive,
        axial_force=at.tension,
        bond_force=at.bond_force,
        slip=at.slip,
        plastic_stretch=installed.yielded,
        utilisation=used,
        limit=limit,
        shear_force=shear,
        shear_point=point,
        shear_direction=across,
    )
