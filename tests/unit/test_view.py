"""The page to explore: every array of the files in it, nothing outside needed. In a browser: tests/viewers."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.converters.vtk_files import read_pvd
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.own_files import own_files
from bsm_mesh.folder.run_writer import RunWriter
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.pages import view_data
from bsm_mesh.pages.view_data import ViewData, read_view
from bsm_mesh.pages.view_page import list_of_falls
from bsm_mesh.results import Results
from tests.scenes.openings import OPENED, ROOF, opening
from tests.unit.test_snapshots import run_with_snapshots

SINGLE = 1e-6  # single precision: six digits


@pytest.fixture(scope="module")
def bolted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Path]:
    folder = tmp_path_factory.mktemp("bolted") / "out"
    results = bsm.run(opening(bolted=True))
    results.save(folder)
    return results, folder


@pytest.fixture(scope="module")
def data(bolted: tuple[Results, Path]) -> ViewData:
    return read_view(SavedResults(bolted[1]))


def test_the_states_are_the_ends_of_the_stages(data: ViewData) -> None:
    assert [state.frame.label for state in data.states] == ["stage initial: stable", "stage dig: stable"]
    assert [set(state.layers) for state in data.states] == [{"blocks", "joints", "bolts", "water"}] * 2
    assert data.falls == []


def test_numbers_of_blocks_are_those_of_the_results(bolted: tuple[Results, Path], data: ViewData) -> None:
    last, arrays = bolted[0].stages[-1], data.states[-1].layers["blocks"].arrays
    there = np.flatnonzero(last.present)
    assert np.isnan(arrays["displacement"][list(OPENED)]).all()
    for name, values in {
        "displacement": np.hypot(*last.displacement[:, :2].T),
        "displacement y": last.displacement[:, 1],
        "rotation": last.displacement[:, 2],
        "stress yy": last.stress[:, 1, 1],
        "stress xy": last.stress[:, 0, 1],
        "load y": last.loads[:, 1],
        "reaction moment": last.reactions[:, 2],
    }.items():
        np.testing.assert_allclose(arrays[name][there], values[there], rtol=SINGLE, atol=1e-30)
    assert data.units["blocks"]["load y"] == "N/m"
    assert data.units["blocks"]["reaction moment"] == "N"
    assert data.units["bolts"]["axial force"] == "N of one bolt"


def test_joints_bolts_and_water(bolted: tuple[Results, Path], data: ViewData) -> None:
    last = bolted[0].stages[-1]
    joints, bolts, water = (data.states[-1].layers[kind] for kind in ("joints", "bolts", "water"))
    assert not np.isin(joints.blocks, OPENED).any()
    lengths = np.hypot(joints.ends[:, 2] - joints.ends[:, 0], joints.ends[:, 3] - joints.ends[:, 1])
    np.testing.assert_allclose(lengths, joints.arrays["length"], rtol=1e-3)
    assert data.names["joints"]["status"] == ("sticking", "slipping", "open")
    np.testing.assert_allclose(bolts.arrays["axial force"], last.bolts.axial_force, rtol=SINGLE)
    assert data.bolt_names == ("B1", "B2")
    np.testing.assert_allclose(water.ends[0] + [*data.middle, *data.middle], [0.0, 0.6, 6.0, 0.8], atol=SINGLE)


@pytest.mark.heavy
def test_bolts_are_there_at_every_step(tmp_path: Path) -> None:
    """Their forces grow with the steps; at a stage's last step they are those of its end."""
    with RunWriter(tmp_path, steps=True) as writer:
        results = bsm.run(opening(bolted=True), snapshot=writer.step, finished=writer.stage)
        writer.finish(results)
    states = read_view(SavedResults(tmp_path)).states
    steps = [state for state in states if not state.frame.is_end]
    assert steps
    assert all("bolts" in state.layers for state in states)
    of_a_stage = [state.layers["bolts"].arrays["axial force"] for state in states if state.frame.stage == 1]
    np.testing.assert_allclose(of_a_stage[-1], results.stages[1].bolts.axial_force, rtol=SINGLE)
    assert len({force.max() for force in of_a_stage}) > 1
    assert [time for time, _ in read_pvd(tmp_path / "bolts.pvd")] == [state.frame.time for state in states]


def test_what_is_zero_throughout_is_left_out(data: ViewData) -> None:
    names = set(data.states[0].layers["blocks"].arrays)
    assert {"displacement x", "displacement y", "rotation"} <= names  # these move the outlines
    assert "unstable" not in names


@pytest.mark.heavy
def test_blocks_that_come_down(tmp_path: Path) -> None:
    results = bsm.run(opening(bolted=False))
    results.save(tmp_path / "out")
    data = read_view(SavedResults(tmp_path / "out"))
    assert [row["block"] for row in data.falls] == results.unstable_blocks.tolist()
    assert set(data.states[-1].unstable) == set(results.unstable_blocks) <= set(ROOF)
    assert data.falls[0]["area"] == pytest.approx(1.0)
    assert data.falls[0]["weight"] == pytest.approx(25e3)
    assert data.falls[0]["stage"] == "dig"
    flake = data.falls[0] | {"area": 0.0024712, "weight": 64.23}
    listed = list_of_falls(replace(data, falls=[flake])).source.data
    assert (listed["area"], listed["weight"]) == ([0.00247], [0.0642])  # not 0 and 0.06


@pytest.mark.heavy
def test_steps_are_states_too_and_are_thinned_evenly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    results = run_with_snapshots(tmp_path / "out")
    saved = SavedResults(tmp_path / "out")
    whole = read_view(saved)
    assert len(whole.states) == len(results.stages[0].steps)
    assert whole.states[0].frame.label == "stage initial, step 1"
    assert whole.states[-1].frame.is_end
    assert whole.left_out == 0
    monkeypatch.setattr(view_data, "MOST_BYTES", 4.5 * view_data._bytes(whole.states[-1]))
    few = read_view(saved)
    assert 2 <= len(few.states) <= 5
    assert few.left_out == len(whole.states) - len(few.states)
    assert few.states[0].frame == whole.states[0].frame
    assert few.states[-1].frame == whole.states[-1].frame


def test_more_than_a_page_holds_is_refused(bolted: tuple[Results, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(view_data, "MOST_BYTES", 1e3)
    with pytest.raises(ModelError, match=r"more than the 0 MB of a page; look at them with ParaView"):
        read_view(SavedResults(bolted[1]))


def test_the_page_needs_nothing_else(bolted: tuple[Results, Path]) -> None:
    _, folder = bolted
    outcome = CliRunner().invoke(cli, ["view", str(folder)])
    assert (outcome.exit_code, outcome.stdout) == (0, f"{folder / 'view.html'}\n")
    page = (folder / "view.html").read_text(encoding="utf-8")
    tags = re.findall(r"<(?:script|link|img|iframe)\b[^>]*>", re.sub(r"(?s)(<script[^>]*>).*?</script>", r"\1", page))
    assert tags
    assert not [tag for tag in tags if "src=" in tag or "href=" in tag]
    assert "view.html" in own_files(folder)


def test_it_says_how_to_get_bokeh(bolted: tuple[Results, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "bokeh.embed", None)
    outcome = CliRunner().invoke(cli, ["view", str(bolted[1])])
    assert isinstance(outcome.exception, ModelError)
    assert str(outcome.exception) == "view needs Bokeh: pip install bokeh"
