"""The area that blocks share, against GEOS."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose

from bsm_mesh.arrays import FloatArray
from bsm_mesh.results.shared_area import shared_area, shares_inside

EXACT = 1e-9  # of an area of about 1 m2


def total(polygons: list[FloatArray]) -> float:
    """Return what `shared_area` finds for polygons."""
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in polygons])]).astype(np.int32)
    return shared_area(np.concatenate(polygons), offsets)


def by_geos(polygons: list[FloatArray]) -> float:
    """Return the same from every pair, one by one."""
    shapes = [shapely.Polygon(p) for p in polygons]
    return sum(a.intersection(b).area for i, a in enumerate(shapes) for b in shapes[:i])


@pytest.mark.parametrize("far", [0.0, 1e5])
@pytest.mark.parametrize("seed", range(8))
def test_random_convex_polygons(seed: int, far: float) -> None:
    rng = np.random.default_rng(seed)
    hulls = [shapely.convex_hull(shapely.MultiPoint(rng.uniform(0, 3, 2) + rng.normal(size=(9, 2)))) for _ in range(12)]
    polygons = [far + np.array(shapely.orient_polygons(hull).exterior.coords)[:-1] for hull in hulls]
    assert by_geos(polygons) > 1
    assert_allclose(total(polygons), by_geos(polygons), rtol=EXACT)


def test_concave_and_convex() -> None:
    corner = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], dtype=float)  # an L
    square = np.array([[0.5, 0.5], [2, 0.5], [2, 2], [0.5, 2]])
    away = np.array([[1.5, 1.5], [2.9, 1.5], [2.9, 2.9], [1.5, 2.9]])  # in the L's box, outside the L
    assert_allclose(total([corner, square, away]), (0.75 + 0.5) + 0.25, rtol=EXACT)


def test_neighbours_that_touch_share_nothing() -> None:
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    shifts = np.array([(0, 0), (1, 0), (0.5, 1), (1, 2)])
    assert total([square + shift for shift in shifts]) == 0.0


def test_a_block_within_another() -> None:
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    assert_allclose(total([square, 0.25 + 0.5 * square]), 0.25, rtol=EXACT)


def test_what_part_of_chosen_blocks_lies_inside_others() -> None:
    """The L and a triangle are not convex or not all: every pair counts once for either."""
    corner = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], dtype=float)
    square = np.array([[0.5, 0.5], [2, 0.5], [2, 2], [0.5, 2]])
    triangle = np.array([[1.5, 0.0], [4.0, 0.0], [4.0, 2.5]])
    away = square + 10.0
    polygons = [corner, square, triangle, away]
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in polygons])]).astype(np.int32)
    shapes = [shapely.Polygon(p) for p in polygons]
    expected = [
        sum(shapes[b].intersection(other).area for k, other in enumerate(shapes) if k != b) / shapes[b].area
        for b in (3, 1, 0)
    ]
    assert_allclose(shares_inside(np.concatenate(polygons), offsets, np.array([3, 1, 0])), expected, atol=EXACT)
    assert min(expected[1:]) > 0.1
