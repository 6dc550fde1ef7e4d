"""The record of the bolts' forces, and in what state each bolt is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.strength import MOST_UTILISATION
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.results.bolts import BoltForces, BoltStatus
from bsm_mesh.solve.bolt_chain import AT_LIMIT
from bsm_mesh.solve.bolts import ROUNDING, BoltEvaluation, InstalledBolts


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
    shear, point, across = np.zeros(len(at.tension)), np.zeros((len(at.tension), 2)), np.zeros((len(at.tension), 2))
    shear[dowels.element], point[dowels.element] = at.dowels.force, at.dowels.point
    across[dowels.element] = at.dowels.across
    return BoltForces(
        names=tuple(bolt.name or f"bolt {k + 1}" for k, bolt in enumerate(bolts)),
        node_start=layout.node_start,
        block=layout.block,
        station=layout.station,
        original=layout.point,
        point=at.point,
        displacement=np.zeros_like(at.point),
        spacing=layout.spacing,
        status=_status(installed, at),
        alive=installed.alive,
        axial_force=at.tension,
        bond_force=at.bond_force,
        slip=at.slip,
        plastic_stretch=installed.yielded,
        utilisation=_utilisation(installed, at),
        shear_force=shear,
        shear_point=point,
        shear_direction=across,
    )


def _utilisation(installed: InstalledBolts, at: BoltEvaluation) -> FloatArray:
    """Return the greatest of tension, bond force and shear over what each may be, (n_elements,)."""
    layout, dowels, first = installed.layout, installed.dowels, installed.layout.first_node
    bond = np.divide(np.abs(at.bond_force), layout.capacity, out=np.zeros(len(layout.block)), where=layout.capacity > 0)
    used = np.maximum(at.tension, 0.0) / layout.yield_force[layout.bolt_of_element]
    used = np.maximum(used, np.maximum(bond[first], bond[first + 1]))
    used[dowels.element] = np.maximum(used[dowels.element], np.abs(at.dowels.force) / dowels.strength)
    return np.minimum(used, MOST_UTILISATION)


def _status(installed: InstalledBolts, at: BoltEvaluation) -> IntArray:
    """Return the worst state along every bolt, (n_bolts,)."""
    layout, dowels = installed.layout, installed.dowels
    bolt = layout.bolt_of_element
    sheared, shear = bolt[dowels.element], np.abs(at.dowels.force)
    state = np.full(layout.bolts, BoltStatus.SLACK)
    state[bolt[installed.taut(at)]] = BoltStatus.ELASTIC
    state[sheared[shear > ROUNDING * dowels.stiffness]] = BoltStatus.ELASTIC
    state[layout.bolt_of_node[installed.slipping(at)]] = BoltStatus.SLIPPING
    state[bolt[installed.yielding(at)]] = BoltStatus.YIELDING
    state[sheared[shear >= dowels.strength * (1 - AT_LIMIT)]] = BoltStatus.YIELDING
    working = np.diff(layout.node_start) == 1  # a bolt in one block is there, and bears nothing
    working[bolt[installed.alive]] = True
    state[~working] = BoltStatus.ABSENT
    return state.astype(np.int8)
