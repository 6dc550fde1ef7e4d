"""Stiffness of faces from the rocks on both sides and the joint between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, place
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.faces import Faces

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model

LEAST_DEPTH = 0.1  # of area over outline, in space of volume over surface: least depth of rock behind a face


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class FaceStiffness:
    """Stiffness per area of every face, and its joint.

    Attributes
    ----------
    normal, shear : (k,) float64 [Pa/m]
        Wang's K_n and K_s of Eq. 3.27.
    joint : (k,) int32
        Number of the joint in ``model.joints``; -1 for unjointed rock.
    """

    normal: FloatArray
    shear: FloatArray
    joint: IntArray


def face_stiffness(model: Model, faces: Faces) -> FaceStiffness:
    """Return rock and joint in series (Wang Eqs. 3.24-3.27) for every face.

    Raises
    ------
    ModelError
        Where two rigid rocks meet without a joint: nothing there could deform.
    """
    blocks = model.blocks
    joint = face_joints(model, faces)
    moduli = np.array([_rock_moduli(model, name) for name in blocks.rock_names])
    least = least_depth(blocks)
    along = faces.end - faces.start
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]

    def rock(edge: IntArray, side: float) -> tuple[FloatArray, FloatArray]:
        block = blocks.owner[edge]
        depth = side * ((faces.start - blocks.moments.centroid[block]) * normal).sum(axis=1)
        return np.maximum(depth, least[block])[:, None], moduli[blocks.rock[block]]

    of_joint = np.array([*(one.contact_stiffness for one in model.joints), (np.inf, np.inf)])  # the last: rock
    normal_and_shear = compliance(*rock(faces.edge_a, -1.0), *rock(faces.edge_b, 1.0), of_joint[joint])
    stiff = np.flatnonzero(normal_and_shear[:, 0] == 0)
    if stiff.size:
        raise ModelError(_rigid_faults(model, faces, stiff))
    return FaceStiffness(normal=1 / normal_and_shear[:, 0], shear=1 / normal_and_shear[:, 1], joint=joint)


def compliance(depth_a: Any, modulus_a: Any, depth_b: Any, modulus_b: Any, joint_stiffness: Any) -> Any:
    """Return the compliance per area of two rocks and the joint between them in series (Wang Eqs. 3.25-3.27) [m/Pa].

    Of numbers or arrays, of normal or shear: depths h of the face below the centroids [m], moduli E' or G [Pa], and the
    stiffness of the joint [Pa/m], infinite for rock without one. `contact.properties` compiles it for contacts.
    """
    return depth_a / modulus_a + depth_b / modulus_b + 1.0 / joint_stiffness


def face_joints(model: Model, faces: Faces) -> IntArray:
    """Return the number in ``model.joints`` of the joint of every face, (k,) int32; -1 for unjointed rock."""
    return joints_of_faces(model.blocks, [joint.name for joint in model.joints], model.default_joint, faces)


def joints_of_faces(blocks: Blocks, defined: Sequence[str], default: str | None, faces: Faces) -> IntArray:
    """Return the number of the joint of every face, (k,) int32, as `joints_of_edges` says."""
    return joints_of_edges(blocks, defined, default, faces.edge_a, faces.edge_b)


def joints_of_edges(
    blocks: Blocks, defined: Sequence[str], default: str | None, edge_a: IntArray, edge_b: IntArray
) -> IntArray:
    """Return the joint between edges: number of that of edge b, else of edge a, else the default joint, else -1 (rock).

    Parameters
    ----------
    blocks : Blocks
        The blocks, whose edges have joints by name.
    defined : sequence of str
        Names of the joints, in the order of their numbers.
    default : str or None
        Name of the joint of faces without one.
    edge_a, edge_b : (k,) int
        The edges.
    """
    known = {name: number for number, name in enumerate(defined)}
    number = np.array([known.get(name, -1) for name in blocks.joint_names] + [-1], dtype=np.int32)
    of_edge = number[blocks.edge_joint]  # edge_joint -1 picks the last entry: no joint
    joint = np.where(of_edge[edge_b] >= 0, of_edge[edge_b], of_edge[edge_a])
    if default is not None:
        joint = np.where(joint >= 0, joint, known[default])
    return joint.astype(np.int32)


def _rock_moduli(model: Model, name: str) -> tuple[float, float]:
    return next((rock.contact_moduli for rock in model.rocks if rock.name == name), (np.inf, np.inf))


def least_depth(blocks: Blocks) -> FloatArray:
    """Return the depth h [m] below which a face of a concave block does not fall: a tenth of area over outline.

    The centroid of a concave block may lie on the line of a face, or beyond it, and h would be zero or negative.
    No convex block is changed: its centroid is a third of its width or more from every face, and area over
    outline is half its least width or less.
    """
    outline = np.add.reduceat(np.hypot(*blocks.edge_vectors.T), blocks.offsets[:-1])
    depth: FloatArray = LEAST_DEPTH * blocks.moments.area / outline
    return depth


def _rigid_faults(model: Model, faces: Faces, rows: IntArray) -> list[str]:
    blocks = model.blocks
    faults = []
    for k in rows:
        a, b = sorted((int(blocks.owner[faces.edge_a[k]]), int(blocks.owner[faces.edge_b[k]])))
        rocks = sorted({blocks.rock_names[blocks.rock[a]], blocks.rock_names[blocks.rock[b]]})
        faults.append(
            f"blocks {a} and {b} meet at {place(faces.start[k])} without a joint and "
            f"their rock ({' and '.join(rocks)}) is rigid; give the rock young and poisson, or the face a joint "
            '(default_joint = ... for all faces; of a mesh, [mesh] blocks = "regions" where only joints bound blocks)'
        )
    return faults
