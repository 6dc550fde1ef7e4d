"""Histories: the record, that it is the movement of the blocks, what is refused, and that it survives files."""

from __future__ import annotations

import csv
import shutil
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.arrays import content_hash
from bsm_mesh.converters.result_files import corner_displacement
from bsm_mesh.results import Results
from tests.scenes.interrupted import copies_of, interrupted
from tests.scenes.model_folders import content, put_model
from tests.scenes.models import model_of
from tests.scenes.shapes import grid
from tests.scenes.small_case import MODEL, Case
from tests.unit.test_run_writer import staged
from tests.unit.test_snapshots import MOVING, pushed

pytestmark = pytest.mark.filterwarnings("ignore::bsm_mesh.errors.MeshWarning")

RECORDED = (
    bsm.History(name="corner", point=(1.5, 1)),
    bsm.History(name="gap", line=[(0.2, -0.2), (1.2, 0.6), (2.5, 0.5)]),
    bsm.History(name="pushed", block=1),
    bsm.History(name="set", joint="J"),
)


@pytest.fixture(scope="module")
def recorded() -> Results:
    """Return the block that was pushed over half a metre, with its histories."""
    return bsm.run(pushed().replace(histories=RECORDED), MOVING)


@pytest.mark.heavy
def test_every_step_has_the_movement_of_its_state() -> None:
    """A point, an extensometer and a block: what the corners and blocks did in the same step."""
    seen: list[tuple[float, ...]] = []
    model = pushed().replace(histories=RECORDED)
    corner = int(np.flatnonzero((model.blocks.vertices == (1.5, 1)).all(axis=1) & (model.blocks.owner == 1))[0])

    def look(record: object, state: object) -> None:
        (stage,) = state().stages  # type: ignore[operator]
        seen.append((*corner_displacement(model.blocks, stage.displacement)[corner], *stage.displacement[1]))

    results = bsm.run(model, MOVING, snapshot=look)
    histories, expected = results.histories, np.array(seen)
    assert len(histories["corner"].values) == len(results.stages[0].steps) > 3
    np.testing.assert_array_equal(histories["corner"].values, expected[:, :2])
    np.testing.assert_array_equal(histories["pushed"].values[:, :2], expected[:, 2:4])
    np.testing.assert_allclose(histories["pushed"]["rotation"], np.degrees(expected[:, 4]))
    shown = f"HistorySeries of point 'corner': {len(expected)} steps, u [m], v [m]; last {expected[-1, 0]:.4g}, "
    assert repr(histories["corner"]).startswith(shown)
    assert histories["corner"]["u"][-1] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.heavy
def test_an_extensometer_measures_the_growth_of_its_length(recorded: Results) -> None:
    """Its head is in the base, which is held; the block ran 0.5 m away, the wall did not move."""
    gap = recorded.histories["gap"]
    assert gap.recorded.quantities == ("extension_1", "extension_2")
    assert gap["extension_1"][-1] == pytest.approx(np.hypot(1.5, 0.8) - np.hypot(1.0, 0.8), abs=1e-3)
    np.testing.assert_allclose(gap["extension_2"], 0, atol=1e-9)
    back = bsm.History(name="back", line=[(1.2, 0.6), (0.8, 0.4), (0.2, -0.2)])  # the head moves, with the first anchor
    series = bsm.run(pushed().replace(histories=[back]), MOVING).histories["back"]
    np.testing.assert_allclose(series["extension_1"], 0, atol=1e-9)
    np.testing.assert_allclose(series["extension_2"], gap["extension_1"], atol=1e-12)


def test_a_name_that_no_history_has_is_told_with_those_that_there_are(recorded: Results) -> None:
    with pytest.raises(bsm.ModelError, match="there is no 'cornr'; did you mean 'corner'"):
        recorded.histories["cornr"]
    with pytest.raises(KeyError, match=r"history 'corner' has no 'x' \(known: u, v\)"):
        recorded.histories["corner"]["x"]


def test_a_series_is_a_mapping_of_its_quantities(recorded: Results) -> None:
    series = next(iter(recorded.histories.values()))
    columns = dict(series)  # type: ignore[call-overload]
    assert tuple(columns) == series.recorded.quantities
    assert (columns[series.keys()[0]] == series.values[:, 0]).all()


