"""Pictures of a study: a grid of values is no sample, and has no histogram."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.pictures.figures import paper
from bsm_mesh.pictures.study_pictures import _draw_values, draw_study
from bsm_mesh.studies.table import StudyTable
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


def test_failing_runs_of_a_grid_are_crosses_at_the_top() -> None:
    figure = paper((10, 5))
    _draw_values(figure, tilted(), "failure")
    assert [axes.get_xlabel() for axes in figure.axes] == ["friction", "tilt"]
    of = {line.get_label(): line for line in figure.axes[0].lines}
    assert {"stable: 3", "unstable, or moved too far: 2", "without verdict: 1"} <= set(of)
    crosses = next(line for line in figure.axes[0].lines if line.get_marker() == "x" and len(line.get_xdata()))
    np.testing.assert_array_equal(crosses.get_xdata(), [20.0, 20.0])
    assert min(crosses.get_ydata()) > 0.9  # of the height of the axes
    joined = [line for line in figure.axes[0].lines if line.get_linestyle() == "-"]
    assert [list(line.get_xdata()) for line in joined] == [[20.0, 30.0, 40.0]] * 2  # a line a tilt
