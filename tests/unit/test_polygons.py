"""Areas, centroids and moments of polygons stored flat."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.model.polygons import (
    convex_polygons,
    corner_turns,
    edge_vectors,
    next_corner,
    owner_of_corner,
    polygon_moments,
    self_crossing,
)
from tests.scenes.shapes import SQUARE, rectangle, turned

RTOL = 1e-12  # a dozen operations


def flat(*polygons):
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in polygons])]).astype(np.int32)
    return np.concatenate([np.asarray(p, float) for p in polygons]), offsets


def test_numbering_goes_round_each_polygon():
    _, offsets = flat(SQUARE, SQUARE[:3])
    assert next_corner(offsets).tolist() == [1, 2, 3, 0, 5, 6, 4]
    assert owner_of_corner(offsets).tolist() == [0, 0, 0, 0, 1, 1, 1]


def test_edges_run_to_the_next_corner():
    assert edge_vectors(*flat(SQUARE)).tolist() == [[1, 0], [0, 1], [-1, 0], [0, -1]]


@pytest.mark.parametrize("shift", [(0, 0), (1e6, -2e6)])
@pytest.mark.parametrize("degrees", [0, 33])
def test_moments_of_a_rectangle(shift, degrees):
    b, h = 3.0, 2.0
    found = polygon_moments(*flat(turned(rectangle(-b / 2, -h / 2, b / 2, h / 2), degrees, shift)))
    rounding = 1e-8 if shift[0] else RTOL  # corners at 1e6 m are known to 1e-10 m
    assert_allclose(found.area, [b * h], rtol=rounding)
    assert_allclose(found.centroid, [shift], rtol=1e-15, atol=1e-9 if shift[0] else 1e-15)
    assert_allclose(found.polar, [b * h * (b**2 + h**2) / 12], rtol=rounding)
    assert_allclose(found.gyration, [np.sqrt((b**2 + h**2) / 12)], rtol=rounding)


def test_moments_of_a_triangle():
    a, b, c = 2.0, 3.0, np.sqrt(13.0)
    found = polygon_moments(*flat([(0, 0), (a, 0), (0, b)]))
    assert_allclose(found.area, [a * b / 2], rtol=RTOL)
    assert_allclose(found.centroid, [(a / 3, b / 3)], rtol=RTOL)
    assert_allclose(found.polar, [a * b / 2 * (a**2 + b**2 + c**2) / 36], rtol=RTOL)


def test_moments_of_an_l_are_those_of_its_parts():
    l_shape = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    found = polygon_moments(*flat(l_shape))
    assert_allclose(found.area, [3.0], rtol=RTOL)
    assert_allclose(found.centroid, [(5 / 6, 5 / 6)], rtol=RTOL)
    parts = np.array([(0.5, 0.5), (1.5, 0.5), (0.5, 1.5)]) - 5 / 6
    assert_allclose(found.polar, [3 * (1 / 6) + (parts**2).sum()], rtol=RTOL)


def test_clockwise_area_is_negative_with_the_same_centroid():
    found = polygon_moments(*flat(SQUARE[::-1]))
    assert_allclose(found.area, [-1.0])
    assert_allclose(found.centroid, [(0.5, 0.5)])


def test_turns_and_convexity():
    l_shape = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    with_corner_on_edge = [(0, 0), (0.5, 0), (1, 0), (1, 1), (0, 1)]
    assert_allclose(np.degrees(corner_turns(*flat(SQUARE))), 90)
    assert convex_polygons(*flat(SQUARE, l_shape, with_corner_on_edge)).tolist() == [True, False, True]


def test_a_pentagram_turns_left_everywhere_and_is_not_convex():
    star = [(np.cos(a), np.sin(a)) for a in np.radians(np.arange(5) * 144)]
    assert not convex_polygons(*flat(star))[0]
    assert self_crossing(*flat(SQUARE, star)).tolist() == [1]


@pytest.mark.parametrize(
    ("outline", "crosses"),
    [
        ([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], False),
        ([(0, 0), (1, 1), (1, 0), (0, 1.5)], True),
        ([(0, 0), (2, 0), (1, 0), (1, 1)], True),  # a spike
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], True),  # touches itself
    ],
)
def test_self_crossing(outline, crosses):
    assert self_crossing(*flat(SQUARE, outline)).tolist() == ([1] if crosses else [])
