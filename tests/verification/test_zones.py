"""Zones against closed forms: patch tests, jointed continua, a slipping crack, Jaeger, Kirsch, a beam, a disc."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.kirsch import error_near, model_of, plate

E, NU = 50e9, 0.25
PATCH = 1e-10  # of the stress: rounding of a few thousand unknowns, with E over stress of 5e4
EXACT = 1e-6  # what a closed form that holds for any mesh is held to


def rectangle(x0, y0, x1, y1):
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)


def turned(points, degrees):
    c, s = cos(radians(degrees)), sin(radians(degrees))
    return np.asarray(points) @ np.array([(c, s), (-s, c)])


def rock(name="rock", *, size=None, order=2, young=E, poisson=NU, **given):
    return bsm.Rock(
        name, unit_weight=0.0, young=young, poisson=poisson, zones=bsm.Zones(size=size, order=order), **given
    )


def joint(kn=10e9, ks=5e9, **given):
    return bsm.Joint("J", normal_stiffness=kn, shear_stiffness=ks, **given)


SIDES = {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)}


def box(polygons, names="rock", degrees=0.0):
    """Return blocks that fill a rectangle from the origin, turned about it, with its four sides as boundaries."""
    high = np.max([np.max(polygon, axis=0) for polygon in polygons], axis=0)
    blocks = bsm.Blocks.from_polygons([turned(polygon, degrees) for polygon in polygons], rock=names)
    for name, (axis, end) in SIDES.items():
        blocks = blocks.with_boundary(
            name,
            lambda x, y, axis=axis, end=end: (
                np.abs(turned(np.column_stack([x, y]), -degrees)[:, axis] - end * high[axis]) < 1e-9
            ),
        )
    return blocks


def tractions(blocks, stress):
    """Return the loads of a uniform stress on the four sides."""
    found = []
    for name in SIDES:
        along = blocks.edge_vectors[blocks.boundaries[name]]
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        found.append(bsm.EdgeTractions(boundary=name, values=np.repeat((normal @ stress)[:, None, :], 2, axis=1)))
    return found


def under_stress(polygons, stress, rocks, *, names="rock", degrees=0.0, **given):
    """Return a rectangle under the tractions of a uniform stress, its lower corners held, both turned."""
    blocks = box(polygons, names, degrees)
    far = turned((np.max([np.max(polygon, axis=0)[0] for polygon in polygons]), 0.0), degrees)
    held = [bsm.Roller(point=(0.0, 0.0), direction=degrees + angle) for angle in (0, 90)]
    turn = turned(np.eye(2), degrees)
    return bsm.Model(
        blocks=blocks,
        rocks=rocks,
        supports=[*held, bsm.Roller(point=tuple(far.tolist()), direction=degrees + 90)],
        loads=tractions(blocks, turn.T @ stress @ turn),
        **given,
    )


def solved(model):
    """Return the last stage of a model, which is in equilibrium and checked."""
    results = bsm.run(model)
    assert results.status == "stable", results.stages[-1].reason
    assert results.check().ok
    return results.stages[-1]


def assert_uniform(stage, stress, degrees=0.0):
    turn = turned(np.eye(2), degrees)
    for found in (stage.zones.stress, stage.stress):
        wanted = np.broadcast_to(turn.T @ stress @ turn, found.shape)
        assert_allclose(found, wanted, atol=PATCH * np.abs(stress).max())


STRESSES = {
    "uniaxial": np.array([(0.0, 0.0), (0.0, -1e6)]),
    "shear": np.array([(0.0, 1e6), (1e6, 0.0)]),
    "all": np.array([(-3e6, 0.7e6), (0.7e6, 1e6)]),
}
BOND = [
    rectangle(0, 0, 2, 1),
    rectangle(2, 0, 5, 1),
    rectangle(0, 1, 1, 2),
    rectangle(1, 1, 3.5, 2),
    rectangle(3.5, 1, 5, 2),
    rectangle(0, 2, 5, 2.7),
]


@pytest.mark.parametrize("degrees", [0.0, 37.0])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", STRESSES)
def test_patch_of_whole_rock(kind, order, degrees):
    """Blocks in bond, whose corners stand on edges of others, and rocks whose zones differ in size."""
    rocks = [rock("rock", size=0.9, order=order), rock("fine", size=0.35, order=order)]
    names = ["rock", "fine", "fine", "rock", "fine", "rock"]
    stage = solved(under_stress(BOND, STRESSES[kind], rocks, names=names, degrees=degrees))
    assert_uniform(stage, STRESSES[kind], degrees)


@pytest.mark.parametrize("degrees", [0.0, 37.0])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", STRESSES)
def test_patch_with_joints(kind, order, degrees):
    grid = [rectangle(2 * i, j, 2 * i + 2, j + 1) for j in range(3) for i in range(2)]
    given = {"joints": [joint()], "default_joint": "J"}
    stage = solved(under_stress(grid, STRESSES[kind], [rock(size=0.7, order=order)], degrees=degrees, **given))
    assert_uniform(stage, STRESSES[kind], degrees)


def test_patch_of_a_bond_with_joints():
    """Under a vertical load joints of a bond, whose corners meet edges, let the stress be uniform."""
    given = {"joints": [joint()], "default_joint": "J"}
    stage = solved(under_stress(BOND, STRESSES["uniaxial"], [rock(size=0.5, poisson=0.0)], **given))
    assert_uniform(stage, STRESSES["uniaxial"])


GRID = [rectangle(2 * i, 2 * j, 2 * i + 2, 2 * j + 2) for j in range(4) for i in range(4)]


def test_modulus_of_a_jointed_rock():
    """1/Em = 1/Er + 1/(kn s): 14.2857 GPa (UDEC manual, equivalent continuum)."""
    stage = solved(under_stress(GRID, STRESSES["uniaxial"], [rock(poisson=0.0)], joints=[joint()], default_joint="J"))
    strain = (stage.displacement[12, 1] - stage.displacement[4, 1]) / 4
    assert_allclose(-1e6 / strain, 1 / (1 / E + 1 / (10e9 * 2)), rtol=EXACT)
    assert_allclose(1 / (1 / E + 1 / (10e9 * 2)) / 1e9, 14.2857, atol=5e-5)


def test_shear_modulus_of_a_jointed_rock():
    """1/Gm = 1/Gr + 1/(ks s): 6.66667 GPa (UDEC manual, equivalent continuum)."""
    slabs = [rectangle(0, 2 * j, 8, 2 * j + 2) for j in range(4)]
    stage = solved(
        under_stress(slabs, STRESSES["shear"], [rock(young=40e9, poisson=0.0)], joints=[joint()], default_joint="J")
    )
    sideways = (stage.displacement[2, 0] - stage.displacement[1, 0]) / 2
    low = stage.zones.points[:, 1] < 1e-9
    upwards = np.polyfit(stage.zones.points[low, 0], stage.zones.displacement[low, 1], 1)[0]
    assert_allclose(1e6 / (sideways + upwards) / 1e9, 1 / (1 / 20 + 1 / (5 * 2)), rtol=EXACT)
    assert_allclose(1 / (1 / 20 + 1 / (5 * 2)), 6.66667, atol=5e-6)


def test_poisson_effect():
    """Horizontal over vertical stress between rigid sides: 1/9 (UDEC manual 3.3); of rigid blocks it is zero."""
    blocks = box(GRID)
    model = bsm.Model(
        blocks=blocks,
        rocks=[rock()],
        joints=[joint()],
        default_joint="J",
        supports=[bsm.NormalRoller(boundary=side) for side in ("left", "right", "bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=1e6)],
    )
    mean = solved(model).stress.mean(axis=0)
    c1, c2, joints = (1 - NU**2) / E, NU * (1 + NU) / E, 3 / 8 / 10e9
    assert_allclose(mean[0, 0] / mean[1, 1], c2 / (c1 + joints), rtol=EXACT)
    assert_allclose(c2 / (c1 + joints), 1 / 9)


def test_slipping_crack():
    """A crack that slips over part of an inclined joint: 37.8511, 38.8934, 37.0526 GN/m (UDEC verification).

    The closed form has uniform stress in the rock, in series with the joint: here an elastic column under rigid halves.
    """
    modulus, k, phi, width, height, length, slips = 88.9e9, 220e9, radians(16), 1.0, 2.0, sqrt(2), 0.54
    stick = 1 / (height / (width * modulus) + 1 / (k * length))

    def sliding(sign):
        more = slips * sin(pi / 4) * sin(pi / 4 + sign * phi) / (length * (length - slips) * cos(phi) * k)
        return 1 / (1 / stick + more)

    assert_allclose(np.array([sliding(-1), stick, sliding(1)]) / 1e9, [37.8511, 38.8934, 37.0526], atol=5e-5)
    s = (length - slips) / 2 / length
    a, b = (s, 2 + s), (1 - s, 3 - s)
    base = [(0, 0), (1, 0), (1, 2), (0, 2)]
    lower, upper = [(0, 2), (1, 2), (1, 3), b, a], [(0, 2), a, b, (1, 3), (0, 3)]
    blocks = bsm.Blocks.from_polygons([base, lower, upper], rock=["rock", "rigid", "rigid"])
    blocks = blocks.with_joint("firm", lambda x, y: np.abs(y - x - 2) < 1e-9)
    crack = lambda x, y: (np.abs(y - x - 2) < 1e-9) & (x > s - 1e-9) & (x < 1 - s + 1e-9)  # noqa: E731
    blocks = blocks.with_joint("crack", crack)
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9).with_boundary("top", lambda x, y: y > 3 - 1e-9)
    steps = [4e6, 4e6, -0.05e6, -3e6, -1e6, -1e6]
    model = bsm.Model(
        blocks=blocks,
        rocks=[rock(young=modulus, poisson=0.0), rock("rigid", young=2e15, poisson=0.0)],
        joints=[
            bsm.Joint("crack", k, k, law=bsm.MohrCoulomb(friction=16)),
            bsm.Joint("firm", k, k),
        ],
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=1e5)],
        stages=[bsm.Stage(name=f"{n}", loads=[bsm.Pressure(boundary="top", pressure=p)]) for n, p in enumerate(steps)],
    )
    results = bsm.run(model)
    assert results.status == "stable"
    force = np.cumsum([1e5, *steps])
    down = np.array([-stage.displacement[2, 1] for stage in results.stages])
    slope = np.diff(force) / np.diff(down)
    assert_allclose(slope[[1, 2, 5]], [sliding(-1), stick, sliding(1)], rtol=1e-4)


@pytest.mark.parametrize("size", [None, 0.6, 0.3])
@pytest.mark.parametrize("angle", [50, 60, 70])
def test_strength_of_a_specimen_with_a_joint(angle, size):
    """Jaeger's peak: sigma_3 + 2 (c + sigma_3 tan phi) / ((1 - tan phi / tan beta) sin 2 beta), within .2 %."""
    c, friction, confined, beta = 1e6, 30.0, 2e6, radians(angle)
    slope = tan(radians(friction))
    peak = confined + 2 * (c + confined * slope) / ((1 - slope / tan(beta)) * sin(2 * beta))
    low, high = 2 - tan(beta) / 2, 2 + tan(beta) / 2
    halves = [[(0, 0), (1, 0), (1, high), (0, low)], [(0, low), (1, high), (1, 4), (0, 4)]]
    blocks = box(halves)

    def loaded(axial):
        return bsm.Model(
            blocks=blocks,
            rocks=[rock(young=20e9, size=size)],
            joints=[joint(1e11, 1e11, law=bsm.MohrCoulomb(friction=friction, cohesion=c))],
            default_joint="J",
            supports=[bsm.Fixed(boundary="bottom")],
            loads=[
                *(bsm.Pressure(boundary=side, pressure=confined) for side in ("left", "right")),
                bsm.Pressure(boundary="top", pressure=axial),
            ],
        )

    assert bsm.run(loaded(0.998 * peak)).status == "stable"
    beyond = bsm.run(loaded(1.002 * peak))
    assert beyond.status == "not_converged"
    assert "zones" in beyond.stages[-1].reason


