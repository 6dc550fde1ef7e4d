"""The continuum's linear systems under exact constraints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError, place, raise_faults
from bsm_mesh.solve.zones.supports import HeldDisplacements, nodal_unknowns

SOLVED = 1e-6  # of the displacements: a larger misfit of the supports means that they contradict each other
RANK = 1e-9  # of a part's greatest eigenvalue (a squared length): a smaller one is a motion that nothing holds
PIVOT = 0.01  # of a column's greatest entry; friction makes a matrix unsymmetric, but rarely less than definite
HINGED = "parts that touch at a single point are hinged there; hold them, or remove them"


class FreeUnknowns:
    """The unknowns without those that supports hold.

    Parameters
    ----------
    supports : HeldDisplacements
        The constraints.
    idle : (N,) bool
        Unknowns of no cell that is there.
    """

    def __init__(self, supports: HeldDisplacements, idle: BoolArray) -> None:
        self.supports = supports
        self.turn = supports.turn
        self.free = np.flatnonzero(~(supports.held | idle))
        self.rows = self.reduced_columns(supports.rows)
        self.none = np.zeros(self.rows.shape[0])
        self.solutions = 0  # how often `solve` was asked
        self._factors = _Factors()

    def hold(self, given: FloatArray, values: FloatArray) -> None:
        """Hold other displacements from now on: `given` (N,) and `values` (m,) [m] of `HeldDisplacements`."""
        self.supports = replace(self.supports, given=given, values=values)

    def fulfilled(self, u: FloatArray) -> FloatArray:
        """Return displacements (N,) with the held ones as given; `rows` are met by `solve`."""
        held, given = self.supports.held, self.supports.given
        if self.turn is None:
            return np.where(held, given, u)
        turned: FloatArray = self.turn @ np.where(held, given, self.turn.T @ u)
        return turned

    def reduced(self, forces: FloatArray, multipliers: FloatArray) -> FloatArray:
        """Return forces (N,) on the free unknowns less those of the rows' multipliers."""
        turned = forces if self.turn is None else self.turn.T @ forces
        left: FloatArray = turned[self.free] - self.rows.T @ multipliers
        return left

    def on_free(self, forces: FloatArray) -> FloatArray:
        """Return forces (N,) without those on unknowns that supports hold, or of no cell."""
        turned = forces if self.turn is None else self.turn.T @ forces
        kept = np.zeros_like(turned)
        kept[self.free] = turned[self.free]
        return self._back(kept)

    def reduced_columns(self, rows: Any) -> Any:
        """Return rows (m, N) on the free unknowns, (m, free)."""
        return sp.csr_matrix(rows if self.turn is None else rows @ self.turn)[:, self.free]

    def reduced_matrix(self, K: Any) -> Any:
        """Return a symmetric matrix (N, N) on the free unknowns."""
        turned = K if self.turn is None else self.turn.T @ K @ self.turn
        return sp.csc_matrix(turned)[self.free][:, self.free]

    def solve(self, A: Any, forces: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the correction (N,) of displacements u under forces out of balance, and the rows' multipliers.

        Rows C u = w that take in many unknowns are met by multipliers m: with K' = A + s C^T C and the misfit
        d = w - C u, the correction is K'^-1 (f + s C^T d - C^T m) where C K'^-1 C^T m = C K'^-1 (f + s C^T d) - d.

        Parameters
        ----------
        A : sparse (free, free)
            The tangent, by columns.
        forces, u : (N,) float64 [N/m], [m]
            Out of balance, and where.

        Raises
        ------
        ModelError
            If the matrix is singular.
        """
        b = self.reduced(forces, self.none)
        self.solutions += 1
        C, correction = self.rows, np.zeros(len(u))
        if not C.shape[0]:
            correction[self.free] = self._factors.of(A)(b) if self.free.size else 0.0
            return self._back(correction), self.none
        misfit = self.misfit(u)
        whole = self.supports.rows
        scale = float(A.diagonal().max()) / float(whole.multiply(whole).sum(axis=1).max())
        solve = self._factors.of(sp.csc_matrix(A + scale * (C.T @ C)))
        y, spread = solve(b - scale * (C.T @ misfit)), solve(C.T.toarray())
        multipliers = np.linalg.lstsq(C @ spread, C @ y + misfit, rcond=1e-10)[0]
        correction[self.free] = y - spread @ multipliers
        return self._back(correction), multipliers

    def misfit(self, u: FloatArray) -> FloatArray:
        """Return by how much displacements (N,) miss the rows, (m,) [m]."""
        missed: FloatArray = self.supports.rows @ u - self.supports.values
        return missed

    def refuse_misfit(self, u: FloatArray) -> None:
        """Raise if displacements that solve the equations do not meet the supports."""
        misfit = self.misfit(u)
        if misfit.size and not np.abs(misfit).max() <= SOLVED * np.abs(u).max():
            raise ModelError(
                "supports of blocks or points contradict others that hold the same nodes; remove one of them"
            )

    def _back(self, turned: FloatArray) -> FloatArray:
        back: FloatArray = turned if self.turn is None else self.turn @ turned
        return back


class _Factors:
    """SuperLU's factors of matrices that are definite, or nearly so; one pattern after another keeps its ordering."""

    def __init__(self) -> None:
        self._pattern: tuple[IntArray, IntArray] | None = None
        self._order = self._place = np.zeros(0, np.intp)
        self._ordered: Any = None

    def of(self, A: Any) -> Callable[[FloatArray], FloatArray]:
        """Return what solves for right-hand sides (n,) or (n, k) with a matrix (n, n) in columns."""
        pattern = A.indptr, A.indices
        if self._pattern is None or not all(map(np.array_equal, pattern, self._pattern)):
            factors = _superlu(A, "MMD_AT_PLUS_A")
            self._pattern, self._order = pattern, np.argsort(factors.perm_c)
            places = sp.csc_matrix((np.arange(A.nnz), A.indices, A.indptr), shape=A.shape)
            self._ordered = places[self._order][:, self._order].tocsc()
            self._ordered.sort_indices()
            self._place = self._ordered.data
            return factors.solve  # type: ignore[no-any-return]
        ordered, order = self._ordered, self._order
        matrix = sp.csc_matrix((A.data[self._place], ordered.indices, ordered.indptr), shape=A.shape)
        factors = _superlu(matrix, "NATURAL")

        def solve(right_side: FloatArray) -> FloatArray:
            x = np.empty_like(right_side)
            x[order] = factors.solve(right_side[order])
            return x

        return solve


def _superlu(A: Any, ordering: str) -> Any:
    try:
        return splu(A, permc_spec=ordering, relax=1, diag_pivot_thresh=PIVOT, options={"SymmetricMode": True})
    except RuntimeError:
        raise ModelError(f"the continuum's equations are singular: {HINGED}") from None


class LoosePart(NamedTuple):
    """A connected part of the rock with a rigid motion that no support holds.

    Attributes
    ----------
    cells : (k,) int
        Its cells.
    place : (2,) float64 [m]
        Its middle.
    is_driven : bool
        Whether the unbalanced force does work on such a motion.
    """

    cells: IntArray
    place: FloatArray
    is_driven: bool


def loose_parts(
    supports: HeldDisplacements, basis: Any, cells: IntArray, ties: IntArray, residual: FloatArray
) -> list[LoosePart]:
    """Return the connected parts with rigid motions that no support holds.

    Parameters
    ----------
    supports : HeldDisplacements
        The constraints.
    basis : skfem.CellBasis
        Of the whole mesh.
    cells : (k,) int
        The cells that are there.
    ties : (2, l) int
        Pairs of unknowns that hold two cells together besides the nodes that these share.
    residual : (N,) float64 [N/m]
        Unbalanced force.
    """
    node_dofs = nodal_unknowns(basis)
    together = basis.element_dofs[:, cells]  # each cell ties its first unknown to all its others
    pairs = np.hstack([np.stack([np.tile(together[0], len(together)), together.ravel()]), ties])
    graph = sp.coo_matrix((np.ones(pairs.shape[1], np.int8), tuple(pairs)), shape=(basis.N, basis.N))
    count, part_of_dof = connected_components(graph, directed=False)
    part = part_of_dof[node_dofs[:, 0]]
    where = basis.doflocs[:, node_dofs[:, 0]].T
    centre = np.stack([np.bincount(part, x, minlength=count) for x in where.T], axis=1)
    members = np.maximum(np.bincount(part, minlength=count), 1)
    arm = where - (centre / members[:, None])[part]
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
    strength, axes = np.linalg.eigh(gram)
    there = np.zeros(count, dtype=bool)
    there[part_of_dof[together.ravel()]] = True
    found = []
    for p in np.flatnonzero(there & (strength[:, 0] <= RANK * np.maximum(strength[:, 2], 1e-300))):
        own = part_of_dof == p
        free = axes[p][:, strength[p] <= RANK * max(strength[p, 2], 1e-300)]
        work = np.abs(residual[own] @ motions[own] @ free).max()
        driven = bool(work > ROUNDING * np.abs(residual[own]).sum())
        found.append(LoosePart(cells[part_of_dof[together[0]] == p], where[part == p].mean(axis=0), driven))
    return found


def refuse_loose(parts: Sequence[LoosePart]) -> None:
    """Raise if there are parts with rigid motions that no support holds."""
    raise_faults(
        [
            f"finite elements: the rock about {place(tuple(part.place))} is free to move as a whole; hold a boundary, "
            "a block or a point of it"
            for part in parts[:20]
        ]
    )


def refuse_unsolved(size: float) -> None:
    """Raise if linear equations are not solved: by the greatest residual over the greatest force."""
    if not size <= 1e-6:  # also true for NaN
        raise ModelError(
            f"the continuum's equations cannot be solved (residual {size:.2g} of the greatest force): {HINGED}"
        )
