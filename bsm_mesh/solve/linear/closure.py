"""Stiffness that is too great or too small for a model's own forces: closure is lost in rounding, or too deep.

Positions are doubles. A contact whose stiffness times their rounding is more than the tolerance allows cannot be
brought into balance; under the model's forces it closes by less than about 1e-10 of a block. And a block that sinks
into its neighbours by more than the contact rules follow (`RULES.max_penetration` of its size) has no contact any
more. Either would end in a verdict that says nothing of the rock.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.errors import counted, place
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantity import shown
from bsm_mesh.solve.linear.system import LinearSystem

EPSILON = float(np.finfo(float).eps)


def closure_faults(system: LinearSystem, options: Options) -> list[str]:
    """Return a sentence for every joint whose stiffness the scheme cannot hold at the model's forces.

    Parameters
    ----------
    system : LinearSystem
        The model where nothing moved, with the contact forces there.
    options : Options
        The linear scheme adds movements up and rounds nothing by the blocks' size; to it nothing is too stiff.
    """
    if not (system.contacts.count and system.reference > 0):
        return []
    stiff = [] if options.scheme == "linear" else _too_stiff(system, options.tolerance)
    return [*stiff, *_too_soft(system)]


def _too_stiff(system: LinearSystem, tolerance: float) -> list[str]:
    """Compare what rounding of positions makes of the contacts' forces with the residual that the tolerance allows."""
    contacts, blocks = system.contacts, system.model.blocks
    stiffness = np.maximum(contacts.normal_stiffness, contacts.shear_stiffness)
    arms = (contacts.point - blocks.moments.centroid[side] for side in (contacts.block_a, contacts.block_b))
    reach = sum(np.hypot(*arm.T) for arm in arms)
    most = tolerance * system.reference / (EPSILON * reach)
    told = []
    for joint, rows in _by_joint(contacts, stiffness > most):
        worst = rows[int((stiffness / most)[rows].argmax())]
        per_area, allowed = (values[worst] / contacts.length[worst] for values in (stiffness, most))
        closes, rounds = system.reference / stiffness[worst], EPSILON * reach[worst]
        told.append(
            f"{_named(system.model, joint)}: {per_area:.3g} Pa/m is too stiff for double precision: the mean force on "
            f"a block, {system.reference:.3g} N/m, closes the contact at {place(contacts.point[worst])} by "
            f"{closes:.1e} m, positions round by {rounds:.1e} m, and the tolerance {tolerance:g} asks for "
            f"{rounds / tolerance:.1e} m at least; give {_rounded_down(allowed):.1e} Pa/m or less"
        )
    return told


def _too_soft(system: LinearSystem) -> list[str]:
    """Compare how far its own load moves a block between neighbours that stay with how deep contacts may be."""
    contacts, model = system.contacts, system.model
    size = np.sqrt(model.blocks.moments.area)
    held_otherwise = np.concatenate([system.constraints.block, system.bolts.layout.block])
    movement = _own_movement(system)
    movement[held_otherwise] = 0.0
    sinks = movement > RULES.max_penetration * size
    told = []
    for joint, rows in _by_joint(contacts, sinks[contacts.block_a] | sinks[contacts.block_b]):
        of_joint = np.unique(np.concatenate([contacts.block_a[rows], contacts.block_b[rows]]))
        of_joint = of_joint[sinks[of_joint]]
        worst = int(of_joint[int((movement / size)[of_joint].argmax())])
        times = shown(float(f"{movement[worst] / (RULES.max_penetration * size[worst]):.2g}"))
        normal, shear = (
            values[rows] / contacts.length[rows] for values in (contacts.normal_stiffness, contacts.shear_stiffness)
        )
        told.append(
            f"{_named(model, joint)}: {normal.min():.3g} and {shear.min():.3g} Pa/m (normal, shear) are too soft: "
            f"block {worst} at {place(model.blocks.moments.centroid[worst])} sinks by {movement[worst]:.3g} m into its "
            f"neighbours under its own weight and loads, {movement[worst] / size[worst]:.2g} of its size"
            f"{_others(len(of_joint) - 1)}; more than {RULES.max_penetration:g} ends a contact: raise the stiffness "
            f"{times} times at least, or look at weights, loads and units"
        )
    return told


def _own_movement(system: LinearSystem) -> FloatArray:
    """Return how far every block moves under its residual while all others stay, (n,) [m]."""
    contacts, n = system.contacts, system.model.blocks.count
    (x, y), k_n, k_s = contacts.normal.T, contacts.normal_stiffness, contacts.shear_stiffness
    stiffness = np.zeros((n, 2, 2))
    for row, column, springs in (
        (0, 0, k_n * x**2 + k_s * y**2),
        (1, 1, k_n * y**2 + k_s * x**2),
        (1, 0, (k_n - k_s) * x * y),
    ):
        for block in (contacts.block_a, contacts.block_b):
            stiffness[:, row, column] += np.bincount(block, springs, minlength=n)
    axes, directions = np.linalg.eigh(stiffness)
    force = np.einsum("nij,ni->nj", directions, system.residual(*system.start)[:, :2])
    force[np.abs(force) <= 1e3 * EPSILON * np.hypot(*force.T)[:, None]] = 0.0  # across, by rounding
    least = np.maximum(axes, EPSILON * axes[:, 1:])  # below, eigenvalues are rounding
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        movement = np.hypot(*np.where(force == 0.0, 0.0, force / least).T)
    return np.where(axes[:, 1] > 0, movement, 0.0)  # without contact it falls, which is another matter


def _by_joint(contacts: ContactTable, chosen: BoolArray) -> list[tuple[int, IntArray]]:
    """Return the chosen contacts (m,) of every joint that has some; -1 for unjointed rock."""
    rows = np.flatnonzero(chosen)
    joint = contacts.joint[rows]
    return [(int(number), rows[joint == number]) for number in np.unique(joint)]


def _named(model: Model, joint: int) -> str:
    return f"joint '{model.joints[joint].name}'" if joint >= 0 else "faces of rock without a joint"


def _others(count: int) -> str:
    return f", {counted(count, 'more block')} too" if count else ""


def _rounded_down(value: float) -> float:
    digit = 10.0 ** np.floor(np.log10(value) - 1)
    return float(np.floor(value / digit) * digit)
