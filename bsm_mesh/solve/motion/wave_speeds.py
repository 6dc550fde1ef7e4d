"""Speeds of plane waves through blocks: of the continuum that deforms as they do on their springs.

Faces act in series where stress is uniform. Their compliances are added, over the area of the blocks: Amadei and
Goodman (1981), with every face in the place of a joint set. Springs of faces contain the rock's compliance. The sum's
inverse is the stiffness C. Eigenvalues of ``n C n`` are ``rho c^2`` of waves along n, eigenvectors their directions.
Faces by which an outline ends have no neighbour: the half blocks there are left out along their normals.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import ROUNDING, FloatArray
from bsm_mesh.contact.forces import ContactSet, Evaluation
from bsm_mesh.model.blocks import Blocks


def stiffness_of_blocks(contacts: ContactSet, at: Evaluation, blocks: Blocks) -> FloatArray:
    """Return the stiffness [Pa] of blocks by their closed contacts, one for each rock: (rocks, 3, 3).

    Rows and columns are xx, yy and the square root of 2 times xy. It is zero where a rock has no closed contact.
    """
    rows = np.flatnonzero(at.closed & (contacts.candidates.length > 0))
    length, springs = contacts.candidates.length[rows], at.springs.stiffness[rows]
    sides = contacts.candidates.block_a[rows], contacts.candidates.block_b[rows]
    tangent, *arms = (each[rows] for each in contacts.frames(at.position))
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    across, along = (_gives_way(length, k) for k in (at.normal_stiffness[rows], springs))
    modes = _mandel(normal, normal), _mandel(normal, tangent)
    inner = [length * np.abs((arm * normal).sum(axis=1)) for arm in arms]  # twice the area between face and centroid
    found = np.zeros((len(blocks.rock_names), 3, 3))
    for rock in range(len(found)):
        mine = (blocks.rock == rock).astype(float)
        part = [mine[side] for side in sides]
        faces = sum(np.einsum("k,ki,kj->ij", p * area, normal, normal) for p, area in zip(part, inner, strict=True))
        ends = _of_edges(blocks, mine) - faces
        area = mine @ blocks.moments.area - np.einsum("ki,ij,kj->k", normal, ends, normal)
        weight = (part[0] + part[1]) / 2 / np.maximum(area, ROUNDING * blocks.moments.area.sum())
        compliance = sum(
            np.einsum("k,ki,kj->ij", weight * give, mode, mode)
            for give, mode in zip((across, along), modes, strict=True)
        )
        largest = np.trace(compliance)
        if largest > 0:
            found[rock] = np.linalg.inv(compliance + ROUNDING * largest * np.eye(3))
    return found


def waves_along(stiffness: FloatArray, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ``rho c^2`` (k, 2) [Pa] and directions (k, 2, 2), a row each, of waves along normals (k, 2).

    Examples
    --------
    >>> isotropic = 2e9 * np.eye(3) + np.pad(np.full((2, 2), 1e9), (0, 1))  # G = 1e9, lambda = 1e9
    >>> moduli, directions = waves_along(isotropic[None], np.array([[0.0, 1.0]]))
    >>> moduli.round().tolist(), np.abs(directions).tolist()
    ([[1000000000.0, 3000000000.0]], [[[1.0, 0.0], [0.0, 1.0]]])
    """
    axes = np.broadcast_to(np.eye(2)[:, None], (2, *normal.shape))
    modes = np.stack([_mandel(normal, axis) for axis in axes], axis=1)
    moduli, vectors = np.linalg.eigh(np.einsum("kai,kij,kbj->kab", modes, stiffness, modes))
    return moduli, np.swapaxes(vectors, 1, 2)


def _gives_way(length: FloatArray, spring: FloatArray) -> FloatArray:
    """Return by how much faces give way, times their lengths, under a unit stress (k,) [m3/N]."""
    gives: FloatArray = length**2 / np.maximum(spring, ROUNDING * spring.max(initial=np.finfo(float).tiny))
    return gives


def _mandel(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the symmetric products of vectors (k, 2) as (k, 3): xx, yy and the square root of 2 times xy."""
    mixed = (one[:, 0] * other[:, 1] + one[:, 1] * other[:, 0]) / np.sqrt(2)
    return np.column_stack([one * other, mixed])


def _of_edges(blocks: Blocks, mine: FloatArray) -> FloatArray:
    """Return the sum over all edges of some blocks of length times depth times n n, (2, 2) [m2]."""
    tangent = blocks.edge_vectors
    across = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)  # times its length
    depth = ((blocks.vertices - blocks.moments.centroid[blocks.owner]) * across).sum(axis=1)
    weight = mine[blocks.owner] * depth / (tangent**2).sum(axis=1)
    found: FloatArray = np.einsum("k,ki,kj->ij", weight, across, across)
    return found