def test_a_joint_set(recorded: Results) -> None:
    """The base of the block, 1 m, slid; it was at strength on the way, and the wall's foot never moved."""
    series = recorded.histories["set"]
    assert series["slip"][-1] == pytest.approx(0.5 / 3, rel=1e-3)  # three faces of 1 m
    assert series["slipping_share"][1] == pytest.approx(0.5)  # of two: the block has not met the wall
    assert series["open_share"][-1] == 0


@pytest.mark.heavy
def test_blocks_that_are_taken_away_have_no_movement_any_more(tmp_path: Path) -> None:
    given = [
        bsm.History(name="five", block=5),
        bsm.History(name="roof", point=(2.5, 1.9)),
        bsm.History(name="b", bolt="bolt 1"),
    ]
    results = bsm.run(staged().replace(histories=given), bsm.Options(scheme="linear"))
    five = results.histories["five"]
    assert five.stage.tolist() == [0, 1, 2]
    assert np.isfinite(five.values[0]).all()
    assert np.isnan(five.values[1:]).all()
    assert np.isnan(results.histories["roof"].values[1:]).all()
    greatest = [stage.bolts.greatest_force[0] for stage in results.stages]
    np.testing.assert_array_equal(results.histories["b"]["axial_force"], greatest)
    results.save(tmp_path)
    rows = list(csv.reader((tmp_path / "history_five.csv").open(encoding="utf-8")))
    assert rows[0] == ["stage", "stage_name", "step", "u [m]", "v [m]", "rotation [deg]"]
    assert rows[2] == ["1", "first", "0", "", "", ""]
    back = Results.load(tmp_path)
    np.testing.assert_array_equal(back.histories["five"].values, five.values)


@pytest.mark.heavy
def test_a_bolt_is_recorded_where_a_stage_changes_strength_and_under_reduced_strength() -> None:
    """The model of such a stage has no bolts of its own, nor has that of a stage before they are installed."""
    block, floor = [(0, 0), (1, 0), (1, 1), (0, 1)], [(-1, -1), (2, -1), (2, 0), (-1, 0)]
    model = model_of(
        [floor, block],
        friction=40.0,
        gravity_direction=-110.0,
        bolts=[bsm.Bolt(start=(0.5, 0.9), end=(0.5, -0.9), diameter=0.02, name="B", stage="bolted")],
        stages=[bsm.Stage(name="bolted"), bsm.Stage(name="rain", strength={"J": 0.9})],
        histories=[bsm.History(name="force", bolt="B")],
    )
    results = bsm.run(model)
    assert len(results.histories["force"].values) == sum(len(stage.steps) for stage in results.stages)
    assert bsm.factor_of_safety(model, stage="initial").stable == pytest.approx(
        np.tan(0.6981317) / np.tan(0.3490659), rel=0.01
    )


@pytest.mark.heavy
def test_recording_changes_nothing(recorded: Results) -> None:
    plain = bsm.run(pushed(), MOVING)
    np.testing.assert_array_equal(plain.stages[0].displacement, recorded.stages[0].displacement)
    assert plain.model_digest == recorded.model_digest
    assert plain.histories == {}


def test_files_hold_what_was_recorded(recorded: Results, tmp_path: Path) -> None:
    recorded.save(tmp_path)
    assert {f"history_{one.name}.csv" for one in RECORDED} <= {path.name for path in tmp_path.iterdir()}
    back = Results.load(tmp_path)
    assert content_hash(back.stages[0]) == content_hash(recorded.stages[0])
    assert back.recorded == recorded.recorded
    for name, series in recorded.histories.items():
        np.testing.assert_array_equal(back.histories[name].values, series.values)
    assert bsm.load(tmp_path / "model.toml").histories == RECORDED
    (tmp_path / "history_gap.csv").write_text("stage\n")
    with pytest.raises(bsm.ModelError, match=r"history_gap\.csv is damaged"):
        Results.load(tmp_path)


