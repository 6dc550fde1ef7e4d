"""The stiffness of what acts on blocks, beside central differences of the forces; blocks that rock on water."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.sparse import bsr_array

import bsm_mesh as bsm
from bsm_mesh.model.face_water import FaceWater
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.steps import begun

EXACT = 1e-7  # of the largest derivative, or of the water's weight on the base: rounding of differences over 2e-6 m
BLOCKS = [
    rectangle(-9, -1, 9, 0),
    np.array([(0.1, 0.2), (2.3, 0.1), (2.1, 1.7), (0.4, 2.2)]),
    np.array([(2.7, 0.3), (5.2, 0.4), (4.1, 3.1)]),
    np.array([(-3.3, 0.5), (-0.4, 0.3), (-0.6, 2.9), (-2.0, 1.1), (-3.1, 3.3)]),  # concave
]
TABLES = {
    "level": {"table": [(0, 1.4)]},
    "covers all": {"table": [(0, 9.0)]},
    "slopes": {"table": [(-9, 2.5), (9, 0.3)]},
    "bends": {"table": [(-5, 3.0), (-1.7, 0.9), (0.9, 1.6), (3.3, 0.4), (6, 2.2)]},
    "parallel": {"table": [(-5, 3.0), (-1.7, 0.9), (0.9, 1.6), (3.3, 0.4), (6, 2.2)], "head": "parallel"},  # jumps
    "two tables": {"table": [[(-9, 1.0), (9, 1.0)], [(-2.2, 2.5), (1.3, 2.0)]]},  # and so does the level
    "joint": {"table": [(0, 1.4)], "joint_pressure": {"J": 3e4}},
}


def stiffness_by_differences(system: BlockSystem, position: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """Return minus the central differences of the loads, (n, 3, 3)."""
    found = np.zeros((len(position), 3, 3))
    for axis in range(3):
        change = np.zeros(3)
        change[axis] = step
        ahead, behind = (system.loads_at(position + sign * change) for sign in (1, -1))
        found[:, :, axis] = -(ahead - behind) / (2 * step)
    return found


def scattered(seed: int, size: float = 0.2) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(len(BLOCKS), 3)) * size


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("seed", range(3))
def test_stiffness_of_water(name, seed):
    """Under tables it is that of a field in space, hence symmetric."""
    polygons = [*BLOCKS, rectangle(2.3 - 1, -3, 4, -1)]  # below the base, on a face with the joint's pressure
    system = BlockSystem(model_of(polygons, water=bsm.Water(**TABLES[name])))
    position = np.vstack([scattered(seed), [(0.01, -0.03, 0.02)]])
    found = system.load_stiffness(position)
    expected = stiffness_by_differences(system, position)
    largest = np.abs(expected).max()
    assert_allclose(found, expected, atol=EXACT * max(largest, 18 * 9810.0))
    if "joint_pressure" not in TABLES[name]:
        assert_allclose(found, found.transpose(0, 2, 1), atol=1e-11 * 9810 * 20)


@pytest.mark.parametrize("seed", range(3))
def test_stiffness_of_the_pressures_of_flow(seed):
    """They stay on their parts of the edges, and turn with them."""
    on_parts = FaceWater(
        edge=np.array([4, 6, 9], np.int32),
        ends=np.array([(0.1, 0.7), (0.0, 1.0), (0.3, 0.4)]),
        pressure=np.array([(2e4, 5e4), (0, 3e4), (1e4, 1e4)], float),
    )
    system = BlockSystem(model_of(BLOCKS).replace(face_water=on_parts))
    position = scattered(seed)
    expected = stiffness_by_differences(system, position)
    assert np.abs(expected).max() > 0
    assert_allclose(system.load_stiffness(position), expected, atol=EXACT * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(3))
def test_stiffness_of_dead_loads(seed):
    """Their points turn with the block: the moment changes by minus the force along its arm."""
    blocks = bsm.Blocks.from_polygons(BLOCKS, rock="rock").with_boundary("top", lambda x, y: y > 1.4)
    loads = [
        bsm.PointLoad(block=1, point=(0.4, 2.2), force=(3e4, -5e4)),
        bsm.Pressure(boundary="top", pressure=(2e4, 1e3, -2e3)),
        bsm.Traction(boundary="top", traction=(1e4, (0, 2e3, 0))),
    ]
    model = model_of(BLOCKS).replace(blocks=blocks, loads=tuple(loads))
    system, position = BlockSystem(model), scattered(seed)
    expected = stiffness_by_differences(system, position)
    assert np.abs(expected[:, 2, 2]).max() > 1e4
    assert_allclose(system.load_stiffness(position), expected, atol=EXACT * np.abs(expected).max())


def test_weights_alone_have_no_stiffness():
    assert BlockSystem(model_of(BLOCKS)).load_stiffness(scattered(0)) is None


@pytest.mark.heavy
def test_still_water_lifts_and_rights_a_floating_block():
    """Of a box b wide at draught d: the waterplane's weight per metre, and by its moment of inertia the metacentre."""
    b, draught, height = 3.0, 0.8, 2.0
    model = model_of([rectangle(0, 0, b, height)], water=bsm.Water(table=[(0, draught)]))
    blocks = model.blocks
    found = WaterLoad(model).stiffness(blocks.vertices, blocks.moments.centroid)[0]
    metacentre = b**2 / (12 * draught) - (height - draught) / 2  # above the centroid
    assert_allclose(found, np.diag([0, 9810 * b, 9810 * b * draught * metacentre]), atol=1e-9 * 9810)


