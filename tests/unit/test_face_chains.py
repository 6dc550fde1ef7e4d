"""Points that slide over the end of a block's face: where they pass to the next block, and where they do not."""

from __future__ import annotations

import numpy as np
import pytest

from bsm_mesh.solve.zones.face_chains import FaceChains

LEAST = 0.01  # m: the overlap below which a lip carries nothing
# Two blocks side by side, whose tops are faced from above: from x = 2 to 1, and on to 0.
TOPS = FaceChains(
    node=np.array([(0, 1), (2, 3)], dtype=np.int32),
    before=np.array([-1, 0], dtype=np.int32),
    after=np.array([1, -1], dtype=np.int32),
    bend=np.zeros(2),
    block=np.array([0, 1], dtype=np.int32),
    plane=np.zeros(2, dtype=np.int32),
)


def faced(x, *, start=0, own=2, present=(True, True, True), step=0.0, tail=0):
    """Return on which block a point at x lies that comes from one of both; the second top is higher by a step."""
    place = np.array([(2.0, 0.0), (1.0, 0.0), (1.0, step), (0.0, step)])
    point, here = np.array([(x, 0.0)]), np.array([start], dtype=np.int32)
    given = np.array([own], dtype=np.int32), here, place, np.array(present), np.array([tail])
    (piece,), _ = TOPS.facing(point, *given, lambda on, _: np.full(len(on), LEAST))
    return int(TOPS.block[piece])


@pytest.mark.parametrize(
    ("given", "block"),
    [
        ({}, 1),
        ({"own": 1}, 0),
        ({"present": (True, False, True)}, 0),
        ({"present": (False, True, True)}, 0),
        ({"step": 0.9 * LEAST}, 1),
        ({"step": 1.1 * LEAST}, 0),
        ({"step": -1.0}, 1),
    ],
    ids=["next", "own", "excavated", "from excavated", "low step", "high step", "step down"],
)
def test_a_point_passes_to_another_block_that_is_there_over_a_low_step(given, block):
    assert faced(1.1, **given) == 0
    assert faced(0.9, **given) == block


@pytest.mark.parametrize(("tail", "at"), [(1, 1 - LEAST), (0, 1.0), (-1, 1 + LEAST)])
@pytest.mark.parametrize("start", [0, 1])
def test_the_end_of_a_face_lies_on_a_block_where_it_overlaps_enough(tail, at, start):
    """Behind its end the face lies on the first block, before it on the second; both ways it passes at one place."""
    assert [faced(at + by, start=start, tail=tail) for by in (0.001, -0.001)] == [0, 1]