@pytest.mark.heavy
def test_those_of_a_former_run_go(recorded: Results, tmp_path: Path) -> None:
    recorded.save(tmp_path)
    (tmp_path / "history_mine.csv").write_text("kept elsewhere")
    with pytest.raises(bsm.ModelError, match=r"history_mine\.csv is not from a run"):
        recorded.save(tmp_path)
    (tmp_path / "history_mine.csv").unlink()
    bsm.run(pushed(), MOVING).save(tmp_path)
    assert [path.name for path in tmp_path.glob("history*")] == ["history.csv"]


@pytest.mark.heavy
@pytest.mark.parametrize("scheme", ["continuation", "linear"])
def test_a_resumed_run_records_the_same_to_the_last_digit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scheme: str
) -> None:
    monkeypatch.setattr("bsm_mesh.folder.checkpoints.SETTINGS.interval", 0.0)
    copies = copies_of(monkeypatch, tmp_path / "left", before=False)
    model = put_model(tmp_path / "case", "staged", tables={"solver": {"scheme": scheme}})
    joint = next(iter(bsm.load(model).joints)).name
    told = f'\n[[history]]\nname = "b"\nblock = 1\n\n[[history]]\nname = "j"\njoint = "{joint}"\n'
    model.write_text(model.read_text(encoding="utf-8") + told, encoding="utf-8")
    out = model.parent / "out"
    bsm.run(model, output=out)
    wanted, left = content(out), list(copies)
    assert {"history_b.csv", "history_j.csv"} <= set(wanted)
    for copy in left[:: max(1, len(left) // 3)]:
        interrupted(model.parent, copy)
        bsm.run(model, output=out, resume=True)
        assert content(out) == wanted
    interrupted(model.parent, left[0])
    model.write_text(model.read_text(encoding="utf-8").replace("block = 1", "block = 0"), encoding="utf-8")
    with pytest.raises(bsm.ModelError, match=r"recorded other histories: \[\[history\]\] was changed"):
        bsm.run(model, output=out, resume=True)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            [{"name": "a", "point": (9, 9)}],
            "history 'a': the point (9, 9) lies in no block; the blocks reach from (0, -1)",
        ),
        ([{"name": "a", "line": [(0.5, -0.5), (2, 5)]}], "history 'a': the point (2, 5) lies in no block"),
        ([{"name": "a", "block": 1}, {"name": "A", "block": 2}], "history 'A' is defined more than once ('a')"),
        ([{"name": "a", "block": 3}], "there is no block 3; blocks are numbered 0 to 2"),
        ([{"name": "a", "joint": "K"}], "there is no joint 'K'"),
        ([{"name": "a", "bolt": "B"}], "there is no bolt 'B'"),
    ],
)
def test_what_the_model_has_not_is_one_clear_message(given: list[dict[str, object]], told: str) -> None:
    with pytest.raises(bsm.ModelError) as caught:
        pushed().replace(histories=[bsm.History(**one) for one in given])  # type: ignore[arg-type]
    assert told in str(caught.value)
    assert len(caught.value.faults) == 1


def test_the_same_name_twice_is_told_once() -> None:
    twice = [bsm.History(name="a", block=1)] * 2
    with pytest.raises(bsm.ModelError) as caught:
        pushed().replace(histories=twice)
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"name": "a/b", "block": 1}, "the name is a part of a file's name"),
        ({"name": ".."}, "the name is a part of a file's name"),
        ({"name": "a"}, "needs exactly one of point, line, block, joint, bolt; it has none"),
        ({"name": "a", "block": 1, "joint": "J"}, "it has block and joint"),
        ({"name": "a", "line": [(0, 0)]}, "must be two points or more"),
        ({"name": "a", "line": [(0, 0), (0, 0)]}, "lies on the first one"),
        ({"name": "a", "block": -1}, "block = -1"),
    ],
)
def test_what_is_no_history(given: dict[str, object], told: str) -> None:
    with pytest.raises(bsm.ModelError) as caught:
        bsm.History(**given)  # type: ignore[arg-type]
    assert told in str(caught.value)


