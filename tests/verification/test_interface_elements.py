"""Interface elements of zero thickness in the continuum, against closed forms and against rigid blocks.

Goodman, Taylor & Brekke (1968); Goodman (1989), Introduction to Rock Mechanics, section 6.7: a regularly jointed rock
has 1/E* = 1/E + 1/(Kn s) across its joints and 1/G* = 1/G + 1/(Ks s) along them.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import compare, solve_continuum
from tests.scenes.models import framed
from tests.scenes.shapes import grid, rectangle, running_bond, turned

EXACT = 1e-9  # linear displacements in every piece of rock lie in both element spaces; rounding is lost
E, MU, KN, KS = 8e9, 0.25, 2e9, 0.3e9
SHEAR = E / (2 * (1 + MU))
ROCK = bsm.Rock("rock", unit_weight=0, young=E, poisson=MU)
JOINT = bsm.Joint("J", normal_stiffness=KN, shear_stiffness=KS)
BEDS, WIDTH = [0.0, 1.0, 2.0, 3.5, 4.0], 2.0  # m


def layered(rock=ROCK, angle=0.0, **fields):
    """Return beds with joints between them under a model's other fields, all turned by an angle [degrees]."""
    blocks = framed(bsm.Blocks.from_polygons(grid([0.0, WIDTH], BEDS), rock="rock"), WIDTH, BEDS[-1])
    names = ("offsets", "nodes", "rock", "rock_names", "edge_joint", "boundaries")
    blocks = bsm.Blocks(vertices=turned(blocks.vertices, angle), **{n: getattr(blocks, n) for n in names})
    return bsm.Model(blocks=blocks, rocks=[rock], joints=[JOINT], default_joint="J", **fields)


@pytest.mark.parametrize("order", [1, 2])
def test_joints_in_series(order):
    """Under a pressure on laterally free beds without Poisson effect: E* of the mass, joint by joint."""
    pressure = 3e6
    model = layered(
        bsm.Rock("rock", unit_weight=0, young=E, poisson=0.0),
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=pressure)],
    )
    solution = solve_continuum(model, order=order, joints=True)
    middle = (np.array(BEDS[:-1]) + BEDS[1:]) / 2
    closed = np.arange(len(middle)) / KN
    assert_allclose(solution.displacement[:, 1], -pressure * (middle / E + closed), rtol=EXACT)
    assert_allclose(solution.stress[:, 1, 1], -pressure, rtol=EXACT)


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_modulus_and_shear_of_a_jointed_mass(angle):
    """A uniform stress: the jumps across the joints are t_n/Kn and t_s/Ks in whatever direction they lie."""
    stress = np.array([(-1.0, 0.4), (0.4, -5.0)]) * 1e6
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    R = np.array([(c, -s), (s, c)])
    supports = [bsm.Fixed(point=(0.0, 0.0)), bsm.Roller(point=tuple(R @ (WIDTH, 0.0)), direction=angle + 90)]
    model = layered(angle=angle, supports=supports, loads=[
        bsm.Traction(boundary=side, traction=tuple(R @ stress @ normal))
        for side, normal in (("left", (-1, 0)), ("right", (1, 0)), ("bottom", (0, -1)), ("top", (0, 1)))
    ])  # fmt: skip
    moved = solve_continuum(model, joints=True)
    assert_allclose(moved.stress, np.broadcast_to(R @ stress @ R.T, (4, 2, 2)), rtol=EXACT, atol=EXACT * 5e6)
    u = moved.displacement[:, :2] @ R  # along and across the beds
    plane = (1 + MU) / E * np.array([-1.0e6 * (1 - MU) + 5e6 * MU, -5e6 * (1 - MU) + 1e6 * MU])
    rise = np.diff((np.array(BEDS[:-1]) + BEDS[1:]) / 2)
    assert_allclose(np.diff(u[:, 1]), plane[1] * rise + stress[1, 1] / KN, rtol=1e-8)
    assert_allclose(np.diff(u[:, 0]), stress[0, 1] * (rise / SHEAR + 1 / KS), rtol=1e-8)


