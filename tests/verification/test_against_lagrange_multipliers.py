"""Supports by exact elimination against a dense solution with Lagrange multipliers, and against the turned model.

A stiff bar of 1e20 destroys the answer where bars are inclined and joints soft (dU / U from 1e-2
to 99), and equilibrium alone does not show it. So displacements and forces are compared, for bars at 30 degrees and
joints of 1 MPa/m, with a solution that knows neither bars of any stiffness nor this package's assembly.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import LINEAR
from tests.scenes.reference import dense_solution, face_forces
from tests.scenes.shapes import grid, running_bond, turned

RTOL = 1e-9  # both solutions lose about 1e-12 to rounding; a bar of 1e20 loses 1e-2 or more
KN, KS, GAMMA = 1e6, 0.4e6, 26e3
TURN = 30.0
GRAVITY = -75.0


def bars_of_scene(polygons):
    """Return bars (block, point, degrees, displacement) that hold the lowest blocks as rollers on an incline."""
    bars = []
    for block in range(3):
        bars += [(block, polygons[block][i], 120.0, 0.0) for i in (0, 1)]  # rollers on a plane that rises by 30 degrees
    bars.append((0, polygons[0][3], 30.0, 0.0))
    bars.append((5, (polygons[5][0] + polygons[5][1]) / 2, 75.0, 2e-3))  # a displacement that is prescribed
    bars.append((7, polygons[7][2], -20.0, -1e-3))
    return bars


def scene(kind, degrees):
    """Return outlines, bars, point loads and gravity's direction, everything turned by `degrees`."""
    flat = grid(3, 4) if kind == "grid" else [2 * p for p in running_bond(3, 3)]
    polygons = [turned(p, TURN) for p in flat]
    loads = [(9, polygons[9].mean(axis=0), np.array([3e5, -1e5])), (4, polygons[4][1], np.array([0.0, 2e5]))]
    bars = bars_of_scene(polygons)
    return (
        [turned(p, degrees) for p in polygons],
        [(b, turned(p, degrees), a + degrees, w) for b, p, a, w in bars],
        [(b, turned(p, degrees), turned(f, degrees)) for b, p, f in loads],
        GRAVITY + degrees,
    )


def solved(kind, degrees, solver="auto"):
    polygons, bars, loads, gravity = scene(kind, degrees)
    centroids = bsm.Blocks.from_polygons(polygons, rock="r").moments.centroid
    supports = []
    for block, point, angle, displacement in bars:
        # a point on a corner would hold every block there: a hair inside holds this one
        inside = tuple(point + 1e-7 * (centroids[block] - point))
        if displacement:
            supports.append(bsm.PrescribedDisplacement(point=inside, direction=angle, displacement=displacement))
        else:
            supports.append(bsm.Roller(point=inside, direction=angle))
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=GAMMA)],
        joints=[bsm.Joint("J", KN, KS)],
        default_joint="J",
        supports=supports,
        loads=[bsm.PointLoad(block=b, point=tuple(p), force=tuple(f)) for b, p, f in loads],
        gravity_direction=gravity,
    )
    results = bsm.run(model, bsm.Options(scheme="linear", linear_solver=solver))
    assert results.check().ok
    return model, results.stages[-1]


def reference(kind, degrees):
    polygons, bars, loads, gravity = scene(kind, degrees)
    moments = bsm.Blocks.from_polygons(polygons, rock="r").moments
    total = np.zeros((len(polygons), 3))
    direction = np.array([np.cos(np.radians(gravity)), np.sin(np.radians(gravity))])
    total[:, :2] = GAMMA * moments.area[:, None] * direction
    for block, point, force in loads:
        x, y = point - moments.centroid[block]
        total[block] += (*force, x * force[1] - y * force[0])
    inside = [(b, p + 1e-7 * (moments.centroid[b] - p), a, w) for b, p, a, w in bars]
    return dense_solution(polygons, (KN, KS), total, inside)