def test_the_tangent_is_the_derivative_of_the_residual():
    """Of all that acts at once: contacts, a bolt, loads and water."""
    polygons = [rectangle(-4, -1, 6, 0), rectangle(0, 0, 2, 3), rectangle(2, 0, 3, 2)]
    model = model_of(
        polygons,
        friction=75.0,
        water=bsm.Water(table=[(-4, 2.6), (0, 2.6), (2, 0.1), (6, 0)]),
        loads=[bsm.PointLoad(block=1, point=(1, 3), force=(2e4, -1e4))],
        bolts=[bsm.Bolt(start=(0.3, 2.0), end=(2.7, 0.5), diameter=0.025, bond_strength=1e5, pretension=2e4)],
    )
    step = begun(model)
    position = step.elastic_position
    position = position + np.array([(0, 0, 0), (2e-5, -1e-5, 3e-6), (-1e-5, -2e-5, 1e-6)])
    found = step.tangent(step.evaluate(position))
    matrix = bsr_array((step.complete(found, position), step.pattern.column, step.pattern.row_start)).toarray()
    expected, width = np.zeros((9, 9)), 1e-8
    for k in range(3, 9):
        change = np.zeros(9)
        change[k] = width
        ends = [position + sign * change.reshape(3, 3) for sign in (1, -1)]
        ahead, behind = (step.residual(at, step.evaluate(at).forces).ravel() for at in ends)
        expected[:, k] = -(ahead - behind) / (2 * width)
    assert_allclose(matrix[3:, 3:], expected[3:, 3:], atol=1e-6 * np.abs(expected).max())


def righting_moment(tilt: float, level: float, width: float, height: float) -> float:
    """Return the moment of weight and water about the toe of a rigid column tilted over it, 10 000 points a side."""
    return righting(np.array([(-width, 0), (0, 0), (0, height), (-width, height)]), tilt, level, width)


