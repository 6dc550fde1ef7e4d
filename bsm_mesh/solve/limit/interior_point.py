"""Linear programs by an interior point method: optimum and multipliers, or that there is none."""

from __future__ import annotations

from dataclasses import dataclass

import clarabel
import numpy as np
from scipy.sparse import csc_array, csr_array, vstack

from bsm_mesh.arrays import FloatArray
from bsm_mesh.solve.limit.conic import Answer, solve_conic
from bsm_mesh.solve.limit.multipliers import exact


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
    proved : float
        Least cost that the multipliers prove: right-hand sides times them; positive where there is no solution.
    loose : (l,) float64
        What rounding leaves of the columns without cost, in which multipliers times rows are to vanish; not negative.
    negative : (q,) float64
        By how much multipliers of bounds were below zero.
    """

    answer: Answer
    x: FloatArray
    of_balance: FloatArray
    of_bounds: FloatArray
    proved: float
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
    sides = np.concatenate([right, bound])
    answer, found = solve_conic(cost, matrix, sides, cones)
    z, columns = np.array(found.z), csr_array(matrix[:, cost == 0].T)
    if answer is not Answer.UNBOUNDED:
        z = exact(z, np.array(found.s), cost, matrix, len(right), is_optimum=answer is Answer.SOLVED)
    return Solution(
        answer=answer,
        x=np.array(found.x),
        of_balance=z[: len(right)],
        of_bounds=np.maximum(z[len(right) :], 0.0),
        proved=-float(sides @ z),
        loose=np.abs(columns @ z),
        negative=np.maximum(-z[len(right) :], 0.0),
    )
