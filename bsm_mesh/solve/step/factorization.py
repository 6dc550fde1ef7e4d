"""Factorization of the tangent: the linear solver of a run, its analysis kept while the pattern stays the same."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import SingularMatrixError
from bsm_mesh.heap import give_back
from bsm_mesh.model.options import Options
from bsm_mesh.solve.algebra.block_matrix import BlockPattern, upper_triangle, whole_pattern
from bsm_mesh.solve.algebra.linear_solvers import LinearSolver, make_linear_solver
from bsm_mesh.solve.algebra.mixed_precision import MixedPrecisionPardiso
from bsm_mesh.solve.step.system import Contacts, System

WORTH_GIVING_BACK = 200_000  # [blocks]; below, free heap memory is worth less than mapping it anew


class Factors:
    """The linear solver of a run; a pattern's analysis is kept while the pattern stays the same.

    Parameters
    ----------
    system : System
        The blocks.
    options : Options
        Name and threads of the linear solver.

    Attributes
    ----------
    name : str
        Name of the linear solver, once it was used.
    count : int
        Factorizations so far.
    ready : bool
        Whether there are factors of a matrix with the last pattern.
    bolt_places : (k,) int32
        Places of the bolts in the last pattern.
    """

    def __init__(self, system: System, options: Options) -> None:
        self.options, self.system, self.blocks = options, system, system.model.blocks
        self.bolt_places = np.zeros(0, np.int32)
        self.name, self.count, self.ready = "", 0, False
        self._solver: LinearSolver | None = None
        self._pattern: BlockPattern | None = None
        self._recalled = ""

    @property
    def double_precision(self) -> str:
        """Digest of the last pattern if its matrix needed factors of double precision; else empty.

        Such a pattern's factors stay of double precision, and the last digit of what follows depends on it.
        """
        double = isinstance(self._solver, MixedPrecisionPardiso) and not self._solver.single
        return _digest(self._pattern) if self._pattern is not None and double else ""

    def recall(self, double_precision: str) -> None:
        """Take double precision at once for the first pattern, if it is that of a digest."""
        self._recalled = double_precision

    def pattern_of(self, contacts: Contacts) -> BlockPattern:
        """Return the pattern of candidates and bolts, `place` being the candidates', and prepare its factorization."""
        c, old = contacts.candidates, self._pattern
        lower, higher = self.system.bolts.pairs
        pairs = np.concatenate([c.block_a, lower]), np.concatenate([c.block_b, higher])
        pattern = whole_pattern(self.blocks.count, *pairs)
        pattern = replace(pattern, place=pattern.place[: contacts.count])
        if (
            old is not None
            and len(old.column) == len(pattern.column)
            and np.array_equal(old.row_start, pattern.row_start)
            and np.array_equal(old.column, pattern.column)
        ):
            return replace(old, place=pattern.place)  # kept once
        self.close()
        self._pattern, self.bolt_places = pattern, self.system.bolts.places(pattern)
        self._open()
        return pattern

    def _open(self) -> LinearSolver:
        """Make the linear solver of the last pattern."""
        assert self._pattern is not None
        options, centroid = self.options, self.blocks.moments.centroid
        name, threads, pattern = options.linear_solver, options.threads, self._pattern
        single = not (self._recalled and self._recalled == _digest(pattern))
        self._recalled = ""
        solver = make_linear_solver(name, pattern, centroid, threads, corrections=True, single=single)
        self._solver, self.name, self.ready = solver, solver.name, False
        return solver

    def factorize(self, data: FloatArray) -> bool:
        """Factorize the blocks (n_places, axes, axes) of the last pattern; False where the matrix is singular."""
        self.count += 1
        self.ready = False
        if self.blocks.count >= WORTH_GIVING_BACK:
            give_back()
        try:
            (self._solver or self._open()).factorize(data)
        except SingularMatrixError:
            return False
        self.ready = True
        return True

    def is_positive_definite(self, data: FloatArray) -> bool:
        """Return whether a symmetric matrix, blocks (n_places, axes, axes) of the last pattern, is positive definite.

        The present factors are released first: a model at rest would need the memory of both.
        """
        assert self._pattern is not None
        upper, chosen = upper_triangle(self._pattern)
        self.close()
        self.count += 1
        options, centroid = self.options, self.blocks.moments.centroid
        name, threads = options.linear_solver, options.threads
        solver = make_linear_solver(name, upper, centroid, threads, once=True, definite=True)
        try:
            solver.factorize(data[chosen])
        except SingularMatrixError:
            return False
        finally:
            solver.close()
        return True

    def solve(self, right_side: FloatArray) -> FloatArray:
        """Return the solution (n, axes) with the last factors."""
        assert self._solver is not None
        return self._solver.solve(right_side)

    def close(self) -> None:
        """Release the factors."""
        if self._solver is not None:
            self._solver.close()
            self._solver, self.ready = None, False


def _digest(pattern: BlockPattern) -> str:
    return hashlib.sha256(pattern.row_start.tobytes() + pattern.column.tobytes()).hexdigest()
