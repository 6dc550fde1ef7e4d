"""Tables of pages: found between their marks, replaced whole, compared number by number."""

from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.algebra import pardiso
from examples.numbers.__main__ import TABLES
from examples.numbers.pages import differences, markdown, table_in, with_table
from examples.numbers.routes import reordered

pytest.importorskip("gmsh")

ROOT = Path(__file__).parents[2]
PAGE = "# Page\n\n<!-- numbers one: begin -->\n\n| a |\n\n<!-- numbers one: end -->\n\nafter\n"


def test_a_table_is_replaced_between_its_marks():
    changed = with_table(PAGE, "one", "| b |")
    assert table_in(changed, "one") == "| b |"
    assert changed == PAGE.replace("| a |", "| b |")
    with pytest.raises(ValueError, match="needs the marks"):
        table_in(PAGE, "two")


@pytest.mark.parametrize(
    ("old", "new", "count"),
    [
        ("| x | 1.000 |", "| x | 1.004 |", 0),
        ("| x | 0.02 |", "| x | 0.03 |", 0),
        ("| x | 0.02 |", "| x | 0.04 |", 1),
        ("| x | 20 |", "| x | 21 |", 1),
        ("| x | 1.000 |", "| x | 1.006 |", 1),
        ("| x | 1.0 |", "| y | 1.0 |", 1),
        ("| x | 0 |", "| x | 1e-12 |", 0),
        ("| x | 1.0 |", "| x | 1.0 |\n| y | 2.0 |", 1),
        ("| x | -1.0 |", "| x | 1.0 |", 1),
    ],
)
def test_numbers_may_differ_by_the_tolerance_and_words_not_at_all(old, new, count):
    assert len(differences(old, new, 0.005)) == count


def test_every_table_has_its_marks():
    for table in TABLES.values():
        assert table_in((ROOT / table.page).read_text(encoding="utf-8"), table.name)


LONG = ("tutorial", "stratified-slope", "filling-thickness", "constants", "joint-laws", "damped")
HEAVY = (
    "bolted-opening",
    "cut_rock",
    "drained-slope",
    "gravity-turned-on",
    "incline",
    "retaining-wall",
    "rough-joint",
    "slides",
    "staged-tunnel",
    "stratified-slope-way",
    "tilted-wall",
    "toppling-column",
)
ALONE = (
    "arch",
    "dam-variants",
    "grouted-dam",
    "key_blocks_wedges",
    "pushed-block",
    "starter-slope",
)  # heavy tests below
QUICK = [name for name, table in TABLES.items() if not table.is_slow and name not in ALONE]


def marks(name: str) -> list[pytest.MarkDecorator]:
    return [pytest.mark.slow] if name in LONG else [pytest.mark.heavy] if name in HEAVY else []


@pytest.mark.parametrize("name", [pytest.param(name, marks=marks(name)) for name in QUICK])
def test_quick_tables_are_what_the_runs_say(name):
    if name == "licences" and not pardiso.is_available():
        pytest.skip("the licences of all extras are listed, and mkl is not installed")
    says_what_the_runs_say(name)


def says_what_the_runs_say(name):
    table = TABLES[name]
    page = (ROOT / table.page).read_text(encoding="utf-8")
    assert differences(table_in(page, name), table.make(), table.tolerance) == []


@pytest.mark.heavy
def test_tables_of_dams_are_what_the_runs_say():
    says_what_the_runs_say("dam-variants")
    says_what_the_runs_say("grouted-dam")


@pytest.mark.heavy
def test_tables_of_slides_are_what_the_runs_say():
    says_what_the_runs_say("pushed-block")
    says_what_the_runs_say("starter-slope")


@pytest.mark.heavy
def test_tables_of_an_arch_and_of_wedges_are_what_the_runs_say():
    says_what_the_runs_say("arch")
    says_what_the_runs_say("key_blocks_wedges")


@pytest.mark.heavy
def test_blocks_in_another_order_are_the_same_model():
    model = bsm.load(ROOT / "examples/staged_tunnel/full_face.toml")
    other = reordered(model, 1)
    one, same = (bsm.run(each).stages[-1].displacement for each in (model, other))
    order = np.lexsort(model.blocks.moments.centroid.T), np.lexsort(other.blocks.moments.centroid.T)
    np.testing.assert_allclose(one[order[0]], same[order[1]], atol=1e-6)
    assert other.blocks.moments.area.sum() == pytest.approx(model.blocks.moments.area.sum())


def test_markdown():
    assert markdown(("a", "b"), [("1", "2")]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"
