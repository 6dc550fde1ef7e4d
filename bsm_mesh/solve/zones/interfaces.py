"""Joints as interfaces of zero thickness between the continuum's cells (Goodman, Taylor & Brekke 1968).

The cells on both sides of a joint have nodes of their own, at the same places; the joint's action on them is
`joint_points`.

References
----------
Goodman, Taylor & Brekke (1968), A model for the mechanics of jointed rock, J. Soil Mech. Found. Div. ASCE 94(SM3),
637-659.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, IntArray
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.mesh import ContinuumMesh, facets_between
from bsm_mesh.solve.zones.rock_faces import number_between, whole_rock


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Interfaces:
    """Pairs of sides of cells that face each other across a joint.

    Attributes
    ----------
    pieces : (k, 2 sides) int32
        The sides, as pieces of the blocks' edges.
    vertex : (k, 2 sides) int32
        Vertices of both sides at one end, which lie on each other.
    facet : (k, 2 sides) int32
        The sides, as facets of the mesh.
    joint : (k,) int32
        Number of the joint in ``model.joints``, behind them that of a face of rock (`rock_faces`).
    """

    pieces: IntArray
    vertex: IntArray
    facet: IntArray
    joint: IntArray


def open_joints(
    model: Model, mesh: ContinuumMesh, presence: Sequence[BoolArray], rock_breaks: bool = False
) -> tuple[ContinuumMesh, Interfaces]:
    """Return the mesh with nodes of their own on both sides of every joint, and the interfaces between them.

    A joint may end in rock that is excavated later. The two sides of such a tip would still share its node when that
    rock has gone; faces of unjointed rock about it are therefore opened too, and tied by interfaces of whole rock.

    Parameters
    ----------
    model : Model
        Its joints.
    mesh : ContinuumMesh
        The whole mesh.
    presence : sequence of (n,) bool
        Which blocks are there in every stage.
    rock_breaks : bool
        Whether the faces of rocks that give a strength are opened too, and tied by interfaces that break.
    """
    one, other, joint = shared_pieces(model, mesh)
    if rock_breaks:
        owner = model.blocks.owner[mesh.edge_of_piece]
        joint = np.where(joint < 0, number_between(model, owner[one], owner[other]), joint)
    tied = np.isin(mesh.piece_facet[one], _facets_about_tips(mesh, mesh.piece_facet[one[joint >= 0]], presence))
    joint = np.where((joint < 0) & tied, whole_rock(model), joint).astype(np.int32)
    pieces = np.stack([one, other], axis=1)[joint >= 0]
    split = opened(model, mesh, mesh.piece_facet[pieces[:, 0]])
    return split, interfaces_between(split, pieces, joint[joint >= 0])


def opened(model: Model, mesh: ContinuumMesh, facets: IntArray) -> ContinuumMesh:
    """Return the mesh with nodes of their own on both sides of some facets; cells and pieces keep their numbers."""
    edge, t, f2t = mesh.edge_of_piece, mesh.mesh.t, mesh.mesh.f2t
    label = _corner_labels(mesh, facets)
    points = np.empty((2, int(label.max()) + 1))
    points[:, label] = mesh.mesh.p[:, t]
    split = type(mesh.mesh)(points, label)
    across = f2t[:, mesh.piece_facet]
    own = np.where(mesh.block[across[0]] == model.blocks.owner[edge], across[0], across[1])
    first, last = (label[_place(t, node, own), own] for node in mesh.piece_ends.T)
    ends = np.stack([first, last], axis=1).astype(np.int32)
    return dataclasses.replace(mesh, mesh=split, piece_ends=ends, piece_facet=facets_between(split, first, last))


def interfaces_between(mesh: ContinuumMesh, pieces: IntArray, joint: IntArray) -> Interfaces:
    """Return the interfaces between pairs of pieces (k, 2) of an opened mesh, with their joints (k,)."""
    one, other = pieces.T
    return Interfaces(
        pieces=pieces,
        vertex=np.stack([mesh.piece_ends[one, 0], mesh.piece_ends[other, 1]], axis=1),
        facet=mesh.piece_facet[pieces],
        joint=joint,
    )


def shared_pieces(model: Model, mesh: ContinuumMesh) -> tuple[IntArray, IntArray, IntArray]:
    """Return the two pieces that share each facet between blocks, and its joint; -1 for unjointed rock."""
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
    return one, other, number[face]


def _facets_about_tips(mesh: ContinuumMesh, opened: IntArray, presence: Sequence[BoolArray]) -> IntArray:
    """Return the facets between rock that leaves and rock that stays at nodes which hold parts together by the former.

    In some stage the cells that are there about such a node belong to several parts that share no side.
    """
    whole = _corner_labels(mesh, opened)
    holds = np.zeros(int(whole.max()) + 1, dtype=bool)
    f2t, block = mesh.mesh.f2t, mesh.block
    inner = np.flatnonzero(f2t[1] >= 0)
    crossing = np.zeros(f2t.shape[1], dtype=bool)
    for present in presence:
        there = present[block]
        gone = inner[~(there[f2t[0, inner]] & there[f2t[1, inner]])]
        parts = _corner_labels(mesh, np.union1d(opened, gone))[:, there]
        node, count = np.unique(
            np.unique(np.stack([whole[:, there].ravel(), parts.ravel()]), axis=1)[0], return_counts=True
        )
        holds[node[count > 1]] = True
        crossing[inner] |= there[f2t[0, inner]] != there[f2t[1, inner]]
    crossing[opened] = False
    facets = np.flatnonzero(crossing)
    cell = f2t[0, facets]
    at_ends = (holds[whole[_place(mesh.mesh.t, node, cell), cell]] for node in mesh.mesh.facets[:, facets])
    found: IntArray = facets[np.logical_or.reduce(list(at_ends))]
    return found


def _corner_labels(mesh: ContinuumMesh, opened: IntArray) -> IntArray:
    """Return the new vertex at every corner of the cells, (3 or 4, t): one where cells meet across whole sides."""
    t, f2t = mesh.mesh.t, mesh.mesh.f2t
    corners, count = t.shape
    whole = np.setdiff1d(np.flatnonzero(f2t[1] >= 0), opened)
    ends, sides = mesh.mesh.facets[:, whole], f2t[:, whole]
    a, b = (np.concatenate([_place(t, node, cell) * count + cell for node in ends]) for cell in (sides[0], sides[1]))
    graph = sp.coo_matrix((np.ones(len(a), np.int8), (a, b)), shape=(t.size, t.size))
    label = connected_components(graph, directed=False)[1].reshape(corners, count)
    # In the order of the old vertices: facets run from the lower to the higher, so those of both sides run alike.
    old = np.empty(label.max() + 1, dtype=np.int64)
    old[label] = t
    rank = np.empty_like(old)
    rank[np.argsort(old, kind="stable")] = np.arange(len(old))
    labels: IntArray = rank[label].astype(np.int32)
    return labels


def _place(t: IntArray, vertex: IntArray, cell: IntArray) -> IntArray:
    """Return which corner of each cell a vertex is."""
    place: IntArray = (t[:, cell] == vertex).argmax(axis=0)
    return place
