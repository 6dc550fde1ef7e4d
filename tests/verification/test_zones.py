"""Zones against closed forms: patch tests, jointed continua, a slipping crack, Jaeger, Kirsch, a beam, a disc."""

from __future__ import annotations

from dataclasses import replace
from math import radians, sin, tan
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.zones import (
    NU,
    SHEAR,
    UNIAXIAL,
    E,
    box,
    cantilever,
    crack,
    crack_exact,
    disc,
    joint,
    kirsch_error,
    modulus,
    rectangle,
    rock,
    shear_modulus,
    solved,
    stress_ratio,
    turned,
    under_stress,
)

PATCH = 1e-10  # of the stress: rounding of a few thousand unknowns, with E over stress of 5e4
RIGID_LIMIT = 2e-3  # found 2.5e-4, 1.7e-3, 4.4e-4
EXAMPLES = Path(__file__).parents[2] / "examples"
EXACT = 1e-6  # what a closed form that holds for any mesh is held to


def assert_uniform(stage, stress, degrees=0.0):
    turn = turned(np.eye(2), degrees)
    for found in (stage.zones.stress, stage.stress):
        wanted = np.broadcast_to(turn.T @ stress @ turn, found.shape)
        assert_allclose(found, wanted, atol=PATCH * np.abs(stress).max())


STRESSES = {
    "uniaxial": UNIAXIAL,
    "shear": SHEAR,
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
    """Blocks in bond, whose corners are on edges of others, and rocks whose zones differ in size."""
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


def test_modulus_of_a_jointed_rock():
    """1/Em = 1/Er + 1/(kn s): 14.2857 GPa (UDEC manual, equivalent continuum)."""
    for order in (1, 2):
        assert_allclose(modulus(order), 1 / (1 / 50 + 1 / (10 * 2)), rtol=EXACT)


def test_shear_modulus_of_a_jointed_rock():
    """1/Gm = 1/Gr + 1/(ks s): 6.66667 GPa (UDEC manual, equivalent continuum)."""
    for order in (1, 2):
        assert_allclose(shear_modulus(order), 1 / (1 / 20 + 1 / (5 * 2)), rtol=EXACT)


def test_poisson_effect():
    """Horizontal over vertical stress between rigid sides: 1/9 (UDEC manual 3.3); of rigid blocks it is zero."""
    c1, c2, joints = (1 - NU**2) / E, NU * (1 + NU) / E, 3 / 8 / 10e9
    assert_allclose(c2 / (c1 + joints), 1 / 9)
    for order in (1, 2):
        assert_allclose(stress_ratio(order), 1 / 9, rtol=EXACT)


@pytest.mark.heavy
def test_slipping_crack():
    """A crack that slips over part of an inclined joint: 37.8511, 38.8934, 37.0526 GN/m (UDEC verification).

    The closed form has uniform stress in the rock, in series with the joint: here an elastic column under stiff halves.
    """
    assert_allclose(crack_exact(), [37.8511, 38.8934, 37.0526], atol=5e-5)
    assert_allclose(crack(2), crack_exact(), rtol=1e-4)


@pytest.mark.parametrize("size", [None, *(pytest.param(size, marks=pytest.mark.heavy) for size in (0.6, 0.3))])
@pytest.mark.parametrize("angle", [*(pytest.param(angle, marks=pytest.mark.heavy) for angle in (50, 70)), 60])
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
    assert beyond.status == "unstable"
    assert beyond.stages[-1].proof.witness is not None


@pytest.mark.heavy
@pytest.mark.parametrize("order", [1, 2])
def test_kirsch_on_quads(order):
    """496 quads, r < 3a: .2 % of Kirsch's stresses, as block means."""
    assert kirsch_error(order) < 2e-3


@pytest.mark.parametrize(("size", "least"), [(1.0, 0.98), (0.5, 0.99)])
def test_cantilever(size, least):
    """The deflection of the end of a beam of 4 by 1 m by bending and shear."""
    assert least < cantilever(2, size) < 1.005


@pytest.mark.heavy
def test_brazilian_disc():
    """Stresses about the middle of a disc: 2 P / (pi D) across, -6 P / (pi D) along the load, within 1.5 %."""
    assert_allclose(disc(2, 0.08), 1.0, rtol=0.015)


@pytest.mark.slow
def test_rigid_limit():
    """Zones of 1e13 Pa move as rigid blocks do: a tunnel in stages, an arch, a wall.

    Of the tunnel's first stage rigid blocks have corners that slid past a node and press there; zones have none.
    """
    for folder, stages in {"staged_tunnel": (2, 3), "arch": (0,), "tilted_wall": (0,)}.items():
        model = bsm.load(EXAMPLES / folder / "model.toml")
        stiff = [replace(one, young=1e13, poisson=0.0, zones=bsm.Zones(order=1)) for one in model.rocks]
        rigid, zoned = bsm.run(model), bsm.run(model.replace(rocks=stiff))
        for number in stages:
            ours, theirs = (results.stages[number].displacement[:, :2] for results in (zoned, rigid))
            assert zoned.stages[number].status == rigid.stages[number].status == "stable"
            assert np.linalg.norm(ours - theirs) < RIGID_LIMIT * np.linalg.norm(theirs)
