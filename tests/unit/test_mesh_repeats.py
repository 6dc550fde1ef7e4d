"""Outlines given more than once."""

from __future__ import annotations

import numpy as np

from bsm_mesh.converters.meshes.repeats import first_of_equal


def first(*outlines: list[int]) -> list[int]:
    offsets = np.cumsum([0, *(len(outline) for outline in outlines)]).astype(np.int32)
    return first_of_equal(np.concatenate(outlines).astype(np.int32), offsets).tolist()


def test_the_round_order_counts_but_not_where_it_starts() -> None:
    assert first([3, 1, 2], [1, 2, 3], [1, 3, 2]) == [0, 0, 2]


def test_outlines_with_the_same_points_in_another_order_differ() -> None:
    assert first([0, 1, 2, 3], [0, 2, 1, 3], [1, 2, 3, 0]) == [0, 1, 0]


def test_sizes_may_differ() -> None:
    assert first([0, 1, 2], [0, 1, 2, 3, 4], [5, 6, 7, 8], [4, 0, 1, 2, 3], [7, 8, 5, 6]) == [0, 1, 2, 1, 2]


def test_none_and_one() -> None:
    assert first_of_equal(np.empty(0, np.int32), np.zeros(1, np.int32)).tolist() == []
    assert first([4, 5, 6]) == [0]
