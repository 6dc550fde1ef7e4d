"""Points of joints that turn and slide with the blocks: opening and slip in large displacement.

A point is a node s of the second side. It faces a place m of the first side, on a side of a zone from node a to node b.
With r = x_s - x_m and e = x_b - x_a opening and slip are ``r . n`` and ``r . t``, where t is the direction of e, and n
its normal out of the first side. Both are the same in all frames that turn, and the forces balance in force and moment:
they act at the node s.

The place m is one of the material: the shape functions of the side's nodes there are constant until equilibrium. A
point that slid too far from it gets the place that it faces then, perhaps on another side of a zone (`face_chains`).
Its slip continues from its value. Forces do not jump, because two sides share the node between them. A point that slid
over the end of a face carries nothing.

Faces that touched nothing before get points where they come upon other blocks (`met_points`), behind those of the given
joints.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.zones.face_chains import FaceChains, Lip
from bsm_mesh.solve.zones.joint_history import JointHistory, JointState
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.tangents import PointStiffness
from bsm_mesh.solve.zones.zone_faces import ZoneFaces

QUARTER = np.array([(0.0, -1.0), (1.0, 0.0)])
SLID = 1e-3  # of the side of a zone: beyond, a point gets the place that it faces


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Places:
    """Where points face the first side, (q,) each.

    Attributes
    ----------
    piece : (q,) int32
        Piece of an edge (`FaceChains`).
    share : (q,) float64
        The part of it from its start.
    slid : (q,) float64 [m]
        Slip up to that place.
    over : (q,) bool
        Whether the point slid over the end of the face.
    """

    piece: IntArray
    share: FloatArray
    slid: FloatArray
    over: BoolArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Met:
    """Points where faces came upon blocks that they did not touch before, (k,) each.

    Attributes
    ----------
    corner : (k,) int32
        Of the outlines (`ZoneFaces`).
    length : (k,) float64 [m]
        That each represents.
    joint : (k,) int32
        As `JointPoints` has it.
    block : (k, 2 sides) int32
        The blocks that met.
    """

    corner: IntArray
    length: FloatArray
    joint: IntArray
    block: IntArray

    @classmethod
    def none(cls) -> Met:
        """Return no points."""
        none = np.zeros(0, np.int32)
        return cls(corner=none, length=np.zeros(0), joint=none, block=np.zeros((0, 2), np.int32))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class MovingPoints(JointPoints):
    """Points of joints in large displacement.

    Attributes
    ----------
    node : (q,) int32
        The nodes s.
    nodes : (k, 2) int
        Unknowns of every node.
    as_given : (k, 2) float64 [m]
        Where the nodes were given.
    places : Places
        Where they are there.
    faces : ZoneFaces
        Outlines of the blocks, with the faces that points slide along.
    own : (p, 2) int32
        Of every point of a given joint, the edge of its side that starts there, and the one that ends there; -1: none.
    met : Met
        The last points, which came later.
    unknown : (q, 2 m) int32
        Unknowns x, y of the node s and of those of the side.
    parts : (q, 2, m) float64
        r and e from these nodes.
    given : (q, 2, 2) float64 [m]
        r and e as given.
    """

    node: IntArray
    nodes: IntArray
    as_given: FloatArray
    places: Places
    faces: ZoneFaces
    own: IntArray
    met: Met
    unknown: IntArray
    parts: FloatArray
    given: FloatArray

    @classmethod
    def of(
        cls,
        points: JointPoints,
        node: IntArray,
        nodes: IntArray,
        as_given: FloatArray,
        piece: IntArray,
        share: FloatArray,
        faces: ZoneFaces,
        own: IntArray,
    ) -> MovingPoints:
        """Return the same points, which lie at parts (q,) of pieces (q,) of the first side as given."""
        zero = np.zeros(len(node))
        places = Places(piece=piece, share=share, slid=zero, over=np.zeros(len(node), dtype=bool))
        known = {field.name: getattr(points, field.name) for field in fields(points)}
        side = _side(faces.chains, node, nodes, as_given, places)
        frame: dict[str, Any] = {"nodes": nodes, "as_given": as_given, "faces": faces}
        return cls(**known, **frame, node=node, places=places, own=own, met=Met.none(), **side)

    def facing(self, places: Places) -> MovingPoints:
        """Return the points at other places of the first side."""
        block = np.stack([self.faces.chains.block[places.piece], self.block[:, 1]], axis=1).astype(np.int32)
        side = _side(self.faces.chains, self.node, self.nodes, self.as_given, places)
        return replace(self, block=block, places=places, **side)

    def slid_on(self, u: FloatArray, present: BoolArray) -> MovingPoints | None:
        """Return the points at the places that they face at displacements u (N,); None: none has slid far.

        `present` (n,): which blocks are there.
        """
        _, slip = self.relative(u)
        places = self.places
        far = np.flatnonzero(np.abs(slip - places.slid) > SLID * self.pieces)
        if not far.size:
            return None
        piece, share, over = places.piece.copy(), places.share.copy(), places.over.copy()
        where = self.as_given + u[self.nodes]
        piece[far], share[far] = self.faces.chains.facing(
            where[self.node[far]],
            self.block[far, 1],
            piece[far],
            where,
            present,
            self._tails[far],
            self._lip_of(far),
        )
        beyond = (np.abs(share[far] - 0.5) - 0.5) * self.pieces[far]
        over[far] = beyond > self._lip_of(far)(np.arange(len(far)), self.faces.chains.block[piece[far]])
        share[over] = share[over].clip(0.0, 1.0)
        if (piece == places.piece).all() and (share == places.share).all() and (over == places.over).all():
            return None  # those that slid far are over the end of a face still
        there = self.facing(Places(piece=piece, share=share, slid=np.zeros_like(slip), over=over))
        slid = places.slid.copy()
        slid[far] = (slip - there.relative(u)[1])[far]
        return replace(there, places=replace(there.places, slid=slid))

    @property
    def _tails(self) -> IntArray:
        """Which way the face of a point lies that ends with it, (q,), as `FaceChains.facing` has it."""
        starts, ends = (self.own >= 0).T.astype(int)
        return np.append(starts - ends, np.zeros(len(self.node) - len(self.own), dtype=int))

    def _lip_of(self, far: IntArray) -> Lip:
        """Return how deep points (k,) at the ends of faces have to lie on a block to carry."""

        def lip(on: IntArray, block: IntArray) -> FloatArray:
            return self.faces.least_overlap(self.block[far[on], 1], block)

        return lip

    @property
    def over(self) -> BoolArray:
        """Which points slid over the end of a face, (q,)."""
        return self.places.over

    def relative(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return opening and slip (q,) [m] at displacements u (N,)."""
        r, e = self._vectors(u)
        square = (e * e).sum(axis=1)
        opening = (e[:, 1] * r[:, 0] - e[:, 0] * r[:, 1]) / np.sqrt(square)
        slip: FloatArray = (e * r).sum(axis=1) / np.sqrt(square) + self.places.slid
        return opening, slip

    def forces(self, u: FloatArray, state: JointState, history: JointHistory) -> FloatArray:
        """Return the points' part of the internal forces at displacements u (N,), (N,) [N/m]."""
        opens, slips = self._gradients(u)
        of_r_and_e = (state.shear[:, None] * slips - state.pressure[:, None] * opens).reshape(-1, 2, 2)
        nodal = self.parts.swapaxes(1, 2) @ of_r_and_e
        return np.bincount(self.unknown.ravel(), nodal.ravel(), minlength=len(u)).astype(np.float64)

    def gradients(self, u: FloatArray) -> FloatArray:
        """Return the derivatives of opening and slip by the unknowns of every point, (q, 2, 2 m)."""
        by = np.stack(self._gradients(u), axis=1).reshape(len(self.parts), 2, 2, 2)
        found: FloatArray = np.einsum("qri,qdrj->qdij", self.parts, by)
        return found.reshape(len(self.parts), 2, 2 * self.parts.shape[2])

    def entries(self, u: FloatArray, state: JointState, of: PointStiffness) -> FloatArray:
        """Return the derivatives (q, 2 m, 2 m) of every point's forces by its unknowns, with the turning of frames."""
        opens, slips = self._gradients(u)
        by_opening = of.normal[:, None] * opens + of.dilating[:, None] * slips
        by_slip = of.shear[:, None] * slips + of.cross[:, None] * opens
        K = opens[:, :, None] * by_opening[:, None, :] + slips[:, :, None] * by_slip[:, None, :]
        opening_twice, slip_twice = self._second_derivatives(u)
        K += state.shear[:, None, None] * slip_twice - state.pressure[:, None, None] * opening_twice
        return self.on_nodes(K)

    def on_nodes(self, of_r_and_e: FloatArray) -> FloatArray:
        """Return second derivatives by r and e (q, 4, 4) as those by the unknowns of every point, (q, 2 m, 2 m)."""
        q, _, m = self.parts.shape
        by = of_r_and_e.reshape(q, 2, 2, 2, 2)
        found: FloatArray = np.einsum("qim,qiajb,qjn->qmanb", self.parts, by, self.parts, optimize=True)
        return found.reshape(q, 2 * m, 2 * m)

    def moved(self, correction: FloatArray, present: BoolArray) -> float:
        """Return how far a correction (N,) moves opposite nodes against each other, at most [m]."""
        r = self._of_nodes(correction)[:, 0]
        return float((np.hypot(*r.T) * present).max(initial=0.0))

    def placed(self, u: FloatArray) -> FloatArray:
        """Return where the points are at displacements u (N,), (q, 2) [m]."""
        found: FloatArray = self.point + u[self.unknown[:, :2]]
        return found

    def frames(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the unit normals out of the first side, and the directions along it, (q, 2) each."""
        _, e = self._vectors(u)
        along = e / np.hypot(*e.T)[:, None]
        return np.stack([along[:, 1], -along[:, 0]], axis=1), along

    @property
    def pieces(self) -> FloatArray:
        """Lengths of the sides of zones that points lie on, as given, (q,) [m]."""
        length: FloatArray = np.hypot(*self.given[:, 1].T)
        return length

    @property
    def side(self) -> float:
        """Length of a side of a zone on a joint, the median; without joints of one along an outline [m]."""
        ends = self.as_given[self.faces.chains.node[:, :2]]
        lengths = self.pieces if len(self.own) else np.hypot(*(ends[:, 1] - ends[:, 0]).T)
        return float(np.median(lengths))

    def _vectors(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        r, e = np.moveaxis(self.given + self._of_nodes(u), 1, 0)
        return r, e

    def _of_nodes(self, u: FloatArray) -> FloatArray:
        """Return what displacements (N,) add to r and e, (q, 2, 2)."""
        found: FloatArray = self.parts @ u[self.unknown].reshape(*self.parts.shape[::2], 2)
        return found

    def _gradients(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives of opening and slip by r and e, (q, 4) each."""
        r, e = self._vectors(u)
        square, dot = (e * e).sum(axis=1)[:, None], (e * r).sum(axis=1)[:, None]
        length = np.sqrt(square)
        opening = (e[:, 1:] * r[:, :1] - e[:, :1] * r[:, 1:]) / length
        n, across = (e @ QUARTER) / length, -(r @ QUARTER) / length
        return (
            np.hstack([n, across - opening / square * e]),
            np.hstack([e / length, (r - dot / square * e) / length]),
        )

    def _second_derivatives(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the second derivatives of opening and slip by r and e, (q, 4, 4) each."""
        r, e = self._vectors(u)
        square, dot = ((of * e).sum(axis=1)[:, None, None] for of in (e, r))
        length = np.sqrt(square)
        opens, _ = self._gradients(u)
        ee, re, one = e[:, :, None] * e[:, None, :], r[:, :, None] * e[:, None, :], np.eye(2)
        opening = (e[:, 1] * r[:, 0] - e[:, 0] * r[:, 1])[:, None, None] / length
        across = -(r @ QUARTER)[:, :, None] * e[:, None, :] / length
        turning = opens[:, 2:, None] * e[:, None, :]

        def whole(mixed: Any, own: Any) -> FloatArray:
            found = np.zeros((len(r), 4, 4))
            found[:, :2, 2:], found[:, 2:, :2], found[:, 2:, 2:] = mixed, mixed.swapaxes(1, 2), own
            return found

        return (
            whole(
                QUARTER.T / length - opens[:, :2, None] * e[:, None, :] / square,
                -(across + turning.swapaxes(1, 2)) / square - opening / square * one + 2 * opening / square**2 * ee,
            ),
            whole(
                (one - ee / square) / length,
                -(re + re.swapaxes(1, 2) + dot * one - 3 * dot / square * ee) / (square * length),
            ),
        )


def _side(chains: FaceChains, node: IntArray, nodes: IntArray, as_given: FloatArray, places: Places) -> dict[str, Any]:
    """Return `unknown`, `parts` and `given` of `MovingPoints` at some places."""
    every = np.column_stack([node, chains.node[places.piece]])
    parts = np.zeros((len(every), 2, every.shape[1]))
    parts[:, 0, 0], parts[:, 0, 1:] = 1.0, -chains.shapes(places.share)
    parts[:, 1, 1], parts[:, 1, 2] = -1.0, 1.0
    unknown = nodes[every].reshape(len(every), 2 * every.shape[1]).astype(np.int32)
    return {"unknown": unknown, "parts": parts, "given": parts @ as_given[every]}
