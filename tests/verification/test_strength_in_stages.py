"""Strength that a stage takes away, or gives back, against statics; the history of contacts continues."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.model.in_stage import model_in_stage
from bsm_mesh.results.check import block_residuals
from tests.scenes.models import GAMMA, LINEAR, model_of
from tests.scenes.random_models import jointed_banks
from tests.scenes.shapes import rectangle, turned

CLOSE = 1e-3
ANGLE = 30.0
STEEP = np.tan(np.radians(ANGLE))
FEW = settings(max_examples=10, derandomize=True, deadline=None)


def on_incline(friction, stages, stop=False, **more):
    """Return a block on a plane that falls to the left; a soft, smooth stop below it if asked for."""
    polygons = [rectangle(-9, -2, 9, 0), rectangle(0, 0, 8, 1)]
    if stop:
        polygons.append(rectangle(-1, 0, 0, 2))
    blocks = bsm.Blocks.from_polygons([turned(p, ANGLE) for p in polygons], rock="rock")
    joints = [bsm.Joint("J1", 1e10, 1e10, law=bsm.MohrCoulomb(friction=friction))]
    if stop:
        normal = turned(np.array([(1.0, 0.0)]), ANGLE)[0]
        blocks = blocks.with_joint("stop", lambda x, y: np.abs(x * normal[0] + y * normal[1]) < 1e-9)
        joints.append(bsm.Joint("stop", STOP, STOP, law=bsm.MohrCoulomb(friction=0)))
    settings = {"joints": joints, **more}
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=GAMMA)],
        default_joint="J1",
        supports=[bsm.Fixed(blocks=[0, 2] if stop else [0])],
        stages=stages,
        **settings,
    )


STOP, WEIGHT = 1e8, 8 * GAMMA  # Pa/m, N/m


def weaker(*parts, key="J1"):
    return [bsm.Stage(name=f"part {k}", strength={key: part}) for k, part in enumerate(parts)]


def mobilised(stage):
    """Return the shear force in all contacts over their strength."""
    shear = np.abs(stage.contacts.shear_force)
    return shear.sum() / (shear / stage.contacts.utilisation).sum()


def verdicts(model, **options):
    results = bsm.run(model, bsm.Options(**options))
    return [str(stage.status) for stage in results.stages], results


@pytest.mark.heavy
@pytest.mark.parametrize("key", ["J1", "*"])
@pytest.mark.parametrize("friction", [35.0, 40.0, 60.0])
def test_a_block_slides_where_its_strength_is_below_the_slope(friction, key, tmp_path):
    """At the part tan(a) / tan(phi) of its strength; both verdicts are checked from the files."""
    limit = STEEP / np.tan(np.radians(friction))
    for part, verdict in ((limit * (1 + CLOSE), "stable"), (limit * (1 - CLOSE), "unstable")):
        found, results = verdicts(on_incline(friction, weaker(part, key=key)))
        assert found == ["stable", verdict]
        if verdict == "stable":
            assert results.check().ok
            assert_allclose([mobilised(stage) for stage in results.stages], [limit, limit / part], rtol=1e-6)
        results.save(tmp_path / verdict)
        outcome = CliRunner().invoke(cli, ["verify", str(tmp_path / verdict), "--json"])
        assert outcome.exit_code == 0
        kinds = [ground["kind"] for ground in json.loads(outcome.stdout)]
        assert kinds == ["equilibrium", "equilibrium" if verdict == "stable" else "proved"]


def test_parts_are_of_the_given_strength_and_hold_until_they_are_set_anew():
    limit = STEEP / np.tan(np.radians(40))
    stages = [
        *weaker(1.1 * limit, 1.1 * limit),
        bsm.Stage(name="waits"),
        *[bsm.Stage(name="mended", strength={"J1": 1})],
    ]
    found, results = verdicts(on_incline(40, stages))
    assert found == ["stable"] * 5
    used = [mobilised(stage) for stage in results.stages]
    assert_allclose(used, [limit, 1 / 1.1, 1 / 1.1, 1 / 1.1, limit], rtol=1e-6)


def on_stop(stage):
    contacts = stage.contacts
    return -contacts.normal_force[contacts.joint == 1].sum()


def test_slip_and_forces_stay_when_the_strength_comes_back():
    """The stop carries W (sin a - part tan(phi) cos a) after a slip; friction that comes back takes none of it."""
    slope, part = np.tan(np.radians(40)), 0.5
    found, results = verdicts(on_incline(40, weaker(part, 1.0), stop=True))
    assert found == ["stable"] * 3
    assert results.check().ok
    a = np.radians(ANGLE)
    pushed = WEIGHT * (np.sin(a) - part * slope * np.cos(a))
    force = [on_stop(stage) for stage in results.stages]
    assert force[0] < 1e-3 * WEIGHT
    assert_allclose(force[1:], pushed, rtol=1e-6)
    slip = [np.abs(stage.contacts.slip[stage.contacts.joint == 0]).max() for stage in results.stages]
    assert_allclose(slip[1:], pushed / STOP, rtol=2e-2)
    assert slip[0] < 0.01 * slip[1]


def test_what_has_failed_stays_failed():
    """Brittle friction: the first slip takes it to the residual one, and there it stays when the strength is back."""
    law = bsm.MohrCoulomb(friction=50, residual_friction=28)
    model = on_incline(0, weaker(0.45, 1.0), stop=True)
    joints = [bsm.Joint("J1", 1e10, 1e10, law=law), model.joints[1]]
    sturdy = model.replace(joints=joints)
    found, results = verdicts(sturdy)
    assert found == ["stable"] * 3
    a = np.radians(ANGLE)
    friction = 0.45 * np.tan(np.radians(28)) * np.cos(a)
    force = [on_stop(stage) / WEIGHT for stage in results.stages]
    assert np.sin(a) - friction <= force[1] <= np.sin(a) + friction  # it fell onto the stop
    assert_allclose(force[2], force[1], rtol=1e-6)
    for stage, part in zip(results.stages[1:], (0.45, 1.0), strict=True):
        ground = stage.contacts.joint == 0
        assert stage.evidence.failed[ground].all()
        pressed = ground & (stage.contacts.utilisation > 0)
        strength = np.abs(stage.contacts.shear_force[pressed]) / stage.contacts.utilisation[pressed]
        assert_allclose(strength, -part * np.tan(np.radians(28)) * stage.contacts.normal_force[pressed], rtol=1e-6)


def hanging():
    """Return a block that hangs from the ceiling."""
    return model_of([rectangle(-2, 0, 4, 2), rectangle(0, -2, 2, 0)])


@pytest.mark.parametrize("of_rock", [False, True])
def test_tension_goes_with_the_strength(of_rock):
    """A block of height 2 hangs on a tensile strength of 4 gamma: it falls at the half of it."""
    strength = {"friction": 30.0, "cohesion": 1e6}
    tension = 4 * GAMMA
    for part, verdict in ((0.5 * (1 + CLOSE), "stable"), (0.5 * (1 - CLOSE), "unstable")):
        if of_rock:
            rock = bsm.Rock("rock", GAMMA, young=1e10, poisson=0.2, tensile_strength=tension, **strength)
            model = hanging().replace(rocks=[rock], default_joint=None, stages=weaker(part, key="rock:rock"))
        else:
            joint = bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(**strength), tensile_strength=tension)
            model = hanging().replace(joints=[joint], stages=weaker(part, key="J"))
        assert verdicts(model)[0] == ["stable", verdict]


@pytest.mark.heavy
def test_blocks_that_a_stage_fills_in_have_the_strength_of_the_stage():
    limit = STEEP / np.tan(np.radians(40))
    for part, verdict in ((limit * (1 + CLOSE), "stable"), (limit * (1 - CLOSE), "unstable")):
        stages = [
            bsm.Stage(name="out", excavate=[1], strength={"J1": 0.1}),
            bsm.Stage(name="in", fill=[1], strength={"J1": part}),
        ]
        assert verdicts(on_incline(40, stages))[0] == ["stable", "stable", verdict]


@pytest.mark.heavy
def test_the_thesis_own_iteration_knows_it():
    limit = STEEP / np.tan(np.radians(40))
    assert verdicts(on_incline(40, weaker(1.01 * limit)), scheme="wang")[0] == ["stable", "stable"]
    assert verdicts(on_incline(40, weaker(0.9 * limit)), scheme="wang")[0][1] != "stable"


def test_in_the_linear_scheme_it_shows_in_utilisation_and_a_note():
    model = on_incline(40, weaker(0.5))
    results = bsm.run(model, LINEAR)
    assert [stage.status for stage in results.stages] == ["no_verdict", "no_verdict"]
    used = [stage.contacts.utilisation.max() for stage in results.stages]
    assert_allclose(used[1], 2 * used[0], rtol=1e-9)
    assert any("stage 'part 0': strength changes nothing in this scheme" in note for note in results.stages[0].notes)
    assert any("beyond their strength" in note or "beyond the strength" in note for note in results.stages[1].notes)
    assert_array_equal(results.stages[1].contacts.shear_force, results.stages[0].contacts.shear_force)


@pytest.mark.slow
@FEW
@given(jointed_banks())
def test_the_whole_strength_in_every_stage_changes_no_digit(model):
    push = bsm.Stage(name="push", gravity=(0.05, 0.0))
    wanted = bsm.run(model.replace(stages=[push, bsm.Stage(name="rest", gravity=(0.0, 0.0))]))
    whole = {"J": 1.0}
    stages = [
        bsm.Stage(name="push", gravity=(0.05, 0.0), strength=whole),
        bsm.Stage(name="rest", gravity=(0.0, 0.0), strength={"*": 1.0}),
    ]
    found = bsm.run(model.replace(stages=stages))
    assert [stage.status for stage in found.stages] == [stage.status for stage in wanted.stages]
    for one, other in zip(found.stages, wanted.stages, strict=True):
        assert_array_equal(one.displacement, other.displacement)
        assert_array_equal(block_residuals(found, one), block_residuals(wanted, other))


def test_a_model_in_a_stage():
    stages = [
        bsm.Stage(name="rain", strength={"*": 0.5}),
        bsm.Stage(name="shakes", gravity=(0.1, 0.0), strength={"J1": 0.75}),
        bsm.Stage(name="later"),
    ]
    model = on_incline(45, stages, stop=True)
    model = model.replace(joints=[model.joints[0], bsm.Joint("stop", 1e6, 1e6, law=bsm.MohrCoulomb(friction=45))])
    assert model_in_stage(model, 0) is model
    for number, (one, other, horizontal) in enumerate([(0.5, 0.5, 0), (0.75, 0.5, 0.1), (0.75, 0.5, 0.1)], 1):
        there = model_in_stage(model, number)
        assert_allclose([np.tan(np.radians(joint.law.friction)) for joint in there.joints], [one, other])
        assert (there.gravity_horizontal, there.gravity_vertical) == (horizontal, 0)
