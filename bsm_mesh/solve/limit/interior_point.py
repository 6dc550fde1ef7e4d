"""Linear programs by an interior point method (Clarabel): optimum and multipliers, or that there is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import clarabel
import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array, hstack, vstack
from scipy.sparse.linalg import splu

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError

TOLERANCE = 1e-10  # of feasibility and of the gap, sought
ENOUGH = 1e-8  # of both, where rounding allows no more: what HiGHS leaves is 1e-7
REGULARIZATION = 1e-7  # of the matrices: with Clarabel's own 1e-8 one program in six near its limit is given up
TENTHS = 7  # shares of its slack, 1, 0.1, ..., that the multiplier of a bound which is met exceeds: clear cut first
PASSES = 4  # of refinement: each leaves what `NEARNESS` is of the squares of the least singular value
NEARNESS = 1e-10  # weight of the change against what is to be corrected
ROUNDING = 1e-13  # over the greatest multiplier: corrected


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


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Solution:
    """Answer of a linear program.

    Attributes
    ----------
    answer : Answer
        The numbers below are those of an optimum only where it is solved.
    x : (k,) float64
        The unknowns.
    of_balance, of_bounds : (r,), (q,) float64
        Multipliers: by how much the least cost falls when a right-hand side grows by 1; of bounds not negative. Where
        there is no solution they prove that.
    loose : (l,) float64
        What rounding leaves of the columns without cost, in which multipliers times rows are to vanish; not negative.
    negative : (q,) float64
        By how much multipliers of bounds were below zero.
    """

    answer: Answer
    x: FloatArray
    of_balance: FloatArray
    of_bounds: FloatArray
    loose: FloatArray
    negative: FloatArray


def minimise(
    cost: FloatArray, balance: csr_array, right: FloatArray, bounded: csr_array, bound: FloatArray
) -> Solution:
    """Return the least ``cost x`` with ``balance x = right`` and ``bounded x <= bound``.

    Raises
    ------
    ModelError
        If the method gives up.
    """
    matrix = csc_array(vstack([balance, bounded]))
    cones = [clarabel.ZeroConeT(len(right)), clarabel.NonnegativeConeT(len(bound))]
    answer, found = solve_conic(cost, matrix, np.concatenate([right, bound]), cones)
    z, columns = np.array(found.z), csr_array(matrix[:, cost == 0].T)
    if answer is not Answer.UNBOUNDED:  # that there is no solution multipliers prove which vanish in all columns
        vanishing = columns if answer is Answer.SOLVED else csr_array(matrix.T)
        z = _polished(z, np.array(found.s), vanishing, len(right))
    return Solution(
        answer=answer,
        x=np.array(found.x),
        of_balance=z[: len(right)],
        of_bounds=np.maximum(z[len(right) :], 0.0),
        loose=np.abs(columns @ z),
        negative=np.maximum(-z[len(right) :], 0.0),
    )


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


def _polished(z: FloatArray, slack: FloatArray, columns: csr_array, balances: int) -> FloatArray:
    """Return multipliers near those of the interior point method, exact to rounding where that can be had.

    Those of bounds that are not met are 0. The others change by as little as makes them vanish in the columns. Which
    bounds are met follows from multiplier and slack; where one was missed the columns do not vanish, and more are
    taken.
    """
    best, error = z, _error(z, columns, balances)
    for share in 10.0 ** -np.arange(TENTHS):
        met = np.concatenate([np.arange(balances), balances + np.flatnonzero((z > share * slack)[balances:])])
        part = csc_array(columns[:, met])
        inverse = splu(
            csc_array(part.T @ part + NEARNESS * eye_array(len(met))),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        found = np.zeros_like(z)
        found[met] = z[met]
        for _ in range(PASSES):
            found[met] -= inverse.solve(part.T @ (part @ found[met]))
        if (left := _error(found, columns, balances)) < error:
            best, error = found, left
        if error <= ROUNDING:
            break
    return best


def _error(z: FloatArray, columns: csr_array, balances: int) -> float:
    """Return by how much multipliers do not vanish in columns, or are negative where they must not be.

    Over the greatest: where a bound was missed only negligible numbers vanish.
    """
    size = float(np.abs(z).max(initial=0.0))
    if size == 0:
        return np.inf
    return float(max(np.abs(columns @ z).max(initial=0.0), -z[balances:].min(initial=0.0))) / size
