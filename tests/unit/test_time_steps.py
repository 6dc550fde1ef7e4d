"""Time steps of shaken stages that `bsm-mesh check` expects: those that the run takes."""

import json
import math
import re
from dataclasses import replace

import pytest

import bsm_mesh as bsm
from bsm_mesh.commands.check import check_model
from bsm_mesh.model.options import Options
from bsm_mesh.model.zones import has_zones
from bsm_mesh.results.records import StepRecord
from bsm_mesh.solve.continuation.time_steps import time_steps_of
from bsm_mesh.solve.linear.readiness import make_ready
from bsm_mesh.solve.zones.scheme import zone_time_steps
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.shaking_given import expected_notes, order_of
from tests.scenes.shaken import STAGE, block_on_plane, shaken, wall
from tests.scenes.shaken_zones import PILE, WEIGHT, column, shaken_zones
from tests.scenes.shapes import rectangle, running_bond

SHORT = {"waveform": "sine", "frequency": 10.0, "amplitude": 1.0, "every": 0.02}
EXPLICIT = bsm.Shaking(**SHORT)


def estimates(model):
    expected = zone_time_steps if has_zones(model) else time_steps_of
    return expected(make_ready(model, Options()).model, Options())


def excavated_before():
    """Return a wall in water, beside which a block is excavated before the shaking, with a bolt."""
    polygons = [rectangle(-2, -1, 5, 0), *running_bond(3, 2), rectangle(3, 0, 4, 2)]
    stages = [bsm.Stage(name="pit", excavate=[len(polygons) - 1]), bsm.Stage(name=STAGE, shaking=EXPLICIT)]
    bolt = bsm.Bolt(start=(0.3, 0.9), end=(0.3, -0.8), diameter=0.02, stage="pit")
    water = bsm.Water(table=[(-2, 0.8), (5, 0.8)])
    return shaken(polygons, EXPLICIT, water=water).replace(stages=stages, bolts=[bolt])


MODELS = {
    "explicit": lambda: wall(EXPLICIT, courses=2, bricks=2),
    "dashpots": lambda: wall(bsm.Shaking(**SHORT, contact_damping=0.2), courses=2, bricks=2),
    "part": lambda: wall(bsm.Shaking(**SHORT, time_step=0.1), courses=2, bricks=2),
    "implicit": lambda: block_on_plane(
        bsm.Shaking(**SHORT, integrator="implicit", time_step=0.1, contact_damping=0.1), friction=0.8
    ),
    "excavated before": excavated_before,
    "zones": lambda: shaken_zones(PILE, EXPLICIT, young=1e9, before=[bsm.Stage(name="cut", excavate=[3])]),
    "zones, quiet": lambda: column(0, count=3)[0],
}


@pytest.mark.heavy
@pytest.mark.parametrize("name", MODELS)
def test_the_run_takes_the_time_steps_that_were_expected(name):
    model = MODELS[name]()
    (expected,) = estimates(model)
    found = bsm.run(model).stages[-1].shaking
    assert (expected.stage, expected.steps) == (STAGE, found.cycles)
    assert expected.time_step == pytest.approx(found.time_step, rel=1e-9)
    assert expected.seconds > 0


def test_a_model_at_rest_has_none():
    assert estimates(wall(EXPLICIT, courses=1, bricks=1).replace(stages=[])) == []


def test_check_says_the_time_steps_before_the_run(tmp_path, capsys):
    bsm.run(block_on_plane(EXPLICIT, friction=0.8)).save(tmp_path / "out")
    path = tmp_path / "out" / "model.toml"
    check_model(path, quiet=True)
    told = " ".join(capsys.readouterr().out.split())
    assert f"shaking in stage {STAGE} explicit, about" in told
    assert re.search(rf"base in stage {STAGE} up to [0-9.]+ m/s2 = [0-9.]+ g and", told)  # tells a unit left out
    assert "processor time: less than a minute" in told
    check_model(path, quiet=True, as_json=True)
    (found,) = json.loads(capsys.readouterr().out)["shaking"]
    assert found["integrator"] == "explicit"
    assert found["steps"] * found["time_step"] == pytest.approx(EXPLICIT.length)


def test_time_steps_of_a_record_are_told_every_few_seconds_when_piped(capsys):
    """There are hundreds in a second; static steps have a line each."""
    record = StepRecord(
        stage=1,
        step=0,
        residual=0.0,
        max_displacement=0.0,
        newton_iterations=0,
        factorizations=0,
        open_contacts=0,
        slipping_contacts=0,
        seconds=0.0,
        method="explicit",
        time=0.01,
    )
    with Progress() as progress:
        for step in range(50):
            progress.step(replace(record, step=step))
    assert len(capsys.readouterr().err.splitlines()) <= 1


