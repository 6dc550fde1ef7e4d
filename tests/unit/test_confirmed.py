"""A stage that a scheme calls stable is so only where the independent check finds nothing against it."""

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.continuation.scheme import ContinuationScheme
from bsm_mesh.solve.linear.scheme import LinearScheme
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, running_bond

SCHEMES = {"linear": LinearScheme, "continuation": ContinuationScheme, "wang": ContinuationScheme}
OUT_OF_BALANCE = "is out of balance by"


def wall(**given):
    blocks = bsm.Blocks.from_polygons([rectangle(-1, -1, 4, 0), *running_bond(4, 3)], rock="r")
    joint = bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=35.0))
    return model_of(blocks, joint=joint, gravity_direction=-95.0, **given)


def tampered(monkeypatch, scheme, change, when=lambda part, number: True):
    """Let a scheme's outcome be changed behind its back: `change` gets the stage as it was solved."""
    kind = SCHEMES[scheme]
    solve = kind.solve

    def tamper(self, part, number, *given):
        outcome = solve(self, part, number, *given)
        return replace(outcome, stage=change(outcome.stage)) if when(part, number) else outcome

    monkeypatch.setattr(kind, "solve", tamper)


def pressed_too_much(stage):
    """Add ten thousandths of its reference weight to a pressure."""
    force = stage.contacts.normal_force.copy()
    force[np.argmin(force)] -= 1e-5 * stage.reference_weight
    return replace(stage, contacts=replace(stage.contacts, normal_force=force))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_forces_out_of_balance(monkeypatch, scheme):
    options = bsm.Options(scheme=scheme)
    assert bsm.run(wall(), options).status.is_at_rest
    tampered(monkeypatch, scheme, pressed_too_much)
    results = bsm.run(wall(), options)
    assert results.status == "not_converged"
    assert OUT_OF_BALANCE in results.stages[-1].reason
    assert not results.check().ok


def test_shear_beyond_strength(monkeypatch):
    def used(stage):
        return replace(stage, contacts=replace(stage.contacts, utilisation=1.01 + 0 * stage.contacts.utilisation))

    tampered(monkeypatch, "continuation", used)
    stage = bsm.run(wall()).stages[-1]
    assert stage.status == "not_converged"
    assert "carries 1.01 times its shear strength" in stage.reason


def test_blocks_inside_each_other(monkeypatch):
    """A block turned about its centroid: forces and their moments are as they were."""
    kind = ContinuationScheme
    solve = kind.solve

    def turned(self, *given):
        outcome = solve(self, *given)
        self.moved[-1, 2] += 0.3
        return outcome

    monkeypatch.setattr(kind, "solve", turned)
    stage = bsm.run(wall()).stages[-1]
    assert stage.status == "not_converged"
    assert "passed into each other" in stage.reason
    assert "most blocks" in stage.reason


def test_reactions_that_do_not_bear_the_loads(monkeypatch):
    def unheld(stage):
        return replace(stage, reactions=0.5 * stage.reactions)

    tampered(monkeypatch, "continuation", unheld)
    stage = bsm.run(wall()).stages[-1]
    assert stage.status == "not_converged"
    assert "loads and reactions differ" in stage.reason


def test_a_run_ends_at_the_stage_that_is_not_confirmed(monkeypatch):
    """Within its first part of the release, before the second is tried."""
    stages = [bsm.Stage(name="a", excavate=[12], relaxation=[0.5, 1.0]), bsm.Stage(name="b", excavate=[11])]
    assert bsm.run(wall(stages=stages)).status == "stable"
    asked = []

    def once(part, number):
        asked.append(number)
        return number == 1

    tampered(monkeypatch, "continuation", pressed_too_much, once)
    results = bsm.run(wall(stages=stages))
    assert [stage.status for stage in results.stages] == ["stable", "not_converged"]
    assert asked == [0, 1]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
def test_it_is_held_to_the_tolerance_that_is_asked_for(monkeypatch, tolerance):
    options = bsm.Options(tolerance=tolerance)
    results = bsm.run(wall(), options)
    assert results.status == "stable"
    assert results.check().tolerance == tolerance
    tampered(monkeypatch, "continuation", pressed_too_much)
    assert bsm.run(wall(), options).status == ("stable" if tolerance > 1e-5 else "not_converged")


def test_a_block_on_an_inclined_roller_is_measured_as_the_check_does():
    """Out of balance along the roller and about it: the greatest of x, y and moment, not of the roller's axes."""
    square = rectangle(0, 0, 1, 1)
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([square, rectangle(1, 0, 2, 1)], rock="r"),
        rocks=[bsm.Rock("r", unit_weight=25e3)],
        joints=[bsm.Joint("J", 1e9, 1e9)],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0]), bsm.Roller(point=(2.0, 0.0), direction=37.0)],
    )
    stage = bsm.run(model).stages[-1]
    check = bsm.run(model).check()
    assert stage.status == "stable"
    np.testing.assert_allclose(check.block_residual, stage.residual, rtol=1e-3, atol=1e-13)
