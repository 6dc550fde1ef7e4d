"""Earth pressure on walls against Coulomb's wedge, Rankine's circle of stress and printed tables."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize_scalar

import bsm_mesh as bsm
from bsm_mesh.model.loads import point_forces_of
from tests.scenes.models import model_of

RTOL = 1e-9  # closed forms in double precision
SEARCH = 1e-9  # of the wedge's force at its extreme, which a search finds
H, GAMMA, Q = 6.0, 19e3, 12e3


def wall(batter: float, height: float = H, cuts: int = 1, mirrored: bool = False) -> bsm.Blocks:
    """Return a wall with its top at (0, 0) and soil on its right; its back has the batter [degrees]."""
    foot = height * np.tan(np.radians(batter))
    ys = np.linspace(-height, 0, cuts + 1)
    back = [(-y / height * foot, y) for y in ys]  # upwards
    polygon = np.array([(-4.0, -height), *back, (-4.0, 0.0)])
    blocks = bsm.Blocks.from_polygons([polygon * (-1, 1) if mirrored else polygon], rock="concrete")
    sign = -1 if mirrored else 1
    return blocks.with_boundary("back", lambda x, y: np.abs(sign * x + y * foot / height) < 1e-9)


def resultant(blocks: bsm.Blocks, load: bsm.EarthPressure, about: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    forces = point_forces_of([load], blocks)
    arm = forces.point - about
    moment = (arm[:, 0] * forces.force[:, 1] - arm[:, 1] * forces.force[:, 0]).sum()
    return np.array([*forces.force.sum(axis=0), moment])


def soil(**changes: object) -> bsm.EarthPressure:
    given: dict[str, object] = {
        "boundary": "back", "state": "active", "unit_weight": GAMMA, "friction": 34.0, "surface": 0.0
    }  # fmt: skip
    return bsm.EarthPressure(**{**given, **changes})  # type: ignore[arg-type]


def wedge(state: str, phi: float, delta: float, batter: float, slope: float, q: float = 0.0) -> float:
    """Return the extreme force of wedges that slide on the wall and on a plane through its foot: equilibrium alone."""
    p, d, t, b = np.radians([phi, delta, batter, slope])
    sign = 1.0 if state == "active" else -1.0
    foot = np.array([H * np.tan(t), -H])

    def force(plane: float) -> float:
        reach = H * (1 + np.tan(t) * np.tan(b)) / (np.tan(plane) - np.tan(b))  # foot to where the plane daylights
        x = foot[0] + reach
        area = 0.5 * abs(foot[0] * x * np.tan(b) - x * foot[1])
        weight = GAMMA * area + q * x / np.cos(b)
        out = np.array([np.cos(t), np.sin(t)])  # of the wall, into the wedge
        up = np.array([-np.sin(t), np.cos(t)])
        on_wedge = out * np.cos(d) + sign * up * np.sin(d)
        below = plane - sign * p  # the plane's reaction leans by phi from its normal
        reaction = np.array([-np.sin(below), np.cos(below)])
        found: float = np.linalg.solve(np.column_stack([on_wedge, reaction]), [0.0, weight])[0]
        return -sign * found

    low, high = (
        (max(b, 0) + 0.02, np.pi / 2 + t - 0.02)
        if state == "active"
        else (b + 0.02, min(np.pi / 4, np.pi / 2 + t - d - p - 0.02))
    )  # beyond the last it jams
    angles = np.linspace(low, high, 400)
    best = int(np.argmin([force(a) for a in angles]))
    bounds = (angles[max(best - 1, 0)], angles[min(best + 1, len(angles) - 1)])
    return -sign * float(minimize_scalar(force, bounds=bounds, method="bounded", options={"xatol": 1e-10}).fun)


@pytest.mark.parametrize("q", [0.0, Q])
@pytest.mark.parametrize(
    ("state", "phi", "delta", "batter", "slope"),
    [
        ("active", 34, 0, 0, 0),
        ("active", 34, 20, 0, 12),
        ("active", 30, 15, 12, 10),
        ("active", 38, 25, -8, -15),
        ("passive", 30, 0, 0, 0),
        ("passive", 32, 10, 5, 6),
        ("passive", 28, 8, -10, -8),
    ],
)
def test_coulomb_is_the_extreme_wedge(state, phi, delta, batter, slope, q):
    """The resultant is that of the worst wedge, at the wall's friction to its normal."""
    line = [(0.0, 0.0), (10.0, 10 * np.tan(np.radians(slope)))]
    given = soil(state=state, friction=phi, theory="coulomb", wall_friction=delta, surface=line, surcharge=q)
    expected = wedge(state, phi, delta, batter, slope, q)
    fx, fy, _ = resultant(wall(batter, cuts=3), given)
    assert_allclose(np.hypot(fx, fy), expected, rtol=SEARCH)
    turn = np.radians(batter) + np.radians(delta) * (1 if state == "active" else -1)
    assert_allclose([fx, fy], [-expected * np.cos(turn), -expected * np.sin(turn)], rtol=1e-8)
    if q == 0:
        assert_allclose(given.coefficient(batter) * GAMMA * H**2 / 2, expected, rtol=SEARCH)


