"""Multipliers of a linear program, made exact to rounding.

Interior point methods end with multipliers that vanish in the columns to a tolerance, relative to forces that may be
many times the loads. A mechanism proves nothing until they vanish to rounding.
"""

from __future__ import annotations

import clarabel
import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array, hstack, vstack
from scipy.sparse.linalg import splu

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.limit.conic import Answer, solve_conic

PASSES = 4  # of refinement: each leaves what `NEARNESS` is of the squares of the least singular value
NEARNESS = 1e-10  # weight of the change against the residual
ROUNDING = 1e-13  # over the greatest multiplier: corrected
ENLARGED = 1e5  # times: the residual, in the program of the change; 1e4 and 1e6 do as well


def exact(
    z: FloatArray, slack: FloatArray, cost: FloatArray, matrix: csc_array, balances: int, *, is_optimum: bool
) -> FloatArray:
    """Return multipliers near those given that satisfy ``matrix^T z = -cost`` to rounding where that can be had.

    Parameters
    ----------
    z, slack : (r,) float64
        Multipliers and slacks of an interior point method.
    cost, matrix : (k,), (r, k) float64
        Of the program: the least ``cost x`` with ``matrix x + slack = right``.
    balances : int
        Rows without slack, the first.
    is_optimum : bool
        Whether they belong to an optimum. Otherwise they prove that there is no solution, and vanish in all columns.
    """
    columns = csr_array((matrix[:, cost == 0] if is_optimum else matrix).T)
    found = [z, _projected(z, slack, columns, balances)]
    if is_optimum and _error(found[1], columns, balances) > ROUNDING:
        found.append(_refined(z, slack, cost, matrix, balances))
    return min(found, key=lambda each: _error(each, columns, balances))


def _projected(z: FloatArray, slack: FloatArray, columns: csr_array, balances: int) -> FloatArray:
    """Return multipliers that vanish in the columns, by the least change of those greater than their slack.

    The others become 0: their bounds are taken for not met.
    """
    met = _rows(z > slack, balances)
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
    return found


def _refined(z: FloatArray, slack: FloatArray, cost: FloatArray, matrix: csc_array, balances: int) -> FloatArray:
    """Return multipliers of an optimum, improved by a linear program of their change; those given if it has none.

    The residual is enlarged, so the tolerance of this program is one of the change (Gleixner, Steffy and Wolter 2016,
    iterative refinement). The change costs the slack of its bound: the optimum remains one. Bounds far from
    being met take no part: their multiplier over their slack is below the mean of the products of both.
    """
    product = float((z * slack)[balances:].sum()) / len(z)
    taken = _rows(z > product * slack, balances)
    bounds = len(taken) - balances
    start = np.zeros_like(z)
    start[taken] = z[taken]
    signs = hstack([csr_array((bounds, balances)), -eye_array(bounds)])
    try:
        answer, change = solve_conic(
            np.append(np.zeros(balances), slack[taken][balances:]),
            csc_array(vstack([csr_array(matrix)[taken].T, signs])),
            ENLARGED * np.append(-(matrix.T @ start + cost), start[taken][balances:]),
            [clarabel.ZeroConeT(len(cost)), clarabel.NonnegativeConeT(bounds)],
        )
    except ModelError:
        return z
    if answer is Answer.SOLVED:
        start[taken] += np.array(change.x) / ENLARGED
    return start if answer is Answer.SOLVED else z


def _error(z: FloatArray, columns: csr_array, balances: int) -> float:
    """Return by how much multipliers do not vanish in columns, or are negative where they must not be.

    Over the greatest: where a bound was missed only negligible numbers vanish.
    """
    size = float(np.abs(z).max(initial=0.0))
    if size == 0:
        return np.inf
    return float(max(np.abs(columns @ z).max(initial=0.0), -z[balances:].min(initial=0.0))) / size


def _rows(met: BoolArray, balances: int) -> IntArray:
    """Return the rows of equilibrium, and those of bounds that are met (r,)."""
    return np.concatenate([np.arange(balances), balances + np.flatnonzero(met[balances:])])
