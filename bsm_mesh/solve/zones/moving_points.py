"""Points of joints that turn with the blocks: opening and slip in large displacement.

A point is a node s of the second side. Opposite lies the node m of the first side, on a side of a zone from node a to
node b. With r = x_s - x_m and e = x_b - x_a opening and slip are ``r . n`` and ``r . t``, where t is the direction of
e, and n its normal out of the first side. So slip is between points of the material: a side that shortens has not
slipped. Both are the same in all frames that turn, and the forces balance in force and moment: they act at the node s.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.zones.joint_history import JointHistory, JointState
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.tangents import PointStiffness

QUARTER = np.array([(0.0, -1.0), (1.0, 0.0)])
NODES = np.array([(1.0, -1.0, 0.0, 0.0), (0.0, 0.0, -1.0, 1.0)])  # r and e from the nodes s, m, a, b
FROM_NODES = np.kron(NODES, np.eye(2))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class MovingPoints(JointPoints):
    """Points of joints in large displacement.

    Attributes
    ----------
    unknown : (q, 8) int32
        Unknowns x, y of the nodes s, m, a, b.
    given : (q, 2, 2) float64 [m]
        r and e as given.
    """

    unknown: IntArray
    given: FloatArray

    @classmethod
    def of(cls, points: JointPoints, node: IntArray, nodes: IntArray, place: FloatArray) -> MovingPoints:
        """Return the same points, of which the nodes s, m, a, b are (q, 4).

        Parameters
        ----------
        points : JointPoints
            At these nodes.
        node : (q, 4) int
            Nodes of every point; a and b in any order.
        nodes : (k, 2) int
            Unknowns of every node.
        place : (k, 2) float64 [m]
            Where the nodes were given.
        """
        e = place[node[:, 3]] - place[node[:, 2]]
        backwards = e[:, 1] * points.normal[:, 0] - e[:, 0] * points.normal[:, 1] < 0
        node = np.where(backwards[:, None], node[:, [0, 1, 3, 2]], node)
        given = np.einsum("kn,qni->qki", NODES, place[node])
        known = {field.name: getattr(points, field.name) for field in fields(points)}
        return cls(**known, unknown=nodes[node].reshape(len(node), 8).astype(np.int32), given=given)

    def relative(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return opening and slip (q,) [m] at displacements u (N,)."""
        r, e = self._vectors(u)
        square = (e * e).sum(axis=1)
        opening = (e[:, 1] * r[:, 0] - e[:, 0] * r[:, 1]) / np.sqrt(square)
        slip: FloatArray = (e * r).sum(axis=1) / np.sqrt(square)
        return opening, slip

    def forces(self, u: FloatArray, state: JointState, history: JointHistory) -> FloatArray:
        """Return the points' part of the internal forces at displacements u (N,), (N,) [N/m]."""
        opens, slips = self._gradients(u)
        nodal = (state.shear[:, None] * slips - state.pressure[:, None] * opens) @ FROM_NODES
        return np.bincount(self.unknown.ravel(), nodal.ravel(), minlength=len(u)).astype(np.float64)

    def entries(self, u: FloatArray, state: JointState, of: PointStiffness) -> FloatArray:
        """Return the derivatives (q, 8, 8) of the forces of every point by its unknowns, with the turning of frames."""
        opens, slips = self._gradients(u)
        by_opening = of.normal[:, None] * opens + of.dilating[:, None] * slips
        by_slip = of.shear[:, None] * slips + of.cross[:, None] * opens
        K = opens[:, :, None] * by_opening[:, None, :] + slips[:, :, None] * by_slip[:, None, :]
        opening_twice, slip_twice = self._second_derivatives(u)
        K += state.shear[:, None, None] * slip_twice - state.pressure[:, None, None] * opening_twice
        found: FloatArray = FROM_NODES.T @ K @ FROM_NODES
        return found

    def moved(self, correction: FloatArray, present: BoolArray) -> float:
        """Return how far a correction (N,) moves opposite nodes against each other, at most [m]."""
        r = (NODES @ correction[self.unknown].reshape(-1, 4, 2))[:, 0]
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

    def _vectors(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        r, e = np.moveaxis(self.given + NODES @ u[self.unknown].reshape(-1, 4, 2), 1, 0)
        return r, e

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
