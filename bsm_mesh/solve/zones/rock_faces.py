"""Faces of rock without a joint in the continuum: interfaces of great stiffness where they may break, or are cut open.

Behind the joints of a model the interfaces have numbers for every pair of rocks, and one for rock that is whole.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import raise_faults
from bsm_mesh.model.joint_laws import Elastic, JointLaw, remembered_by
from bsm_mesh.model.joint_laws.shear_stiffness import ShearCurve
from bsm_mesh.model.materials import Rock
from bsm_mesh.model.model import Model
from bsm_mesh.model.rock_faces import law_between, residual_tension_between, tension_between

REMEMBERED = ("offset", "slip_path")  # state variables of points of interfaces, `failed` apart


def interface_laws(model: Model) -> tuple[JointLaw, ...]:
    """Return the laws of all interfaces, by number.

    Raises
    ------
    ModelError
        If one depends on a state variable that points of interfaces have not.
    """
    raise_faults(
        [
            f"joint '{joint.name}': its law remembers '{name}', and zones remember {' and '.join(REMEMBERED)} only; "
            "choose another law, or leave zones out"
            for joint in model.joints
            for name in (() if joint.law is None else remembered_by(joint.law))
            if name not in REMEMBERED
        ]
    )
    rocks = rocks_of(model)
    between = (None if _yield(one, other) else law_between(one, other) for one in rocks for other in rocks)
    return (*(joint.law or Elastic() for joint in model.joints), *(law or Elastic() for law in between), Elastic())


def interface_tensions(model: Model) -> tuple[FloatArray, FloatArray]:
    """Return the tensile strengths of all interfaces, by number [Pa], and what slip leaves of them."""
    rocks = rocks_of(model)
    of_joints = (np.inf if joint.law is None else joint.tensile_strength for joint in model.joints)
    between = (np.inf if _yield(one, other) else tension_between(one, other) for one in rocks for other in rocks)
    left = (residual_tension_between(one, other) for one in rocks for other in rocks)
    residual = [*(joint.residual_tensile_strength for joint in model.joints), *left, 0.0]
    return np.array([*of_joints, *between, np.inf]), np.array(residual)


def interface_closures(model: Model) -> FloatArray:
    """Return the greatest closures of all interfaces, by number [m]; infinite where there is none."""
    of_joints = [joint.max_closure or np.inf for joint in model.joints]
    return np.array([*of_joints, *np.full(whole_rock(model) + 1 - len(of_joints), np.inf)])


def interface_dilations(model: Model) -> FloatArray:
    """Return tangents of the dilation angles of all interfaces, and the slips on which they wear off, (2, k) [-, m]."""
    of_joints = [(np.tan(np.radians(joint.dilation_angle)), joint.dilation_slip or 0.0) for joint in model.joints]
    rock = np.zeros((2, whole_rock(model) + 1 - len(of_joints)))
    return np.concatenate([np.array(of_joints).reshape(-1, 2).T, rock], axis=1)


def interface_curves(model: Model) -> FloatArray:
    """Return the shear stiffness of all interfaces by normal stress, by number (k, 7), as `ShearCurve`; 0: constant."""
    curves = np.zeros((whole_rock(model) + 1, len(ShearCurve._fields)))
    for number, joint in enumerate(model.joints):
        if joint.shear_curve is not None:
            curves[number] = joint.shear_curve
    return curves


def whole_rock(model: Model) -> int:
    """Return the number of interfaces that never break."""
    return len(model.joints) + len(model.blocks.rock_names) ** 2


def number_between(model: Model, one: IntArray, other: IntArray) -> IntArray:
    """Return the number of the faces between blocks (k,) and others (k,); -1 where they never break."""
    rock, count = model.blocks.rock, len(model.blocks.rock_names)
    number = len(model.joints) + rock[one] * count + rock[other]
    never = np.isinf(interface_tensions(model)[0])
    found: IntArray = np.where(never[number], -1, number).astype(np.int32)
    return found


def _yield(one: Rock, other: Rock) -> bool:
    """Return whether both rocks yield within their zones: faces between them are part of one piece."""
    return one.yields and other.yields


def rocks_of(model: Model) -> list[Rock]:
    """Return the rocks by their numbers in ``model.blocks.rock``."""
    by_name = {rock.name: rock for rock in model.rocks}
    return [by_name[name] for name in model.blocks.rock_names]
