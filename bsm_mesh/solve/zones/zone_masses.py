"""Masses of zones at their nodes, and the longest time step with which no wave grows."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.model import Model


def cell_masses(model: Model, basis: Any, block: IntArray, on: BoolArray) -> FloatArray:
    """Return the masses of cells at their nodes, (w, t) [kg/m]: in the ratio of the consistent ones.

    Hinton, Rock & Zienkiewicz (1976): so they are positive in cells of second order too.

    Parameters
    ----------
    model : Model
        Its weights.
    basis : skfem.CellBasis
        Of the vector-valued element.
    block, on : (t,) int, (t,) bool
        Block of every cell, and whether it is there.
    """
    density = model.weights[block] / model.blocks.moments.area[block] / GRAVITY * on
    squares = np.stack([(np.asarray(field[0])[0] ** 2 * basis.dx).sum(axis=1) for field in basis.basis[::2]])
    parts: FloatArray = squares / squares.sum(axis=0) * (density * basis.dx.sum(axis=1))
    return parts


def sums_of_cells(entries: FloatArray, corner: IntArray, count: int) -> FloatArray:
    """Return stiffness sums of nodes (count,) [Pa]: as springs to the ground they are stiffer than the cells.

    However cells turn, their sums remain.

    Parameters
    ----------
    entries : (t, 2 w, 2 w) float64 [Pa]
        Of every cell.
    corner : (t, w) int
        Its nodes.

    Examples
    --------
    >>> bar = np.array([[3.0, 0, -3.0, 0], [0, 0, 0, 0], [-3.0, 0, 3.0, 0], [0, 0, 0, 0]])
    >>> sums_of_cells(bar[None], np.array([[0, 2]]), 3)
    array([6., 0., 6.])
    """
    cells, width = corner.shape
    parts = entries.reshape(cells, width, 2, width, 2).swapaxes(2, 3)
    sums = np.linalg.norm(parts, 2, axis=(-2, -1)).sum(axis=2)
    return np.bincount(corner.ravel(), sums.ravel(), count).astype(np.float64)


def sums_of_points(stiffness: FloatArray, gradient: FloatArray, nodes: IntArray, count: int) -> FloatArray:
    """Return stiffness sums of nodes (count,) [Pa], as `sums_of_cells`, of springs across and along joints.

    Parameters
    ----------
    stiffness : (q,) float64 [Pa]
        Of both springs of every point.
    gradient : (q, 2, m, 2) float64
        Derivatives of its opening and slip by the displacements of nodes.
    nodes : (q, m) int
        These nodes.

    Examples
    --------
    >>> apart = np.array([[[[0.0, 1.0], [0.0, -1.0]], [[1.0, 0.0], [-1.0, 0.0]]]])
    >>> sums_of_points(np.array([5.0]), apart, np.array([[0, 1]]), 2)
    array([20., 20.])
    """
    size = np.linalg.norm(gradient, axis=-1)
    sums = stiffness[:, None] * (size * size.sum(axis=-1, keepdims=True)).sum(axis=1)
    return np.bincount(nodes.ravel(), sums.ravel(), count).astype(np.float64)


def weighted_quantile(values: FloatArray, weights: FloatArray, part: float) -> float:
    """Return the value that a part of the weights does not exceed.

    Examples
    --------
    >>> weighted_quantile(np.array([9.0, 1.0, 2.0]), np.array([1.0, 5.0, 4.0]), 0.9)
    2.0
    """
    order = np.argsort(values)
    whole = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(whole, part * whole[-1])])


def greatest_frequency(stiffness: Any, mass: FloatArray) -> float:
    """Return the greatest circular frequency [1/s] of a symmetric stiffness (f, f) [Pa] on masses (f,).

    Examples
    --------
    >>> springs = sp.csr_matrix([[2.0, -1.0], [-1.0, 2.0]])
    >>> round(greatest_frequency(springs, np.array([1.0, 1.0])) ** 2, 2)
    3.0
    """
    if not len(mass):
        return 0.0
    root = sp.diags(1 / np.sqrt(mass))
    scaled = sp.csr_matrix(root @ stiffness @ root)
    if len(mass) < 4:
        return float(np.sqrt(np.linalg.eigvalsh(scaled.toarray())[-1]))
    start = np.random.default_rng(0).standard_normal(len(mass))
    (square,) = eigsh(scaled, k=1, which="LA", v0=start, return_eigenvectors=False)
    return float(np.sqrt(square))


def stable_time_step(frequency: float, damping: float) -> float:
    """Return the longest stable time step of central differences [s].

    Parameters
    ----------
    frequency : float [1/s]
        The greatest circular one.
    damping : float [1/s]
        Greatest rate of dashpots over masses; they act with the velocity of half a step before.

    Examples
    --------
    >>> stable_time_step(10.0, 0.0)
    0.2
    """
    half = damping / 2
    return float(2 / (half + np.sqrt(half**2 + frequency**2))) if frequency > 0 else float("inf")
