"""Outlines that are given more than once."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from bsm_mesh.arrays import IntArray
from bsm_mesh.model.edges import LongArray


def first_of_equal(corners: IntArray, offsets: IntArray) -> LongArray:
    """Return for every outline the first one with the same corners in the same round order, (n_outlines,).

    Parameters
    ----------
    corners : (n_corners,) int32
        Points of the outlines, all turning the same way, outline after outline.
    offsets : (n_outlines + 1,) int32
        Outline k owns ``corners[offsets[k]:offsets[k + 1]]``.

    Notes
    -----
    Outlines with equal sums of scrambled point numbers are candidates; only these are compared.

    Examples
    --------
    >>> first_of_equal(np.array([0, 1, 2, 2, 1, 3, 1, 2, 0]), np.array([0, 3, 6, 9])).tolist()
    [0, 1, 0]
    """
    n = len(offsets) - 1
    first = np.arange(n)
    if n < 2:
        return first
    sums = np.add.reduceat(_scramble(corners), offsets[:-1])
    order = np.argsort(sums, kind="stable")
    same = np.flatnonzero(sums[order][1:] == sums[order][:-1]) + 1
    if same.size == 0:
        return first
    new_run = np.ones(n, dtype=np.bool_)
    new_run[same] = False
    leader = order[np.flatnonzero(new_run)[np.cumsum(new_run) - 1]]
    later, earlier = order[same], leader[same]
    sizes = np.diff(offsets)
    alike = sizes[later] == sizes[earlier]
    later, earlier = later[alike], earlier[alike]
    differs = _from_lowest(corners, offsets, later) != _from_lowest(corners, offsets, earlier)
    starts = np.cumsum(sizes[later]) - sizes[later]
    equal = ~np.logical_or.reduceat(differs, starts) if later.size else np.empty(0, np.bool_)
    first[later[equal]] = earlier[equal]
    return first


def _scramble(numbers: IntArray) -> npt.NDArray[np.uint64]:
    """Return well-mixed 64-bit numbers (the finisher of splitmix64)."""
    x = numbers.astype(np.uint64) + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed: npt.NDArray[np.uint64] = x ^ (x >> np.uint64(31))
    return mixed


def _from_lowest(corners: IntArray, offsets: IntArray, which: LongArray) -> IntArray:
    """Return the corners of some outlines, each from its lowest point number on."""
    if which.size == 0:
        return np.empty(0, np.int32)
    sizes = np.diff(offsets)[which]
    starts = np.cumsum(sizes) - sizes
    owner = np.repeat(np.arange(len(which)), sizes)
    within = np.arange(len(owner)) - starts[owner]
    begin = offsets[:-1][which][owner]
    values = corners[begin + within]
    lowest = np.flatnonzero(values == np.minimum.reduceat(values, starts)[owner])
    _, at = np.unique(owner[lowest], return_index=True)
    shift = within[lowest[at]]
    rolled: IntArray = corners[begin + (within + shift[owner]) % sizes[owner]]
    return rolled
