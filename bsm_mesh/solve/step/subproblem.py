"""A subproblem of a step: the equations of some blocks (a subdomain), all others fixed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.algebra.block_matrix import BlockPattern, constrain
from bsm_mesh.solve.algebra.linear_solvers import LinearSolver, make_linear_solver
from bsm_mesh.solve.step.equations import StepEquations


class SubdomainEquations(StepEquations):
    """The equations of a step restricted to some blocks, the others fixed.

    Positions, movements and forces (q, 3) are those of the blocks in these equations: the moving ones and their
    neighbours, which are fixed. Fixed blocks have no movement, and their residual does not count.

    Parameters
    ----------
    step : StepEquations
        The equations of all.
    moves : (n,) bool
        The blocks that move.
    position : (n, 3) float64
        Where all blocks are.

    Attributes
    ----------
    blocks : (q,) int64
        The blocks in these equations.
    block : (k,) int64
        Which of them move.
    rows : (l,) int64
        The step's contacts of moving blocks.
    """

    def __init__(self, step: StepEquations, moves: BoolArray, position: FloatArray) -> None:
        candidates, self._position = step.contacts.candidates, position
        self.rows = np.flatnonzero(moves[candidates.block_a] | moves[candidates.block_b])
        involved = moves.copy()
        involved[candidates.block_a[self.rows]] = involved[candidates.block_b[self.rows]] = True
        self.blocks = np.flatnonzero(involved)
        self.block = np.flatnonzero(moves[self.blocks])
        self.system, self.factors, self.lam = step.system, step.factors, step.lam
        self.settlement_allowance, self.supports_move = step.settlement_allowance, False
        self.is_symmetric, self.has_inertia = step.is_symmetric, step.has_inertia
        self.anchor, self.start = step.anchor[self.blocks], position[self.blocks]
        self.regularization_reference = step.regularization_reference[self.blocks]
        self.searched = step.searched[self.blocks]
        self.mass, self.scale = step.mass[self.blocks], step.scale[self.blocks]
        self.supports = step.supports.of(self.blocks)
        self.contacts = step.system.some(step.contacts, self.rows, np.cumsum(involved, dtype=np.int32) - 1)
        self._set_pattern(step.pattern, self.blocks[self.block])
        options, centroid = self.factors.options, step.system.centroid[self.blocks[self.block]]
        self._solver: LinearSolver = make_linear_solver(
            options.linear_solver, self._solved, centroid, options.threads, corrections=True
        )

    def _set_pattern(self, whole: BlockPattern, free: IntArray) -> None:
        """Set the pattern of the moving blocks, with one more place for their coupling to fixed blocks."""
        places = csr_array((np.arange(1, len(whole.column) + 1), whole.column, whole.row_start))
        part = places[free][:, free]
        part.sort_indices()
        row_start, column = part.indptr.astype(np.int32), part.indices.astype(np.int32)
        local = np.full(len(whole.column), len(column), np.int32)
        local[part.data - 1] = np.arange(len(column))  # counted from 1 above: a 0 would be no entry of the graph
        row = np.repeat(np.arange(len(free)), np.diff(row_start))
        self._solved = BlockPattern(
            row_start=row_start,
            column=column,
            diagonal=np.flatnonzero(column == row).astype(np.int32),
            place=local[whole.place[self.rows]],
            symmetric=False,
        )
        self.pattern = replace(self._solved, column=np.append(column, np.int32(0)))
        self._bolt_places = local[self.factors.bolt_places]

    def whole(self, position: FloatArray) -> FloatArray:
        """Return the position of all blocks (n, 3), with those of the subproblem at theirs (q, 3)."""
        everywhere = self._position.copy()
        everywhere[self.blocks] = position
        return everywhere

    def acting_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads, water and bolt forces on the blocks of the subproblem, (q, 3)."""
        constant = self.system.constant_loads
        found: FloatArray = (self.system.acting_at(self.whole(position)) if constant is None else constant)[self.blocks]
        return found

    def load_stiffness(self, position: FloatArray) -> FloatArray | None:
        """Return the derivatives of minus weights, loads and water, (q, 3, 3); None: all are zero."""
        found = super().load_stiffness(self.whole(position))
        return None if found is None else found[self.blocks]

    def project(self, forces: FloatArray) -> FloatArray:
        """Project forces (q, 3) onto the free degrees of freedom of the moving blocks, (k, 3)."""
        return super().project(forces)[self.block]

    def complete(self, data: FloatArray, position: FloatArray) -> FloatArray:
        """Return the tangent of contacts, bolts, loads and regularisation, constrained axes eliminated."""
        bolts, own, support = self.system.bolts, self._solved, self.supports
        if len(bolts.alive):
            bolts.add_tangent(bolts.evaluate(self.whole(position)), self._bolt_places, data)
        loads = self.load_stiffness(position)
        if loads is not None:
            data[own.diagonal] += loads[self.block]
        axis = np.arange(self.system.axes)[:, None]
        data[own.diagonal, axis, axis] += self.lam * self.mass[self.block].T
        number = support.number[self.block]
        constrain(own.row_start, own.column, own.diagonal, data, number, support.basis, support.constrained)
        return data[:-1]

    def factorize(self, data: FloatArray, position: FloatArray) -> bool:
        """Factorize the completed tangent; return False where it is singular."""
        try:
            self._solver.factorize(self.complete(data, position))
        except SingularMatrixError:
            return False
        return True

    def solve(self, forces: FloatArray) -> FloatArray:
        """Return the movement (q, 3) under forces with the last factors."""
        movement = np.zeros_like(forces)
        movement[self.block] = self._solver.solve(self.supports.free_part(forces)[self.block])
        return self.supports.expand(movement)

    def close(self) -> None:
        """Give the factors' memory back."""
        self._solver.close()
