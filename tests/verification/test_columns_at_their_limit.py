"""Limit analysis within a thirtieth of a degree of toppling: every program has an answer, on the right side."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.limit_analysis import strength_limit
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned


def with_nodes(polygon: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a polygon with up to two more nodes on every edge."""
    corners = []
    for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        shares = np.sort(rng.uniform(0.05, 0.95, rng.integers(0, 3)))
        corners += [start, *(start + share * (end - start) for share in shares)]
    return np.array(corners)


@pytest.mark.parametrize("seed", range(41, 57))
def test_a_column_with_nodes_is_answered_just_below_and_above_its_limit(seed):
    """Seen: one program in six ended with a numerical error, so that a factor of safety could not be found."""
    rng = np.random.default_rng(seed)
    n, b, h = int(rng.integers(3, 14)), rng.uniform(0.3, 1.2), rng.uniform(0.2, 1)
    past = rng.uniform(-0.03, 0.03)  # degrees
    angle = np.degrees(np.arctan(b / (n * h))) + past
    polygons = [rectangle(-6, -1, 6, 0), *(rectangle(0, k * h, b, (k + 1) * h) for k in range(n))]
    model = model_of([turned(with_nodes(np.asarray(p, float), rng), -angle) for p in polygons], friction=50.0)
    bound = strength_limit(model).factor
    assert bsm.limit_analysis(model).admissible == (past < 0)
    assert (bound > 1.0) == (past < 0), "no strength helps what topples"
