"""benchmarks.continuum: every example compared with finite elements, as a table between the marks of a page."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import continuum, pages
from benchmarks import continuum_limits as limits
from bsm_mesh.converters import solve_continuum
from examples.numbers.pages import parted

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/continuum.md"


@pytest.mark.heavy
def test_a_model_is_told_stage_by_stage():
    (model,) = (path for path in continuum.all_models() if path.match("falling_table/rapid.toml"))
    first, second = continuum.lines_of(model)
    assert first[:3] == ("falling_table/rapid", "initial", "with interfaces")
    assert "with the same joints differ by" in first[3]
    assert second[:3] == ("falling_table/rapid", "drawdown", "not comparable")
    assert second[4:] == ("-", "-")
    text = continuum.table([first, second])
    assert text.startswith("1 models, 1 of them compared in one stage at least. By their last stage: 1 not comparable.")


def test_the_page_names_every_model():
    text = PAGE.read_text(encoding="utf-8")
    for path in continuum.all_models():
        assert f"| {continuum.name_of(path)} |" in text


def test_nothing_that_is_not_comparable_has_a_percentage_of_difference():
    between = pages.marks(continuum.COMMAND)
    table = parted(PAGE.read_text(encoding="utf-8"), between)[1]
    rows = [row.split(" | ") for row in table.splitlines() if row.startswith("| ")]
    refused = [row for row in rows if row[2] == "not comparable"]
    assert refused
    assert not any("differ" in row[3] for row in refused)
    assert all("differ by" in row[3] for row in rows if row[2] in ("comparable", "with interfaces"))


def test_a_slope_of_which_some_blocks_are_hardly_held():
    """Full corrections carry them 17 m away; none larger than small displacements allow, they reach rest near by."""
    stage = solve_continuum(limits.slope(140)[1], order=1, joints=True)
    assert stage.converged
    assert np.abs(stage.displacement[:, :2]).max() < 0.01
