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
