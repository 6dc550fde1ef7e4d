"""A mesh of another program with linear fields, whose averages over blocks are exact."""

import numpy as np
from numpy.testing import assert_allclose

from bsm_mesh.converters.continuum.foreign_fields import FieldNames

EXACT = 1e-9  # of the greatest: linear fields are averaged exactly
NONE = FieldNames(arrays={}, factors={})


def theirs(n=7, kind="triangle"):
    """Return points and elements of a mesh of 4 m x 3 m that fits no block."""
    x, y = np.meshgrid(np.linspace(0, 4, n + 1), np.linspace(0, 3, n + 1))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    i = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.stack([i, i + 1, i + n + 2, i + n + 1], axis=1)
    cells = quads if kind == "quad" else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return points, cells


def linear(points):
    """Return a displacement and a stress (xx, yy, xy) that are linear in x and y."""
    x, y = points[:, 0], points[:, 1]
    u = 1e-3 * np.stack([1 + x - 2 * y, 0.5 * x + y], axis=1)
    return u, 1e6 * np.stack([-1 - x, -3 + y, 0.2 * x], axis=1)


def check(averages, blocks):
    u, s = linear(blocks.moments.centroid)
    for name, exact in zip(("ux", "uy", "sxx", "syy", "sxy"), np.hstack([u, s]).T, strict=True):
        assert_allclose(averages.fields[name], exact, atol=EXACT * np.abs(exact).max())
    assert_allclose(averages.covered, 1.0, rtol=1e-9)
