"""Polyhedra against closed forms: incline, toppling, wedges, cantilever; arches of the plane as slices of space."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.polyhedra import box, model_in_space, on_incline, prism, rotation, turned
from tests.scenes.rock_3d import WEDGES, wedge_factor, wedge_rock

OPTIONS = bsm.Options(threads=1)
FRICTION = 30.0
FALLS = pytest.mark.heavy  # blocks are followed until they fall: seconds


@pytest.mark.parametrize("azimuth", [0, 20, 45, 70, 200])
def test_a_block_slides_where_the_plane_is_steeper_than_friction(azimuth):
    """To a thousandth of a degree."""
    assert bsm.run(on_incline(FRICTION - 1e-3, azimuth), OPTIONS).status == "stable"


@pytest.mark.slow
@pytest.mark.parametrize("azimuth", [0, 20, 45, 70, 200])
def test_a_block_slides_a_thousandth_of_a_degree_beyond(azimuth):
    results = bsm.run(on_incline(FRICTION + 1e-3, azimuth), OPTIONS)
    assert (results.status, results.unstable_blocks.tolist()) == ("unstable", [1])


@pytest.mark.heavy
def test_a_block_slides_a_tenth_of_a_degree_beyond():
    results = bsm.run(on_incline(FRICTION + 0.1, 20), OPTIONS)
    assert (results.status, results.unstable_blocks.tolist()) == ("unstable", [1])
    assert results.stages[0].proof.text.startswith("inadmissible: no forces within strength balance the loads")


@pytest.mark.parametrize("trend", [70, 160, 250])
@pytest.mark.parametrize(("beyond", "status"), [(0.999, "stable"), pytest.param(1.001, "unstable", marks=FALLS)])
def test_an_earthquake_moves_a_block_on_an_incline(trend, beyond, status):
    """Dip 20 towards 70 degrees, friction 30: down the dip tan(30 - 20) of the weight, up it tan(30 + 20).

    Along the strike the pull is that of both: the root of (tan 30 cos 20)^2 - sin(20)^2.
    """
    friction, dip = np.radians([FRICTION, 20.0])
    limit = {
        70: np.tan(friction - dip),
        160: np.sqrt((np.tan(friction) * np.cos(dip)) ** 2 - np.sin(dip) ** 2),
        250: np.tan(friction + dip),
    }[trend]
    shaken = bsm.Stage(name="shaken", gravity=(beyond * limit, 0.0), gravity_trend=trend)
    stages = bsm.run(on_incline(20.0, 20.0, stages=[shaken]), OPTIONS).stages
    assert [stage.status for stage in stages] == ["stable", status]


def column(height, azimuth, dip):
    """Return a square column on a base of its section, turned about its axis and then dipped."""
    solids = [box((-0.5, -0.5, -1), (0.5, 0.5, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, height))]
    return model_in_space(turned(turned(solids, rotation(azimuth, 0)), rotation(0, dip)), friction=70, kn=1e10, ks=1e10)


@pytest.mark.parametrize(("height", "azimuth"), [(2, 0), (2, 20), (3, 45)])
@pytest.mark.parametrize(("beyond", "status"), [(-0.01, "stable"), pytest.param(0.05, "unstable", marks=FALLS)])
def test_a_column_topples_where_its_weight_leaves_its_base(height, azimuth, beyond, status):
    """Tan dip = b / (h max(cos, sin)): the nearest edge lies nearer than the corners."""
    angle = np.radians(azimuth)
    limit = np.degrees(np.arctan(1 / (height * max(np.cos(angle), np.sin(angle)))))
    assert bsm.run(column(height, azimuth, limit + beyond), OPTIONS).status == status


@pytest.mark.parametrize("name", WEDGES)
@pytest.mark.parametrize(("share", "status"), [(0.999, "stable"), pytest.param(1.001, "unstable", marks=FALLS)])
def test_a_wedge_slides_on_two_planes_as_hoek_and_bray_say(name, share, status):
    """Strength over the factor of limit equilibrium; a thousandth less stands, a thousandth more falls."""
    first, second, face, top, height, friction, cohesion, weight = WEDGES[name]
    blocks, wedge, volume, areas = wedge_rock(first, second, face, top, height)
    factor = share * wedge_factor(first, second, volume, areas, weight, friction, cohesion)
    laws = [
        bsm.MohrCoulomb(friction=np.degrees(np.arctan(np.tan(np.radians(phi)) / factor)), cohesion=c / factor)
        for phi, c in zip(friction, cohesion, strict=True)
    ]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock(blocks.rock_names[0], unit_weight=weight)],
        joints=[
            bsm.Joint(n, normal_stiffness=1e9, shear_stiffness=1e8, law=law) for n, law in zip("AB", laws, strict=True)
        ],
        default_joint="A",
        supports=[bsm.Fixed(blocks=[b for b in range(blocks.count) if b != wedge])],
    )
    assert bsm.run(model, OPTIONS).status == status


def test_a_cantilever_of_cubes_bends_as_its_joints_do():
    """Rotation M / (kn I) in every joint, I = 1/12: centroids beside the corners give the face its own moments."""
    count, kn = 8, 1e9
    blocks = bsm.Polyhedra.from_solids(
        [box((i, 0, 0), (i + 1, 1, 1)) for i in range(count + 1)], rock="granite", joint="J1"
    )
    model = model_of(blocks, gamma=1.0, joint=bsm.Joint("J1", normal_stiffness=kn, shear_stiffness=1e12))
    carried = count + 1 - np.arange(1, count + 1)  # cubes beyond every joint
    exact = (carried**2 / 2 / (kn / 12) * (carried - 0.5) + carried / 1e12).sum()
    assert_allclose(bsm.run(model, OPTIONS).stages[0].displacement[count, 2], -exact, rtol=1e-6)


def arch(count, thickness):
    """Return the voussoirs of a semicircular arch of radius 1 m, and the two springings under it."""
    angle = np.linspace(0, np.pi, count + 1)
    inner, outer = 1 - thickness / 2, 1 + thickness / 2
    rays = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    stones = [
        np.array([inner * rays[i], outer * rays[i], outer * rays[i + 1], inner * rays[i + 1]]) for i in range(count)
    ]
    low = [np.array([(s * inner, -0.2), (s * outer, -0.2), (s * outer, 0), (s * inner, 0)]) for s in (1, -1)]
    return [low[0], *stones, low[1][::-1]]


@pytest.mark.parametrize(
    ("count", "thickness", "status"),
    [(9, 0.2, "stable"), (15, 0.2, "stable"), pytest.param(15, 0.08, "unstable", marks=FALLS)],
)
def test_an_arch_of_the_plane_is_a_slice_of_space(count, thickness, status):
    """Its verdict, and where it is stable its displacements to a thousandth: corners of faces are the ends of edges."""
    polygons = arch(count, thickness)
    fixed = [0, len(polygons) - 1]
    plane = bsm.run(model_of(polygons, friction=40, kn=1e9, gamma=26e3, fixed=fixed), OPTIONS)
    space = bsm.run(
        model_in_space([prism(p) for p in polygons], friction=40, fixed=fixed, contact_points="corners"), OPTIONS
    )
    assert plane.status == space.status == status
    if status == "stable":
        expected = plane.stages[0].displacement[:, :2]
        found = space.stages[0].displacement
        assert_allclose(found[:, [0, 2]], expected, atol=1e-3 * np.abs(expected).max())
        assert_allclose(found[:, 1], 0, atol=1e-9 * np.abs(expected).max())


@pytest.fixture(scope="module")
def two_pillars():
    """Return two pillars with a block on each, on bases that are fixed."""
    return [
        box((0, 0, -1), (1, 1, 0)),
        box((2, 0, -1), (3, 1, 0)),
        box((0, 0, 0), (1, 1, 1)),
        box((2, 0, 0), (3, 1, 1)),
        box((0, 0, 1), (1, 1, 2)),
        box((2, 0, 1), (3, 1, 2)),
    ]


def test_excavation_takes_the_weight_off(two_pillars):
    """In two parts, half of the removed block's weight acting after the first."""
    stage = bsm.Stage(name="upper", excavate=(4,), relaxation=(0.5, 1.0))
    results = bsm.run(model_in_space(two_pillars, fixed=(0, 1), stages=[stage]), OPTIONS)
    first, last = (stage.displacement[:, 2] for stage in results.stages)
    settlement = 26e3 / 1e9
    assert_allclose(first, settlement * np.array([0, 0, -2, -2, -3, -3]), atol=1e-12)
    assert_allclose(last, settlement * np.array([0, 0, -1, -2, 0, -3]), atol=1e-12)
    assert results.check().ok