def test_the_picture(recorded: Results) -> None:
    """A chart for each history; what is written is no formula."""
    figure = replace(recorded, title="what $x$ did").plot("histories")
    assert "what $x$ did" in figure.get_suptitle()
    titles = [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]
    assert titles == [f"{one.name} ({one.kind})" for one in recorded.recorded]
    assert all(axes.lines for axes in figure.axes if axes.get_title(loc="left"))


def test_the_names_of_all_stages_are_whole_in_the_picture() -> None:
    stages = [bsm.Stage(name="dig", excavate=[2])]
    results = bsm.run(model_of(grid(1, 3), stages=stages, histories=[bsm.History(name="top", block=1)]))
    figure = results.plot("histories")
    figure.canvas.draw()
    (axes,) = [axes for axes in figure.axes if axes.texts]
    assert [text.get_text().strip() for text in axes.texts] == ["initial", "dig"]
    assert all(text.get_window_extent().x0 >= axes.bbox.x0 for text in axes.texts)


@pytest.mark.heavy
def test_the_names_of_short_stages_do_not_overlap_in_the_picture() -> None:
    """In a narrow chart, one of two beside each other, names longer than their stages are in rows below each other."""
    stages = [bsm.Stage(name=f"a stage with a name that is long, {k}") for k in range(3)]
    histories = [bsm.History(name=f"block{k}", block=k) for k in range(2)]
    figure = bsm.run(model_of(grid(1, 3), stages=stages, histories=histories)).plot("histories")
    figure.canvas.draw()
    for axes in [axes for axes in figure.axes if axes.texts]:
        boxes = [text.get_window_extent() for text in axes.texts]
        assert len(boxes) == 4
        assert len({round(box.y0) for box in boxes}) > 1
        assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


def test_extensometers_over_their_length(recorded: Results) -> None:
    """At the end of a stage each anchor's extension is at its distance; the first point has none."""
    (line,) = [series for series in recorded.histories.values() if series.recorded.kind == "line"]
    np.testing.assert_allclose(line.recorded.distances, np.hypot([1.0, 2.3], [0.8, 0.7]))
    (axes,) = recorded.plot("extensometers").axes
    assert axes.lines[0].get_label() == "computed"  # of the only stage
    distance, extension = axes.lines[0].get_data()
    last = np.flatnonzero(line.stage == 0)[-1]
    np.testing.assert_allclose(distance, [0.0, *line.recorded.distances])
    shown = {"um": 1e-6, "mm": 1e-3, "m": 1.0}[axes.get_ylabel().removeprefix("extension, ")]
    np.testing.assert_allclose(extension * shown, [0.0, *line.values[last]])


def test_what_gravity_moved_before_the_stages_is_no_jump_in_the_picture() -> None:
    """Displacements count from the end of the in-situ state: the picture begins there, the series has all."""
    model = model_of(
        grid(1, 3),
        stages=[bsm.Stage(name="dig", excavate=[2])],
        in_situ=bsm.InSitu(method="gravity"),
        histories=[bsm.History(name="top", block=1)],
    )
    results = bsm.run(model)
    series = results.histories["top"]
    assert abs(series["v"][series.stage == 0]).max() > 1e-6
    axes, *_ = results.plot("histories").axes  # and that of the rotation
    assert len(axes.lines[0].get_xdata()) == (series.stage > 0).sum() > 0
    assert axes.get_xlabel() == "step after the in-situ state"


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_here")
def test_the_command(case: Case) -> None:
    """A model file with a history: its file is there, told, listed, and drawn; a wrong point ends with code 2."""
    case.write("model.toml", MODEL + '\n[[history]]\nname = "middle"\npoint = ["1 m", 1]\n')
    outcome = case.run("run", "model.toml")
    assert outcome.code == 0
    assert "history_middle.csv" in outcome.out
    assert case.run("plot", "out/model").code == 0
    assert (case.folder / "out/model/pictures/histories.png").exists()
    shutil.rmtree(case.folder / "out")
    case.write("model.toml", MODEL + '\n[[history]]\nname = "middle"\npoint = [100, 1]\n')
    outcome = case.run("run", "model.toml")
    assert outcome.code == 2
    assert "model.toml: history 'middle': the point (100, 1) lies in no block" in outcome.err
    assert not (case.folder / "out").exists()