def test_check_names_the_sliver_that_decides_the_time_step(tmp_path, capsys):
    """A sliver of 2 mm beside blocks of 1 m; a block with a lower number is excavated before the shaking."""
    polygons = [rectangle(-3, -1, 5, 0), rectangle(-3, 0, -2, 1), *(rectangle(x, 0, x + 1, 1) for x in (0, 1.5, 3))]
    polygons.append(rectangle(-1.5, 0, -1.498, 0.002))
    stages = [bsm.Stage(name="pit", excavate=[1]), bsm.Stage(name=STAGE, shaking=EXPLICIT)]
    model = shaken(polygons, EXPLICIT).replace(stages=stages)
    (expected,) = estimates(model)
    assert expected.block == 5
    assert expected.shorter == pytest.approx(math.sqrt(500), rel=1e-6)  # springs over masses: a length over its square
    assert estimates(shaken(polygons[:-1], EXPLICIT))[0].shorter == 1
    bsm.run(model).save(tmp_path / "out")
    check_model(tmp_path / "out" / "model.toml", quiet=True)
    told = " ".join(capsys.readouterr().out.split())
    assert f"note: stage {STAGE}: block 5 at (-1.499, 0.001) m" in told
    assert "22 times shorter" in told
    assert "merge slivers with bsm-mesh check --repair FILE" in told
    assert "set mass_scaling = 10 in [stage.shaking], with 1 block up to 10 times as heavy" in told
    assert "the time step 3.2 times as long" in told
    (given,) = estimates(shaken(polygons, replace(EXPLICIT, mass_scaling=10)))
    assert given.scaling == 1  # no usual factor is left
    assert given.time_step / estimates(shaken(polygons, EXPLICIT))[0].time_step == pytest.approx(10**0.5, rel=0.01)


@pytest.mark.heavy
def test_a_sliver_with_zones_is_named_too():
    """A square of 5 mm on the base of blocks of 1 m: its elements are a hundredth of theirs."""
    (plain,) = estimates(shaken_zones(PILE, EXPLICIT, young=1e9))
    model = shaken_zones([*PILE, rectangle(-1.5, 0, -1.495, 0.005)], EXPLICIT, young=1e9)
    (found,) = estimates(model)
    assert (found.block, found.scaling) == (4, 1.0)
    assert found.shorter > 20 > 5 > plain.shorter
    assert plain.time_step / found.time_step > 20
    (note,) = expected_notes([found], model)
    assert "block 4 at (-1.498, 0.002) m" in note
    assert "mass_scaling" not in note


def test_a_rigid_rock_beside_zones_is_named_with_its_cures():
    """A base without zones that is held at its foot only: its 1e13 Pa decide the time step; held as a whole, not."""
    blocks = bsm.Blocks.from_polygons(PILE, rock=["base", "rock", "rock", "rock"])
    blocks = blocks.with_boundary("foot", lambda x, y: y < -1 + 1e-9)
    zoned = shaken_zones(PILE, EXPLICIT, young=1e9, zones=bsm.Zones(size=1.0))
    rocks = [bsm.Rock("base", unit_weight=WEIGHT), *zoned.rocks]
    model = zoned.replace(blocks=blocks, rocks=rocks, supports=[bsm.Fixed(boundary="foot")])
    (note,) = expected_notes(estimates(model), model)
    assert "block 0 at (0.5, -0.5) m" in note
    assert "its rock 'base' has no zones, so it is nearly rigid; give the rock zones, or hold the whole block" in note
    assert expected_notes(estimates(zoned.replace(blocks=blocks, rocks=rocks)), zoned) == []


def bridged(overlap, **given):
    """Return a block on two others, on the first of them by an overlap [m]; their dashpots are a fifth of critical."""
    polygons = [rectangle(-1, -1, 3, 0), rectangle(0, 0, 1, 1), rectangle(1.5, 0, 2.5, 1)]
    polygons.append(rectangle(1 - overlap, 1, 2.5, 2))
    return shaken(polygons, bsm.Shaking(**SHORT, contact_damping=0.2, **given))


def test_the_dashpot_of_a_short_contact_leaves_the_time_step_alone():
    (long,), (short,) = estimates(bridged(1e-2)), estimates(bridged(1e-6))
    assert short.steps == pytest.approx(long.steps, rel=0.02)


def test_heavier_blocks_make_the_time_step_longer_with_dashpots_too():
    (real,), (heavier,) = estimates(bridged(0.1)), estimates(bridged(0.1, mass_scaling=4))
    assert 2 < heavier.time_step / real.time_step < 4  # the root of the masses by springs, the masses by dashpots


def test_the_order_of_a_time_is_in_words():
    times = (1.0, 100.0, 1000.0, 1e4, 1e6)
    assert [order_of(seconds) for seconds in times] == [
        "less than a minute",
        "minutes",
        "tens of minutes",
        "hours",
        "days",
    ]
