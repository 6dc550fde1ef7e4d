"""The quick cases of the verification manual, each beside its exact answer; what its tables name exists."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gmsh")

from examples.numbers.pages import differences, table_in
from verification.case import Between, error_of, in_words, limit_between, value_in_words
from verification.elsewhere import table_with
from verification.equations import EQUATIONS, all_numbers, is_a_test, is_there
from verification.manual import TABLES
from verification.registry import CASES, TOPICS
from verification.sources import KINDS, SOURCES

ROOT = Path(__file__).parents[2]
QUICK = [name for name, case in CASES.items() if not case.is_slow]
LONG = (
    "bench-barton-bandis",
    "bench-ladanyi-archambault",
    "bench-mohr-coulomb-softening",
    "cycles-of-a-slide",
    "dilation",
    "sheet-pile",
)
HEAVY = (
    "arch-that-falls",
    "brittle-cohesion",
    "earthquake",
    "example-2-apart",
    "example-3",
    "example-3-toe",
    "example-4",
    "graph-laplacian",
    "hung-block",
    "laid-lengths",
    "laid-verdicts",
    "limit-angle",
    "softening",
    "stack-that-falls",
    "toppled-slab",
    "tutorial-of-udec",
)


def marks(name: str) -> list[pytest.MarkDecorator]:
    return [pytest.mark.slow] if name in LONG else [pytest.mark.heavy] if name in HEAVY else []


@pytest.mark.parametrize("name", [pytest.param(name, marks=marks(name)) for name in QUICK])
def test_case(name: str) -> None:
    case = CASES[name]
    exact, found = case.answer
    told = f"{case.what}: {case.quantity}: exact {value_in_words(exact)}, found {value_in_words(found)}"
    assert case.error <= case.tolerance, told


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CASES if name not in QUICK])
def test_slow_case(name: str) -> None:
    assert CASES[name].error <= CASES[name].tolerance, CASES[name].what


def test_cases_have_names_and_sources_of_their_own() -> None:
    assert len(CASES) == sum(len(topic.cases) for topic in TOPICS)
    assert {case.source for case in CASES.values()} == set(SOURCES)
    assert {source.kind for source in SOURCES.values()} == set(KINDS)
    independent = [case for case in CASES.values() if SOURCES[case.source].kind in ("thesis", "book", "program")]
    assert len(independent) >= 40


def test_every_equation_of_the_thesis_has_one_line() -> None:
    numbers = [number for equation in EQUATIONS for number in equation.each]
    assert sorted(numbers) == sorted(all_numbers())


@pytest.mark.parametrize("equation", EQUATIONS, ids=lambda equation: equation.numbers)
def test_an_equation_is_held_and_proved_or_it_is_said_why_not(equation) -> None:
    assert [name for name in equation.holds if not is_there(name)] == []
    assert [name for name in equation.tests if not is_a_test(name)] == []
    proved = {number for case in CASES.values() for number in case.equations}
    assert equation.note or equation.holds
    assert not equation.holds or set(equation.each) <= proved


def test_what_is_gone_is_noticed() -> None:
    assert is_there("bsm_mesh.contact.kernels:spring_forces")
    assert not is_there("bsm_mesh.contact.kernels:spring_force")
    assert not is_there("bsm_mesh.model.bolts:Bolt.no_such")
    assert is_a_test("verification/test_manual.py::test_case")
    assert not is_a_test("verification/test_manual.py::test_cases_gone")
    assert not is_a_test("verification/gone.py::test_case")


@pytest.mark.slow  # two tables take the answers of all cases, wherever those were found
@pytest.mark.parametrize("table", [table for table in TABLES if not table.is_slow], ids=lambda table: table.name)
def test_the_pages_say_what_the_cases_find(table) -> None:
    page = (ROOT / table.page).read_text(encoding="utf-8")
    assert differences(table_in(page, table.name), table.make(), table.tolerance) == []


def test_slow_tables_have_their_marks() -> None:
    for table in TABLES:
        assert table_in((ROOT / table.page).read_text(encoding="utf-8"), table.name)


@pytest.mark.parametrize(
    ("exact", "found", "error"),
    [
        (2.0, 1.0, 0.5),
        (0.0, 0.25, 0.25),
        (np.array([4.0, 0.0]), np.array([4.0, 1.0]), 0.25),
        (1.0, Between(0.99, 1.02), 0.02),
        ("slides", "slides", 0.0),
        ("slides", "stands", np.inf),
        (1.0, np.nan, np.inf),
    ],
)
def test_error(exact, found, error) -> None:
    assert error_of(exact, found) == pytest.approx(error)


def test_a_limit_that_is_not_between_is_an_error() -> None:
    assert limit_between(lambda x: x < 1, 0.9, 1.1) == Between(0.9, 1.1)
    assert error_of(1.0, limit_between(lambda x: x < 2, 0.9, 1.1)) == np.inf


@pytest.mark.parametrize(
    ("error", "words"), [(0.0, "below 1e-8"), (2e-8, "below 1e-6"), (0.0123, "1.23 %"), (np.inf, "wrong")]
)
def test_errors_in_words(error, words) -> None:
    assert in_words(error) == words


def test_tables_of_other_pages_are_found_by_their_columns() -> None:
    rows = table_with("other_programs.md", "model", "program", "verdict or movement")
    assert {row["program"] for row in rows} == {"bsm-mesh", "compas_dem", "lmgc90"}
    with pytest.raises(ValueError, match=r"other_programs\.md has no table with the columns gone"):
        table_with("other_programs.md", "gone")
