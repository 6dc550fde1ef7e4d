"""Flow in results: files read back as they were, tables, pictures, resumed runs, stages that raise and lower."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.commands.check import check_model
from bsm_mesh.modelfile.model_text import files_of_model
from bsm_mesh.pages.report import write_report
from bsm_mesh.pictures.pictures import figure_of
from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.joint_faces import joint_faces
from bsm_mesh.text.flow_text import flow_rows, how_solved
from tests.scenes.flow_models import bricks, on_two_joints
from tests.scenes.interrupted import interrupted
from tests.scenes.model_folders import content
from tests.scenes.models import LINEAR

DRAIN = bsm.Drain(start=(5, 0.1), end=(5, 2.9))
STAGES = [
    bsm.Stage(name="raised", flow=bsm.FlowChange(head={"left": 8.0})),
    bsm.Stage(name="drained", flow=bsm.FlowChange(drains=(DRAIN,))),
    bsm.Stage(name="lowered", flow=bsm.FlowChange(head={"left": 2.5})),
]


def model():
    return bricks(flow=bsm.Flow(head={"left": 2.5, "right": 1.0}), stages=STAGES)


@pytest.fixture(scope="module", params=["linear", "continuation"])
def results(request):
    return bsm.run(model(), bsm.Options(scheme=request.param))


def test_stages_raise_drain_and_lower(results):
    start, raised, drained, lowered = (stage.flow for stage in results.stages)
    assert raised.through > 2 * start.through
    assert drained.leaving[drained.places.index("drain 1")] > 0
    assert drained.head.mean() < raised.head.mean()
    assert lowered.through < drained.through
    for flow in (start, raised, drained, lowered):
        assert flow.imbalance <= 1e-12
        assert abs(flow.leaving.sum()) <= 1e-12 * flow.through
        assert flow.change <= 1e-4
        assert flow.rounds >= 1


def test_water_opens_joints_that_it_presses_on(results):
    """Raised water lifts effective stress off the joints near it, and they open."""
    start, raised = results.stages[0].flow, results.stages[1].flow
    assert raised.aperture.mean() > start.aperture.mean()
    assert (raised.aperture >= 0.05e-3).all()


def test_results_are_read_back_as_they_were(results, tmp_path):
    again = bsm.Results.load(results.save(tmp_path / "out"))
    for stage, read in zip(results.stages, again.stages, strict=True):
        before, after = stage.flow, read.flow
        for name in FlowResult.__slots__:
            np.testing.assert_array_equal(getattr(before, name), getattr(after, name), err_msg=name)


def test_joints_that_are_dug_away_leave_no_nodes(tmp_path):
    """Nor numbers that are none where results are read back."""
    dug = bsm.Stage(name="dug", excavate=[1, 5, 9])
    flow = bsm.Flow(head={"left": 2.5, "right": 1.0}, coupling="one_way")
    results = bsm.run(bricks(flow=flow, stages=[dug]), LINEAR)
    again = bsm.Results.load(results.save(tmp_path / "out"))
    before, after = (one.stages[-1].flow for one in (results, again))
    assert len(before.point) == len(np.unique([before.first, before.last]))
    for name in ("point", "head", "place", "outflow"):
        np.testing.assert_array_equal(getattr(before, name), getattr(after, name), err_msg=name)


@pytest.mark.parametrize(("imbalance", "told"), [(2e-42, "to rounding"), (0.0, "to rounding"), (3e-13, "to 3e-13 of")])
def test_no_balance_is_told_finer_than_rounding(results, imbalance, told):
    assert f"the water of every node balances {told}" in how_solved(
        replace(results.stages[0].flow, imbalance=imbalance)
    )


def test_the_table_says_what_enters_and_leaves_where(results, tmp_path):
    folder = results.save(tmp_path / "out")
    with (folder / "flow.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["stage", "stage_name", "place", "outflow [m^2/s]", "nodes"]
    drained = {row["place"]: float(row["outflow [m^2/s]"]) for row in rows if row["stage_name"] == "drained"}
    assert list(drained) == ["left", "right", "drain 1"]
    assert drained["left"] < 0 < drained["drain 1"]
    flow = results.stages[2].flow
    assert sum(drained.values()) == pytest.approx(0, abs=1e-12 * flow.through)


def test_pressures_on_faces_are_those_of_the_flow(results):
    """The mean over the faces of the joints is that of the pieces, in files and pictures of joints too."""
    stage = results.stages[1]
    faces, flow = joint_faces(results, stage), stage.flow
    total = float((faces.water_pressure * np.hypot(*(faces.end - faces.start).T)).sum())
    length = np.hypot(*(flow.lines[:, 1] - flow.lines[:, 0]).T)
    assert total == pytest.approx(float((flow.mean_pressure * length).sum()), rel=1e-3)
    near = np.abs(stage.contacts.point - (2, 1)).max(axis=1) < 0.01
    at = np.flatnonzero((np.abs(flow.point - (2, 1)) < 1e-6).all(axis=1))[0]
    np.testing.assert_allclose(stage.contacts.water_pressure[near], 9810 * (flow.head[at] - 1), rtol=2e-3)


def test_what_enters_and_leaves_is_told_in_one_unit(results):
    """So that they can be summed up by eye; nothing is reported of places where nothing moves."""
    stage = results.stages[2]
    rows = flow_rows(stage)
    assert [row[0] for row in rows] == ["left", "right", "drain 1", "all"]
    told = [text.split(" ", 1) for row in rows for text in row[1:] if text != "-"]
    assert len({unit for _, unit in told}) == 1
    assert float(rows[2][1].split()[0]) > 0
    assert rows[0][1] == "-"
    still = replace(stage, flow=replace(stage.flow, outflow=np.zeros_like(stage.flow.outflow)))
    assert {text for row in flow_rows(still) for text in row[1:]} == {"-"}


@pytest.mark.parametrize("name", ["flow_head", "flow_discharge", "water_pressure"])
def test_pictures_show_it(results, name):
    figure = figure_of(results, name, "drained")
    assert figure is not None
    told = " ".join(text.get_text() for axes in figure.axes for text in (axes.title, axes._left_title, *axes.texts))
    words = {"flow_head": "drain 1", "flow_discharge": "discharge of the joints", "water_pressure": "water pressure"}
    assert words[name] in told


def test_other_runs_have_no_such_pictures_and_files(tmp_path):
    plain = bsm.run(bricks(water=bsm.Water(table=((0, 2),))), bsm.Options(scheme="linear"))
    assert figure_of(plain, "flow_head") is None
    folder = plain.save(tmp_path / "out")
    assert not list(folder.glob("flow*"))


@pytest.mark.heavy
@pytest.mark.usefixtures("at_every_step")
@pytest.mark.parametrize(("given", "scheme"), [(model, "linear"), (model, "continuation"), (on_two_joints, "linear")])
def test_a_run_that_was_interrupted_between_turns_ends_as_the_whole_one(tmp_path: Path, left, given, scheme) -> None:
    """On two joints part of the change of pressure is taken, for many turns: what Aitken's factor needs is kept."""
    case, out = tmp_path / "case", tmp_path / "case" / "out"
    case.mkdir()
    for name, write in files_of_model(given(), bsm.Options(scheme=scheme)).items():
        write(case / name)
    bsm.run(case / "model.toml", output=out)
    wanted, copies = content(out), list(left)
    assert len(copies) > 4
    for copy in copies[:: 1 + len(copies) // 5]:
        interrupted(case, copy)
        bsm.run(case / "model.toml", output=out, resume=True)
        assert content(out) == wanted


def test_check_says_what_flow_there_is(tmp_path, capsys):
    """So that a drain typed in centimetres, which meets a hundredth of the joints, is seen."""
    well, grout = bsm.Well(point=(3, 1.1), discharge=1e-6), bsm.Grout(polygon=((1, 0.5), (3, 0.5), (3, 2.5), (1, 2.5)))
    first = bsm.Stage(name="more", flow=bsm.FlowChange(wells=(well,), grout=(grout,), closed=("right",)))
    flow = bsm.Flow(head={"left": 2.5, "right": 1.0}, drains=(bsm.Drain(start=(2, 0.1), end=(2, 2.9)),))
    for name, write in files_of_model(bricks(flow=flow, stages=[first, *STAGES]), bsm.Options()).items():
        write(tmp_path / name)
    check_model(tmp_path / "model.toml", as_json=True)
    told = {
        (entry["what"], entry["name"], entry["stage"]): entry for entry in json.loads(capsys.readouterr().out)["flow"]
    }
    assert told["head", "left", ""]["level"] == 2.5
    assert told["head", "left", "raised"]["level"] == 8.0
    assert told["drain", "1", ""]["points"] == 6  # its ends, two crossings of joints, two of the grout's outline
    assert told["drain", "2", "drained"]["points"] == 2
    assert told["well", "1", "more"]["point"] == [3, 1]
    assert told["grout", "1", "more"]["length"] == pytest.approx(2 * 2 + 2)
    assert ("closed", "right", "more") in told
    check_model(tmp_path / "model.toml", quiet=True)
    words = " ".join(capsys.readouterr().out.split())
    assert "flow: drain 1" in words
    assert "meets joints at 6 points" in words


def test_the_report_says_where_joints_meet_drains(results, tmp_path):
    page = write_report(results.save(tmp_path / "out"), pictures=False).read_text(encoding="utf-8")
    assert "left: 2 points; right: 2 points; drain 1: 2 points" in page
    assert "turns of flow and blocks" in page