def righting(outline: np.ndarray, tilt: float, level: float, width: float) -> float:
    """Return that of any body with its toe at the origin; the table falls from its heel to its toe."""
    corners = outline @ np.array([(np.cos(tilt), -np.sin(tilt)), (np.sin(tilt), np.cos(tilt))])  # clockwise
    x, y = corners.T
    u, v = np.roll(x, -1), np.roll(y, -1)
    moment = 25e3 * -((x + u) * (x * v - u * y)).sum() / 6  # of the area about the y axis
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        t = (np.arange(10_000) + 0.5) / 10_000
        x, y = (start + t[:, None] * (end - start)).T
        depth = np.maximum(np.interp(x, [-width, 0], [level, 0]) - y, 0)
        moment += 9810 * (depth * (x * (end - start)[0] + y * (end - start)[1])).mean()
    return moment


@pytest.mark.parametrize("level", [5.836, 5.85, 5.878])
def test_a_column_that_rocks_on_water_rests_at_its_tilt(level):
    """It leaves its heel at a level of 5.8287 m; then the water presses less the more it tilts, and it rests again."""
    column = rectangle(0, 0, 2, 8)
    model = model_of(
        [rectangle(-4, -1, 6, 0), column],
        friction=75.0,
        kn=1e11,
        water=bsm.Water(table=[(-4, level), (0, level), (2, 0), (6, 0)]),
    )
    stage = bsm.run(model).stages[-1]
    assert stage.status == "stable"
    assert len(stage.steps) < 12
    tilt = brentq(lambda tilt: righting_moment(tilt, level, 2, 8), 0.0, 0.03)
    assert 0.001 < tilt < 0.02
    assert_allclose(-stage.displacement[1, 2], tilt, rtol=3e-3)  # the toe gives way by 4e-6 m


def test_a_tilt_farther_than_contacts_were_searched_for():
    """A dam 12 m high that rests at about 0.1 rad: its middle moves more than contacts are searched for."""
    width, level = 3.8465, 10.4555
    dam = np.array([(-width, 0), (0, 0), (-2.7037, 12.3493), (-3.335, 12.3493)])
    base = rectangle(-30, -2, 30, 0)
    tilts = np.linspace(0, 0.2, 81)
    first = next(k for k, tilt in enumerate(tilts) if righting(dam, tilt, level, width) >= 0)
    assert tilts[first] > 0.09
    water = bsm.Water(table=[(-27, level), (-width, level), (0, 0), (27, 0)])
    stage = bsm.run(model_of([base, dam], friction=78.0, kn=1.25e12, gamma=25e3, water=water)).stages[-1]
    assert stage.status == "stable"
    tilt = brentq(lambda tilt: righting(dam, tilt, level, width), tilts[first - 1], tilts[first])
    assert_allclose(-stage.displacement[1, 2], tilt, rtol=1e-2)


@pytest.mark.heavy
@pytest.mark.parametrize("width", [3.0, 2.5, 2.4, 2.35, 1.5])
def test_a_floating_box_stands_upright_by_its_metacentre(width):
    """Of half the water's weight, 2 m high: upright it rests from a width of sqrt(6) m; narrower it has a list.

    The metacentre is width^2 / 12 - 1/2 above the centroid. Below it the box comes to rest at the angle of loll, whose
    tangent is the root of -2 times that height over width^2 / 12, as long as its deck is dry (Attwood's formula for
    walls that are vertical at the waterline).
    """
    model = model_of(
        [rectangle(-9, -9, 9, -8), rectangle(0, 0, width, 2)],
        gamma=9810 / 2,
        water=bsm.Water(table=[(0, 1.0)]),
    )
    stage = bsm.run(model, bsm.Options(max_steps=100)).stages[-1]
    radius = width**2 / 12  # from the centre of buoyancy to the metacentre
    slope = np.sqrt(max(0.0, 1 - 2 * radius) / radius)
    if slope * width / 2 < 1:
        assert stage.status == "stable"
        assert abs(stage.displacement[1, 2]) == pytest.approx(np.arctan(slope), rel=1e-4, abs=1e-6)
    else:
        assert abs(stage.displacement[1, 2]) > 0.5