@pytest.mark.parametrize(
    ("phi", "delta", "printed"),
    [(28, 10, 0.3330), (30, 20, 0.2973), (36, 0, 0.2596)],
)
def test_coulomb_in_print(phi, delta, printed):
    """Das, Principles of Foundation Engineering, table of Ka for a vertical back and level ground."""
    assert_allclose(soil(friction=phi, theory="coulomb", wall_friction=delta).coefficient(), printed, atol=6e-5)


@pytest.mark.parametrize(("delta", "printed"), [(10, 4.143), (15, 4.977), (20, 6.105)])
def test_coulomb_passive_in_print(delta, printed):
    """Das, the table of Kp for a vertical back and level ground, at 30 degrees."""
    given = soil(state="passive", friction=30, theory="coulomb", wall_friction=delta)
    assert_allclose(given.coefficient(), printed, atol=6e-4)


@pytest.mark.parametrize(("phi", "slope", "printed"), [(30, 0, 0.333), (30, 10, 0.350), (36, 20, 0.306)])
def test_rankine_in_print(phi, slope, printed):
    """Das, the table of Rankine's Ka under sloping ground."""
    assert_allclose(soil(friction=phi).coefficient(slope=slope), printed, atol=6e-4)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(("state", "sign"), [("active", 1), ("passive", -1)])
def test_rankine_under_level_ground(state, sign, mirrored):
    """Resultant and moment of K (gamma h + q) with tan^2(45 -+ phi / 2)."""
    K = np.tan(np.radians(45 - sign * 34 / 2)) ** 2
    side = 1 if mirrored else -1
    thrust, turning = K * (GAMMA * H**2 / 2 + Q * H), K * (GAMMA * H**3 / 3 + Q * H**2 / 2)
    found = resultant(wall(0, mirrored=mirrored), soil(state=state, surcharge=Q))
    assert_allclose(found, [side * thrust, 0, side * turning], rtol=RTOL, atol=1e-4)


@pytest.mark.parametrize("batter", [0.0, 15.0, -10.0])
@pytest.mark.parametrize("state", ["active", "passive"])
def test_rankine_under_sloping_ground_touches_the_strength(state, batter):
    """The stress that acts on faces of any inclination is on Mohr's circle that touches the strength."""
    slope, phi = np.radians(14.0), np.radians(34.0)
    line = [(-3.0, -3 * np.tan(slope)), (5.0, 5 * np.tan(slope))]
    given = soil(state=state, surface=line)
    fx, fy, _ = resultant(wall(batter), given)
    t = np.radians(batter)
    length = H / np.cos(t)
    depth = H * (1 + np.tan(t) * np.tan(slope)) / 2
    normal = -(fx * np.cos(t) + fy * np.sin(t)) / length / (GAMMA * depth)
    shear = (fx * np.sin(t) - fy * np.cos(t)) / length / (GAMMA * depth)
    pressed, sheared = np.cos(slope) ** 2, np.cos(slope) * np.sin(slope)  # on planes along the ground
    s = np.roots([np.cos(phi) ** 2, -2 * pressed, pressed**2 + sheared**2])
    centre = min(s) if state == "active" else max(s)
    assert_allclose(np.hypot(normal - centre, shear), centre * np.sin(phi), rtol=RTOL)


