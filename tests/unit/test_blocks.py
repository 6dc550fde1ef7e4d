"""Blocks: what is taken, what is refused and in which words."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import bsm_mesh as bsm
from bsm_mesh.merged_points import merge_points
from tests.scenes.faults import fault
from tests.scenes.models import framed
from tests.scenes.shapes import SQUARE, grid, rectangle, square


def blocks(*polygons, rock="r", **more):
    return bsm.Blocks.from_polygons(polygons, rock=rock, **more)


def raw(**changes):
    given = {
        "vertices": SQUARE,
        "offsets": [0, 4],
        "nodes": [0, 1, 2, 3],
        "rock": [0],
        "rock_names": ("r",),
        "edge_joint": [-1] * 4,
    }
    return bsm.Blocks(**{**given, **changes})


def test_from_polygons_keeps_order_rocks_and_nodes():
    b = blocks(SQUARE, square(1, 0), square(5, 0)[:3], rock=["a", "b", "a"])
    assert b.count == 3
    assert b.offsets.tolist() == [0, 4, 8, 11]
    assert b.rock_names == ("a", "b")
    assert b.rock.tolist() == [0, 1, 0]
    assert b.nodes[1] == b.nodes[4]
    assert b.nodes[2] == b.nodes[7]
    assert len(set(b.nodes.tolist())) == 9
    assert_array_equal(b.polygon(1), square(1, 0))
    assert b.owner.tolist() == [0] * 4 + [1] * 4 + [2] * 3


def test_closed_rings_of_geojson_and_shapely_are_outlines():
    assert_array_equal(blocks([*SQUARE, SQUARE[0]]).vertices, blocks(SQUARE).vertices)


def test_clockwise_outlines_are_turned_round():
    assert_allclose(blocks(SQUARE[::-1]).moments.area, [1.0])


def test_arrays_cannot_be_written_not_even_through_the_users_own():
    mine = SQUARE.copy()
    b = raw(vertices=mine)
    with pytest.raises(ValueError, match="read-only"):
        b.vertices[0, 0] = 5.0
    mine[0, 0] = 5.0
    assert b.vertices[0, 0] == 0.0


def test_a_read_only_view_of_a_writable_array_is_copied():
    mine = SQUARE.copy()
    view = mine.view()
    view.setflags(write=False)
    b = raw(vertices=view)
    mine[0] = (-5.0, -5.0)
    assert_array_equal(b.vertices, SQUARE)


@pytest.mark.parametrize(
    ("polygon", "message"),
    [
        ([(0, 0), (1, 0)], "block 1: needs at least 3 corners (x, y), has an array of shape (2, 2)"),
        ([(0, 0, 0)] * 3, "block 1: needs at least 3 corners (x, y), has an array of shape (3, 3)"),
        ("abc", "block 1: needs at least 3 corners"),
        ([(0, 0), (1, np.nan), (0, 1)], "block 1: corner 1 has coordinates that are no numbers below 1e+12 m"),
        (
            [(0, 0), (1, 0), (1, 1), (0, 1), (0, 1)],
            "block 1: edge 3 at (0, 1) has length 0 m; merge duplicate corners (tolerance 1e-09 m)",
        ),
        ([(0, 0), (1, 0), (2, 0)], "block 1 at (0, 0): encloses no area: corners on a line, or crossing"),
        (
            [(0, 0), (1, 1), (1, 0), (0, 1.5)],
            "its outline crosses or touches itself; give the corners in order round the block, or split it",
        ),
    ],
)
def test_bad_outlines_are_named(polygon, message):
    with fault(message):
        blocks(square(9, 9), polygon)


def test_every_bad_outline_is_listed():
    with pytest.raises(bsm.ModelError) as caught:
        blocks([(0, 0), (1, 0), (2, 0)], SQUARE, [(0, 0), (1, 0), (1, 1), (0, 1), (0, 1)])
    assert len(caught.value.faults) == 2
    assert "2 faults:" in str(caught.value)


def test_clockwise_raw_outline_is_refused():
    with fault("block 0 at (0, 1): corners run clockwise; reverse their order"):
        raw(vertices=SQUARE[::-1])


def test_not_finite_raw_corner():
    bad = SQUARE.copy()
    bad[2, 1] = np.inf
    with fault("block 0: corner 2 is at (1.0, inf); coordinates must be numbers below 1e+12 m"):
        raw(vertices=bad)


def test_no_blocks():
    with fault("there are no blocks; a model needs at least one polygon"):
        blocks()
    with fault("there are no blocks"):
        raw(vertices=np.zeros((0, 2)), offsets=[0], nodes=[], rock=[], edge_joint=[])


def test_rock_names_must_fit():
    with fault("rock: 2 names for 1 blocks; give one name, or one a block"):
        blocks(SQUARE, rock=["a", "b"])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vertices": np.zeros(3)}, "Blocks.vertices: shape (3,) where (n x 2) is needed"),
        ({"vertices": [["a", "b"]]}, "Blocks.vertices: not an array of float64 numbers"),
        ({"rock": [0.5]}, "Blocks.rock: not an array of int32 numbers"),
        ({"offsets": [0, 3]}, "Blocks.offsets: must rise from 0 to 4 (the number of corners) by 3 or more a block"),
        ({"offsets": [0, 2, 4], "rock": [0, 0]}, "by 3 or more a block"),
        ({"nodes": [0, 1, 2]}, "Blocks.nodes: has 3 entries, needs 4"),
        ({"edge_joint": [-1]}, "Blocks.edge_joint: has 1 entries, needs 4"),
        ({"rock": [0, 0]}, "Blocks.rock: has 2 entries, needs 1"),
        ({"rock": [1]}, "Blocks.rock: index outside 0 .. 0"),
        ({"edge_joint": [-2, -1, -1, -1]}, "Blocks.edge_joint: index outside -1 .. -1"),
        ({"boundaries": {"top": [4]}}, "Blocks.boundaries['top']: edge number outside 0 .. 3"),
        ({"excavations": {"1": [-1]}}, "Blocks.excavations['1']: block number outside 0 .. 0"),
    ],
)
def test_arrays_that_do_not_fit_are_named(changes, message):
    with fault(message):
        raw(**changes)


def test_outer_edges_and_boundaries():
    b = framed(blocks(*grid(2, 2)), 2, 2)
    assert len(b.outer_edges) == 8
    assert {name: len(edges) for name, edges in b.boundaries.items()} == dict.fromkeys(
        ("left", "right", "bottom", "top"), 2
    )
    assert_allclose(b.vertices[b.boundary_edges("top")][:, 1], 2.0)


def test_unknown_boundary_gives_the_nearest_name():
    with fault("there is no boundary 'bottm'; did you mean 'bottom'? (known: bottom, left, right, top)"):
        framed(blocks(*grid(2, 2)), 2, 2).boundary_edges("bottm")
    with fault("there is no boundary 'x' (there are none)"):
        blocks(SQUARE).boundary_edges("x")


def test_a_condition_that_no_edge_fulfils():
    with fault("boundary 'top': no outer edge fulfils the condition at both its ends"):
        blocks(SQUARE).with_boundary("top", lambda x, y: y > 5)
    with fault("joint 'J': no edge fulfils the condition at both its ends"):
        blocks(SQUARE).with_joint("J", lambda x, y: y > 5)


@pytest.mark.parametrize("where", [None, lambda x, y: x, lambda x, y: None, lambda x, y: np.zeros(3, dtype=bool)])
def test_a_condition_that_says_no_truth_for_every_point(where):
    with fault("boundary 'b': where must be a function of the arrays x, y that returns True or False for every point"):
        blocks(SQUARE).with_boundary("b", where)


def test_a_group_needs_a_name_and_a_polygon_its_block():
    with fault("joint: the name must be a non-empty text"):
        blocks(SQUARE).with_joint("", lambda x, y: y < 1)
    for number in (-1, 1):
        with fault(f"there is no block {number} (blocks 0 .. 0)"):
            blocks(SQUARE).polygon(number)


def test_with_joint_marks_both_sides():
    b = blocks(*grid(2, 1)).with_joint("J", lambda x, y: np.abs(x - 1) < 1e-9)
    assert b.joint_names == ("J",)
    assert (b.edge_joint >= 0).sum() == 2
    again = b.with_joint("K", lambda x, y: y < 1e-9).with_joint("J", lambda x, y: y > 1 - 1e-9)
    assert again.joint_names == ("J", "K")
    assert np.bincount(again.edge_joint + 1).tolist() == [2, 4, 2]


def test_merging_also_in_a_chain():
    points = np.array([(0, 0), (6e-10, 0), (12e-10, 0), (1, 0), (0.0, 0.0)])
    assert len(set(merge_points(points, 1e-9)[[0, 1, 2, 4]].tolist())) == 1
    assert merge_points(points, 1e-9).max() == 1
    assert merge_points(points, 1e-12).max() == 3


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("axes", [2, 3])
def test_merging_as_by_a_tree_of_scipy(seed, axes):
    """Points of a grid, moved a little and far from the origin."""
    random = np.random.default_rng(seed)
    grid_points = random.integers(0, 6, size=(300, axes)) * 0.1 + 1e4
    points = grid_points + random.uniform(-4e-4, 4e-4, size=grid_points.shape)
    pairs = cKDTree(points).query_pairs(3e-4, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    count, label = connected_components(graph, directed=False)
    merged = merge_points(points, 3e-4)
    assert merged.max() + 1 == count < len(points)
    assert len(np.unique(np.stack((label, merged)), axis=1).T) == count


def test_merge_tolerance_is_the_users():
    apart = [SQUARE, rectangle(1.0001, 0, 2, 1)]
    assert blocks(*apart).nodes.max() == 7
    assert blocks(*apart, merge_tolerance=1e-3).nodes.max() == 5
