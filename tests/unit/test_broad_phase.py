"""Broad phase: the pairs of blocks whose boxes overlap, against a comparison of every box with every other."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.contact.broad_phase import near_pairs
from bsm_mesh.contact.outlines import Outlines, records_at
from bsm_mesh.model.polygons import polygon_moments
from tests.scenes.shapes import rectangle, square, turned

BAND = 0.05


def outlines_of(polygons, fixed=None):
    """Return outlines and position of polygons that may overlap, which `Blocks` refuses."""
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in polygons])])
    vertices = np.concatenate(polygons)
    moments = polygon_moments(vertices, offsets)
    size = np.sqrt(moments.area)
    outlines = Outlines(
        corners=vertices - np.repeat(moments.centroid, np.diff(offsets), axis=0),
        directions=np.zeros_like(vertices),  # which the broad phase does not look at
        centroid=moments.centroid,
        offsets=offsets,
        vertex_clusters=np.arange(len(vertices)),
        neighbour_clusters=np.arange(len(vertices)),
        fixed=np.zeros(len(polygons), dtype=bool) if fixed is None else fixed,
        block_size=size,
        size=float(np.median(size)),
    )
    return outlines, np.column_stack([moments.centroid, np.zeros(len(polygons))])


def pairs_of(polygons, fixed=None):
    pairs = near_pairs(*records_at(*outlines_of(polygons, fixed), BAND))
    found = [tuple(pair) for pair in pairs.tolist()]
    assert found == sorted(set(found)), "sorted, each once"
    assert all(i < j for i, j in found)
    return set(found)


def overlapping_boxes(polygons):
    low, high = np.array([p.min(axis=0) for p in polygons]), np.array([p.max(axis=0) for p in polygons])
    apart = (low[:, None] > high[None] + BAND).any(axis=2) | (low[None] > high[:, None] + BAND).any(axis=2)
    return {(int(i), int(j)) for i, j in np.argwhere(~apart) if i < j}


def near_outlines(polygons):
    """Return the pairs of blocks whose outlines are nearer than the band in x and y: those that can have contacts."""
    import shapely

    rings = [shapely.linearrings(p) for p in polygons]
    return {
        (i, j)
        for i, j in overlapping_boxes(polygons)
        if shapely.distance(rings[i], rings[j]) <= 0.999 * BAND  # diagonally nearer than the band in x and in y
    }


def polygons_of_size(rng, sizes, extent):
    corners = np.array([(0.0, 0.0), (1.0, 0.1), (0.9, 1.0), (-0.1, 0.8)])
    return [turned(corners * s, rng.uniform(0, 360), rng.uniform(-extent, extent, 2)) for s in sizes]


@pytest.mark.parametrize("seed", range(8))
def test_blocks_of_like_size_give_exactly_the_overlapping_boxes(seed):
    rng = np.random.default_rng(seed)
    polygons = polygons_of_size(rng, rng.uniform(0.7, 1.3, 150), 8.0)
    assert pairs_of(polygons) == overlapping_boxes(polygons)


@pytest.mark.parametrize("seed", range(8))
def test_blocks_of_very_different_size_give_all_that_may_touch(seed):
    rng = np.random.default_rng(seed)
    polygons = polygons_of_size(rng, 10 ** rng.uniform(-2, 1.5, 120), 10.0)
    found = pairs_of(polygons)
    assert near_outlines(polygons) <= found <= overlapping_boxes(polygons)


def test_a_cell_crowded_with_small_blocks_is_swept():
    rng = np.random.default_rng(3)
    crowd = polygons_of_size(rng, np.full(200, 0.02), 0.4)
    polygons = crowd + [rectangle(3 * k, 5, 3 * k + 3, 8) for k in range(250)]  # the median box is 150 times as wide
    found = pairs_of(polygons)
    assert found == overlapping_boxes(polygons)
    assert len([1 for i, j in found if j < 200]) > 200


@pytest.mark.heavy
def test_a_block_round_all_others_is_the_pair_of_those_near_its_edges_only():
    outside = [(-50, 0), (-50, -50), (51, -50), (51, 51), (-50, 51), (-50, 0.5)]
    inside = [(-49, 0.5), (-49, 50), (50, 50), (50, -49), (-49, -49), (-49, 0)]
    room = np.array(outside + inside, dtype=float)
    inner = [square(x, y) for x in range(-49, 49, 2) for y in range(-49, 49, 2)]
    polygons = [room, *inner]
    found = pairs_of(polygons)
    partners = {j for i, j in found if i == 0}
    assert near_outlines(polygons) <= found
    assert len(partners) < 0.25 * len(inner), "its box holds all of them"


def test_two_held_blocks_are_no_pair():
    polygons = [square(0, 0), square(1, 0), square(2, 0)]
    assert pairs_of(polygons) == {(0, 1), (1, 2)}
    assert pairs_of(polygons, np.array([True, True, False])) == {(1, 2)}


@pytest.mark.parametrize("far", [(1e9, -1e9), (-1e12, 3.0), (5.0, 1e15)])
def test_a_block_that_flew_off_costs_nothing(far):
    wall = [square(x, y) for x in range(12) for y in range(12)]
    assert pairs_of([*wall, square(0, 0) + np.array(far)]) == overlapping_boxes(wall)


def test_a_long_diagonal_chain_needs_no_table_of_all_cells():
    chain = [square(0.9 * k, 0.9 * k) for k in range(20_000)]  # its bounding box has 4e8 cells
    assert pairs_of(chain) == {(k, k + 1) for k in range(len(chain) - 1)}


@pytest.mark.parametrize("polygons", [[square(0, 0)], [square(0, 0), square(9, 9)]])
def test_nothing_near_nothing_found(polygons):
    assert pairs_of(polygons) == set()


def test_outlines_of_blocks():
    blocks = bsm.Blocks.from_polygons([square(5, 5), rectangle(0, 0, 4, 4), rectangle(10, 0, 12, 2)], rock="r")
    outlines = Outlines.of(blocks, [True, False, False])
    np.testing.assert_allclose(outlines.block_size, [1, 4, 2])
    assert outlines.size == pytest.approx(3.0), "the median of the blocks that can move"
    np.testing.assert_allclose(outlines.corners[:4], square(-0.5, -0.5))
    assert Outlines.of(blocks, [True, True, True]).size == pytest.approx(2.0)
