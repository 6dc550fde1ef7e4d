"""Contact properties: stiffness of rock and joint in series, and joint law, of any pair of corner and edge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.contact.corner_joints import edges_of_corners
from bsm_mesh.errors import ModelError, place
from bsm_mesh.model.face_stiffness import compliance, least_depth
from bsm_mesh.model.joint_laws import Elastic, JointLaw, wear_length_of
from bsm_mesh.model.law_faults import PROBED
from bsm_mesh.model.model import Model
from bsm_mesh.model.rock_faces import law_between, residual_tension_between, tension_between

_compliance = njit(error_model="numpy")(compliance)
NO_CURVE = (0.0,) * 7  # shear stiffness is constant


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactProperties:
    """Properties of contacts, per contact.

    Attributes
    ----------
    normal_stiffness, shear_stiffness : (m,) float64 [Pa/m]
        Rock and joint in series, per area (Wang Eqs. 3.24-3.27).
    joint : (m,) int32
        Number of the joint in ``model.joints``; -1 for unjointed rock.
    law : (m,) int32
        Number of the law in `JointCatalogue.laws`.
    tension, residual_tension : (m,) float64 [Pa]
        Tensile strength while it has not been broken, and what slip leaves of it.
    """

    normal_stiffness: FloatArray
    shear_stiffness: FloatArray
    joint: IntArray
    law: IntArray
    tension: FloatArray
    residual_tension: FloatArray


class LawCatalogue:
    """Stiffness and laws of the joints and rocks of a model, whatever its blocks are.

    Parameters
    ----------
    model : Model
        The model.

    Attributes
    ----------
    laws : tuple of JointLaw
        Of the joints and of every pair of rocks, different ones.
    wears : bool
        Whether slip wears the strength of any law off.
    dilates : bool
        Whether any joint opens as it slides.
    stiffens : bool
        Whether the shear stiffness of any joint grows with pressure.
    """

    def __init__(self, model: Model) -> None:
        blocks = model.blocks
        self._model = model
        defined = [joint.name for joint in model.joints]
        named = [defined.index(n) if n in defined else -1 for n in blocks.joint_names]
        self._number = np.array([*named, -1], dtype=np.int32)  # of the blocks' joints in the model's; the last: rock
        self._default = np.int32(-1 if model.default_joint is None else defined.index(model.default_joint))
        rocks = [next(rock for rock in model.rocks if rock.name == name) for name in blocks.rock_names]
        self._moduli = np.array([rock.contact_moduli for rock in rocks])
        self._joint_stiffness = np.array([joint.contact_stiffness for joint in model.joints]).reshape(-1, 2)
        closure = [(joint.max_closure or np.inf, joint.contact_stiffness[0]) for joint in model.joints]
        self._closure = np.array([*closure, (np.inf, np.inf)])  # the last: rock
        dilation = [(np.tan(np.radians(joint.dilation_angle)), joint.dilation_slip or 0.0) for joint in model.joints]
        self._dilation = np.array([*dilation, (0.0, 0.0)])
        curves = [joint.shear_curve for joint in model.joints]
        self.stiffens = any(curve is not None for curve in curves)
        self._shear_curve = np.array([*(curve or NO_CURVE for curve in curves), NO_CURVE])
        laws: list[JointLaw] = [joint.law or Elastic() for joint in model.joints]
        tension = [np.inf if joint.law is None else joint.tensile_strength for joint in model.joints]
        residual = [joint.residual_tensile_strength for joint in model.joints]
        for one in rocks:
            for other in rocks:
                laws.append(law_between(one, other))
                tension.append(tension_between(one, other))
                residual.append(residual_tension_between(one, other))
        self.laws, self._law = _different(laws)
        self._tension, self._residual_tension = np.array(tension), np.array(residual)
        self.wears = any(wear_length_of(law) is not None for law in self.laws)
        self.dilates = bool(self._dilation.any())

    @cached_property
    def smooth(self) -> BoolArray:
        """Laws that carry no shear at any pressure, (n_laws,)."""
        return np.array([_is_smooth(law) for law in self.laws], dtype=bool)

    def laws_of(self, joint: IntArray, block_a: IntArray, block_b: IntArray) -> tuple[IntArray, FloatArray]:
        """Return number of the law and tensile strength [Pa] of contacts whose joints (m,) are known (-1: rock)."""
        kind = self.kind_of(joint, block_a, block_b)
        return self._law[kind], self._tension[kind]

    def kind_of(self, joint: IntArray, block_a: IntArray, block_b: IntArray) -> IntArray:
        """Return the kind of contacts (m,): their joint, or behind all joints the pair of rocks that meet without."""
        rock, n_rocks = self._model.blocks.rock, len(self._moduli)
        between = len(self._joint_stiffness) + rock[block_a] * n_rocks + rock[block_b]
        kind: IntArray = np.where(joint >= 0, joint, between)
        return kind

    def refuse_rigid(self, rigid: BoolArray, block_a: IntArray, block_b: IntArray) -> None:
        """Raise a `ModelError` for the first of the contacts (m,) that are rigid: without a joint, of rigid rocks."""
        if (stiff := np.flatnonzero(rigid)).size:
            centroid = self._model.blocks.moments.centroid  # in a stage blocks have other numbers than in the whole
            a, b = (place(centroid[of[stiff[0]]]) for of in (block_a, block_b))
            raise ModelError(
                f"the blocks at {a} and {b} m meet without a joint and their rocks are rigid; give the rock young and "
                "poisson, or default_joint = ..., the joint of all faces without one"
            )

    def closure_of(self, joint: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return closure limit [m], infinite where there is none, and normal stiffness [Pa/m] of joints (m,), -1: rock.

        Of a model without a limit they are empty.
        """
        if np.isinf(self._closure[:, 0]).all():
            return np.zeros(0), np.zeros(0)
        limit, stiffness = self._closure[joint].T
        return limit, stiffness

    def dilation_of(self, joint: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the dilation angle's tangent, and the slip [m] on which it wears off, of joints (m,), -1: rock.

        Of a model whose joints do not open by slip they are empty.
        """
        if not self.dilates:
            return np.zeros(0), np.zeros(0)
        slope, last = self._dilation[joint].T
        return slope, last

    def shear_curve_of(self, joint: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return curves (m, 7) and reference stiffness (m,) [Pa/m] in shear of joints (m,), -1: rock.

        Of a model whose joints have constant ones they are empty.
        """
        if not self.stiffens:
            return np.zeros((0, 7)), np.zeros(0)
        own = np.append(self._joint_stiffness[:, 1], np.inf)
        return self._shear_curve[joint], own[joint]


class JointCatalogue(LawCatalogue):
    """Looks up stiffness and law of any pair of corner and edge of a model.

    Parameters
    ----------
    model : Model
        The model.
    """

    def __init__(self, model: Model) -> None:
        super().__init__(model)
        self._joint_of_edge = self._number[model.blocks.edge_joint]
        self._jointed = self._joint_of_edge >= 0
        self._floor = least_depth(model.blocks)

    def look_up(
        self, placed: FloatArray, sides: tuple[IntArray, ...], corners: FloatArray, directions: FloatArray
    ) -> ContactProperties:
        """Return the properties of contacts.

        Parameters
        ----------
        placed : (n, 3) float64 [m, m, rad]
            Centroid and rotation of every block.
        sides : tuple of (m,) int32
            Block with the corner, block with the edge, that corner, that edge, and the edge of the first block that
            lies along it (-1: none).
        corners : (n_vertices, 2) float64 [m]
            All corners in the frames of their blocks.
        directions : (n_vertices, 2) float64
            Unit directions of the edges that start there.

        Raises
        ------
        ModelError
            Where two rigid rocks meet without a joint.
        """
        own = sides[4]
        if self._jointed.any() and not self._jointed.all():
            own = self._edges_of_corners(placed, sides, directions)
        joints = self._joint_of_edge, self._default, self._joint_stiffness
        rocks = self._model.blocks.rock, self._floor, self._moduli
        normal, shear, joint, kind = _in_series(placed, *sides[:4], own, corners, directions, *joints, *rocks)
        self.refuse_rigid(np.isinf(normal), *sides[:2])
        return ContactProperties(
            normal_stiffness=normal,
            shear_stiffness=shear,
            joint=joint,
            law=self._law[kind],
            tension=self._tension[kind],
            residual_tension=self._residual_tension[kind],
        )

    def _edges_of_corners(self, placed: FloatArray, sides: tuple[IntArray, ...], directions: FloatArray) -> IntArray:
        """Return the edge of the first block (m,) that gives the joint where the second one's edge has none."""
        blocks, corner, edge, parallel = self._model.blocks, *sides[2:]
        turn = placed[blocks.owner, 2]
        x, y = directions.T
        turned = np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y], axis=1)
        own = edges_of_corners(turned, self._jointed, blocks.preceding, corner, edge)
        return np.where(parallel >= 0, parallel, own).astype(np.int32)


