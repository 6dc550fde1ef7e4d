"""The report of a results folder: one page that needs nothing else, whose numbers are those of the results."""

import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.app.cli import cli
from bsm_mesh.app.own_files import own_files
from bsm_mesh.app.pictures import NAMES
from bsm_mesh.app.report import _shown
from bsm_mesh.results.joint_sets import joint_sets
from tests.scenes.known_factors import incline, tutorial_slope


def report(folder, *options):
    outcome = CliRunner().invoke(cli, ["report", str(folder), *options])
    return outcome, (folder / "report.html").read_text(encoding="utf-8") if outcome.exit_code == 0 else ""


@pytest.fixture(scope="module")
def slope(tmp_path_factory):
    """Return the results of a slope whose left block is excavated, and their folder with its report."""
    folder = tmp_path_factory.mktemp("slope") / "out"
    results = bsm.run(tutorial_slope(30.0))
    results.save(folder)
    return results, folder, report(folder)[1]


def test_verdicts_with_their_grounds(slope):
    results, _, page = slope
    assert [stage.name for stage in results.stages] == re.findall(r"<h3>Stage (\w+)</h3>", page)
    assert page.count("<td>stable</td>") == 2
    assert "equilibrium: every block is in balance" in page
    assert 'class="fails"' not in page


def test_numbers_are_those_of_the_results(slope):
    results, folder, page = slope
    last = results.stages[-1]
    most = int(np.hypot(*last.stage_displacement[:, :2].T).argmax())
    assert f"block {most} at " in page
    assert f"<td>{int(last.present.sum())}, {len(last.contacts.length)}</td>" in page
    assert results.model_digest in page
    assert str((folder / "contacts_0000.vtu").stat().st_size) in page
    (joint,) = joint_sets(results, last)
    assert f">{100 * joint.slipping:.3g}</td>" in page


def test_numbers_of_the_input_bear_their_units(slope):
    """With a prefix where that loses no digit."""
    _, _, page = slope
    rows = dict(re.findall(r"<tr><td>(\w+)</td><td>(.*?)</td></tr>", page))
    assert rows["unit_weight"].endswith("N/m^3")
    assert rows["normal_stiffness"].endswith("Pa/m")
    assert rows["friction"].endswith(" degrees")
    assert _shown(26123.25, "N/m^3") == "26123.25 N/m^3"
    assert _shown(["x", "y"]) == "x, y"


def test_the_page_needs_nothing_else(slope):
    _, _, page = slope
    assert not re.findall(r'(?:src|href)="(?!data:)', page)
    assert "http" not in page
    assert "<script" not in page


def test_pictures_are_in_the_page(slope):
    """All of the last stage; of the stage before what moved and slipped, before them and by its name."""
    _, folder, page = slope
    drawn = {path.stem for path in (folder / "pictures").glob("*.png")}
    last = {name for name in drawn if "_stage_" not in name}
    before = {name for name in ("displacement_stage_0", "joints_state_stage_0") if name in drawn}
    captions = re.findall(r"<figcaption>(.*?)</figcaption>", page)
    told = sorted(f"{name.removesuffix('_stage_0').replace('_', ' ')}, stage initial" for name in before)
    assert captions == told + [name.replace("_", " ") for name in NAMES if name in last]
    assert captions[len(told)] == "model"
    assert page.count('src="data:image/png;base64,') == len(captions) > 3
    assert before
    assert f"{len(drawn) - len(captions)} more pictures" in page


def test_a_picture_of_a_stage_that_there_is_none(slope, tmp_path):
    """A file that somebody put there is no picture of these results."""
    results, _, _ = slope
    results.save(tmp_path / "out")
    (tmp_path / "out/pictures").mkdir()
    (tmp_path / "out/pictures/displacement_stage_99.png").write_bytes(b"a picture")
    outcome, page = report(tmp_path / "out")
    assert outcome.exit_code == 0
    assert "None were drawn." in page


def test_the_next_run_takes_it_away(slope, tmp_path):
    results, _, _ = slope
    results.save(tmp_path / "out")
    assert report(tmp_path / "out", "--no-pictures")[0].exit_code == 0
    assert "report.html" in own_files(tmp_path / "out")
    results.save(tmp_path / "out")
    assert not (tmp_path / "out" / "report.html").exists()


def test_blocks_that_come_down_and_texts_that_are_no_html(tmp_path):
    bsm.run(replace(incline(20.0, 30.0), title="a < b & <script>alert(1)</script>")).save(tmp_path / "out")
    _, page = report(tmp_path / "out", "--no-pictures")
    assert "<td>comes down</td><td>1 block, 1 m2 (" in page
    assert "proved: " in page
    assert "&lt;script&gt;" in page
    assert "<script" not in page
    assert "None were drawn." in page


def test_damaged_results_have_no_report(slope, tmp_path):
    results, _, _ = slope
    results.save(tmp_path / "out")
    (tmp_path / "out" / "history.csv").write_text("nothing")
    outcome, _ = report(tmp_path / "out", "--no-pictures")
    assert "history.csv" in str(outcome.exception)
    assert not (tmp_path / "out" / "report.html").exists()


def test_a_folder_without_results(tmp_path):
    outcome = CliRunner().invoke(cli, ["report", str(tmp_path)])
    assert isinstance(outcome.exception, bsm.ModelError)