def test_regular_spacing_gives_the_equivalent_modulus():
    """1/E* = 1/E + 1/(Kn s) over twenty beds, Goodman (1989)."""
    spacing, count, pressure = 0.5, 20, 1e6
    blocks = framed(
        bsm.Blocks.from_polygons(grid([0.0, 1.0], np.arange(count + 1) * spacing), rock="rock"), 1.0, count * spacing
    )
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0, young=E, poisson=0.0)],
        joints=[JOINT],
        default_joint="J",
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=pressure)],
    )
    v = solve_continuum(model, joints=True).displacement[:, 1]
    strain = (v[-1] - v[0]) / ((count - 1) * spacing)
    assert_allclose(-pressure / strain, 1 / (1 / E + 1 / (KN * spacing)), rtol=EXACT)


@pytest.mark.parametrize("order", [1, 2])
def test_rigid_blocks_move_as_in_the_block_spring_model(order):
    """Rock a million times stiffer than its joints: the blocks' own method, with springs at the Gauss points."""
    blocks = framed(bsm.Blocks.from_polygons(running_bond(6, 4), rock="rock"), 4.0, 3.0)
    given = {
        "joints": [JOINT],
        "default_joint": "J",
        "supports": [bsm.Fixed(boundary="bottom")],
        "loads": [bsm.Pressure(boundary="right", pressure=2e6)],
        "contact_points": "gauss",
    }
    rigid = bsm.Model(blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=26e3)], **given)
    stiff = bsm.Model(blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=26e3, young=1e16, poisson=0.0)], **given)
    ours = bsm.run(rigid, bsm.Options(scheme="linear")).stages[-1].displacement
    theirs = solve_continuum(stiff, order=order, joints=True).displacement
    assert_allclose(theirs, ours, rtol=1e-4, atol=1e-5 * np.abs(ours).max())


def test_rock_without_joints_is_untouched():
    """A joint on one line only: the mesh stays whole elsewhere, and the same as without the option if there is none."""
    blocks = framed(bsm.Blocks.from_polygons(grid(4, 3), rock="rock"), 4.0, 3.0)
    held = {"supports": [bsm.Fixed(boundary="bottom")], "loads": [bsm.Pressure(boundary="top", pressure=1e6)]}
    plain = bsm.Model(blocks=blocks, rocks=[ROCK], **held)
    assert_allclose(
        solve_continuum(plain, joints=True).displacement, solve_continuum(plain).displacement, rtol=1e-12, atol=1e-18
    )
    one = plain.replace(blocks=blocks.with_joint("J", lambda x, y: np.abs(y - 1) < 1e-9), joints=[JOINT])
    whole, opened = solve_continuum(one), solve_continuum(one, joints=True)
    assert len(opened.points) - len(whole.points) == 5 + 2 * 4 - 4  # vertices and middles on the line of four blocks
    assert "are ignored" in whole.notes[0]
    assert "neither slip nor open" in opened.notes[0]


def test_compare_with_joints_is_nearer_than_without():
    """Blocks and continuum of one jointed slab: 1 m squares, joints on all faces."""
    model = bsm.Model(
        blocks=framed(bsm.Blocks.from_polygons([rectangle(0, k, 4, k + 1) for k in range(4)], rock="rock"), 4.0, 4.0),
        rocks=[bsm.Rock("rock", unit_weight=0, young=E, poisson=0.0, stiffness="homogeneous")],
        joints=[JOINT],
        default_joint="J",
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=1e6)],
    )
    results = bsm.run(model, bsm.Options(scheme="linear"))
    without, joined = (compare(model, results, joints=j).displacement_errors[0].l2 for j in (False, True))
    assert without > 0.5
    assert joined < 0.12  # the rest: the lowest half block, whose base is held
