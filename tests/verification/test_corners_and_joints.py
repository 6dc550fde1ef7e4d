"""Blocks that meet corner on corner, and blocks that slide over the joints of what they lie on.

Sliding is judged by statics: a block pushed by H slides if H > W tan(phi), on a plane if psi > phi, whatever the joints
in the base are like. A step that is higher than 0.005 of the block size stops it.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import GAMMA, model_of, moved_polygons
from tests.scenes.shapes import rectangle, turned

FRAMES = [(False, 0.0), (True, 0.0), (False, 33.0)]  # mirrored, turned by degrees


def run(model, limit, steps=500):
    """Run until a block moved `limit`, and hold the end to no overlap, stable or not."""
    results = bsm.run(model, bsm.Options(scheme="continuation", displacement_limit=limit, max_steps=steps))
    assert results.check().overlap <= 1.3e-3
    if results.status == "stable":
        assert results.check().ok, str(results.check())
    return results


def pushed_over_a_joint(factor, kn, *, lean=0.0, step=0.0, mirrored=False, degrees=0.0):
    """Return a block whose toe is at the joint of two others, pushed by W tan(phi) / factor towards the second.

    Its front leans back by `lean` degrees; the second block stands out by `step`. The first one settles under it.
    """
    toe = np.array([(-1.0, 0.0), (0.0, 0.0), (-np.tan(np.radians(lean)), 1.0), (-1.0, 1.0)])
    sign = -1 if mirrored else 1

    def put(points):
        points = points * (sign, 1)
        return turned(points[::sign], degrees)

    polygons = [rectangle(-3, -2, 6, -1), rectangle(-3, -1, 0, 0), rectangle(0, -1, 3, step), toe]
    area = bsm.Blocks.from_polygons([toe], rock="r").moments.area[0]
    push = GAMMA * area * np.tan(np.radians(30.0)) / factor
    force, point = (turned(np.array([v]) * (sign, 1), degrees)[0] for v in ((push, 0.0), (-1.0, 0.05)))
    load = bsm.PointLoad(block=3, point=tuple(point), force=tuple(force))
    return model_of([put(p) for p in polygons], friction=30, kn=kn, gravity_direction=degrees - 90.0, loads=[load])


@pytest.mark.heavy
@pytest.mark.parametrize("lean", [0.0, 35.0])
@pytest.mark.parametrize("kn", [1e7, 1e9, 1e11])
def test_a_block_does_not_catch_on_what_its_neighbour_settles_less(kn, lean):
    """Seen: a dam at a factor of 0.94 stopped after 11 mm, its sloping toe at a rock that stood out by 0.1 mm."""
    for mirrored, degrees in FRAMES:
        frame = {"mirrored": mirrored, "degrees": degrees, "lean": lean}
        slides = run(pushed_over_a_joint(0.94, kn, **frame), limit=0.6)
        assert slides.status == "unstable", (mirrored, degrees)
        assert list(slides.unstable_blocks) == [3]
        assert run(pushed_over_a_joint(1.06, kn, **frame), limit=0.6).status == "stable"


@pytest.mark.heavy
@pytest.mark.parametrize("lean", [0.0, 35.0])
@pytest.mark.parametrize(("step", "status"), [(1e-4, "unstable"), (1e-3, "unstable"), (0.02, "stable")])
def test_a_low_step_is_none_and_a_real_one_stops_the_block(step, status, lean):
    for mirrored, degrees in FRAMES:
        model = pushed_over_a_joint(0.94, 1e9, lean=lean, step=step, mirrored=mirrored, degrees=degrees)
        results = run(model, limit=0.6)
        assert results.status == status
        if status == "unstable":  # it has climbed onto the step
            normal = np.array([-np.sin(np.radians(degrees)), np.cos(np.radians(degrees))])
            lowest = min((moved_polygons(results)[3] @ normal)[:2])
            assert lowest >= -1e-3


def incline_of_blocks(friction, angle, *, kn=1e10, degrees=0.0, scale=1.0):
    """Return a slab on an incline made of five blocks with a stop below them."""
    row = [rectangle(0.8 * k, -0.5, 0.8 * k + 0.8, 0) for k in range(5)]
    fixed = [rectangle(-2, -1.5, 5, -0.5), rectangle(-1, -0.5, 0, -0.2)]
    slab = rectangle(2.9, 0, 3.9, 0.5)
    polygons = [scale * turned(p, angle + degrees) for p in (*fixed, *row, slab)]
    return model_of(polygons, friction=friction, kn=kn, fixed=(0, 1), gravity_direction=degrees - 90.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "degrees", "scale"),
    [
        (20.0, 0.0, 1.0),
        (35.0, 0.0, 1.0),
        (20.0, 33.0, 1.0),
        pytest.param(35.0, 217.0, 1.0, marks=pytest.mark.heavy),
        (35.0, 0.0, 1e3),
        (20.0, 0.0, 1e-2),
    ],
)
def test_joints_in_an_incline_neither_stop_a_slab_nor_let_it_go(friction, degrees, scale):
    """Within 0.01 degrees of the limit, over two joints."""
    frame = {"degrees": degrees, "scale": scale}
    assert run(incline_of_blocks(friction, friction - 0.01, **frame), limit=scale).status == "stable"
    slides = run(incline_of_blocks(friction, friction + 0.01, **frame), limit=scale)
    assert slides.status == "unstable"
    assert list(slides.unstable_blocks) == [7]


@pytest.mark.heavy
def test_a_slab_does_not_sink_while_it_slides_over_joints():
    """On soft joints every new support must carry what the last one did: seen, it sank by its closure at each joint."""
    results = run(incline_of_blocks(30.0, 30.3, kn=1e8), limit=2.0)
    assert results.status == "unstable"
    lowest = turned(moved_polygons(results)[7], -30.3)[:, 1].min()
    closure = GAMMA * 0.5 / 1e8  # of a joint under the slab; the block below it sinks as well
    assert lowest > -6 * closure


@pytest.mark.heavy
@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("angle", [60.0, 90.0, 120.0])
def test_a_block_on_the_tip_of_another_comes_down_on_the_side_it_leans_to(side, angle):
    half = np.radians(angle / 2)
    wedge = np.array([(0, 1), (-np.tan(half), 0), (np.tan(half), 0)])
    kite = np.array([(0, 1), (0.7, 1.7), (0, 2.4), (-0.7, 1.7)]) + np.array([side * 2e-3, 0])
    model = model_of([rectangle(-6, -1, 6, 0), wedge, kite], friction=10, fixed=(0, 1))
    results = run(model, limit=9.0)
    assert results.status == "stable"
    assert np.sign(results.stages[-1].displacement[2, 0]) == side


def test_a_block_that_turns_about_one_corner_lands_on_the_next():
    """Its lower edge leans by more than an entrance at the start of the step in which it closes."""
    block = np.array([(-2.5043, 0.3341), (-2.2721, 0.0), (-1.6238, 0.3211), (-1.4888, 0.7537), (-1.7715, 0.9397)])
    results = run(model_of([rectangle(-4, -1, 4, 0), block], friction=10), limit=9.0)
    assert results.status == "stable"
    assert_allclose(moved_polygons(results)[1][:, 1].min(), 0.0, atol=1e-3)
