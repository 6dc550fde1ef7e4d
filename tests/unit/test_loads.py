"""Loads and the point forces that they represent."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.loads import point_forces_of
from tests.scenes.faults import fault
from tests.scenes.models import framed
from tests.scenes.shapes import grid, turned

BLOCKS = framed(bsm.Blocks.from_polygons(grid(2, 2), rock="r"), 2, 2)
RTOL = 1e-13


def resultant(forces, about=(0.0, 0.0)):
    arm = forces.point - about
    moment = (arm[:, 0] * forces.force[:, 1] - arm[:, 1] * forces.force[:, 0]).sum()
    return np.array([*forces.force.sum(axis=0), moment])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: bsm.PointLoad(block=0, point=(0, np.nan), force=(1, 1)),
            "point load on block 0: point y = nan is not",
        ),
        (lambda: bsm.PointLoad(block=0, point=(0, 0), force=3), "force = 3 must be two numbers (x, y), or in"),
        (lambda: bsm.PointLoad(block=0.5, point=(0, 0), force=(1, 1)), "block = 0.5 must be a whole number, 0 to"),
        (lambda: bsm.Pressure(boundary="t", pressure=(1, 2)), "load on 't': pressure: give one number, or three"),
        (lambda: bsm.Pressure(boundary="t", pressure=None), "load on 't': pressure: value = None is not a finite"),
        (lambda: bsm.Traction(boundary="t", traction=(1, 2, 3, 4)), "needs two components (t_x, t_y), in space three"),
        (lambda: bsm.Traction(boundary="t", traction=3.0), "needs two components (t_x, t_y)"),
        (lambda: bsm.EdgeTractions(boundary="t", values=np.zeros((3, 2))), "EdgeTractions.values: shape (3, 2)"),
        (
            lambda: bsm.EdgeTractions(boundary="t", values=np.full((1, 2, 2), np.nan)),
            "load on 't': values: nan Pa must be -1e10 to 1e10 Pa",
        ),
    ],
)
def test_faults(make, message):
    with fault(message):
        make()


def test_number_of_edge_tractions_must_fit():
    with fault("load on 'top': values for 1 edges; the boundary has 2"):
        point_forces_of([bsm.EdgeTractions(boundary="top", values=np.zeros((1, 2, 2)))], BLOCKS)


def test_numpy_integers_are_numbers():
    load = bsm.PointLoad(block=np.int32(1), point=np.array([1, 0]), force=np.array([0, -5]))
    assert load.force == (0.0, -5.0)
    assert bsm.Pressure(boundary="top", pressure=np.int64(3)).pressure == (3.0, 0.0, 0.0)


def test_pressure_pushes_into_the_blocks():
    for side, expected in {"left": (8, 0), "right": (-8, 0), "bottom": (0, 8), "top": (0, -8)}.items():
        forces = point_forces_of([bsm.Pressure(boundary=side, pressure=4.0)], BLOCKS)
        assert_allclose(resultant(forces)[:2], expected, rtol=RTOL)


def test_linear_pressure_has_its_resultant_and_moment():
    c, slope, h = 3.0, -1.5, 2.0
    forces = point_forces_of([bsm.Pressure(boundary="right", pressure=(c, 0.0, slope))], BLOCKS)
    # integral of -(c + slope y) dy, and of its moment -y fx about the corner (2, 0)
    expected = (-(c * h + slope * h**2 / 2), 0, c * h**2 / 2 + slope * h**3 / 3)
    assert_allclose(resultant(forces, about=(2.0, 0.0)), expected, rtol=RTOL, atol=1e-12)


def test_linear_traction_splits_two_to_one():
    blocks = framed(bsm.Blocks.from_polygons(grid([0, 3], [0, 1]), rock="r"), 3, 1)
    forces = point_forces_of([bsm.Traction(boundary="bottom", traction=((0, 1, 0), 2.0))], blocks)
    assert_allclose(forces.point, [(0, 0), (3, 0)])
    assert_allclose(forces.force, [(3 * 3 / 6, 3), (3 * 6 / 6, 3)], rtol=RTOL)  # l (2 q1 + q2) / 6, l (q1 + 2 q2) / 6


def test_edge_tractions_in_the_order_of_the_boundary():
    values = np.arange(8.0).reshape(2, 2, 2)
    forces = point_forces_of([bsm.EdgeTractions(boundary="top", values=values)], BLOCKS)
    edges = BLOCKS.boundaries["top"]
    assert forces.block.tolist() == np.repeat(BLOCKS.owner[edges], 2).tolist()
    assert_allclose(forces.force.sum(axis=0), values.mean(axis=1).sum(axis=0), rtol=RTOL)
    assert_allclose(forces.force[0], (2 * values[0, 0] + values[0, 1]) / 6, rtol=RTOL)


def test_pressure_on_inclined_edges():
    turn = 25.0
    blocks = bsm.Blocks.from_polygons([turned(p, turn) for p in grid(2, 1)], rock="r")
    up = turned(np.array([(0.0, 1.0)]), turn)[0]
    blocks = blocks.with_boundary("top", lambda x, y: x * up[0] + y * up[1] > 1 - 1e-9)
    forces = point_forces_of([bsm.Pressure(boundary="top", pressure=7.0)], blocks)
    assert_allclose(resultant(forces)[:2], -7.0 * 2 * up, rtol=RTOL)


def test_no_loads():
    assert len(point_forces_of([], BLOCKS).block) == 0
