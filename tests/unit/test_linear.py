"""What the linear scheme reports: contacts, supports, the step, and who is reported."""

import numpy as np
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results import Status
from tests.scenes.models import LINEAR
from tests.scenes.shapes import grid, running_bond

KN, KS = 2e9, 3e8


def model(polygons, **more):
    given = {
        "blocks": bsm.Blocks.from_polygons(polygons, rock="r"),
        "rocks": [bsm.Rock("r", unit_weight=26e3)],
        "joints": [bsm.Joint("J", KN, KS)],
        "default_joint": "J",
        "gravity_direction": -70.0,
        "supports": [bsm.Fixed(blocks=[0])],
    }
    return bsm.Model(**{**given, **more})


def test_opening_and_slip_are_the_displacements_of_a_relative_to_b():
    stage = bsm.run(model(running_bond(3, 2)), LINEAR).stages[0]
    c = stage.contacts
    centroid = model(running_bond(3, 2)).blocks.moments.centroid

    def moved(block):
        u, v, theta = stage.displacement[block].T
        x, y = (c.point - centroid[block]).T
        return np.stack([u - theta * y, v + theta * x], axis=1)

    relative = moved(c.block_a) - moved(c.block_b)
    tangent = np.stack([-c.normal[:, 1], c.normal[:, 0]], axis=1)
    size = np.abs(stage.displacement).max()
    assert_allclose(c.opening, (relative * c.normal).sum(axis=1), atol=1e-10 * size)
    assert_allclose(c.slip, (relative * tangent).sum(axis=1), atol=1e-10 * size)
    assert_allclose(c.normal_force, KN * c.length * c.opening, rtol=1e-12)
    assert_allclose(c.shear_force, KS * c.length * c.slip, rtol=1e-12)
    assert (c.status == 0).all()


def test_a_block_held_as_a_whole_reports_force_and_moment():
    force, point = np.array([3e4, -5e4]), np.array([1.0, 0.75])
    m = model(grid(1, 1), loads=[bsm.PointLoad(block=0, point=point, force=force)], gravity_direction=-90.0)
    stage = bsm.run(m, LINEAR).stages[0]
    x, y = point - 0.5
    assert_allclose(stage.supports.block, [0])
    assert_allclose(stage.supports.point, [(0.5, 0.5)])
    assert_allclose(stage.supports.reaction, [(-3e4, 5e4 + 26e3)], rtol=1e-12)
    assert_allclose(stage.supports.moment, [-(x * force[1] - y * force[0])], rtol=1e-12)
    assert_allclose(stage.reactions[0], (*stage.supports.reaction[0], stage.supports.moment[0]), rtol=1e-12)


def test_bars_at_one_point_are_one_row():
    m = model(grid(1, 1), supports=[bsm.Fixed(point=(0, 0)), bsm.Roller(point=(1, 0), direction=90)])
    supports = bsm.run(m.replace(gravity_direction=-90.0), LINEAR).stages[0].supports
    assert_allclose(supports.point, [(0, 0), (1, 0)])
    assert_allclose(supports.reaction, [(0, 13e3), (0, 13e3)], atol=1e-9)
    assert_allclose(supports.moment, 0)


def test_the_run_tells_what_it_does_and_records_its_step():
    steps, told = [], []
    results = bsm.run(model(grid(2, 2)), LINEAR, observer=steps.append, report=told.append)
    assert told == ["contacts", "assembly", "linear solution", "forces and stresses"]
    assert steps == list(results.stages[0].steps)
    assert results.status == Status.NO_VERDICT
    assert results.stages[0].reason == "one linear step: nothing can fail in this scheme"
    assert results.stages[0].name == "initial"
    assert results.scheme == "linear"
    assert results.linear_solver in ("pardiso", "superlu")
    assert results.model_digest == model(grid(2, 2)).digest
    assert len(results.unstable_blocks) == 0
    assert_allclose(results.stages[0].max_displacement, np.hypot(*results.stages[0].displacement[:, :2].T).max())


def test_a_singular_matrix_is_an_answer_and_no_refusal():
    """A weightless block on a joint without stiffness to speak of, and a stiff one on it."""
    blocks = bsm.Blocks.from_polygons(grid(1, 3), rock=["r", "light", "light"])
    blocks = blocks.with_joint("soft", lambda x, y: abs(y - 1) < 1e-9)
    joints = [bsm.Joint("J", 1e18, 1e18), bsm.Joint("soft", 1.0, 1.0)]
    rocks = [bsm.Rock("r", unit_weight=26e3), bsm.Rock("light", unit_weight=0.0)]
    stage = bsm.run(model(grid(1, 3), blocks=blocks, rocks=rocks, joints=joints), LINEAR).stages[0]
    assert stage.status == "not_converged"
    assert "the stiffness matrix is singular" in stage.reason
    assert "many orders apart" in stage.reason
    assert_allclose(stage.displacement, 0)
