"""Meshes given as arrays: the fault with nodes, elements, groups and cell data is one message."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from bsm_mesh.converters import convert_mesh
from bsm_mesh.errors import ModelError
from tests.scenes.square_mesh import NODES, QUADS

GIVEN: dict[str, Any] = {
    "points": np.array(NODES, dtype=float),
    "cells": [("quad", np.array(QUADS)), ("line", np.array([[0, 1], [1, 2]]))],
    "cell_sets": {"rock:r": [np.arange(4), None], "boundary:b": [None, np.arange(2)]},
}


def moved(x: float) -> np.ndarray:
    points = np.array(NODES, dtype=float)
    points[4, 0] = x
    return points


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"points": moved(1e155)}, "coordinates of 1 node are no numbers below 1e+12 (counted from 0: 4)"),
        ({"points": moved(1e200)}, "no numbers below 1e+12"),
        ({"points": moved(np.nan)}, "no numbers below 1e+12"),
        ({"points": moved(2e9), "unit_scale": 1e3}, "no numbers below 1e+09"),
        ({"points": [["a", "b"]]}, "nodes are no array of numbers"),
        ({"points": [[0, 0], [1]]}, "nodes are no array of numbers"),
        (
            {"cell_sets": {"rock:r": [[0, 4], None]}},
            "group 'rock:r' has elements that are not there (4; its block has 4",
        ),
        ({"cell_sets": {"rock:r": [[-1], None]}}, "group 'rock:r' has elements that are not there (-1;"),
        ({"cell_sets": {"rock:r": [[0.5], None]}}, "group 'rock:r' is no list of element numbers"),
        ({"cell_sets": {"rock:r": [[True, False, True, True], None]}}, "of a mask: np.flatnonzero"),
        ({"cell_sets": {"rock:r": [[0], None, [0]]}}, "group 'rock:r' has 3 entries for 2 blocks of elements"),
        ({"cell_sets": {5: [[0], None]}}, "the name 5 of a group or of cell data is no text"),
        ({"cell_data": {"a": [np.arange(3), np.arange(2)]}}, "cell data 'a' has [3, 2] values for blocks of [4, 2]"),
        ({"cells": [("quad", [[0, 1, 2]])], "cell_sets": {}}, "quad elements of 3 nodes; they need 4 at least"),
        ({"groups": {5: "rock:r"}}, "the names of groups and their meanings must be texts"),
    ],
)
def test_faulty_arrays(given: dict[str, Any], says: str) -> None:
    with pytest.raises(ModelError, match=re.escape(says)):
        convert_mesh(**(GIVEN | given))


def test_they_are_told_together() -> None:
    with pytest.raises(ModelError) as caught:
        convert_mesh(**(GIVEN | {"cell_sets": {"rock:r": [[9], None], "boundary:b": [None, [7]]}}))
    assert len(caught.value.faults) == 2


@pytest.mark.parametrize("values", [[np.inf, 1, 1, 1], [np.nan] * 4, [1e300, 1, 1, 1], [2.0**60, 1, 1, 1]])
def test_numbers_that_stand_for_no_group(values: list[float]) -> None:
    data = {"material": [np.array(values), np.zeros(2)]}
    blocks, _ = convert_mesh(**(GIVEN | {"cell_data": data}))
    assert blocks.count == 4
