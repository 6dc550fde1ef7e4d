"""A liner of blocks against the closed forms of an elastic ring, and its capacity."""

from __future__ import annotations

import json
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results.liner import Capacity
from tests.scenes.small_case import Case

N, R, T, E, NU, P = 80, 3.0, 0.2, 20e9, 0.2, 1e3
PART = 0.02  # of the greatest moment or thrust: a ring of 80 chords, and shear deformation
LINEAR = bsm.Options(scheme="linear", threads=1)


def ring(blocks: int = N, points: str = "gauss", loads=(), **rock) -> bsm.Model:
    """Return a ring whose first block lies on the x axis, held against rigid movement by its symmetry."""
    turn = 2 * np.pi * (np.arange(blocks + 1) - 0.5) / blocks
    inner, outer = ((R + side * T / 2) * np.stack([np.cos(turn), np.sin(turn)], axis=1) for side in (-1, 1))
    polygons = [[inner[k], outer[k], outer[k + 1], inner[k + 1]] for k in range(blocks)]
    made = bsm.Blocks.from_polygons(polygons, rock="shotcrete")
    made = made.with_boundary("outside", lambda x, y: np.hypot(x, y) > R)
    given = {"unit_weight": 0.0, "young": E, "poisson": NU, "stiffness": "homogeneous", **rock}
    return bsm.Model(
        blocks=made,
        rocks=[bsm.Rock("shotcrete", **given)],
        supports=[
            bsm.Roller(blocks=[0, blocks // 2], direction=90),
            bsm.Roller(blocks=[blocks // 4, 3 * blocks // 4], direction=0),
        ],
        loads=loads,
        contact_points=points,
    )


def squeezed(blocks: int = N) -> list[bsm.PointLoad]:
    """Return two loads that press the ring together along the y axis."""
    return [
        bsm.PointLoad(block=blocks // 4, point=(0, R), force=(0, -P)),
        bsm.PointLoad(block=3 * blocks // 4, point=(0, -R), force=(0, P)),
    ]


@pytest.mark.heavy
@pytest.mark.parametrize("points", ["gauss", "ends"])
def test_thrust_shear_and_moment_of_a_squeezed_ring(points):
    """Timoshenko, Strength of Materials: N = P/2 sin a, V = P/2 cos a, M = P R (1/pi - sin(a)/2), a from the load."""
    results = bsm.run(ring(points=points, loads=squeezed()), LINEAR)
    found = bsm.liner_forces(results, "shotcrete")
    assert len(found.thrust) == N
    assert_allclose(found.thickness, T, rtol=1e-9)
    x, y = np.abs(found.point.T) / np.hypot(*found.point.T)
    assert_allclose(found.thrust, P / 2 * x, atol=PART * P / 2)
    assert_allclose(np.abs(found.shear), P / 2 * y, atol=PART * P / 2)
    # under the load the inner side is pulled, at the sides it is compressed
    assert_allclose(found.moment, -P * R * (1 / np.pi - x / 2), atol=PART * P * R / np.pi)


def test_deflection_of_a_squeezed_ring():
    """The diameter shrinks by P R^3 / (E I) (pi/4 - 2/pi), in plane strain: bending stiffness is that of the beam."""
    stage = bsm.run(ring(loads=squeezed()), LINEAR).stages[-1]
    shrunk = stage.displacement[3 * N // 4, 1] - stage.displacement[N // 4, 1]
    bending = E / (1 - NU**2) * T**3 / 12
    assert_allclose(shrunk, P * R**3 / bending * (np.pi / 4 - 2 / np.pi), rtol=0.02)


def test_a_ring_under_uniform_pressure():
    """N = p R of the outside, no moment."""
    results = bsm.run(ring(loads=[bsm.Pressure(boundary="outside", pressure=1e6)]), LINEAR)
    found = bsm.liner_forces(results, "shotcrete")
    assert_allclose(found.thrust, 1e6 * (R + T / 2), rtol=1e-9)
    assert_allclose(found.moment, 0.0, atol=1e-3 * 1e6 * R * T)


def test_the_same_forces_whichever_way_blocks_are_numbered():
    results = bsm.run(ring(loads=squeezed()), LINEAR)
    first = bsm.liner_forces(results, "shotcrete", "initial")
    a, b = first.block_a, first.block_b
    assert (a < b).all()
    order = np.argsort(np.arctan2(first.point[:, 1], first.point[:, 0]))
    half = N // 2
    assert_allclose(first.moment[order][:half], first.moment[order][half:], rtol=1e-6, atol=1e-6 * P * R)


def test_the_envelope_is_where_the_stress_of_a_side_reaches_a_strength():
    capacity = Capacity(compressive_strength=25e6, tensile_strength=2e6)
    moments, thrusts = capacity.envelope(T)
    results = bsm.run(ring(loads=squeezed()), LINEAR)
    one = bsm.liner_forces(results, "shotcrete")
    for k in range(4):  # corners, and between two of them
        for part in (0.0, 0.37):
            moment, thrust = (v[k] + part * (v[k + 1] - v[k]) for v in (moments, thrusts))
            at = np.full(len(one.thrust), 1.0)
            section = type(one)(
                block_a=one.block_a, block_b=one.block_b, point=one.point, thickness=T * at, thrust=thrust * at,
                shear=one.shear, moment=moment * at,
            )  # fmt: skip
            assert_allclose(section.utilisation(25e6, 2e6), 1.0, rtol=1e-9)


def test_a_liner_after_closure_takes_no_load_until_the_next_change():
    """Rings N = p R, u = N R / (E t): the liner's share of a later pressure; rock has closed by 10 mm before."""
    blocks, young, thick, middle = 32, (20e9, 10e9), (0.2, 0.8), (3.1, 3.6)
    outside, bond, later = 4.0, 1e12, 5e6
    turn = 2 * np.pi * (np.arange(blocks + 1) - 0.5) / blocks
    circles = [r * np.stack([np.cos(turn), np.sin(turn)], axis=1) for r in (3.0, 3.2, outside)]
    polygons = [[i[k], o[k], o[k + 1], i[k + 1]] for i, o in pairwise(circles) for k in range(blocks)]
    made = bsm.Blocks.from_polygons(polygons, rock=["shotcrete"] * blocks + ["rock"] * blocks)
    made = made.with_boundary("outside", lambda x, y: np.hypot(x, y) > 3.9)
    made = made.with_joint("bond", lambda x, y: np.abs(np.hypot(x, y) - 3.2) < 0.1)
    alike = {"unit_weight": 0.0, "poisson": NU, "stiffness": "homogeneous"}
    model = bsm.Model(
        blocks=made,
        rocks=[bsm.Rock(name, young=e, **alike) for name, e in zip(("shotcrete", "rock"), young, strict=True)],
        joints=[bsm.Joint("bond", normal_stiffness=bond, shear_stiffness=bond, law=bsm.MohrCoulomb(friction=30))],
        supports=[
            bsm.Roller(blocks=[blocks, blocks + blocks // 2], direction=90),
            bsm.Roller(blocks=[blocks + blocks // 4, blocks + 3 * blocks // 4], direction=0),
        ],
        loads=[bsm.Pressure(boundary="outside", pressure=6e6)],
        contact_points="gauss",
        stages=[
            bsm.Stage(name="dug", excavate=list(range(blocks))),
            bsm.Stage(name="lined", fill=list(range(blocks))),
            bsm.Stage(name="later", loads=[bsm.Pressure(boundary="outside", pressure=later)]),
        ],
    )
    results = bsm.run(model)
    assert [stage.status for stage in results.stages] == ["stable"] * 4
    assert results.check().ok
    lined, after = (bsm.liner_forces(results, "shotcrete", stage).thrust for stage in results.stages[2:])
    give_liner, give_rock = (r / (e / (1 - NU**2) * t) for r, e, t in zip(middle, young, thick, strict=True))
    give_bond = 1 / bond + sum(t / 2 / (e / (1 - NU**2)) for t, e in zip(thick, young, strict=True))
    share = give_rock / (give_rock + give_liner + give_bond / 3.2)
    assert np.abs(lined).max() < 1e-6 * later * outside
    assert_allclose(after, share * later * outside, rtol=PART)


def test_faults():
    results = bsm.run(ring(16, loads=squeezed(16)), LINEAR)
    with pytest.raises(bsm.ModelError, match="there is no rock 'shotcret'; did you mean 'shotcrete'"):
        bsm.liner_forces(results, "shotcret")
    with pytest.raises(bsm.ModelError, match="compressive_strength = 5 Pa must be"):
        bsm.liner_forces(results, "shotcrete").utilisation(5, 1e6)


@pytest.mark.heavy
def test_the_command(case: Case):
    bsm.run(ring(16, loads=squeezed(16)), LINEAR).save("out")
    strengths = ("--compressive-strength", "25 MPa", "--tensile-strength", "2 kPa")
    outcome = case.run("liner", "out", "--rock", "shotcrete", *strengths)
    assert outcome.code == 0, outcome.err
    assert "the liner is beyond its capacity: greatest utilisation" in outcome.out
    told = json.loads(case.run("liner", "out", "--rock", "shotcrete", *strengths, "--json").out)
    assert told["sections"] == 16
    rows = (case.folder / "out/liner.csv").read_text().splitlines()
    assert rows[0].startswith("block_a,block_b,x [m],y [m],thickness [m],thrust [N/m],shear [N/m],moment [N m/m]")
    assert (case.folder / "out/liner.png").read_bytes().startswith(b"\x89PNG")
    for words, says in (
        (("--rock", "tuff", *strengths), "there is no rock 'tuff'"),
        (("--rock", "shotcrete", *strengths[:2], "--tensile-strength", "2 m"), "--tensile-strength"),
        (("--rock", "shotcrete", *strengths, "--stage", "dug"), "there is no stage 'dug'"),
    ):
        assert case.run("liner", "out", *words).code == 2
        case.refuses("liner", "out", *words, says=[says])