def _different(laws: Sequence[JointLaw]) -> tuple[tuple[JointLaw, ...], IntArray]:
    """Return one of equal laws each, and the number there of every law; a law that cannot be hashed equals itself."""
    found: dict[object, int] = {}
    number = np.array([found.setdefault(_key(law), len(found)) for law in laws], dtype=np.int32)
    return tuple(laws[int(k)] for k in np.unique(number, return_index=True)[1]), number


def _key(law: JointLaw) -> object:
    try:
        hash(law)
    except TypeError:
        return "same object", id(law)
    return law


@njit(error_model="numpy", allocates=True)
def _in_series(
    placed: FloatArray,
    block_a: IntArray,
    block_b: IntArray,
    corner: IntArray,
    edge: IntArray,
    parallel_edge: IntArray,
    corners: FloatArray,
    directions: FloatArray,
    joint_of_edge: IntArray,
    default: int,
    joint_stiffness: FloatArray,
    rock: IntArray,
    floor: FloatArray,
    moduli: FloatArray,
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:  # pragma: no cover - compiled
    """Return normal and shear stiffness of joint and both rocks in series, joint, and kind of contact, (m,) each.

    The kind is the joint, or behind all joints the pair of rocks that meet without one.
    """
    m, n_joints, n_rocks = block_a.size, joint_stiffness.shape[0], moduli.shape[0]
    normal, shear = np.empty(m), np.empty(m)
    joint, kind = np.empty(m, np.int32), np.empty(m, np.int32)
    cosine, sine = np.cos(placed[:, 2]), np.sin(placed[:, 2])
    for k in range(m):
        a, b, v, e = block_a[k], block_b[k], corner[k], edge[k]
        joint[k] = joint_of_edge[e]
        if joint[k] < 0 and parallel_edge[k] >= 0:
            joint[k] = joint_of_edge[parallel_edge[k]]
        if joint[k] < 0:
            joint[k] = default
        tx = cosine[b] * directions[e, 0] - sine[b] * directions[e, 1]
        ty = sine[b] * directions[e, 0] + cosine[b] * directions[e, 1]
        ax = cosine[a] * corners[v, 0] - sine[a] * corners[v, 1]
        ay = sine[a] * corners[v, 0] + cosine[a] * corners[v, 1]
        rx, ry = placed[a, 0] - placed[b, 0] + ax, placed[a, 1] - placed[b, 1] + ay
        depth_a = max(ay * tx - ax * ty, floor[a])
        depth_b = max(rx * ty - ry * tx, floor[b])
        one, other = rock[a], rock[b]
        kind[k], of_joint = n_joints + one * n_rocks + other, (np.inf, np.inf)
        if joint[k] >= 0:
            kind[k], of_joint = joint[k], (joint_stiffness[joint[k], 0], joint_stiffness[joint[k], 1])
        normal[k] = 1.0 / _compliance(depth_a, moduli[one, 0], depth_b, moduli[other, 0], of_joint[0])
        shear[k] = 1.0 / _compliance(depth_a, moduli[one, 1], depth_b, moduli[other, 1], of_joint[1])
    return normal, shear, joint, kind


def _is_smooth(law: JointLaw) -> bool:
    """Return whether a law carries no shear at the pressures at which laws are asked beforehand."""
    pressure = np.array(PROBED)
    one, intact = np.ones_like(pressure), np.zeros(len(pressure), dtype=bool)
    return not law.respond(pressure, 1e15 * one, one, intact).strength.any()
