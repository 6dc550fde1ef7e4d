"""The initial contact table: one row per point contact, one array per property."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.face_stiffness import face_stiffness
from bsm_mesh.model.faces import Faces, find_faces
from bsm_mesh.model.model import Model
from bsm_mesh.model.submodel import SubModel

GAUSS = 0.5 - 0.5 / np.sqrt(3.0)  # distance of a Gauss point from the nearer end, over the length


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContactTable:
    """Point contacts: a corner of `block_a` on an edge of `block_b` (edge to edge: two of them).

    Attributes
    ----------
    block_a, block_b : (m,) int32
        The block with the corner, and the block with the edge.
    edge : (m,) int32
        The edge of `block_b`.
    point : (m, 2) float64 [m]
        Where the contact is.
    normal : (m, 2) float64
        Outward unit normal of `block_b`'s edge.
    length : (m,) float64 [m]
        Share of the face's length that the contact represents.
    normal_stiffness, shear_stiffness : (m,) float64 [N/m2]
        Spring stiffness, per metre of thickness: stiffness per area times length.
    joint : (m,) int32
        Number of the joint in ``model.joints``; -1 for unjointed rock.
    """

    block_a: IntArray
    block_b: IntArray
    edge: IntArray
    point: FloatArray
    normal: FloatArray
    length: FloatArray
    normal_stiffness: FloatArray
    shear_stiffness: FloatArray
    joint: IntArray

    @property
    def count(self) -> int:
        """Number of contacts."""
        return len(self.block_a)

    def in_whole(self, part: SubModel) -> ContactTable:
        """Return the contacts of a part in the numbers of the whole."""
        blocks = {name: part.block[getattr(self, name)] for name in ("block_a", "block_b")}
        return replace(self, **blocks, edge=part.corner[self.edge])


def initial_contacts(model: Model) -> ContactTable:
    """Return the contacts of the blocks as they are given: two on every face, each with half its length.

    Raises
    ------
    ModelError
        For overlapping blocks, or two rigid rocks that meet without a joint.
    """
    blocks = model.blocks
    faces = find_faces(blocks)
    stiffness = face_stiffness(model, faces)
    edge_of_a = np.stack([faces.edge_a, faces.edge_a], axis=1)
    edge_of_b = np.stack([faces.edge_b, faces.edge_b], axis=1)
    along = faces.end - faces.start
    length = np.hypot(*along.T)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
    normals = np.stack([normal, normal], axis=1)
    points = _contact_points(faces, along, model.contact_points)
    if model.contact_points == "ends":  # an end that is a corner of b only: b has the corner, a the edge
        swapped = ~np.stack([faces.start_corner_of_a, faces.end_corner_of_a], axis=1)
        if swapped.any():
            edge_of_a[swapped], edge_of_b[swapped] = edge_of_b[swapped], edge_of_a[swapped]
            normals[swapped] *= -1
    share = np.repeat(length / 2, 2)
    return ContactTable(
        block_a=blocks.owner[edge_of_a.reshape(-1)],
        block_b=blocks.owner[edge_of_b.reshape(-1)],
        edge=edge_of_b.reshape(-1),
        point=points.reshape(-1, 2),
        normal=normals.reshape(-1, 2),
        length=share,
        normal_stiffness=np.repeat(stiffness.normal, 2) * share,
        shear_stiffness=np.repeat(stiffness.shear, 2) * share,
        joint=np.repeat(stiffness.joint, 2),
    )


def _contact_points(faces: Faces, along: FloatArray, rule: str) -> FloatArray:
    """Return the two contact points of every face, (k, 2, 2) [m]."""
    if rule == "ends":
        return np.stack([faces.start, faces.end], axis=1)
    return np.stack([faces.start + GAUSS * along, faces.end - GAUSS * along], axis=1)