@pytest.mark.heavy
def test_kirsch_on_quads():
    """496 quads, r < 3a: .2 % of Kirsch's stresses, as block means."""
    corners = plate(16)
    model = model_of(corners, "wang")
    for order, most in ((1, 2e-3), (2, 1e-3)):
        zoned = model.replace(rocks=[rock("rock", order=order)])
        assert error_near(solved(zoned).stress, corners) < most


@pytest.mark.parametrize(("size", "least"), [(1.0, 0.98), (0.5, 0.99)])
def test_cantilever(size, least):
    """A beam of 4 by 1 m: the deflection of its end by bending and shear."""
    load, length, height = 1e5, 4.0, 1.0
    blocks = box([rectangle(0, 0, length, height)])
    model = bsm.Model(
        blocks=blocks,
        rocks=[rock(size=size)],
        supports=[bsm.Fixed(boundary="left")],
        loads=[bsm.Traction(boundary="right", traction=(0.0, load))],
    )
    zones = solved(model).zones
    tip = zones.displacement[zones.points[:, 0] > length - 1e-9, 1].mean()
    inertia, G = height**3 / 12, E / (2 * (1 + NU))
    wanted = load * length**3 / (3 * E / (1 - NU**2) * inertia) + 1.2 * load * length / (G * height)
    assert least < tip / wanted < 1.005


