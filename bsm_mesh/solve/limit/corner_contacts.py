"""Contacts of limit analysis where blocks touch by a corner alone: candidates that faces do not give.

Faces have their two ends as contacts (`initial_contacts`). Blocks without a common face there touch by a corner on an
edge, or by two corners at one point. The force of a corner on an edge has the edge's normal. Of two corners it has any
normal between those of the edges that separate both blocks: these are candidates, all of them.

Corners round a node that are connected by faces are no such pair: of four blocks that meet, the diagonal ones have
their neighbours between them.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import cKDTree

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.corner_joints import edges_of_corners
from bsm_mesh.contact.corners_on_edges import corners_on_edges
from bsm_mesh.contact.outlines import Outlines
from bsm_mesh.contact.rules import CONTACT_TOLERANCE, RULES
from bsm_mesh.contact.table import ContactTable
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_stiffness import joints_of_edges
from bsm_mesh.model.model import Model


def with_corner_contacts(model: Model, contacts: ContactTable) -> ContactTable:
    """Return the contacts of faces with those of corners alone, which have no stiffness.

    Parameters
    ----------
    model : Model
        The model.
    contacts : ContactTable
        Those of its faces, at their ends.
    """
    blocks = model.blocks
    outlines = Outlines.of(blocks, np.zeros(blocks.count, dtype=bool))
    near = CONTACT_TOLERANCE * outlines.size
    on_edge, at_node = corners_on_edges(blocks, outlines), _corners_at_one_node(blocks, outlines.neighbour_clusters)
    alone = ~_covered(blocks, contacts, *on_edge, near)
    corner, edge = (np.concatenate([some[alone], more]) for some, more in zip(on_edge, at_node, strict=True))
    if not len(corner):
        return contacts
    sizes = (outlines.block_size[blocks.owner[ends]] for ends in (corner, edge))
    more = _table(model, corner, edge, RULES.corner_share * np.minimum(*sizes))
    names = [field.name for field in fields(ContactTable)]
    return ContactTable(**{name: np.concatenate([getattr(contacts, name), getattr(more, name)]) for name in names})


def _covered(blocks: Blocks, contacts: ContactTable, corner: IntArray, edge: IntArray, near: float) -> BoolArray:
    """Return the corners on edges (m,) at which a face of the same two blocks ends."""
    covered = np.zeros(len(corner), dtype=bool)
    if contacts.count and len(corner):
        close = cKDTree(blocks.vertices[corner]).sparse_distance_matrix(
            cKDTree(contacts.point), near, output_type="coo_matrix"
        )
        low, high = np.minimum(contacts.block_a, contacts.block_b), np.maximum(contacts.block_a, contacts.block_b)
        row, col = close.row, close.col
        a, b = blocks.owner[corner[row]], blocks.owner[edge[row]]
        same = (np.minimum(a, b) == low[col]) & (np.maximum(a, b) == high[col])
        covered[row[same]] = True
    return covered


def _corners_at_one_node(blocks: Blocks, clusters: IntArray) -> tuple[IntArray, IntArray]:
    """Return corner and edge of two blocks, (k,) each, that meet at a node without faces between them."""
    n = len(blocks.vertices)
    at = coo_array((np.ones(n, dtype=np.int32), (np.arange(n), blocks.nodes))).tocsr()
    pairs = (at @ at.T).tocoo()
    one, other = pairs.row, pairs.col
    apart = (blocks.owner[one] != blocks.owner[other]) & (clusters[one] != clusters[other])
    one, other = one[apart], other[apart]
    corner, edge = np.concatenate([one, one]), np.concatenate([other, blocks.preceding[other]])
    separates = _lies_outside(blocks, corner, edge)
    return corner[separates].astype(np.int32), edge[separates].astype(np.int32)


def _lies_outside(blocks: Blocks, corner: IntArray, edge: IntArray) -> BoolArray:
    """Return whether both edges at a corner (k,) lie outside an edge (k,) that ends there.

    An edge in line with that edge, beyond its end, shares no length with it and carries nothing.
    """
    normal = _normals(blocks, edge)
    away = np.where(blocks.nodes[edge] == blocks.nodes[corner], 1.0, -1.0)[:, None] * blocks.edge_vectors[edge]
    outside = np.ones(len(corner), dtype=bool)
    for end in (blocks.following[corner], blocks.preceding[corner]):
        along = blocks.vertices[end] - blocks.vertices[corner]
        height, limit = (along * normal).sum(axis=1), CONTACT_TOLERANCE * np.hypot(*along.T)
        beyond = (np.abs(height) <= limit) & ((along * away).sum(axis=1) < 0)
        outside &= (height >= -limit) & ~beyond
    return outside


def _normals(blocks: Blocks, edge: IntArray) -> FloatArray:
    """Return the outward unit normals of edges, (k, 2)."""
    along = blocks.edge_vectors[edge]
    normal: FloatArray = np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]
    return normal


def _table(model: Model, corner: IntArray, edge: IntArray, length: FloatArray) -> ContactTable:
    """Return contacts of corners on edges, each with a length [m]."""
    blocks, defined = model.blocks, [joint.name for joint in model.joints]
    directions = blocks.edge_vectors / np.hypot(*blocks.edge_vectors.T)[:, None]
    own = edges_of_corners(directions, blocks.edge_joint >= 0, blocks.preceding, corner, edge)
    nothing = np.zeros(len(corner))
    return ContactTable(
        block_a=blocks.owner[corner],
        block_b=blocks.owner[edge],
        edge=edge,
        point=blocks.vertices[corner],
        normal=_normals(blocks, edge),
        length=length,
        normal_stiffness=nothing,
        shear_stiffness=nothing,
        joint=joints_of_edges(blocks, defined, model.default_joint, own, edge),
    )
