"""Status and utilisation of bolts, and the pairs of blocks that they connect."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.contact.strength import MAX_UTILISATION
from bsm_mesh.results.bolts import BoltLimit, BoltStatus
from bsm_mesh.solve.bolts.chain import AT_LIMIT
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.bolts.kernels import own_coupling


def bolt_status(installed: InstalledBolts, at: BoltEvaluation) -> IntArray:
    """Return the status of every bolt: the worst along it, (n_bolts,)."""
    layout, dowels = installed.layout, installed.dowels
    bolt = layout.bolt_of_element
    sheared, shear = bolt[dowels.element], np.abs(at.dowels.force)
    state = np.full(layout.bolts, BoltStatus.SLACK)
    state[bolt[taut(installed, at)]] = BoltStatus.ELASTIC
    state[sheared[shear > AT_LIMIT * dowels.stiffness]] = BoltStatus.ELASTIC
    state[layout.bolt_of_node[slipping(installed, at)]] = BoltStatus.SLIPPING
    state[bolt[installed.yielding(at)]] = BoltStatus.YIELDING
    state[sheared[shear >= dowels.strength * (1 - AT_LIMIT)]] = BoltStatus.YIELDING
    working = np.diff(layout.node_start) == 1  # a bolt in one block is installed, without force
    working[bolt[installed.alive]] = True
    state[~working] = BoltStatus.ABSENT
    return state.astype(np.int8)


def utilisation(installed: InstalledBolts, at: BoltEvaluation) -> tuple[FloatArray, IntArray]:
    """Return the largest of tension, bond force and shear over their limits, and which it is, (n_elements,) each."""
    layout, dowels, first = installed.layout, installed.dowels, installed.layout.first_node
    bond = np.divide(np.abs(at.bond_force), layout.capacity, out=np.zeros(len(layout.block)), where=layout.capacity > 0)
    parts = np.zeros((len(BoltLimit), len(first)))
    parts[BoltLimit.STEEL] = np.maximum(at.tension, 0.0) / layout.yield_force[layout.bolt_of_element]
    parts[BoltLimit.BOND] = np.maximum(bond[first], bond[first + 1])
    parts[BoltLimit.DOWEL, dowels.element] = np.abs(at.dowels.force) / dowels.strength
    return np.minimum(parts.max(axis=0), MAX_UTILISATION), parts.argmax(axis=0).astype(np.int8)


def taut(installed: InstalledBolts, at: BoltEvaluation) -> BoolArray:
    """Return which elements have a tension above the rounding of their length, (n_elements,)."""
    found: BoolArray = at.tension > AT_LIMIT * installed.stiffness * at.length
    return found


def slipping(installed: InstalledBolts, at: BoltEvaluation) -> BoolArray:
    """Return which nodes are at the capacity of their bond, (n_nodes,)."""
    full = np.abs(at.bond_force) >= installed.layout.capacity * (1 - AT_LIMIT)
    pulled, first = np.zeros(len(full), dtype=bool), installed.layout.first_node[taut(installed, at)]
    pulled[first] = pulled[first + 1] = True
    found: BoolArray = full & pulled
    return found


def holding_pairs(installed: InstalledBolts, at: BoltEvaluation) -> tuple[IntArray, IntArray]:
    """Return the pairs of blocks connected by a bolt whose tension or shear rises with their separation."""
    layout, dowels = installed.layout, installed.dowels
    if not installed.alive.size:
        return np.zeros(0, np.int32), np.zeros(0, np.int32)
    own = own_coupling(layout.node_start, installed.coupling(at))
    resists = taut(installed, at) & (own > ROUNDING * installed.stiffness)  # less is left where its bond gives way
    sheared = np.abs(at.dowels.force)
    holds = (sheared > AT_LIMIT * dowels.stiffness) & (sheared < dowels.strength * (1 - AT_LIMIT))
    node = layout.first_node[resists]
    near = np.concatenate([layout.block[node], dowels.near[holds]])
    return near, np.concatenate([layout.block[node + 1], dowels.far[holds]])
