"""Linear programs by an interior point method (Clarabel): optimum and multipliers, or that there is none."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import clarabel
import numpy as np
from scipy.sparse import csc_array, csr_array, vstack

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError

TOLERANCE = 1e-10  # of feasibility and of the gap: the greatest that leaves velocities of a mechanism to nine digits
ITERATIONS = 200  # 10 to 30 are usual


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
    """What a linear program has for an answer.

    Attributes
    ----------
    answer : Answer
        The numbers below are those of an optimum only where it is solved.
    x : (k,) float64
        The unknowns.
    of_balance, of_bounds : (r,), (q,) float64
        Multipliers: by how much the least cost falls when a right-hand side grows by 1; of bounds not negative.
    """

    answer: Answer
    x: FloatArray
    of_balance: FloatArray
    of_bounds: FloatArray


def minimise(
    cost: FloatArray, balance: csr_array, right: FloatArray, bounded: csr_array, bound: FloatArray
) -> Solution:
    """Return the least ``cost x`` with ``balance x = right`` and ``bounded x <= bound``.

    Raises
    ------
    ModelError
        If the method gives up.
    """
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = ITERATIONS
    settings.max_threads = 1
    settings.direct_solve_method = "qdldl"
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    matrix = csc_array(vstack([balance, bounded]))
    cones = [clarabel.ZeroConeT(len(right)), clarabel.NonnegativeConeT(len(bound))]
    no_squares = csc_array((len(cost), len(cost)))
    found = clarabel.DefaultSolver(no_squares, cost, matrix, np.concatenate([right, bound]), cones, settings).solve()
    answer = ANSWERS.get(str(found.status))
    if answer is None:
        raise ModelError(f"limit analysis: the linear program could not be solved ({found.status})")
    z = np.array(found.z)
    return Solution(answer=answer, x=np.array(found.x), of_balance=z[: len(right)], of_bounds=z[len(right) :])
