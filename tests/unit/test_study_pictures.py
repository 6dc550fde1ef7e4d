"""Pictures of a study: a grid of values is no sample, and has no histogram."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.pictures.figures import paper
from bsm_mesh.pictures.study_pictures import _draw_values, draw_study
from bsm_mesh.studies.statistics import summary_of
from bsm_mesh.studies.table import UNITS, StudyTable
from bsm_mesh.text.study_tables import run_rows, study_rows
from tests.scenes.shapes import grid
from tests.unit.test_study_statistics import table_of

MODEL = bsm.Model(blocks=bsm.Blocks.from_polygons(grid(1, 2), rock="r"), rocks=[bsm.Rock("r", unit_weight=25e3)])


def tilted() -> StudyTable:
    """Return a grid of two keys: three of six runs are stable, two slide and one has no verdict."""
    friction, tilt = zip(*product((20.0, 30.0, 40.0), (0.0, 10.0)), strict=True)
    status = ["unstable", "unstable", "stable", "not_converged", "stable", "stable"]
    answers = [{"status": each, "max_displacement": 1e-3 * (k + 1)} for k, each in enumerate(status)]
    return table_of(answers, friction=list(friction), tilt=list(tilt))


def test_a_grid_has_the_answer_over_the_values(tmp_path: Path) -> None:
    names = {path.stem for path in draw_study(tilted(), MODEL, "Tilted", tmp_path, drawn=False)}
    assert names == {"model", "values"}
    names = {path.stem for path in draw_study(tilted(), MODEL, "Tilted", tmp_path)}
    assert names == {"model", "histogram", "scatter"}


def test_failing_runs_of_a_grid_are_crosses_above_the_frame() -> None:
    figure = paper((10, 5))
    _draw_values(figure, tilted(), "failure")
    assert [axes.get_xlabel() for axes in figure.axes] == ["friction", "tilt"]
    of = {line.get_label(): line for line in figure.axes[0].lines}
    without = "above the frame: no value"
    told = {f"unstable, or moved too far: 2 (2 {without})", f"without verdict: 1 (1 {without})"}
    assert {"stable: 3", *told} <= set(of)
    crosses = next(line for line in figure.axes[0].lines if line.get_marker() == "x" and len(line.get_xdata()))
    np.testing.assert_array_equal(crosses.get_xdata(), [20.0, 20.0])
    assert min(crosses.get_ydata()) > 1.0  # of the height of the axes: unstable runs have no displacement
    joined = [line for line in figure.axes[0].lines if line.get_linestyle() == "-"]
    assert [list(line.get_xdata()) for line in joined] == [[20.0, 30.0, 40.0]] * 2  # a line a tilt


def test_a_run_without_a_factor_of_safety_is_above_the_frame_and_counted() -> None:
    answers = [{"status": "unstable"}, {"status": "stable", "factor": 1.4}, {"status": "stable", "factor": 1.6}]
    table = table_of(answers, factor=True, friction=[24.0, 30.0, 36.0])
    figure = paper((10, 5))
    _draw_values(figure, table, "factor")
    of = {str(line.get_label()): line for line in figure.axes[0].lines}
    assert "unstable, or moved too far: 1 (1 above the frame: no value)" in of
    cross = next(line for line in figure.axes[0].lines if line.get_marker() == "x" and len(line.get_xdata()))
    assert min(cross.get_ydata()) > 1.0  # of the height of the axes: it has no place on the axis of factors
    assert not cross.get_clip_on()
    rows = dict(row for row in study_rows({"title": "", **summary_of(table, drawn=False)})[0][2] if len(row) == 2)
    assert rows["runs without a factor of safety"] == "1"


def test_a_grid_names_the_values_of_its_least_and_greatest_answers_and_no_statistics_of_a_sample() -> None:
    """Its values were chosen: their mean and the share that fails say nothing of the rock."""
    answers = [{"status": "stable", "factor": factor} for factor in (1.2, 0.9, 1.6)]
    units = {UNITS: json.dumps({"friction": "degrees"})}
    table = replace(table_of(answers, factor=True, friction=[30.0, 24.0, 36.0]), metadata=units)
    (_, _, counts), (_, _, extremes), *_ = study_rows({"title": "", **summary_of(table, drawn=False)})
    assert not [name for name, *_ in counts if "share" in name or "probability" in name]
    assert extremes == [
        ("least factor of safety", "0.9", "friction = 24 degrees"),
        ("greatest factor of safety", "1.6", "friction = 36 degrees"),
    ]
    _, header, rows = run_rows(table)
    assert header == ("run", "friction", "verdict", "factor of safety")
    assert rows[1] == ("1", "24 degrees", "stable", "0.9")
    drawn = study_rows({"title": "", **summary_of(table, drawn=True)})
    assert "mean" in drawn[1][1]
    assert [name for name, *_ in drawn[0][2] if "probability of failure" in name]


def test_answers_that_differ_by_rounding_are_one_extreme() -> None:
    answers = [{"status": "stable", "factor": 1.2 * (1 + off)} for off in (0.0, -1e-10, 2e-10)]
    table = table_of([*answers, {"status": "stable", "factor": 1.5}], factor=True, spacing=[1.0, 2.0, 3.0, 4.0])
    (_, _, least), *_ = study_rows({"title": "", **summary_of(table, drawn=False)})[1][2]
    assert least == "spacing = 1, and 2 more runs"


def test_axes_of_keys_have_units() -> None:
    units = {UNITS: json.dumps({"friction": "degrees", "tilt": ""})}
    figure = paper((10, 5))
    _draw_values(figure, replace(tilted(), metadata=units), "failure")
    assert [axes.get_xlabel() for axes in figure.axes] == ["friction, degrees", "tilt"]
