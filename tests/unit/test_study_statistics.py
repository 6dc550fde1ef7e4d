"""What a study says of its runs: journal, table, probability of failure, quantiles, which key decides."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bsm_mesh.errors import ModelError
from bsm_mesh.studies.journal import Journal
from bsm_mesh.studies.sampling import Plan
from bsm_mesh.studies.statistics import effects_on, failure_of, main_answer, spread_of, summary_of
from bsm_mesh.studies.table import StudyTable, make_table
from bsm_mesh.text.study_tables import GAVE_WAY, sheet_rows, study_rows


def table_of(rows: list[dict[str, Any]], factor: bool = False, **keys: list[Any]) -> StudyTable:
    plan = Plan(values=keys or {"a": [float(run) for run in range(len(rows))]})
    return make_table(plan, dict(enumerate(rows)), factor=factor, bulk="area", metadata={"version": "0"})


def with_status(**counts: int) -> StudyTable:
    return table_of([{"status": status} for status, count in counts.items() for _ in range(count)])


def test_runs_without_a_verdict_are_bounds_and_no_failures() -> None:
    told = failure_of(with_status(stable=5, stable_after_falls=1, unstable=2, not_converged=1, failed=1), drawn=True)
    assert (told.runs, told.stable, told.unstable, told.undecided, told.failed) == (10, 6, 2, 1, 1)
    assert told.share == 2 / 8
    assert told.bounds == (2 / 10, 4 / 10)


def test_a_run_that_comes_to_rest_beyond_the_limit_fails() -> None:
    table = table_of([{"status": "stable", "max_displacement": moved} for moved in (0.001, 0.2, 0.5)])
    assert failure_of(table, drawn=False).share == 0
    limited = StudyTable(keys=table.keys, columns=table.columns, metadata={"movement_limit": "0.1"})
    told = failure_of(limited, drawn=False)
    assert (told.stable, told.moved_far, told.unstable, told.share) == (1, 2, 0, 2 / 3)
    assert main_answer(limited) == "failure"


def test_stable_runs_in_which_blocks_gave_way_are_counted() -> None:
    """A slide of 13 m that ends on the road is at rest, and must not be read as a slope that never moved."""
    rows = [{"status": status, "moved_blocks": n} for status, n in [("stable", 0), ("stable", 4), ("unstable", 2)]]
    told = summary_of(table_of(rows), drawn=True)
    assert (told["failure"]["stable"], told["failure"]["gave_way"]) == (2, 1)
    assert (GAVE_WAY, "1") in study_rows({"title": "", **told})[0][2]
    limited = replace(table_of(rows), metadata={"movement_limit": "0.1"})
    assert failure_of(limited, drawn=True).gave_way == 0


def test_the_interval_is_clopper_and_pearsons() -> None:
    """With no failure in n runs its upper end is where (1 - p)^n = 0.025."""
    told = failure_of(with_status(stable=30), drawn=True)
    assert told.interval == pytest.approx((0.0, 1 - 0.025 ** (1 / 30)))
    told = failure_of(with_status(stable=29, unstable=1), drawn=True)
    assert told.interval is not None
    assert told.interval[0] == pytest.approx(1 - 0.975 ** (1 / 30))
    assert failure_of(with_status(stable=29, unstable=1), drawn=False).interval is None


def test_nothing_decided_has_no_probability() -> None:
    told = failure_of(with_status(failed=3), drawn=True)
    assert (told.share, told.interval, told.bounds) == (None, None, (0.0, 1.0))
    assert main_answer(with_status(failed=3)) is None
    assert summary_of(with_status(failed=3), drawn=True)["answers"] == []


def test_quantiles_are_of_the_runs_that_have_an_answer() -> None:
    rows = [{"status": "stable", "factor": 1 + run / 100} for run in range(101)]
    table = table_of([*rows, {"status": "failed"}], factor=True)
    told = spread_of(table, "factor")
    assert (told.runs, told.mean) == (101, pytest.approx(1.5))
    assert told.quantiles == pytest.approx({"5 %": 1.05, "25 %": 1.25, "50 %": 1.5, "75 %": 1.75, "95 %": 1.95})
    assert told.deviation == pytest.approx(math.sqrt(101 * 102 / 12) / 100)
    assert main_answer(table) == "factor"


def test_movements_are_those_of_stable_runs() -> None:
    moved = [{"status": "stable", "max_displacement": 1.0}, {"status": "unstable", "max_displacement": 99.0}]
    assert spread_of(table_of(moved), "max_displacement").quantiles["95 %"] == 1.0
    assert main_answer(table_of(moved)) == "failure"
    assert main_answer(table_of(moved[:1])) == "max_displacement"


def test_the_key_that_decides_comes_first() -> None:
    generator = np.random.default_rng(3)
    a, b = generator.random(400), generator.random(400)
    rows = [{"status": "stable", "factor": float(math.exp(3 * x) + 0.1 * y)} for x, y in zip(a, b, strict=True)]
    first, second, third = effects_on(table_of(rows, True, b=b.tolist(), a=a.tolist(), c=[7] * 400), "factor")
    assert (first.key, second.key, third.key) == ("a", "b", "c")
    assert first.correlation == pytest.approx(1, abs=0.01)  # of ranks: the exponential does not matter
    low, high = ((math.exp(3 * end) - math.exp(3 * end - 0.75)) / 0.75 + 0.05 for end in (0.25, 1.0))
    assert first.low == pytest.approx(low, rel=0.06)  # means of 100 values
    assert first.high == pytest.approx(high, rel=0.06)
    assert abs(second.correlation or 1) < 0.2
    assert (third.correlation, third.low, third.width) == (None, None, 0.0)


def test_a_table_is_read_as_it_was_written(tmp_path: Path) -> None:
    rows = [
        {"status": "stable", "max_displacement": 0.5, "steps": 3, "seconds": 0.1},
        {"status": "failed", "error": "no such boundary"},
    ]
    table = table_of(rows, x=[1.5, 2], seed=[1, 2], law=["patton", "mohr_coulomb"])
    table.write(tmp_path / "study.parquet")
    back = StudyTable.read(tmp_path / "study.parquet")
    assert back.columns == table.columns
    assert (back.keys, back.metadata) == (("x", "seed", "law"), {"version": "0"})
    from pyarrow import parquet

    file = parquet.ParquetFile(tmp_path / "study.parquet")
    assert [str(file.schema_arrow.field(name).type) for name in back.keys] == ["double", "int64", "string"]
    assert file.metadata.row_group(0).column(0).compression == "ZSTD"


def test_the_sheet_of_a_study_has_units_and_leaves_out_what_there_is_not() -> None:
    rows = [{"status": "stable", "max_displacement": 0.5, "seconds": 0.1}, {"status": "failed", "error": "no mesh"}]
    table = table_of(rows, x=[1.5, 2])
    table = replace(table, metadata={**table.metadata, "units": json.dumps({"x": "degrees"})})
    header, *cells = sheet_rows(table)
    assert {"run", "x [degrees]", "status", "max_displacement [m]", "seconds [s]"} <= set(header)
    first, second = (dict(zip(header, row, strict=True)) for row in cells)
    assert (first["x [degrees]"], first["max_displacement [m]"], first["error"]) == (1.5, 0.5, "")
    assert (second["status"], second["max_displacement [m]"], second["error"]) == ("failed", "", "no mesh")


def test_what_is_no_table_is_told(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no such file"):
        StudyTable.read(tmp_path / "study.parquet")
    (tmp_path / "study.parquet").write_text("junk")
    with pytest.raises(ModelError, match="damaged"):
        StudyTable.read(tmp_path / "study.parquet")


def test_a_journal_bears_torn_lines(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "runs.jsonl")
    assert journal.rows() == {}
    journal.add(4, {"status": "stable"})
    journal.add(2, {"status": "failed", "error": "a\nb"})
    with journal.path.open("ab") as file:
        file.write(b'\n{"run": 7, "sta')  # the process was killed here
    assert journal.rows() == {4: {"status": "stable"}, 2: {"status": "failed", "error": "a\nb"}}
    journal.add(7, {"status": "unstable"})
    journal.add(7, {"status": "stable"})  # of two the first counts
    assert journal.rows()[7] == {"status": "unstable"}
    assert all(json.loads(line) for line in journal.path.read_text().splitlines() if line.endswith("}"))


@pytest.mark.parametrize(
    ("old", "new"),
    [('"max": 1.5', '"max": 1.4'), ('"run": 3', '"run": 9'), ('"stable"', '"unstable"'), ("}", ', "more": 1}')],
)
def test_a_line_that_was_changed_is_noticed(tmp_path: Path, old: str, new: str) -> None:
    """Which one, and what to do; a line of another study, or of other code, is none of this one's either."""
    journal = Journal(tmp_path / "runs.jsonl", "a study")
    journal.add(1, {"status": "stable", "max": 0.1 + 0.2})
    journal.add(3, {"status": "stable", "max": 1.5})
    assert journal.rows()[1]["max"] == 0.1 + 0.2
    with pytest.raises(ModelError, match=r"runs\.jsonl: line 2, 4 is not as this study wrote it; remove"):
        Journal(tmp_path / "runs.jsonl", "another").rows()
    before, last = journal.path.read_text().rstrip("\n").rsplit("\n", 1)
    assert old in last
    journal.path.write_text(f"{before}\n{last.replace(old, new, 1)}\n")
    with pytest.raises(ModelError, match=r"runs\.jsonl: line 4 is not as this study wrote it"):
        journal.rows()
    journal.path.write_text(f"{before}\n")
    assert set(journal.rows()) == {1}
