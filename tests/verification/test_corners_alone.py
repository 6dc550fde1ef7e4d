"""Blocks that touch by a corner alone, also where the corner lies on a node of a straight edge: statics by hand.

A node in the middle of an edge is no corner. Conforming meshes have one wherever a joint ends on another, so verdict,
movement and limit must not depend on it.
"""

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

FRICTION = 40.0
TIPS = [[(0, 0), (2, 0), (1, 1)], [(4, 0), (6, 0), (5, 1)]]
LINTELS = {
    "without nodes": [(0, 1), (6, 1), (6, 2), (0, 2)],
    "nodes on the tips": [(0, 1), (1, 1), (5, 1), (6, 1), (6, 2), (0, 2)],
    "nodes beside the tips": [(0, 1), (1.000001, 1), (4.999999, 1), (6, 1), (6, 2), (0, 2)],
    "two nodes at a tip": [(0, 1), (0.999, 1), (1, 1), (5, 1), (6, 1), (6, 2), (0, 2)],
    "edges at 179.9 degrees": [(0, 1 + 0.00175), (1, 1), (5, 1), (6, 1), (6, 2), (0, 2)],
}


def lintel(kind, tilt):
    polygons = [turned(np.array(polygon, float), tilt) for polygon in (*TIPS, LINTELS[kind])]
    return model_of(polygons, fixed=(0, 1), friction=FRICTION)


@pytest.mark.parametrize("kind", LINTELS)
@pytest.mark.parametrize("tilt", [0.0, 20.0, 39.0])
def test_a_lintel_rests_on_tips_up_to_its_friction(kind, tilt):
    model = lintel(kind, tilt)
    results = bsm.run(model)
    assert results.status == "stable"
    assert results.stages[-1].max_displacement < 3e-3  # 1.5e-3 elastic, and slip of contacts a degree from their limit
    assert bsm.limit_analysis(model).admissible


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=[pytest.mark.heavy] * (kind == "nodes beside the tips")) for kind in LINTELS]
)
def test_a_lintel_slides_beyond_its_friction(kind):
    model = lintel(kind, 41.0)
    assert not bsm.limit_analysis(model).admissible
    assert bsm.run(model).stages[-1].max_displacement > 0.1


@pytest.mark.heavy
@pytest.mark.parametrize("kind", LINTELS)
def test_the_factor_of_a_lintel_on_tips(kind):
    exact = np.tan(np.radians(FRICTION)) / np.tan(np.radians(20.0))
    found = bsm.factor_of_safety(lintel(kind, 20.0))
    assert found.stable <= exact * 1.001
    assert found.unstable >= exact * 0.999
    steeper = 0.1 if "179.9" in kind else 0.0  # the bound takes the steeper of the two edges [degrees]
    bound = np.tan(np.radians(FRICTION)) / np.tan(np.radians(20.0 - steeper))
    assert exact * (1 - 1e-3) < found.limit.factor < bound * (1 + 1e-3)


def test_a_square_on_its_corner_between_walls_is_admissible():
    """It is on the floor by a corner, and leans against both walls by corners."""
    half = np.sqrt(0.5)
    walls = [rectangle(-5, -1, 5, 0), rectangle(-5, 0, -half, 3), rectangle(half, 0, 5, 3)]
    square = turned(rectangle(-0.5, -0.5, 0.5, 0.5), 45.0, (0.0, half))
    for nodes in (False, True):
        floor = np.array([(-5, -1), (5, -1), (5, 0), (0, 0), (-5, 0)]) if nodes else walls[0]
        model = model_of([floor, *walls[1:], square], fixed=(0, 1, 2), friction=30.0)
        assert bsm.limit_analysis(model).admissible
        assert bsm.run(model).status == "stable"


def test_two_stones_that_lean_on_each_other_by_a_corner_are_admissible():
    """Two bars between abutments touch at one point at the crown; their thrust needs tan(friction) >= .5."""
    left = [(-4, 0), (0, 2), (-0.5, 3), (-4.5, 1)]
    right = [(4, 0), (4.5, 1), (0.5, 3), (0, 2)]
    abutments = [[(-6, -2), (-4, -2), (-4, 0), (-4.5, 1), (-6, 1)], [(4, -2), (6, -2), (6, 1), (4.5, 1), (4, 0)]]
    polygons = [np.array(polygon, float) for polygon in (*abutments, left, right)]
    for friction in (20.0, 80.0):
        model = model_of(polygons, fixed=(0, 1), friction=friction)
        assert bsm.limit_analysis(model).admissible
        assert bsm.run(model).status == "stable"


@pytest.mark.parametrize("extra", [False, True])
def test_a_post_on_the_tips_of_two_stones_that_meet_there(extra):
    """Three corners in a point, and a node of the post's foot on it."""
    foot = [(-1, 1), (0, 1), (1, 1)] if extra else [(-1, 1), (1, 1)]
    stones = [[(-2, 0), (-0.5, 0), (0, 1)], [(0.5, 0), (2, 0), (0, 1)]]
    guides = [rectangle(-3, 1, -1, 4), rectangle(1, 1, 3, 4)]
    polygons = [np.array(polygon, float) for polygon in (*stones, *guides, [*foot, (1, 3), (-1, 3)])]
    model = model_of(polygons, fixed=(0, 1, 2, 3), friction=5.0)
    results = bsm.run(model)
    assert results.status == "stable"
    assert results.stages[-1].max_displacement < 2e-2
    assert bsm.limit_analysis(model).admissible


def test_squares_that_meet_at_a_corner_in_line_share_no_length():
    """The upper square is compared with the lower one, with its corner on that one's corner: nothing carries it."""
    polygons = [rectangle(0, 0, 1, 1), rectangle(-1, 1, 0, 2)]
    assert not bsm.limit_analysis(model_of(polygons, friction=40.0)).admissible


@pytest.mark.parametrize("plane_is", [0, 1, 2])
@pytest.mark.parametrize("node", [False, True])
def test_blocks_beside_each_other_on_one_face_are_no_pair(node, plane_is):
    """A wedge of a bench and one of its face meet at the toe, both on one bedding plane, with a node there or without.

    They touch at a point between their faces on the plane: that point carries nothing, or it would hold the slope. The
    numbers of the blocks change nothing.
    """
    toe = [(0.0, 0.0)] if node else []
    plane = [(-4.0, 1.0), (-4.0, -4.0), (4.0, -4.0), (4.0, -1.0), *toe]
    left, right = [(-4.0, 1.0), (0.0, 0.0), (-4.0, 1.6)], [(0.0, 0.0), (4.0, -1.0), (3.5, 1.0)]
    polygons = [left, right]
    polygons.insert(plane_is, plane)
    model = model_of([np.array(polygon) for polygon in polygons], friction=30.0, fixed=(plane_is,))
    results = bsm.run(model)
    pairs = {frozenset(pair) for pair in zip(*map(np.ndarray.tolist, _sides(results)), strict=True)}
    assert pairs == {frozenset((plane_is, other)) for other in range(3) if other != plane_is}
    assert bsm.limit_analysis(model).contacts.count == 4


def _sides(results):
    contacts = results.stages[-1].contacts
    return contacts.block_a, contacts.block_b
