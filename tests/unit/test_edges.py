"""Edges found by their two points."""

from __future__ import annotations

import numpy as np

from bsm_mesh.model.edges import EdgeTable

# Two squares side by side: 0-1-4-5 and 1-2-3-4 share the edge 1-4.
NODES = np.array([0, 1, 4, 5, 1, 2, 3, 4], dtype=np.int32)
OFFSETS = np.array([0, 4, 8], dtype=np.int32)


def test_edges_are_found_from_either_end_and_on_both_sides() -> None:
    table = EdgeTable.of(NODES, OFFSETS)
    for first, last in ((1, 4), (4, 1)):
        query, edge = table.joining(np.array([first]), np.array([last]))
        assert query.tolist() == [0, 0]
        assert sorted(edge.tolist()) == [1, 7]


def test_points_that_no_edge_joins_give_nothing() -> None:
    query, edge = EdgeTable.of(NODES, OFFSETS).joining(np.array([0, -1, 0, 0]), np.array([4, 1, 9, 1]))
    assert query.tolist() == [3]
    assert edge.tolist() == [0]


def test_only_the_shared_edge_is_paired() -> None:
    assert np.flatnonzero(~EdgeTable.of(NODES, OFFSETS).unpaired()).tolist() == [1, 7]


def test_an_edge_used_three_times_or_twice_in_one_direction_is_not_paired() -> None:
    thrice = EdgeTable.of(np.array([0, 1, 2, 1, 0, 3, 0, 1, 4], dtype=np.int32), np.array([0, 3, 6, 9], dtype=np.int32))
    assert thrice.unpaired().all()
    same_way = EdgeTable.of(np.array([0, 1, 2, 0, 1, 3], dtype=np.int32), np.array([0, 3, 6], dtype=np.int32))
    assert same_way.unpaired().all()
