"""Stiffness and law of contacts wherever they arise: from the edge, the corner's block, and their rocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.model.face_stiffness import least_depth
from bsm_mesh.model.joint_laws import Elastic, JointLaw, MohrCoulomb, Weaker
from bsm_mesh.model.materials import Rock
from bsm_mesh.model.model import Model


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
    tension : (m,) float64 [Pa]
        Tensile strength while it has not been broken.
    """

    normal_stiffness: FloatArray
    shear_stiffness: FloatArray
    joint: IntArray
    law: IntArray
    tension: FloatArray


class JointCatalogue:
    """Looks up stiffness and law of any pair of corner and edge of a model.

    Parameters
    ----------
    model : Model
        What is given.

    Attributes
    ----------
    laws : tuple of JointLaw
        Of the joints and of every pair of rocks, different ones.
    """

    def __init__(self, model: Model) -> None:
        blocks = model.blocks
        self._model = model
        defined = [joint.name for joint in model.joints]
        number = np.array([defined.index(n) if n in defined else -1 for n in blocks.joint_names] + [-1], dtype=np.int32)
        self._joint_of_edge = number[blocks.edge_joint]
        self._default = -1 if model.default_joint is None else defined.index(model.default_joint)
        rocks = [next(rock for rock in model.rocks if rock.name == name) for name in blocks.rock_names]
        self._moduli = np.array([rock.contact_moduli for rock in rocks])
        self._joint_stiffness = np.array([joint.contact_stiffness for joint in model.joints]).reshape(-1, 2)
        self._floor = least_depth(blocks)
        self._n_rocks = len(rocks)
        laws: list[JointLaw] = [joint.law or Elastic() for joint in model.joints]
        tension = [np.inf if joint.law is None else joint.tensile_strength for joint in model.joints]
        for one in rocks:
            for other in rocks:
                laws.append(_between(one, other))
                tension.append(min(_rock_tension(one), _rock_tension(other)))
        self.laws = tuple(dict.fromkeys(laws))  # one of equal ones
        self._law = np.array([self.laws.index(law) for law in laws], dtype=np.int32)
        self._tension = np.array(tension)

    def look_up(
        self,
        block_a: IntArray,
        block_b: IntArray,
        edge: IntArray,
        parallel_edge: IntArray,
        arm_a: FloatArray,
        arm_b: FloatArray,
        normal: FloatArray,
    ) -> ContactProperties:
        """Return the properties of contacts.

        Parameters
        ----------
        block_a, block_b : (m,) int32
            Block with the corner, block with the edge.
        edge, parallel_edge : (m,) int32
            Edge of b, and the edge of a that lies along it (-1: none).
        arm_a, arm_b : (m, 2) float64 [m]
            From each block's centroid to the contact.
        normal : (m, 2) float64
            Outward unit normal of b's edge.

        Raises
        ------
        ModelError
            Where two rigid rocks meet without a joint.
        """
        blocks = self._model.blocks
        joint = self._joint_of_edge[edge]
        of_a = np.where(parallel_edge >= 0, self._joint_of_edge[parallel_edge], -1)
        joint = np.where(joint >= 0, joint, of_a)
        joint = np.where(joint >= 0, joint, self._default).astype(np.int32)
        rock_a, rock_b = blocks.rock[block_a], blocks.rock[block_b]
        depth_a = np.maximum(-(arm_a * normal).sum(axis=1), self._floor[block_a])
        depth_b = np.maximum((arm_b * normal).sum(axis=1), self._floor[block_b])
        compliance = depth_a[:, None] / self._moduli[rock_a] + depth_b[:, None] / self._moduli[rock_b]
        jointed = joint >= 0
        if jointed.any():
            compliance[jointed] += 1 / self._joint_stiffness[joint[jointed]]
        stiff = np.flatnonzero(compliance[:, 0] == 0)
        if stiff.size:
            a, b = int(block_a[stiff[0]]), int(block_b[stiff[0]])
            raise ModelError(
                f"blocks {a} and {b} meet without a joint and their rocks are rigid; give the rock young and poisson, "
                "or default_joint = ... for faces that bear none"
            )
        kind = np.where(jointed, joint, len(self._model.joints) + rock_a * self._n_rocks + rock_b)
        return ContactProperties(
            normal_stiffness=1 / compliance[:, 0],
            shear_stiffness=1 / compliance[:, 1],
            joint=joint,
            law=self._law[kind],
            tension=self._tension[kind],
        )


def _has_strength(rock: Rock) -> bool:
    return not (rock.cohesion is None and rock.friction is None and rock.tensile_strength is None)


def _rock_tension(rock: Rock) -> float:
    return (rock.tensile_strength or 0.0) if _has_strength(rock) else np.inf


def _between(one: Rock, other: Rock) -> JointLaw:
    """Return the law of the face between two rocks : Mohr-Coulomb, the weaker governs."""
    laws = [
        MohrCoulomb(friction=rock.friction or 0.0, cohesion=rock.cohesion or 0.0)
        for rock in (one, other)
        if _has_strength(rock)
    ]
    if not laws:
        return Elastic()
    return laws[0] if len(laws) == 1 or laws[0] == laws[1] else Weaker(laws[0], laws[1])