def test_a_pressure_on_a_boundary_and_on_bare_faces_acts_at_their_centroids(two_pillars):
    """Vertically half a block's weight on top; sideways the wall of an excavation holds what its rock did not."""
    blocks = bsm.Polyhedra.from_solids(two_pillars, rock="granite", joint="J1")
    blocks = blocks.with_boundary("top", lambda x, y, z: z > 2 - 1e-9)
    model = model_in_space(two_pillars, fixed=(0, 1)).replace(
        blocks=blocks,
        loads=[bsm.Pressure(boundary="top", pressure=13e3)],
        stages=[bsm.Stage(name="upper", excavate=(4,), pressure=52e3)],
    )
    initial, last = bsm.run(model, OPTIONS).stages
    assert_allclose(initial.displacement[2:, 2], -np.array([2.5, 2.5, 4, 4]) * 26e-6, atol=1e-12)
    assert_allclose(last.displacement[[2, 3, 5], 2], -np.array([3, 2.5, 4]) * 26e-6, atol=1e-12)


@pytest.mark.parametrize(("on_fall", "status"), [("stop", "unstable"), ("remove", "stable_after_falls")])
def test_what_loses_its_pillar_falls(two_pillars, on_fall, status):
    stage = bsm.Stage(name="pillar", excavate=(3,))
    options = bsm.Options(threads=1, falls=bsm.Falls(on_fall=on_fall))
    results = bsm.run(model_in_space(two_pillars, fixed=(0, 1), stages=[stage]), options)
    fell = results.unstable_blocks.tolist() + [fall.block for fall in results.stages[-1].falls]
    assert (results.status, fell) == (status, [5])


@FALLS
def test_the_factor_of_safety_is_found_by_the_same_search():
    exact = np.tan(np.radians(FRICTION)) / np.tan(np.radians(20))
    found = bsm.factor_of_safety(on_incline(20))
    assert found.factor == pytest.approx(exact, rel=0.005)
