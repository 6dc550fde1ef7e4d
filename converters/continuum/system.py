"""Solution of the continuum's equations under exact constraints."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.continuum.supports import HeldDisplacements, nodal_unknowns
from bsm_mesh.errors import ModelError, place

SOLVED = 1e-6  # of the greatest force: a larger residual means a singular matrix, or constraints in contradiction
RANK = 1e-9  # of a part's greatest eigenvalue (a squared length): a smaller one is a motion that nothing holds
HINGED = "parts that touch at a single point are hinged there; hold them, or remove them"


def solve_held(
    K: Any, f: FloatArray, supports: HeldDisplacements, basis: Any, ties: IntArray | None = None
) -> FloatArray:
    """Return the displacements u (N,) of K u = f under the supports.

    The held unknowns are condensed. Rows C u = w that take in many unknowns are met by multipliers: with
    K' = K + s C^T C, positive definite and of the same solution, u = K'^-1 (f + s C^T w - C^T m) and
    C K'^-1 C^T m = C K'^-1 (f + s C^T w) - w.

    Parameters
    ----------
    K : sparse (N, N)
        Stiffness, in x and y components.
    f : (N,) float64 [N/m]
        Forces.
    supports : HeldDisplacements
        The constraints.
    basis : skfem.CellBasis
        What K and f were assembled on.
    ties : (2, k) int, optional
        Pairs of unknowns that hold two elements together besides the nodes that these share.

    Raises
    ------
    ModelError
        If the supports leave a part free to move, or contradict each other.
    """
    from skfem import condense

    _refuse_free_motion(supports, basis, ties)
    turn, C = supports.turn, supports.rows
    turned = (K, f, C) if turn is None else (turn.T @ K @ turn, turn.T @ f, C @ turn)
    held = np.flatnonzero(supports.held)
    if len(held) == len(f):
        return supports.given if turn is None else turn @ supports.given
    A, b, w, free = condense(turned[0], turned[1], x=supports.given, D=held)
    rows = turned[2][:, free]
    values = supports.values - turned[2] @ np.where(supports.held, supports.given, 0.0)
    strength = float(C.multiply(C).sum(axis=1).max()) if C.shape[0] else 1.0
    scale = float(A.diagonal().max()) / strength
    factors = _factorize(A + scale * (rows.T @ rows))
    y = factors.solve(b + scale * (rows.T @ values))
    if rows.shape[0]:
        spread = factors.solve(rows.T.toarray())
        multipliers = np.linalg.lstsq(rows @ spread, rows @ y - values, rcond=1e-10)[0]
        y -= spread @ multipliers
    else:
        multipliers = np.zeros(0)
    solution = w.copy()
    solution[free] = y
    _check_misfit(turned[2] @ solution - supports.values, solution)
    _check_solved(A @ y + rows.T @ multipliers - b, b)
    u: FloatArray = solution if turn is None else turn @ solution
    return u


def _factorize(A: Any) -> Any:
    """Return SuperLU's factors of a positive definite matrix."""
    try:
        return splu(
            sp.csc_matrix(A), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:
        raise ModelError(f"the continuum's equations are singular: {HINGED}") from None


def _refuse_free_motion(supports: HeldDisplacements, basis: Any, ties: IntArray | None) -> None:
    """Raise if a connected part has a rigid motion that no support holds."""
    node_dofs = nodal_unknowns(basis)
    together = basis.element_dofs  # each triangle ties its first unknown to all its others
    pairs = np.stack([np.tile(together[0], len(together)), together.ravel()])
    pairs = pairs if ties is None else np.hstack([pairs, ties])
    graph = sp.coo_matrix((np.ones(pairs.shape[1], np.int8), tuple(pairs)), shape=(basis.N, basis.N))
    count, part_of_dof = connected_components(graph, directed=False)
    part = part_of_dof[node_dofs[:, 0]]
    where = basis.doflocs[:, node_dofs[:, 0]].T
    centre = np.stack([np.bincount(part, x, minlength=count) for x in where.T], axis=1)
    arm = where - (centre / np.bincount(part, minlength=count)[:, None])[part]
    size = max(float(np.abs(arm).max()), 1e-300)
    motions = np.zeros((len(part_of_dof), 3))
    motions[node_dofs[:, 0], 0] = motions[node_dofs[:, 1], 1] = 1.0
    motions[node_dofs[:, 0], 2], motions[node_dofs[:, 1], 2] = -arm[:, 1] / size, arm[:, 0] / size

    turned = motions if supports.turn is None else supports.turn.T @ motions
    many = sp.csr_matrix(supports.rows)
    first = many.indices[many.indptr[:-1]] if many.shape[0] else np.zeros(0, np.int32)
    held = np.concatenate([turned[supports.held], many @ motions])
    of_part = np.concatenate([part_of_dof[supports.held], part_of_dof[first]])
    gram = np.zeros((count, 3, 3))
    np.add.at(gram, of_part, held[:, :, None] * held[:, None, :])
    strength = np.linalg.eigvalsh(gram)
    loose = np.flatnonzero(strength[:, 0] <= RANK * np.maximum(strength[:, 2], 1e-300))
    if loose.size:
        raise ModelError(
            [
                f"the continuum about {place((where[part == p, 0].mean(), where[part == p, 1].mean()))} is free to "
                "move as a whole; hold a boundary, a block or a point of it"
                for p in loose[:20]
            ]
        )


def _check_solved(residual: FloatArray, forces: FloatArray) -> None:
    off = float(np.abs(residual).max(initial=0.0))
    scale = float(np.abs(forces).max(initial=0.0))
    if not off <= SOLVED * scale:  # also true for NaN
        raise ModelError(
            f"the continuum's equations cannot be solved (residual {off:.2g} of {scale:.2g} N/m): {HINGED}"
        )


def _check_misfit(misfit: FloatArray, displacement: FloatArray) -> None:
    if misfit.size and not np.abs(misfit).max() <= SOLVED * np.abs(displacement).max():
        raise ModelError("supports of blocks or points contradict others that hold the same nodes; remove one of them")
