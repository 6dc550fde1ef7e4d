"""Points that lie within a tolerance of each other become one."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray

ASKEW = np.array([0.5772156649, 0.8346268417, 0.3275822919])  # few points of a grid lie side by side across it


def merge_points(points: FloatArray, tolerance: float) -> IntArray:
    """Return a number for every point; points nearer than `tolerance` (also in a chain) share one.

    Parameters
    ----------
    points : (n, 2) or (n, 3) float64 [m]
        Coordinates.
    tolerance : float [m]
        Greatest distance of points taken as one.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # Equal coordinates first: a corner shared by k blocks would give k^2 pairs.
    unique, number = np.unique(points, axis=0, return_inverse=True)
    pairs = _near_pairs(unique, tolerance)
    if len(pairs) == 0:
        return number.reshape(-1).astype(np.int32)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(unique), len(unique)))
    _, label = connected_components(graph, directed=False)
    merged: IntArray = label[number.reshape(-1)].astype(np.int32)
    return merged


def _near_pairs(points: FloatArray, tolerance: float) -> IntArray:
    """Return the pairs of points within a tolerance of each other.

    They are near each other along any line too. So each point is compared with those next to it along one line. A tree
    of SciPy finds the same pairs, but its import takes longer than a small model.
    """
    line = ASKEW[: points.shape[1]]
    along = points @ (line / np.linalg.norm(line))
    order = np.argsort(along)
    along = along[order]
    reach = tolerance + 8.0 * np.spacing(np.abs(along).max(initial=0.0))
    first, step = np.arange(len(points)), 0
    pairs = [np.empty((0, 2), dtype=np.intp)]
    while len(first):
        step += 1
        first = first[first + step < len(points)]
        first = first[along[first + step] - along[first] <= reach]
        both = order[np.stack((first, first + step), axis=1)]
        apart = np.linalg.norm(points[both[:, 0]] - points[both[:, 1]], axis=1)
        pairs.append(both[apart <= tolerance])
    return np.concatenate(pairs)
