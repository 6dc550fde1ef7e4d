"""Position of filled blocks: as given, carried along by the blocks next to them."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.movements import by_movement, carried, turned, turns


def are_supported(model: Model) -> BoolArray:
    """Return which blocks have a support, (n,): as fill they are where they were given."""
    supported = np.zeros(model.blocks.count, dtype=bool)
    supported[bars_of(model.supports, model.blocks).block] = True
    return supported


def fitted_fill(
    moved: FloatArray,
    fill: BoolArray,
    sides: tuple[IntArray, IntArray],
    point: FloatArray,
    length: FloatArray,
    centroid: FloatArray,
) -> FloatArray:
    """Return movements (n, axes) in which filled blocks fit their neighbours: least squares of the gaps at contacts.

    Blocks that touched a moved one as given touch it again; where a rigid block cannot, gaps and overlaps are least.

    Parameters
    ----------
    moved : (n, axes) float64 [m, rad]
        Of every block since the start; those of the fill are a first guess.
    fill : (n,) bool
        The blocks to be placed.
    sides : (m,) int32, (m,) int32
        Blocks of the contacts of the given geometry.
    point : (m, 2) or (m, 3) float64 [m]
        Those contacts.
    length : (m,) float64 [m]
        Their lengths, in space areas [m2].
    centroid : (n, 2) or (n, 3) float64 [m]
        Of the blocks.
    """
    found = moved.copy()
    rows = np.flatnonzero(fill[sides[0]] | fill[sides[1]])
    blocks, weight = [side[rows] for side in sides], np.sqrt(length[rows])[:, None]
    arms = [point[rows] - centroid[block] for block in blocks]
    if not any(moved[block].any() for block in blocks):
        return found
    from scipy.optimize import least_squares
    from scipy.sparse import csr_array

    number = np.cumsum(fill) - 1

    def gaps(values: FloatArray) -> FloatArray:
        found[fill] = values.reshape(-1, moved.shape[1])
        a, b = (carried(arm, found[block]) for arm, block in zip(arms, blocks, strict=True))
        return np.asarray(weight * (a - b)).ravel()

    def derivatives(values: FloatArray) -> csr_array:
        found[fill] = values.reshape(-1, moved.shape[1])
        entries: list[tuple[FloatArray, IntArray, IntArray]] = []
        for sign, arm, block in zip((1.0, -1.0), arms, blocks, strict=True):
            on = np.flatnonzero(fill[block])
            part = sign * weight[on, :, None] * by_movement(turned(arm[on], turns(found[block[on]])))
            inner = np.indices(part.shape[1:])
            row = arm.shape[1] * on[:, None, None] + inner[0]
            column = part.shape[2] * number[block[on]][:, None, None] + inner[1]
            entries.append((part.ravel(), row.ravel(), column.ravel()))
        data, rows, columns = (np.concatenate(each) for each in zip(*entries, strict=True))
        return csr_array((data, (rows, columns)), shape=(weight.size * arms[0].shape[1], values.size))

    with np.errstate(divide="ignore", invalid="ignore"):  # where the fit is exact, SciPy divides by a gradient of zero
        solved = least_squares(gaps, found[fill].ravel(), derivatives, tr_solver="lsmr", x_scale="jac", gtol=None)
    found[fill] = solved.x.reshape(-1, moved.shape[1])
    return found