def test_brazilian_disc():
    """Stresses about the middle of a disc: 2 P / (pi D) across, -6 P / (pi D) along the load, within 1.5 %."""
    sides = 72
    angle = 2 * pi * (np.arange(sides) + 0.5) / sides
    corners = np.column_stack([np.cos(angle), np.sin(angle)])
    blocks = bsm.Blocks.from_polygons([corners], rock="rock")
    for name, sign in (("top", 1), ("bottom", -1)):
        blocks = blocks.with_boundary(name, lambda x, y, sign=sign: sign * y > np.cos(pi / sides) - 1e-9)
    load = 1e6
    pressure = load / (2 * np.sin(pi / sides))
    model = bsm.Model(
        blocks=blocks,
        rocks=[rock(size=0.08)],
        supports=[
            bsm.Fixed(point=tuple(corners[0])),
            bsm.Roller(point=tuple(corners[sides // 2 - 1]), direction=90),
        ],
        loads=[bsm.Pressure(boundary=name, pressure=pressure) for name in ("top", "bottom")],
    )
    zones = solved(model).zones
    middle = zones.points[zones.cells[:, :3]].mean(axis=1)
    near = np.hypot(*middle.T) < 0.1
    stress = zones.stress[near].mean(axis=0)
    assert_allclose(stress[0, 0], 2 * load / (pi * 2), rtol=0.015)
    assert_allclose(stress[1, 1], -6 * load / (pi * 2), rtol=0.015)
