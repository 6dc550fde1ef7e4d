"""A step in which only some blocks move and the others stay where they are: their contacts, their equations."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.solve.algebra.block_matrix import BlockPattern, constrain
from bsm_mesh.solve.algebra.linear_solvers import LinearSolver, make_linear_solver
from bsm_mesh.solve.contacts.forces import MovingContacts, rows_by_law
from bsm_mesh.solve.step.equations import Step


class LocalStep(Step):
    """The part of a step's equations that some blocks have, the others held where they are.

    Positions, movements and forces (q, 3) are those of the blocks that have a part in these equations: of those that
    move, and of those they touch, which are held. Movements of held blocks are zero, and what they have out of balance
    does not count.

    Parameters
    ----------
    step : Step
        The equations of all.
    moves : (n,) bool
        The blocks that move.
    position : (n, 3) float64
        Where all blocks are.

    Attributes
    ----------
    blocks : (q,) int64
        The blocks that have a part.
    block : (k,) int64
        Which of them move.
    rows : (l,) int64
        The step's contacts that they have a part in.
    clusters : int
        Number of groups of moving blocks without a contact between.
    cluster : (k,) int32
        Group of each.
    cluster_of_row : (l,) int64
        Group that each contact has a part in.
    """

    def __init__(self, step: Step, moves: BoolArray, position: FloatArray) -> None:
        candidates, self._position = step.contacts.candidates, position
        self.rows = np.flatnonzero(moves[candidates.block_a] | moves[candidates.block_b])
        involved = moves.copy()
        involved[candidates.block_a[self.rows]] = involved[candidates.block_b[self.rows]] = True
        self.blocks = np.flatnonzero(involved)
        self.block = np.flatnonzero(moves[self.blocks])
        self.moving, self.factors, self.lam, self.room = step.moving, step.factors, step.lam, step.room
        self.anchor, self.start, self.driven = step.anchor[self.blocks], position[self.blocks], False
        self.still = step.still[self.blocks]
        self.mass, self.scale = step.mass[self.blocks], step.scale[self.blocks]
        self.supports = step.supports.of(self.blocks)
        self.contacts = _chosen(step.contacts, self.rows, np.cumsum(involved, dtype=np.int32) - 1)
        held = step.friction_pressure
        self.friction_pressure = None if held is None else held[self.rows]
        self.smoothing = step.smoothing
        self._set_pattern(step.pattern, self.blocks[self.block])
        options, centroid = self.factors.options, step.moving.outlines.centroid[self.blocks[self.block]]
        self._solver: LinearSolver = make_linear_solver(
            options.linear_solver, self._solved, centroid, options.threads, corrections=True
        )

    def _set_pattern(self, whole: BlockPattern, moving: IntArray) -> None:
        """Set the pattern of the moving blocks, and with a place more, for what they share with the others."""
        places = csr_array((np.arange(1, len(whole.column) + 1), whole.column, whole.row_start))
        part = places[moving][:, moving]
        part.sort_indices()
        row_start, column = part.indptr.astype(np.int32), part.indices.astype(np.int32)
        local = np.full(len(whole.column), len(column), np.int32)
        local[part.data - 1] = np.arange(len(column))  # counted from 1 above: a 0 would be no entry of the graph
        row = np.repeat(np.arange(len(moving)), np.diff(row_start))
        self._solved = BlockPattern(
            row_start=row_start,
            column=column,
            diagonal=np.flatnonzero(column == row).astype(np.int32),
            place=local[whole.place[self.rows]],
            symmetric=False,
        )
        self.pattern = replace(self._solved, column=np.append(column, np.int32(0)))
        self._bolt_places = local[self.factors.bolt_places]
        self.clusters, self.cluster = connected_components(part, directed=False)
        self._set_clusters()

    def _set_clusters(self) -> None:
        """Set the cluster of every contact, and of every block: held ones belong to one of those that they touch."""
        c, of_block = self.contacts.candidates, np.full(len(self.blocks), -1, np.int64)
        of_block[self.block] = self.cluster
        self.cluster_of_row = np.maximum(of_block[c.block_a], of_block[c.block_b])
        for side in (c.block_a, c.block_b):
            held = of_block[side] < 0
            of_block[side[held]] = self.cluster_of_row[held]
        self._cluster_of_block = of_block

    def by_cluster(self, values: FloatArray) -> FloatArray:
        """Return the sums of blocks' values (n,) over every cluster and the held blocks around it, (clusters,)."""
        sums: FloatArray = np.bincount(self._cluster_of_block, values[self.blocks], self.clusters).astype(float)
        return sums

    def whole(self, position: FloatArray) -> FloatArray:
        """Return where all blocks (n, 3) are with those of this step at a position."""
        everywhere = self._position.copy()
        everywhere[self.blocks] = position
        return everywhere

    def acting_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads, water and bolt forces on the blocks of this step, (q, 3)."""
        constant = self.moving.constant_loads
        found: FloatArray = (self.moving.acting_at(self.whole(position)) if constant is None else constant)[self.blocks]
        return found

    def free(self, forces: FloatArray) -> FloatArray:
        """Return what counts of forces (q, 3) as being out of balance, of the moving blocks alone, (k, 3)."""
        return super().free(forces)[self.block]

    def complete(self, data: FloatArray, position: FloatArray) -> FloatArray:
        """Return contacts' tangent blocks with the bolts' at a position and the regularisation, supports eliminated."""
        bolts, own, support = self.moving.bolts, self._solved, self.supports
        if len(bolts.alive):
            bolts.add_tangent(bolts.evaluate(self.whole(position)), self._bolt_places, data)
        data[own.diagonal, [[0], [1], [2]], [[0], [1], [2]]] += self.lam * self.mass[self.block].T
        number = support.number[self.block]
        constrain(own.row_start, own.column, own.diagonal, data, number, support.basis, support.held)
        return data[:-1]

    def factorize(self, data: FloatArray, position: FloatArray) -> bool:
        """Factorize contacts' tangent blocks, completed; False where that is singular."""
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


def _chosen(contacts: MovingContacts, rows: IntArray, block: IntArray) -> MovingContacts:
    """Return some of the contacts, their blocks numbered anew, (n,); whoever is chosen, its rival is."""
    number = np.full(contacts.count, -1, np.int32)
    number[rows] = np.arange(len(rows))
    candidates = _rows_of(contacts.candidates, rows)
    opposing_candidate = candidates.opposing_candidate
    entering = number[contacts.entering]
    plain = ("outlines", "candidates", "opposing", "entering", "entering_direction", "by_law")
    others = {field.name for field in fields(contacts)}.difference(plain)
    return MovingContacts(
        outlines=contacts.outlines,
        candidates=replace(
            candidates,
            block_a=block[candidates.block_a],
            block_b=block[candidates.block_b],
            opposing_candidate=np.where(opposing_candidate >= 0, number[opposing_candidate], -1),
        ),
        by_law=rows_by_law(contacts.law[rows]),
        opposing=np.flatnonzero(opposing_candidate >= 0),
        entering=entering[entering >= 0],
        entering_direction=contacts.entering_direction[entering >= 0],
        **{name: getattr(contacts, name)[rows] for name in others},
    )


def _rows_of(table: Any, rows: IntArray) -> Any:
    """Return a dataclass of arrays with some of their rows."""
    return replace(table, **{field.name: getattr(table, field.name)[rows] for field in fields(table)})
