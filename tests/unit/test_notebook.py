"""What a notebook shows of a model and of results."""

from html import unescape

import pytest

import bsm_mesh as bsm
from bsm_mesh.commands.commands import _print_results
from bsm_mesh.text.result_text import tables_of
from bsm_mesh.text.tables import engineering
from tests.scenes.known_factors import incline
from tests.scenes.openings import opening


@pytest.fixture(scope="module")
def results():
    return bsm.run(opening(bolted=True))


def test_a_model(results):
    shown = results.model._repr_html_()
    for text in ("Opening with bolts", "24, of 1 m2 to 1 m2", "25 kN/m3", "MohrCoulomb(friction=5", "dig", "1, 0, 2"):
        assert text in shown
    assert "stress in situ" not in shown  # there is none


def test_results(results):
    shown = results._repr_html_()
    assert "<td>verdict</td><td>stable</td>" in shown
    assert engineering(results.stages[-1].max_displacement, "m") in shown
    assert "<th>stage</th>" in shown
    assert "<td>dig</td>" in shown


def test_one_stage_has_no_table_of_stages():
    assert "<th>stage</th>" not in bsm.run(incline(40.0, 30.0))._repr_html_()


@pytest.mark.heavy
def test_a_factor_of_safety():
    answer = bsm.factor_of_safety(incline(30.0, 40.0))
    shown = unescape(answer._repr_html_())
    assert f"<b>{answer}</b>" in shown
    assert "<td>limit analysis</td>" in shown
    assert f"<td>{len(answer.trials)}, " in shown


def test_it_has_every_table_that_the_terminal_prints(results, capsys):
    """Headings of tables, rows and sentences: both come of one list."""
    shown = unescape(results._repr_html_())
    for table in tables_of(results):
        assert all(f"<td>{cell}</td>" in shown for row in table.rows for cell in row)
        assert all(f"<p>{line}</p>" in shown for line in table.lines)
    _print_results(results, (), verbose=False)
    said = capsys.readouterr().out
    assert all(table.title in said for table in tables_of(results))
    assert "Joints" in said


def test_names_are_no_html():
    model = incline(40.0, 30.0).replace(title="a < b & <script>")
    assert "a &lt; b &amp; &lt;script&gt;" in model._repr_html_()
    assert "<script" not in model._repr_html_()
