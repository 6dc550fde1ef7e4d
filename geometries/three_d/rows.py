"""Arrays that grow, and rows of numbers of different lengths that are appended and replaced."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.signedinteger[Any]]
BoolArray = npt.NDArray[np.bool_]


class Growing:
    """An array that rows are added to; it doubles where it is full.

    Parameters
    ----------
    values : array
        The first rows.
    """

    def __init__(self, values: npt.NDArray[Any]) -> None:
        self._values, self._count = values.copy(), len(values)

    def __len__(self) -> int:
        return self._count

    @property
    def values(self) -> npt.NDArray[Any]:
        """The rows, as a view that can be written."""
        return self._values[: self._count]

    def add(self, values: npt.NDArray[Any]) -> None:
        """Add rows at the end."""
        count = self._count + len(values)
        if count > len(self._values):
            longer = np.empty((max(count, 2 * len(self._values)), *self._values.shape[1:]), self._values.dtype)
            longer[: self._count] = self.values
            self._values = longer
        self._values[self._count : count] = values
        self._count = count


class Rows:
    """Rows of whole numbers of different lengths. A row that is replaced is written anew at the end.

    Parameters
    ----------
    values : (k,) int64
        All rows, one after the other.
    sizes : (n,) int64
        Their lengths.
    """

    def __init__(self, values: IntArray, sizes: IntArray) -> None:
        self._values = Growing(values)
        self._first, self._size = Growing(np.cumsum(sizes) - sizes), Growing(sizes)

    def __len__(self) -> int:
        return len(self._first)

    def take(self, rows: IntArray) -> tuple[IntArray, IntArray]:
        """Return the numbers of some rows, one row after the other, and the lengths of these rows."""
        sizes = self._size.values[rows]
        return self._values.values[spread(self._first.values[rows], sizes)], sizes

    def add(self, values: IntArray, sizes: IntArray) -> IntArray:
        """Add rows, and return their numbers."""
        new = np.arange(len(self), len(self) + len(sizes))
        self._first.add(len(self._values) + np.cumsum(sizes) - sizes)
        self._size.add(sizes)
        self._values.add(values)
        return new

    def replace(self, rows: IntArray, values: IntArray, sizes: IntArray) -> None:
        """Put other numbers in place of some rows."""
        self._first.values[rows] = len(self._values) + np.cumsum(sizes) - sizes
        self._size.values[rows] = sizes
        self._values.add(values)


def spread(first: IntArray, sizes: IntArray) -> IntArray:
    """Return ``first[i], first[i] + 1, ...``, of every i as many as its size.

    Examples
    --------
    >>> spread(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    ends = np.cumsum(sizes)
    return np.repeat(first - ends + sizes, sizes) + np.arange(ends[-1] if len(ends) else 0)


def following(sizes: IntArray) -> IntArray:
    """Return for every place in rows, one after the other, the next place of the same row, the first after the last."""
    ends = np.cumsum(sizes)
    after = np.arange(1, (ends[-1] if len(ends) else 0) + 1)
    after[ends - 1] = ends - sizes
    return after


def any_in_row(found: BoolArray, sizes: IntArray) -> BoolArray:
    """Return for every row whether anything in it is true; no row is empty."""
    whole: BoolArray = np.logical_or.reduceat(found, np.cumsum(sizes) - sizes) if len(sizes) else found[:0]
    return whole