@pytest.mark.parametrize("solver", ["auto", "superlu"])
@pytest.mark.parametrize("degrees", [0.0, -TURN])
@pytest.mark.parametrize("kind", ["grid", "bond"])
def test_against_a_dense_solution(kind, degrees, solver):
    _, stage = solved(kind, degrees, solver)
    expected = reference(kind, degrees)
    size = np.abs(expected.displacement).max()
    assert_allclose(stage.displacement, expected.displacement, rtol=0, atol=RTOL * size)
    force = np.abs(expected.reactions).max()
    assert_allclose(stage.reactions, expected.reactions, rtol=0, atol=RTOL * force)
    found = face_forces(stage.contacts)
    assert found.keys() == expected.face_forces.keys()
    for pair, force_on_lower in expected.face_forces.items():
        assert_allclose(found[pair], force_on_lower, rtol=0, atol=RTOL * force)


@pytest.mark.parametrize("kind", ["grid", "bond"])
def test_against_the_model_turned_to_the_level(kind):
    """Bars at 120 and 30 degrees become bars along the axes: nothing else may change."""
    (_, inclined), (_, level) = solved(kind, 0.0), solved(kind, -TURN)
    size = np.abs(level.displacement).max()
    assert_allclose(turned(inclined.displacement[:, :2], -TURN), level.displacement[:, :2], rtol=0, atol=RTOL * size)
    assert_allclose(inclined.displacement[:, 2], level.displacement[:, 2], rtol=0, atol=RTOL * size)
    force = np.abs(level.reactions).max()
    found, expected = face_forces(inclined.contacts), face_forces(level.contacts)  # the order of contacts is free
    for pair in expected:
        assert_allclose(turned(found[pair], -TURN), expected[pair], rtol=0, atol=RTOL * force)
    assert_allclose(np.sort(inclined.contacts.normal_force), np.sort(level.contacts.normal_force), atol=RTOL * force)
    assert_allclose(np.sort(inclined.contacts.shear_force), np.sort(level.contacts.shear_force), atol=RTOL * force)
    assert_allclose(turned(inclined.reactions[:, :2], -TURN), level.reactions[:, :2], rtol=0, atol=RTOL * force)
    turn = turned(np.eye(2), TURN).T
    assert_allclose(inclined.stress, turn @ level.stress @ turn.T, rtol=0, atol=RTOL * np.abs(level.stress).max())


@pytest.mark.parametrize("kind", ["grid", "bond"])
def test_bars_reach_their_displacements_and_bear_along_themselves(kind):
    model, stage = solved(kind, 0.0)
    _, bars, _, _ = scene(kind, 0.0)
    centroid = model.blocks.moments.centroid
    size = np.abs(stage.displacement).max()
    for block, point, angle, displacement in bars:
        x, y = point - centroid[block]
        u, v, theta = stage.displacement[block]
        along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        assert_allclose((u - theta * y, v + theta * x) @ along, displacement, rtol=0, atol=1e-6 * size)
    supports = stage.supports
    for block in np.unique(supports.block):
        own = supports.block == block
        arm, force = supports.point[own] - centroid[block], supports.reaction[own]
        moment = (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0] + supports.moment[own]).sum()
        assert_allclose((*force.sum(axis=0), moment), stage.reactions[block], rtol=1e-9, atol=1e-9 * 1e6)


def test_a_normal_roller_on_the_incline_is_that_bar():
    """`NormalRoller` on the turned lower side equals rollers at 120 degrees at both ends of its edges."""
    polygons = [turned(p, TURN) for p in grid(3, 3)]
    out = turned(np.array([(0.0, -1.0)]), TURN)[0]
    blocks = bsm.Blocks.from_polygons(polygons, rock="r").with_boundary(
        "bottom", lambda x, y: x * out[0] + y * out[1] > -1e-9
    )
    given = {
        "blocks": blocks,
        "rocks": [bsm.Rock("r", unit_weight=GAMMA)],
        "joints": [bsm.Joint("J", KN, KS)],
        "default_joint": "J",
    }
    stop = bsm.Roller(blocks=[0], direction=TURN)
    one = bsm.run(bsm.Model(**given, supports=[bsm.NormalRoller(boundary="bottom"), stop]), LINEAR).stages[-1]
    rollers = bsm.Roller(boundary="bottom", direction=TURN + 90)
    other = bsm.run(bsm.Model(**given, supports=[rollers, stop]), LINEAR).stages[-1]
    assert_allclose(one.displacement, other.displacement, rtol=0, atol=RTOL * np.abs(other.displacement).max())
    normal = one.reactions[1:3, :2] / np.hypot(*one.reactions[1:3, :2].T)[:, None]
    assert_allclose(normal, [-out, -out], atol=1e-9)
