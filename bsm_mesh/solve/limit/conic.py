"""Conic programs by an interior point method (Clarabel): how they end, with optimum and multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import clarabel
import numpy as np
from scipy.sparse import csc_array, hstack, vstack

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError

TOLERANCE = 1e-10  # of feasibility and of the gap, sought
ENOUGH = 1e-8  # of both, where rounding allows no more: what HiGHS leaves is 1e-7
REGULARIZATION = 1e-7  # of the matrices: with Clarabel's own 1e-8 one program in six near its limit is given up


class Answer(Enum):
    """How a linear program ends."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"


ANSWERS = {
    "Solved": Answer.SOLVED,
    "AlmostSolved": Answer.SOLVED,
    "PrimalInfeasible": Answer.INFEASIBLE,
    "AlmostPrimalInfeasible": Answer.INFEASIBLE,
    "DualInfeasible": Answer.UNBOUNDED,
    "AlmostDualInfeasible": Answer.UNBOUNDED,
}


def solve_conic(cost: FloatArray, matrix: csc_array, right: FloatArray, cones: Sequence[Any]) -> tuple[Answer, Any]:
    """Return how a conic program ends, and Clarabel's solution: ``x``, slacks ``s`` and multipliers ``z``.

    Parameters
    ----------
    cost : (k,) float64
        The least ``cost x`` is sought.
    matrix, right : (r, k), (r,) float64
        ``matrix x + s = right`` with s in the cones.
    cones : sequence
        Clarabel's cones, in the order of the rows.

    Raises
    ------
    ModelError
        If the method gives up.
    """
    answer, found = _asked(cost, matrix, right, cones)
    if answer is None and (proof := _infeasibility(matrix, right, cones)) is not None:
        return Answer.INFEASIBLE, proof
    if answer is None:
        raise ModelError(f"limit analysis: the linear program could not be solved ({found.status})")
    return answer, found


def _asked(cost: FloatArray, matrix: csc_array, right: FloatArray, cones: Sequence[Any]) -> tuple[Answer | None, Any]:
    """Return how a conic program ends, None where Clarabel gives up, and what Clarabel returns."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.direct_solve_method = "qdldl"  # on one thread: the same to the last digit every time
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = ENOUGH
    settings.reduced_tol_infeas_abs = settings.reduced_tol_infeas_rel = ENOUGH
    settings.static_regularization_constant = REGULARIZATION
    no_squares = csc_array((len(cost), len(cost)))
    found = clarabel.DefaultSolver(no_squares, cost, matrix, right, list(cones), settings).solve()
    return ANSWERS.get(str(found.status)), found


@dataclass(frozen=True, eq=False, slots=True)
class _Proof:
    """Multipliers `z` which prove that a program has no solution; `x` and `s` are zero."""

    x: FloatArray
    s: FloatArray
    z: FloatArray


def _infeasibility(matrix: csc_array, right: FloatArray, cones: Sequence[Any]) -> _Proof | None:
    """Return the proof that a program has no solution; None where it has one, or Clarabel gives up again.

    Asked for is the least part of the right-hand side that has to go. Without all of it ``x = 0`` is a solution, so
    this program always has an optimum: Clarabel finds it where it gives up on the program itself.
    """
    rows, unknowns = matrix.shape
    goes = _outside(right, cones)
    part = csc_array(([-1.0], ([0], [unknowns])), shape=(1, unknowns + 1))
    relaxed = csc_array(vstack([hstack([matrix, goes[:, None]]), part]))
    cost = np.append(np.zeros(unknowns), 1.0)
    answer, found = _asked(cost, relaxed, np.append(right, 0.0), [*cones, clarabel.NonnegativeConeT(1)])
    if answer is not Answer.SOLVED or found.x[-1] <= ENOUGH:
        return None
    return _Proof(np.zeros(unknowns), np.zeros(rows), np.array(found.z)[:-1])


def _outside(right: FloatArray, cones: Sequence[Any]) -> FloatArray:
    """Return the right-hand side where it lies outside of its cone, else 0."""
    found, first = np.zeros_like(right), 0
    for cone in cones:
        rows = slice(first, first + cone.dim)
        first += cone.dim
        given = right[rows]
        if isinstance(cone, clarabel.NonnegativeConeT):
            found[rows] = np.minimum(given, 0.0)
        elif isinstance(cone, clarabel.ZeroConeT) or given[0] < np.hypot.reduce(given[1:]):
            found[rows] = given
    return found