def test_cohesion_and_the_depth_of_tension():
    """Bell: K (gamma h + q) - 2 c sqrt(K) below z0, nothing above, with the force and the moment of the triangle."""
    c, K = 15e3, np.tan(np.radians(45 - 34 / 2)) ** 2
    z0 = 2 * c / (GAMMA * np.sqrt(K)) - Q / GAMMA
    thrust = K * GAMMA * (H - z0) ** 2 / 2
    found = resultant(wall(0), soil(cohesion=c, surcharge=Q))
    assert_allclose(found, [-thrust, 0, -thrust * (z0 + 2 * (H - z0) / 3)], rtol=RTOL, atol=1e-6)
    up = np.tan(np.radians(45 + 34 / 2)) ** 2
    thrust = up * GAMMA * H**2 / 2 + 2 * c * np.sqrt(up) * H
    assert_allclose(resultant(wall(0), soil(state="passive", cohesion=c))[0], -thrust, rtol=RTOL)


def test_at_rest():
    """Jaky, with the overconsolidation ratio and the slope of EN 1997-1, 9.5.2, either side of the wall."""
    K0 = (1 - np.sin(np.radians(34))) * np.sqrt(4)
    assert_allclose(resultant(wall(0), soil(state="at_rest", overconsolidation=4))[0], -K0 * GAMMA * H**2 / 2)
    b = np.radians(10.0)
    rising = soil(state="at_rest", surface=[(0, 0), (1, np.tan(b))])
    Kb = (1 - np.sin(np.radians(34))) * (1 + np.sin(b))
    assert_allclose(resultant(wall(0), rising)[:2], -Kb * GAMMA * H**2 / 2 * np.array([np.cos(b), np.sin(b)]))
    falling = soil(state="at_rest", surface=[(-1, np.tan(b)), (0, 0)])  # rises away from a wall with soil on its left
    assert_allclose(resultant(wall(0, mirrored=True), falling)[0], Kb * GAMMA * H**2 / 2 * np.cos(b))


def test_a_surface_within_a_face():
    """Above the surface nothing acts: force and moment are those of the part below, with its surcharge."""
    K = np.tan(np.radians(45 - 34 / 2)) ** 2
    below = H - 1.3
    found = resultant(wall(0), soil(surface=-1.3, surcharge=Q), about=(0.0, -1.3))
    thrust, turning = K * (GAMMA * below**2 / 2 + Q * below), K * (GAMMA * below**3 / 3 + Q * below**2 / 2)
    assert_allclose(found, [-thrust, 0, -turning], rtol=RTOL, atol=1e-6)


def test_faces_of_two_inclinations():
    """Each face takes the coefficient of its plane, produced to the surface."""
    polygon = [(-4, -6), (1, -6), (0.5, -3), (0, 0), (-4, 0)]  # one line of two edges
    kinked = [(-4, -6), (2, -6), (0.5, -3), (0, 0), (-4, 0)]
    forces = []
    for shape in (polygon, kinked):
        blocks = bsm.Blocks.from_polygons([shape], rock="r").with_boundary("back", lambda x, y: x > -0.01)
        load = soil(theory="coulomb", wall_friction=20)
        forces.append(point_forces_of([load], blocks).force)
    lower = np.degrees(np.arctan(1.5 / 3))
    K = soil(theory="coulomb", wall_friction=20).coefficient(lower)
    found = np.hypot(*forces[1][:2].sum(axis=0))
    assert_allclose(found, K * GAMMA * (6**2 - 3**2) / 2, rtol=RTOL)
    assert_allclose(forces[1][2:], forces[0][2:], rtol=RTOL)


@pytest.mark.parametrize(("part", "admissible"), [(0.999, True), (1.001, False)])
def test_a_wall_slides_at_the_height_of_statics(part, admissible):
    """The thrust is the friction of the base, K gamma h^2 / 2 = W tan(base) with W = 26e3 h b."""
    b, base = 2.5, 15.0
    K = np.tan(np.radians(45 - 34 / 2)) ** 2
    height = part * 2 * 26e3 * b * np.tan(np.radians(base)) / (K * GAMMA)
    ground, stem = [(-5, -1), (5, -1), (5, 0), (-5, 0)], [(0, 0), (b, 0), (b, height), (0, height)]
    blocks = bsm.Blocks.from_polygons([ground, stem], rock="r").with_boundary(
        "back", lambda x, y: (np.abs(x - b) < 1e-9) & (y > -1e-9)
    )
    model = model_of(blocks, gamma=26e3, friction=base, kn=1e10, loads=[soil(surface=height)])
    assert bsm.limit_analysis(model).admissible == admissible
