"""The tangent on the free unknowns: one pattern a stage, into which the values of rock and joints are summed."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.solve.zones.system import FreeUnknowns


class PointStiffness(NamedTuple):
    """Derivatives of the forces at the points of joints, (q,) each.

    Attributes
    ----------
    normal, shear, cross, dilating : (q,) float64 [Pa]
        Normal by opening; shear by slip; shear by opening; normal by slip.
    """

    normal: FloatArray
    shear: FloatArray
    cross: FloatArray
    dilating: FloatArray


class Tangents:
    """Tangents of one stage.

    With the rows n and s that give a point's opening and slip its part is
    ``n n^T kn + s s^T ks + s n^T kc + n s^T kd``. Sparse products would find its pattern anew for every tangent, which
    takes longer than the factorization.

    Parameters
    ----------
    rock : sparse (N, N)
        Stiffness of the rock that is there.
    opening, slip : sparse (q, N) or None
        Rows of all points.
    free : FreeUnknowns
        Those left by the supports.
    """

    def __init__(self, rock: Any, opening: Any, slip: Any, free: FreeUnknowns) -> None:
        self._given = rock, opening, slip, free

    def at(self, points: PointStiffness | None, rock: float = 1.0, softer: Any = None) -> Any:
        """Return the tangent (free, free), by columns, with so many times the rock's stiffness.

        `softer` (N, N) is what yielding adds to it, within its pattern.
        """
        pattern, free = self._pattern, self._given[-1]
        data = rock * pattern.rock
        if softer is not None:
            change = free.reduced_matrix(softer).tocoo()
            slot = np.searchsorted(pattern.place, change.col.astype(np.int64) * free.free.size + change.row)
            data = data + np.bincount(slot, change.data, minlength=len(data))
        if points is not None:
            values = sum(product * of[pattern.row] for product, of in zip(pattern.products, points, strict=True))
            data = data + np.bincount(pattern.slot, values, minlength=len(data))
        shape = (len(pattern.starts) - 1,) * 2
        return sp.csc_matrix((data, pattern.indices, pattern.starts), shape=shape)

    @cached_property
    def _pattern(self) -> _Pattern:
        rock, opening, slip, free = self._given
        size = free.free.size
        rock = free.reduced_matrix(rock).tocoo()
        keys = [rock.col.astype(np.int64) * size + rock.row]  # column after column
        row: IntArray = np.zeros(0, np.intp)
        products: tuple[FloatArray, ...] = ()
        if opening is not None:
            row, key, products = _products(*(free.reduced_columns(rows) for rows in (opening, slip)))
            keys.append(key)
        place, slot = np.unique(np.concatenate(keys), return_inverse=True)
        return _Pattern(
            indices=(place % max(size, 1)).astype(np.int32),
            starts=np.searchsorted(place, np.arange(size + 1) * size).astype(np.int32),
            rock=np.bincount(slot[: rock.nnz], rock.data, minlength=len(place)).astype(np.float64),
            row=row,
            products=products,
            slot=slot[rock.nnz :],
            place=place,
        )


class _Pattern(NamedTuple):
    """Where columns start and their rows; the rock's values; of each product its point and its place; all places."""

    indices: IntArray
    starts: IntArray
    rock: FloatArray
    row: IntArray
    products: tuple[FloatArray, ...]
    slot: IntArray
    place: IntArray


def _products(n: Any, s: Any) -> tuple[IntArray, IntArray, tuple[FloatArray, ...]]:
    """Return the point of each pair of values in one row, its place in the tangent, and n n, s s, s n and n s there."""
    size = n.shape[1]
    union = np.union1d(*(_keys(of) for of in (n, s)))
    n_at, s_at = (_values(of, union) for of in (n, s))
    row, column = np.divmod(union, max(size, 1))
    starts = np.searchsorted(row, np.arange(n.shape[0] + 1))
    count = np.diff(starts)[row]
    a = np.repeat(np.arange(len(union)), count)
    b = np.repeat(starts[row] - (np.cumsum(count) - count), count) + np.arange(len(a))
    return (
        row[a],
        column[b] * size + column[a],
        (
            n_at[a] * n_at[b],
            s_at[a] * s_at[b],
            s_at[a] * n_at[b],
            n_at[a] * s_at[b],
        ),
    )


def _keys(rows: Any) -> IntArray:
    coo = rows.tocoo()
    keys: IntArray = coo.row.astype(np.int64) * rows.shape[1] + coo.col
    return keys


def _values(rows: Any, union: IntArray) -> FloatArray:
    values = np.zeros(len(union))
    values[np.searchsorted(union, _keys(rows))] = rows.tocoo().data
    return values
