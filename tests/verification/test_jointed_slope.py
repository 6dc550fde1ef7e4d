"""A slope with two joint sets and gravity switched on: the verdict, beside what statics alone can prove of the start.

Limit analysis: where the start is inadmissible the slope must move.
"""

import numpy as np
import pytest
import shapely

import bsm_mesh as bsm
from bsm_mesh.solve.algebra import pardiso
from tests.scenes.large import jointed_slope, leaning_slope
from tests.scenes.models import admissible_at

DIP, HEIGHT = 60.0, 8.0  # of one set, degrees; of the model, m


def slope(friction: float, turn: float = 0.0, scale: float = 1.0) -> bsm.Model:
    """Return unit squares along sets at 60 and -30 degrees in a slope, all turned by `turn` degrees and scaled."""
    h = HEIGHT
    outline = shapely.Polygon([(0, 0), (2.6 * h, 0), (2.6 * h, h / 2), (1.6 * h, h / 2), (h, 1.3 * h), (0, 1.3 * h)])
    along, across = bearing(DIP), bearing(DIP + 90)
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(-24.0, 24), np.arange(-24.0, 24)))
    corner = np.array([0.3, 0.2]) + i[:, None] * along + j[:, None] * across
    squares = shapely.polygons(np.stack([corner, corner + along, corner + along + across, corner + across], axis=1))
    pieces = [p for p in shapely.intersection(squares, outline) if p.geom_type == "Polygon" and p.area > 0.02]
    polygons = [np.array(p.exterior.coords)[:-1] for p in pieces]
    low, left, right = (np.array([f(p) for p in polygons]) for f in (lowest, leftmost, rightmost))
    held = np.flatnonzero((low < 1e-6) | (left < 1e-6) | (right > 2.6 * h - 1e-6))
    turned = np.stack([bearing(turn), bearing(turn + 90)])
    law = bsm.MohrCoulomb(friction=friction)
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([scale * p @ turned for p in polygons], rock="rock", merge_tolerance=1e-7),
        rocks=[bsm.Rock("rock", unit_weight=26e3 / scale)],
        joints=[bsm.Joint("J", normal_stiffness=1e10 / scale, shear_stiffness=1e10 / scale, law=law)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=held)],
        gravity_direction=-90.0 + turn,
    )


def bearing(angle: float) -> np.ndarray:
    """Return a unit vector."""
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def lowest(polygon: np.ndarray) -> float:
    return float(polygon[:, 1].min())


def leftmost(polygon: np.ndarray) -> float:
    return float(polygon[:, 0].min())


def rightmost(polygon: np.ndarray) -> float:
    return float(polygon[:, 0].max())


@pytest.mark.heavy
@pytest.mark.parametrize(("turn", "scale"), [(0.0, 1.0), (17.0, 1.0), (0.0, 0.01)])
def test_what_cannot_rest_moves(turn, scale):
    """It falls, or slides to where it can rest: that end is admissible by statics alone."""
    model = slope(24.0, turn, scale)
    assert not bsm.limit_analysis(model).admissible
    results = bsm.run(model, bsm.Options(scheme="continuation"))
    assert results.status in ("unstable", "stable")
    assert results.stages[0].max_displacement > 0.1 * scale
    if results.status == "stable":
        assert results.check().ok
        assert admissible_at(results, 24.0)
    else:
        assert results.unstable_blocks.size > 0


@pytest.mark.parametrize(("turn", "scale"), [(0.0, 1.0), (17.0, 1.0), (0.0, 0.01)])
def test_what_rests_is_found_in_two_steps(turn, scale):
    results = bsm.run(slope(45.0, turn, scale), bsm.Options(scheme="continuation"))
    assert results.status == "stable"
    assert results.check().ok
    assert len(results.stages[0].steps) == 2
    assert sum(step.factorizations for step in results.stages[0].steps) < 25


@pytest.mark.slow
@pytest.mark.parametrize(("dips", "frictions"), [((80.0, -25.0), (24.9, 25.1)), ((60.0, -30.0), (31.0, 32.0))])
def test_a_slope_of_more_blocks_moves_where_statics_knows_no_rest_and_only_there(dips, frictions):
    """To either side of the limit, in slopes whose blocks are followed by cycles of damped motion."""
    for friction in frictions:
        model = jointed_slope(200, friction, dips=dips).model(None)
        results = bsm.run(model, bsm.Options(scheme="continuation"))
        assert results.status in ("unstable", "stable")
        assert bsm.limit_analysis(model).admissible == (results.stages[0].max_displacement < 0.01)


@pytest.mark.slow
@pytest.mark.skipif(not pardiso.is_available(), reason="mkl is not installed")
def test_a_run_is_the_same_to_the_last_digit_whatever_the_threads():
    """Thousands of contacts slip: what differs in a correction's last digit would be another way, and another end."""
    ends = [
        bsm.run(leaning_slope(6000).model(1.0), bsm.Options(scheme="continuation", threads=threads)).stages[-1]
        for threads in (1, 2)
    ]
    assert ends[0].status == "stable"
    assert ends[0].displacement.tobytes() == ends[1].displacement.tobytes()
