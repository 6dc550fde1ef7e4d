"""Blocks in large displacement: their rock, its tangent with that of the joints, and corrections that turn blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.zones.joint_history import JointState
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.large_rock import LargeRock
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.system import FreeUnknowns
from bsm_mesh.solve.zones.tangents import PointStiffness

MOST_TURNING = 0.2  # gradient of a correction's displacements: by how much it may turn or strain a cell


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LargeBlocks:
    """The blocks of a stage.

    Attributes
    ----------
    rock : LargeRock
        The cells.
    dofs : (2 nodes, t) int32
        Their unknowns.
    free : FreeUnknowns
        Those left by the supports.
    node : (k, 2) int32
        Unknowns of the nodes of pieces of rock that turn freely.
    piece : (k,) int32
        Number of the piece of each, from 0: blocks that share nodes are one.
    place : (k, 2) float64 [m]
        Where it was given.
    """

    rock: LargeRock
    dofs: IntArray
    free: FreeUnknowns
    node: IntArray
    piece: IntArray
    place: FloatArray

    @classmethod
    def of(cls, rock: LargeRock, basis: Any, on: BoolArray, free: FreeUnknowns) -> LargeBlocks:
        """Return the blocks of cells (t,) that are there; pieces of rock with two held nodes or more do not turn."""
        dofs = basis.element_dofs
        together = dofs[:, on]  # each cell ties its first unknown to all its others
        pairs = np.tile(together[0], len(together)), together.ravel()
        graph = sp.coo_matrix((np.ones(len(pairs[0]), np.int8), pairs), shape=(basis.N, basis.N))
        piece = connected_components(graph, directed=False)[1]
        node = np.unique(np.stack([together[::2].ravel(), together[1::2].ravel()], axis=1), axis=0)
        piece = piece[node[:, 0]]
        held = free.supports.held[node].any(axis=1)
        turning = np.bincount(piece, held)[piece] < 2
        node, number = node[turning], np.unique(piece[turning], return_inverse=True)[1]
        place = np.stack([basis.doflocs[axis, node[:, axis]] for axis in (0, 1)], axis=1)
        return cls(rock=rock, dofs=dofs, free=free, node=node, piece=number.reshape(-1), place=place)

    def forces(self, u: FloatArray) -> FloatArray:
        """Return the internal forces of the rock at displacements u (N,), (N,) [N/m]."""
        return self.rock.forces(self.rock.at(u, self.dofs), self.dofs, len(u))

    def tangent(
        self,
        u: FloatArray,
        joints: JointPoints | None,
        state: JointState | None,
        points: PointStiffness | None,
        rock: float = 1.0,
        softer: Any = None,
    ) -> Any:
        """Return the tangent (free, free), by columns, with so many times the rock's stiffness.

        `softer` (N, N) is what yielding adds to it.
        """
        K = self.matrix(u, joints, state, points, rock)
        return self.free.reduced_matrix(K if softer is None else K + softer)

    def matrix(
        self,
        u: FloatArray,
        joints: JointPoints | None,
        state: JointState | None,
        points: PointStiffness | None,
        rock: float = 1.0,
    ) -> Any:
        """Return the tangent (N, N) of all unknowns, held ones too."""
        unknowns = [self.dofs.T]
        entries = [rock * self.rock.entries(self.rock.at(u, self.dofs))]
        if isinstance(joints, MovingPoints) and state is not None and points is not None:
            unknowns.append(joints.unknown)
            entries.append(joints.entries(u, state, points))
        rows = np.concatenate([np.repeat(of, of.shape[1], axis=1).ravel() for of in unknowns])
        columns = np.concatenate([np.tile(of, of.shape[1]).ravel() for of in unknowns])
        values = np.concatenate([of.ravel() for of in entries])
        return sp.csr_matrix((values, (rows, columns)), shape=(len(u), len(u)))

    def leaves(self, A: Any, weight: float) -> bool:
        """Return whether blocks leave an equilibrium by the least disturbance: its stiffness is not positive.

        Parameters
        ----------
        A : sparse (free, free) [Pa]
            The tangent; its symmetric part counts.
        weight : float [N/m2]
            Force over displacement, of a node, up to which a negative stiffness counts as none.
        """
        rows = self.free.rows
        if rows.shape[0]:
            scale = float(A.diagonal().max()) / float(rows.multiply(rows).sum(axis=1).max())
            A = A + scale * (rows.T @ rows)
        size = A.shape[0]
        # Without exchange of rows the pivots have the signs of the eigenvalues (Sylvester).
        options = {"SymmetricMode": True}
        shifted = sp.csc_matrix((A + A.T) / 2 + weight * sp.identity(size))
        try:
            factors = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        except RuntimeError:  # singular
            return True
        return bool((factors.U.diagonal() <= 0).any())

    def allowed(self, correction: FloatArray) -> float:
        """Return the part of a correction (N,) that turns and strains no cell too much, at most 1."""
        turned = self.rock.greatest_gradient(correction, self.dofs)
        return min(1.0, MOST_TURNING / turned) if turned else 1.0

    def moved(self, u: FloatArray, correction: FloatArray) -> FloatArray:
        """Return displacements u (N,) after a correction, which turns pieces of rock about their instant centres.

        A sum alone would strain them by half the square of the angle. That would be more stress than all loads cause,
        and the line search would shorten every correction to that.
        """
        count = np.maximum(np.bincount(self.piece), 1)

        def mean(values: FloatArray) -> FloatArray:
            return np.stack([np.bincount(self.piece, column) for column in values.T], axis=1) / count[:, None]

        moved, where = correction[self.node], self.place + u[self.node]
        shift = mean(moved)
        arm, rest = where - mean(where)[self.piece], moved - shift[self.piece]
        turning = np.bincount(self.piece, arm[:, 0] * rest[:, 1] - arm[:, 1] * rest[:, 0])
        angle = turning / np.maximum(np.bincount(self.piece, (arm**2).sum(axis=1)), np.finfo(float).tiny)
        to_centre = np.stack([-shift[:, 1], shift[:, 0]], axis=1)
        to_centre /= np.where(np.abs(angle) > np.finfo(float).eps, angle, np.inf)[:, None]
        x, y = (arm - to_centre[self.piece]).T
        versed, lag = (-2 * np.sin(angle / 2) ** 2)[self.piece], (np.sin(angle) - angle)[self.piece]
        changed = u + correction
        changed[self.node] += np.stack([versed * x - lag * y, versed * y + lag * x], axis=1)
        return self.free.fulfilled(changed)
