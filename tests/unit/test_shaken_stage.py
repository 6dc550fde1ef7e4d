"""A stage that is shaken: energies, verdicts, times, laws and bolts in it, and how it continues."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.results.spread import spread_text
from bsm_mesh.solve.stages import as_built
from bsm_mesh.solve.zones import departures
from bsm_mesh.text.tables import describe
from tests.scenes.shaken import LAWS as GIVEN_LAWS
from tests.scenes.shaken import STAGE, block_on_plane, quake, shaken, wall
from tests.scenes.shapes import rectangle, running_bond
from tests.unit.test_own_laws import Power

HARD = bsm.Shaking(record=quake(5.0, 2.5), every=0.05)  # half of g
BOLT = {"start": (0.3, -0.5), "end": (0.3, 2.4), "diameter": 0.02}
LAWS = {**GIVEN_LAWS, "own": {"law": Power(a=1.2, b=0.95)}}


def wall_of(name, **given):
    model = wall(HARD, courses=4, bricks=3, **given)
    return model.replace(joints=[bsm.Joint("J", 1e9, 1e9, **LAWS[name])])


@pytest.mark.heavy
@pytest.mark.parametrize("name", LAWS)
def test_energies_balance_under_every_law(name):
    stage = bsm.run(wall_of(name)).stages[-1]
    energy = dict(zip(bsm.results.shaking.ENERGIES, stage.shaking.energy[-1], strict=True))
    assert stage.status == "stable"
    assert stage.shaking.imbalance < 5e-3
    assert energy["slip"] > 0.5 * energy["input"] > 0
    assert_allclose(stage.shaking.slip_energy.sum(), energy["slip"])
    assert stage.shaking.heaviest == pytest.approx(1.0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("bolt", [{}, {"bond_strength": 2e4}, {"kind": "end_anchored", "pretension": 2e4}])
def test_energies_balance_with_bolts(bolt):
    given = {"bolts": [bsm.Bolt(**BOLT, **bolt)]}
    bolted = bsm.run(wall(HARD, courses=5, bricks=1, **given)).stages[-1]
    alone = bsm.run(wall(HARD, courses=5, bricks=1)).stages[-1]
    assert bolted.status == "stable"
    assert bolted.shaking.imbalance < 5e-3
    assert np.abs(bolted.shaking.energy[:, 4]).max() > 0
    assert alone.shaking.energy[-1, 5] != bolted.shaking.energy[-1, 5]


def test_water_and_an_excavated_stage_before():
    polygons = [rectangle(-2, -1, 5, 0), *running_bond(4, 3), rectangle(3, 0, 4, 2)]
    stages = [bsm.Stage(name="pit", excavate=[len(polygons) - 1]), bsm.Stage(name=STAGE, shaking=HARD)]
    model = shaken(polygons, HARD, water=bsm.Water(table=[(-2, 0.8), (5, 0.8)])).replace(stages=stages)
    results = bsm.run(model)
    assert [stage.status.value for stage in results.stages] == ["stable"] * 3
    found = results.stages[-1].shaking
    assert found.imbalance < 5e-3
    assert found.peak_velocity[-1] == 0  # it is gone
    assert results.check().ok


def test_times_of_the_histories_are_those_that_were_asked_for():
    shaking = bsm.Shaking(record=quake(1.0, 2.0), every=0.1, duration=2.3)
    model = block_on_plane(shaking, friction=0.6, histories=[bsm.History(name="b", block=1)])
    results = bsm.run(model)
    steps = [step for step in results.stages[-1].steps if step.time is not None]
    assert_allclose([step.time for step in steps], 0.1 * np.arange(1, 24), rtol=1e-12)
    assert_array_equal(results.stages[-1].shaking.time[1:], [step.time for step in steps])
    assert len(results.histories["b"].values) == sum(len(stage.steps) for stage in results.stages)


def roof(shaking):
    """Return a block that hangs by the tensile strength of its joint, high above a floor, beside one that stands."""
    polygons = [rectangle(-2, 3, 3, 4), rectangle(-2, -3, 5, -2), rectangle(0, 2, 1, 3), rectangle(3.5, -2, 4.5, -1)]
    model = shaken(polygons, shaking, fixed=(0, 1))
    glue = bsm.MohrCoulomb(friction=35, cohesion=1e5)
    return model.replace(joints=[bsm.Joint("J", 1e9, 1e9, law=glue, tensile_strength=35e3)])


UP = bsm.Shaking(record=quake(8.0, 3.0), direction=90.0, every=0.1)


@pytest.mark.heavy
def test_a_roof_block_that_is_shaken_loose_comes_down():
    results = bsm.run(roof(UP))
    stage = results.stages[-1]
    assert results.stages[0].status == "stable"
    assert results.status == "unstable"
    assert stage.unstable_blocks.tolist() == [2]
    assert "s of shaking a block has lost all contact" in stage.reason
    assert "limit analysis is of blocks at rest" in stage.proof.text
    assert stage.shaking.time[-1] < 3.0


@pytest.mark.heavy
def test_the_others_are_shaken_on_without_what_came_down():
    results = bsm.run(roof(UP), bsm.Options(falls=bsm.Falls(on_fall="remove")))
    stage = results.stages[-1]
    assert results.status == "stable_after_falls"
    assert [fall.block for fall in stage.falls] == [2]
    assert stage.shaking.time[-1] == 3.0
    assert_allclose(np.diff(stage.shaking.time), 0.1)


@pytest.mark.heavy
def test_a_block_that_topples_and_then_rests_is_in_the_verdict(tmp_path):
    """Half of its height, less half of its width, is how far its centroid falls."""
    width, height = 0.25, 1.0
    sine = bsm.Shaking(waveform="sine", frequency=1.0, amplitude=6.0, cycles=1, duration=1.2, every=0.2)
    polygons = [rectangle(-3, -1, 4, 0), rectangle(0, 0, width, height)]
    results = bsm.run(shaken(polygons, replace(sine, contact_damping=0.3), friction=35, kn=1e8))
    stage = results.stages[-1]
    assert stage.status == "stable"
    assert_allclose(stage.stage_displacement[1, 1], (width - height) / 2, atol=1e-3)
    said = f"stable, after 1 block moved by {np.hypot(*stage.stage_displacement[1, :2]):.3g} m ("
    assert dict(describe(results))["verdict"].startswith(said)
    assert repr(results).startswith(f"Results: {said}")
    told = json.loads((results.save(tmp_path / "out") / "summary.json").read_text(encoding="utf-8"))
    assert told["stages"][-1]["verdict"].startswith(said)


@pytest.mark.slow
def test_energies_balance_with_dashpots_whatever_the_windows():
    damped = replace(HARD, contact_damping=0.3, mass_damping=(0.05, 2.0))
    found = [bsm.run(wall(replace(damped, every=every))).stages[-1].shaking for every in (0.5, 0.005)]
    for one in found:
        assert one.imbalance < 5e-3
        assert (one.energy[-1, 6:8] > 0).all()
        assert one.heaviest == pytest.approx(1.0, abs=1e-12)
    assert_allclose(found[0].energy[-1, 6], found[1].energy[-1, 6], rtol=0.1)


def test_results_of_a_shaken_stage_come_back_from_their_folder(tmp_path):
    watched = [bsm.History(name="b", block=1)]
    results = bsm.run(block_on_plane(replace(HARD, every=0.25), friction=0.3, histories=watched))
    results.save(tmp_path / "out")
    again = bsm.Results.load(tmp_path / "out")
    one, other = results.stages[-1].shaking, again.stages[-1].shaking
    assert again.stages[0].shaking is None
    for name in ("time", "energy", "peak_velocity", "peak_acceleration", "slip_energy", "heavier", "imbalance"):
        assert_array_equal(getattr(one, name), getattr(other, name))
    assert [step.time for step in results.stages[-1].steps] == [step.time for step in again.stages[-1].steps]
    with (tmp_path / "out" / "time_history.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert_allclose([float(row["time [s]"]) for row in rows], one.time[1:], rtol=1e-12)
    assert_allclose([float(row["base_acceleration [m/s2]"]) for row in rows], one.base_acceleration[1:])
    moved = [step.recorded[0] for step in results.stages[-1].steps if step.time is not None]
    assert_allclose([float(row["b: u [m]"]) for row in rows], moved)
    path = tmp_path / "out" / "energy.csv"
    path.write_text(path.read_text().replace("0.25", "0.26", 1))
    with pytest.raises(bsm.ModelError, match=r"energy\.csv"):
        bsm.Results.load(tmp_path / "out")


@pytest.mark.heavy
def test_blocks_that_slid_far_and_rest_did_not_survive_the_record():
    """A slide of 0.3 block sizes is a verdict of its own, and the note does not contradict it."""
    stage = bsm.run(block_on_plane(replace(HARD, scale=8.0), friction=0.05)).stages[-1]
    assert stage.status.is_stable
    assert not any("survived" in note for note in stage.notes)
    assert any(note.startswith("this record displaced blocks (stable, after 1 block moved") for note in stage.notes)


@pytest.mark.heavy
def test_a_verdict_says_what_it_means():
    stage = bsm.run(block_on_plane(HARD, friction=0.2)).stages[-1]
    assert any("survived this record; that is no factor of safety" in note for note in stage.notes)
    assert not any("mass scaling" in note for note in stage.notes)
    assert any("permanent displacement up to" in note for note in stage.notes)
    record = replace(HARD, record=([0, 1, 2], [0, 1, 1]))
    assert any("no baseline" in note for note in bsm.run(block_on_plane(record, friction=0.5)).stages[-1].notes)


@pytest.mark.heavy
def test_a_record_of_nothing_is_not_survived():
    """Blocks are followed all the same: they move freely from where they are."""
    still = bsm.Shaking(waveform="sine", frequency=2, amplitude=0.0, duration=0.2)
    stage = bsm.run(block_on_plane(still, friction=0.5)).stages[-1]
    assert stage.notes[0].startswith("nothing shook the model: amplitude or scale is 0")
    assert not any("survived" in note for note in stage.notes)


@pytest.mark.heavy
def test_energies_that_do_not_balance_are_no_answer():
    stage = bsm.run(wall(replace(HARD, max_imbalance=1e-9))).stages[-1]
    assert stage.status == "not_converged"
    assert "energy balance of the shaking has an error of" in stage.reason
    assert "give shaking a smaller time_step (now" in stage.reason


@pytest.mark.heavy
def test_masses_are_raised_where_it_is_asked_for_and_told():
    polygons = [*running_bond(2, 2), rectangle(0, 1, 0.1, 1.1)]
    light = [rectangle(-2, -1, 4, 0), *polygons]
    real = bsm.run(shaken(light, HARD)).stages[-1].shaking
    scaled = bsm.run(shaken(light, replace(HARD, mass_scaling=4.0))).stages[-1]
    found = scaled.shaking
    assert real.heaviest == pytest.approx(1.0, abs=1e-12)
    assert not real.heavier.any()
    assert_allclose(found.time_step, 2 * real.time_step, rtol=0.1)
    assert found.heavier[-1]
    assert not found.heavier[0]
    assert 1 < found.heaviest <= 4 + 1e-9
    assert any("were heavier than real for a time" in note for note in scaled.notes)


@pytest.mark.parametrize(
    ("ask", "what"),
    [
        (bsm.factor_of_safety, "a factor of safety is of blocks at rest, and stage 'earthquake' is shaken"),
        (lambda model: bsm.limit_value(lambda _: model, 0.0, 1.0), "the limit of a number is of blocks at rest"),
        (lambda model: as_built.in_stage(model, None), "limit analysis is of blocks at rest"),
        (
            lambda model: departures.refuse(model, True, at_rest=True),
            "the continuum is at rest, and stage 'earthquake' is shaken",
        ),
    ],
)
def test_what_asks_about_blocks_at_rest_refuses_a_shaken_stage(ask, what):
    with pytest.raises(bsm.ModelError, match=what):
        ask(block_on_plane(replace(HARD, duration=0.1, every=0.1), friction=0.6))


@pytest.mark.slow
def test_spread_compares_time_steps_and_the_record_turned_over():
    """A block on a level plane: the record turned over does the same by symmetry.

    A block that sticks again swings on its springs without damping. At 1e9 Pa/m, when it slips next varies by up to
    0.5 % of the displacement, at 1e10 Pa/m by 0.1 %.
    """
    pulse = bsm.Shaking(waveform="sine", frequency=2.0, amplitude=5.0, cycles=1.5, duration=1.5)
    results = bsm.spread(bsm.run(block_on_plane(pulse, friction=0.2)))
    usual, half, quarter, over = results.spread
    assert [end.route for end in results.spread[1:]] == ["time step / 2", "time step / 4", "record turned over"]
    assert {end.status.value for end in results.spread} == {"stable"}
    assert usual.permanent == results.stages[-1].max_stage_displacement > 0.01
    for end in (half, quarter):
        assert_allclose(end.permanent, usual.permanent, rtol=5e-3)
        assert 0 < end.difference < 5e-3 * usual.permanent
    assert_allclose(over.permanent, usual.permanent, rtol=1e-9)
    assert over.difference is None
    assert [end.same_loads for end in results.spread] == [True, True, True, False]
    assert "less than a tenth apart" in spread_text(results.spread)
    wide = (*results.spread[:3], replace(over, permanent=1.2 * usual.permanent))
    assert "a single run is no answer here" in spread_text(wide)


@pytest.mark.heavy
def test_threads_change_no_digit(monkeypatch):
    monkeypatch.setattr("bsm_mesh.solve.motion.threads.AT_ONCE", 20)
    shaking = bsm.Shaking(record=quake(5.0, 0.4), every=0.1)
    found = [bsm.run(wall(shaking), bsm.Options(threads=threads)).stages[-1] for threads in (1, 2)]
    for name in ("displacement", "stress"):
        assert_array_equal(getattr(found[0], name), getattr(found[1], name))
    assert_array_equal(found[0].shaking.energy, found[1].shaking.energy)
    assert_array_equal(found[0].shaking.peak_acceleration, found[1].shaking.peak_acceleration)
