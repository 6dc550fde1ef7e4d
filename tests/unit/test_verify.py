"""The ground of a verdict, from the files of a results folder alone."""

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.app.cli import cli
from bsm_mesh.app.verify import grounds_of
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned


def on_incline(friction, degrees=30.0, **given):
    polygons = [turned(p, degrees) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    return model_of(polygons, friction=friction, **given)


def told(results, folder, *options):
    results.save(folder)
    outcome = CliRunner().invoke(cli, ["verify", str(folder), "--json", *options])
    return json.loads(outcome.stdout), outcome.exit_code


def test_forces_at_rest_are_checked(tmp_path):
    (ground,), code = told(bsm.run(on_incline(35.0)), tmp_path / "out")
    assert (ground["verdict"], ground["kind"], ground["holds"], code) == ("stable", "checked", True, 0)
    assert "forces in 2 contacts balance every block" in ground["text"]


def test_a_slide_is_proved_by_statics(tmp_path):
    (ground,), code = told(bsm.run(on_incline(25.0)), tmp_path / "out")
    assert (ground["verdict"], ground["kind"], code) == ("unstable", "proved", 0)


@pytest.mark.parametrize(("options", "words"), [(("--no-proof",), "no proof was sought"), ((), "first stage alone")])
def test_what_was_followed_is_named_where_nothing_is_proved(tmp_path, options, words):
    stages = [] if options else [bsm.Stage(name="later", excavate=[2])]
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    stop = turned(rectangle(-1.5, 0, -0.5, 0.5), 30.0)
    model = model_of([*polygons, stop], friction=25.0, fixed=(0, 2), stages=stages) if stages else on_incline(25.0)
    grounds, code = told(bsm.run(model), tmp_path / "out", *options)
    assert (grounds[-1]["kind"], code) == ("followed", 0)
    assert "block 1" in grounds[-1]["text"]
    assert words in grounds[-1]["text"]


def test_forces_that_do_not_balance_do_not_hold():
    results = bsm.run(on_incline(35.0))
    (stage,) = results.stages
    heavier = replace(results, stages=(replace(stage, loads=1.001 * stage.loads),))
    (ground,) = grounds_of(heavier, lambda: on_incline(35.0))
    assert not ground.holds
    assert "out of balance" in ground.text


def test_a_verdict_that_there_is_not_has_no_ground():
    results = bsm.run(on_incline(25.0), bsm.Options(max_steps=2))
    (ground,) = grounds_of(results, lambda: on_incline(25.0))
    assert (ground.verdict, ground.kind) == ("not_converged", "none")
    assert "the limit of 2 steps was reached" in ground.text
