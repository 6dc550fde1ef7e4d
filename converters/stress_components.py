"""Plane stresses as six components, and back."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray


def six_components(stress: FloatArray) -> FloatArray:
    """Return XX YY ZZ XY YZ XZ of stresses (k, 2, 2); ZZ is 0: rigid blocks in the plane have none out of it."""
    zero = np.zeros(len(stress))
    return np.column_stack([stress[:, 0, 0], stress[:, 1, 1], zero, stress[:, 0, 1], zero, zero])


def tensors(six: FloatArray) -> FloatArray:
    """Return the tensors (k, 2, 2) of six components XX YY ZZ XY YZ XZ (k, 6)."""
    xx, yy, _, xy, _, _ = six.T
    return np.stack([np.stack([xx, xy], axis=1), np.stack([xy, yy], axis=1)], axis=1)
