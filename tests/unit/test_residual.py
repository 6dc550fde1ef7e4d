"""Limit analysis counts peak strength; which joints and rocks have less after slip, and where it is said."""

from dataclasses import replace

import pytest

import bsm_mesh as bsm
from bsm_mesh.model.residual import residual_note
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import JOINT, MODEL, Case

GROUND = [rectangle(-5, -1, 5, 0), rectangle(-1, 0, 1, 1)]
SAYS = "limit analysis counts peak strength everywhere. A run follows the residual strength that slip leaves ("
LAWS = [
    (bsm.MohrCoulomb(friction=35, cohesion=1e4), False),
    (bsm.MohrCoulomb(friction=35, residual_friction=25), True),
    (bsm.MohrCoulomb(friction=35, cohesion=1e4, residual_cohesion=0.0), True),
    (bsm.MohrCoulomb(friction=35, residual_friction=25, softening_slip=0.01), True),
    (bsm.Patton(friction=30), False),
    (bsm.Patton(friction=30, dilation=10, cohesion=1e5), True),
    (bsm.BartonBandis(jrc=8, jcs=50e6, residual_friction=25), False),
    (bsm.BartonBandis(jrc=8, jcs=50e6, residual_friction=25, roughness_wears=True), True),
]


@pytest.mark.parametrize(("law", "loses"), LAWS)
def test_joints_that_slip_weakens_are_named(law, loses):
    note = residual_note(model_of(GROUND, law=law))
    assert note == (f"{SAYS}joint 'J'): its factor of safety may be lower" if loses else "")


def test_tension_counts_where_slip_takes_it_away():
    model = model_of(GROUND)
    kept = replace(model.joints[0], tensile_strength=1e4)
    assert residual_note(model.replace(joints=[kept])) == ""
    brittle = bsm.MohrCoulomb(friction=35, cohesion=1e4, residual_cohesion=1e4)
    lost = replace(kept, law=brittle)
    assert "joint 'J'" in residual_note(model.replace(joints=[lost]))
    assert residual_note(model.replace(joints=[replace(lost, residual_tensile_strength=1e4)])) == ""
    rock = bsm.Rock("rock", unit_weight=25e3, friction=40, residual_friction=30)
    assert "(rock 'rock')" in residual_note(model.replace(rocks=[rock]))


@pytest.mark.parametrize("law", [LAWS[0][0], pytest.param(LAWS[1][0], marks=pytest.mark.heavy)])
def test_safety_says_so_where_the_factor_is_below_the_bound(law):
    """On a plane of 30 degrees a block that has slipped has tan(25) / tan(30); the bound is tan(35) / tan(30)."""
    found = bsm.factor_of_safety(model_of(GROUND, law=law, gravity_direction=-120))
    told = [note for note in found.notes if note.startswith(SAYS)]
    assert len(told) == (found.stable < 0.99 * found.limit.factor)
    assert bool(told) is (law is LAWS[1][0])


def test_the_command_limit_says_so(case: Case):
    case.write("model.toml", MODEL.replace(JOINT, JOINT + 'law = "mohr_coulomb"\nresidual_friction = 20\n'))
    assert SAYS in case.run("limit", "model.toml").err
    case.write("model.toml", MODEL)
    assert SAYS not in case.run("limit", "model.toml").err
