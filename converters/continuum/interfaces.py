"""Joints as interface elements of zero thickness between the continuum's triangles (Goodman, Taylor & Brekke 1968).

The triangles on both sides of a joint have nodes of their own, at the same places. Between them springs per area resist
the relative displacement: ``t_n = K_n [u_n]``, ``t_s = K_s [u_s]``, integrated exactly along each side. They are
elastic: they neither slip nor open.

References
----------
Goodman, Taylor & Brekke (1968), A model for the mechanics of jointed rock, J. Soil Mech. Found. Div. ASCE 94(SM3),
637-659.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import IntArray
from bsm_mesh.converters.continuum.mesh import ContinuumMesh, facets_between
from bsm_mesh.converters.continuum.supports import nodal_unknowns
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.model import Model

# Integrals of the products of shape functions along a side of length 1: ends (order 1); ends and middle (order 2).
MASS = {
    1: np.array([(2.0, 1.0), (1.0, 2.0)]) / 6,
    2: np.array([(4.0, -1.0, 2.0), (-1.0, 4.0, 2.0), (2.0, 2.0, 16.0)]) / 30,
}


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Interfaces:
    """Pairs of triangle sides that face each other across a joint.

    Attributes
    ----------
    ends : (k, 2 sides, 2) int32
        Vertices at the start and at the end of both sides, which lie on each other.
    facet : (k, 2 sides) int32
        The sides, as facets of the mesh.
    joint : (k,) int32
        Number of the joint in ``model.joints``.
    """

    ends: IntArray
    facet: IntArray
    joint: IntArray

    def nodes(self, order: int, vertices: int) -> IntArray:
        """Return the nodes of both sides in the order of `MASS`, (k, 2 sides, order + 1)."""
        middle = vertices + self.facet[:, :, None]
        nodes: IntArray = self.ends if order == 1 else np.concatenate([self.ends, middle], axis=2)
        return nodes


def open_joints(model: Model, mesh: ContinuumMesh) -> tuple[ContinuumMesh, Interfaces]:
    """Return the mesh with nodes of their own on both sides of every joint, and the interfaces between them."""
    one, other, joint = _jointed_pieces(model, mesh)
    edge = mesh.edge_of_piece
    t, f2t = mesh.mesh.t, mesh.mesh.f2t
    label = _corner_labels(mesh, mesh.piece_facet[one])
    points = np.empty((2, int(label.max()) + 1))
    points[:, label] = mesh.mesh.p[:, t]
    split = type(mesh.mesh)(points, label)
    across = f2t[:, mesh.piece_facet]
    own = np.where(mesh.block[across[0]] == model.blocks.owner[edge], across[0], across[1])
    ends = mesh.mesh.facets[:, mesh.piece_facet]
    along = mesh.mesh.p[:, ends[1]] - mesh.mesh.p[:, ends[0]]
    backwards = (along.T * model.blocks.edge_vectors[edge]).sum(axis=1) < 0
    ends = np.where(backwards, ends[::-1], ends)
    first, last = (label[_place(t, node, own), own] for node in ends)
    facet = facets_between(split, first, last)
    interfaces = Interfaces(
        ends=np.stack([np.stack([first[one], last[one]], 1), np.stack([last[other], first[other]], 1)], axis=1),
        facet=np.stack([facet[one], facet[other]], axis=1),
        joint=joint,
    )
    return dataclasses.replace(mesh, mesh=split, piece_facet=facet), interfaces


def interface_stiffness(model: Model, interfaces: Interfaces, basis: Any, order: int) -> Any:
    """Return the stiffness matrix (N, N) [N/m2] of the interfaces, in x and y components."""
    p = basis.mesh.p
    along = (p[:, interfaces.ends[:, 0, 1]] - p[:, interfaces.ends[:, 0, 0]]).T
    length = np.hypot(*along.T)
    tangent = along / length[:, None]
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    of_joint = np.array([joint.contact_stiffness for joint in model.joints]).reshape(-1, 2)[interfaces.joint]
    springs = sum(
        (length * of_joint[:, k])[:, None, None] * axis[:, :, None] * axis[:, None, :]
        for k, axis in enumerate((normal, tangent))
    )
    sign = np.repeat([1.0, -1.0], order + 1)
    mass = np.tile(MASS[order], (2, 2)) * np.outer(sign, sign)
    unknown = nodal_unknowns(basis)[interfaces.nodes(order, p.shape[1])].reshape(len(length), 2 * (order + 1), 2)
    size = 4 * (order + 1)
    entries = np.einsum("ij,kxy->kixjy", mass, springs).reshape(len(length), size, size)
    flat = unknown.reshape(len(length), size)
    rows, columns = (np.broadcast_to(u, entries.shape).ravel() for u in (flat[:, :, None], flat[:, None, :]))
    return sp.csr_matrix((entries.ravel(), (rows, columns)), shape=(basis.N, basis.N))


def _jointed_pieces(model: Model, mesh: ContinuumMesh) -> tuple[IntArray, IntArray, IntArray]:
    """Return the two pieces that share each facet on a joint, and the joint."""
    faces = find_faces(model.blocks)
    number = face_joints(model, faces)
    order = np.argsort(mesh.piece_facet, kind="stable")
    paired = np.flatnonzero(mesh.piece_facet[order][1:] == mesh.piece_facet[order][:-1])
    one, other = order[paired], order[paired + 1]
    size = len(model.blocks.vertices)

    def key(a: IntArray, b: IntArray) -> IntArray:
        return np.minimum(a, b).astype(np.int64) * size + np.maximum(a, b)

    known = key(faces.edge_a, faces.edge_b)
    sorting = np.argsort(known)
    wanted = key(mesh.edge_of_piece[one], mesh.edge_of_piece[other])
    face = sorting[np.searchsorted(known, wanted, sorter=sorting)]
    joint = number[face]
    jointed = joint >= 0
    return one[jointed], other[jointed], joint[jointed]


def _corner_labels(mesh: ContinuumMesh, opened: IntArray) -> IntArray:
    """Return the new vertex at every corner of the triangles, (3, t): one where triangles meet across whole sides."""
    t, f2t = mesh.mesh.t, mesh.mesh.f2t
    count = t.shape[1]
    whole = np.setdiff1d(np.flatnonzero(f2t[1] >= 0), opened)
    ends, sides = mesh.mesh.facets[:, whole], f2t[:, whole]
    a, b = (
        np.concatenate([_place(t, node, triangle) * count + triangle for node in ends])
        for triangle in (sides[0], sides[1])
    )
    graph = sp.coo_matrix((np.ones(len(a), np.int8), (a, b)), shape=(3 * count, 3 * count))
    labels: IntArray = connected_components(graph, directed=False)[1].reshape(3, count).astype(np.int32)
    return labels


def _place(t: IntArray, vertex: IntArray, triangle: IntArray) -> IntArray:
    """Return which corner of each triangle a vertex is."""
    place: IntArray = (t[:, triangle] == vertex).argmax(axis=0)
    return place
