"""Blocks in large displacement: their rock, its tangent with that of the joints, and corrections that turn blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.solve.zones.joint_history import JointState
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.large_rock import LargeRock
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.system import FreeUnknowns
from bsm_mesh.solve.zones.tangents import PointStiffness

NO_TURN = 1e-12  # rad: with less a block turns about no centre
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
        Unknowns of the nodes of blocks that turn freely, block after block.
    turns : (k,) int32
        Number of the block of each, from 0.
    place : (k, 2) float64 [m]
        Where it was given.
    """

    rock: LargeRock
    dofs: IntArray
    free: FreeUnknowns
    node: IntArray
    turns: IntArray
    place: FloatArray

    @classmethod
    def of(cls, rock: LargeRock, basis: Any, block: IntArray, on: BoolArray, free: FreeUnknowns) -> LargeBlocks:
        """Return the blocks of cells (t,) that are there; blocks with two held nodes or more do not turn."""
        dofs = basis.element_dofs
        pairs = np.unique(np.stack([np.tile(block, len(dofs) // 2), dofs[::2].ravel(), dofs[1::2].ravel()]), axis=1)
        pairs = pairs[:, np.isin(pairs[0], block[on])]
        held = free.supports.held[pairs[1:]].any(axis=0)
        turning = np.bincount(pairs[0], held, minlength=int(block.max()) + 1)[pairs[0]] < 2
        number, x, y = pairs[:, turning]
        turns = np.unique(number, return_inverse=True)[1].reshape(-1).astype(np.int32)
        place = np.stack([basis.doflocs[0, x], basis.doflocs[1, y]], axis=1)
        return cls(rock=rock, dofs=dofs, free=free, node=np.stack([x, y], axis=1), turns=turns, place=place)

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
    ) -> Any:
        """Return the tangent (free, free), by columns, with so many times the rock's stiffness."""
        unknowns = [self.dofs.T]
        entries = [rock * self.rock.entries(self.rock.at(u, self.dofs))]
        if isinstance(joints, MovingPoints) and state is not None and points is not None:
            unknowns.append(joints.unknown)
            entries.append(joints.entries(u, state, points))
        rows = np.concatenate([np.repeat(of, of.shape[1], axis=1).ravel() for of in unknowns])
        columns = np.concatenate([np.tile(of, of.shape[1]).ravel() for of in unknowns])
        values = np.concatenate([of.ravel() for of in entries])
        return self.free.reduced_matrix(sp.csr_matrix((values, (rows, columns)), shape=(len(u), len(u))))

    def allowed(self, correction: FloatArray) -> float:
        """Return the part of a correction (N,) that turns and strains no cell too much, at most 1."""
        turned = self.rock.greatest_gradient(correction, self.dofs)
        return min(1.0, MOST_TURNING / turned) if turned else 1.0

    def moved(self, u: FloatArray, correction: FloatArray) -> FloatArray:
        """Return displacements u (N,) after a correction, which turns every block about its instant centre.

        A sum alone would strain blocks by half the square of the angle. That would be more stress than all loads cause,
        and the line search would shorten every correction to that.
        """
        count = np.maximum(np.bincount(self.turns), 1)

        def mean(values: FloatArray) -> FloatArray:
            return np.stack([np.bincount(self.turns, column) for column in values.T], axis=1) / count[:, None]

        moved, where = correction[self.node], self.place + u[self.node]
        shift = mean(moved)
        arm, rest = where - mean(where)[self.turns], moved - shift[self.turns]
        turning = np.bincount(self.turns, arm[:, 0] * rest[:, 1] - arm[:, 1] * rest[:, 0])
        angle = turning / np.maximum(np.bincount(self.turns, (arm**2).sum(axis=1)), np.finfo(float).tiny)
        turns = np.abs(angle) > NO_TURN
        versed, lag = -2 * np.sin(angle / 2) ** 2, np.sin(angle) - angle  # cos - 1, sin - angle

        def turned(vectors: FloatArray, along: FloatArray, across: FloatArray) -> FloatArray:
            x, y = vectors.T
            return np.stack([along * x - across * y, along * y + across * x], axis=1)

        # About the instant centre c + z x d / angle: arms are x - c - z x d / angle.
        centre = np.stack([-shift[:, 1], shift[:, 0]], axis=1) / np.where(turns, angle, np.inf)[:, None]
        more = turned(arm - centre[self.turns], versed[self.turns], lag[self.turns])
        found, sharing = np.zeros_like(u), np.zeros(len(u))
        np.add.at(found, self.node, more)
        np.add.at(sharing, self.node, 1.0)
        return self.free.fulfilled(u + correction + found / np.maximum(sharing, 1.0))
