"""Campaigns: what is too slow or fails is recorded, what is stopped continues, what is stored is compared."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from benchmarks.campaign import comparison, runner, store, tables
from benchmarks.campaign.__main__ import LARGE, MAKER, main
from benchmarks.pages import marks

pytestmark = pytest.mark.robust

HEAD = {"engine": "e", "limit": 5.0, "commit": "c"}


def record(status="stable", seconds=1.0, digest="d", contradictions=(), **more):
    numbers = {"blocks": 9, "steps": 2, "factorizations": 5, "moved": 0.0}
    return {
        "status": status,
        "seconds": seconds,
        "digest": digest,
        "contradictions": list(contradictions),
        **numbers,
        **more,
    }


@pytest.mark.slow
def test_slow_and_failing_models_are_recorded_and_the_others_run():
    found = {}
    slow = "1e4 layers"  # of 10 000 blocks
    tasks = [(slow, 0), ("no such family", 0), ("wall", 1)]
    runner.run_all(tasks, 1, 2.0, lambda r: found.__setitem__(r["family"], r))
    assert found[slow]["status"] == "timeout"
    assert found["no such family"]["status"] == "error"
    assert "KeyError" in found["no such family"]["reason"]
    assert found["wall"]["status"] == "stable"
    assert found["wall"]["facts"]["lack_at_end"] < 1e-6


def test_a_log_goes_on_where_it_was_stopped(tmp_path):
    path = tmp_path / "log.jsonl"
    runner.Log(path, HEAD).keep({"family": "a", "seed": 1})
    with path.open("a") as file:
        file.write('{"family": "a", "se')  # stopped while it was written
    log = runner.Log(path, HEAD)
    assert log.done == {("a", 1)}
    log.keep({"family": "a", "seed": 2})
    assert [json.loads(line).get("seed") for line in path.read_text().splitlines()] == [None, 1, 2]


def test_a_log_of_another_program_is_refused(tmp_path):
    runner.Log(tmp_path / "log.jsonl", HEAD)
    with pytest.raises(ValueError, match="of another engine"):
        runner.Log(tmp_path / "log.jsonl", HEAD | {"engine": "other"})


def test_models_come_in_turn():
    tasks = list(runner.in_turn({"many": 4, "few": 2}))
    assert len(tasks) == 6
    assert {family for family, _ in tasks[:3]} == {"many", "few"}


def test_what_changed_is_told_by_name():
    names = ("same", "lost", "gained", "changed", "false", "other model", "gone")
    before = {(name, 1): record() for name in names}
    before["gained", 1] = record("not_converged")
    now = {key: record(seconds=0.5, factorizations=10) for key in before if key[0] != "gone"}
    now["lost", 1] = record("timeout")
    del now["lost", 1]["digest"]
    now["changed", 1] = record("unstable", 0.5)
    now["false", 1] = record(contradictions=["end: 3 weights"])
    now["other model", 1] = record("unstable", digest="x")
    pairs, others = comparison.pairs_of(before, now)
    assert others == 1
    told = {(row[0], row[1]) for row in comparison.differences(pairs)[1:]}
    assert told == {("lost", "lost 1"), ("gained", "gained 1"), ("changed", "changed 1"), ("new proof", "false 1")}
    ratios = {row[0]: row for row in comparison.ratios(pairs, (5.0, 5.0))[1:]}
    assert ratios["same"][5:7] == ["0.50", "0.50"]
    assert ratios["same"][-1] == "2.00"
    assert ratios["all"][1:5] == ["5", "1", "1", "1"]


def test_tables_count_and_spread():
    records = {("a", k): record(seconds=float(k), contradictions=["end: x"] * (k == 1)) for k in range(1, 11)}
    rows = tables.of_families(records, 5.0)
    row = dict(zip(rows[0], rows[1], strict=True))
    assert (row["models"], row["stable"], row["proofs"], row["sum s"]) == ("10", "10", "1", "55")
    assert row["processor s"] == "5.50 / 9.55 / 10.00"
    assert tables.of_contradictions(records)[1] == ["a 1", "9", "end: x"]


def test_large_scenes_stand_beside_what_they_were_before(tmp_path):
    names, files = ("1e4 wall", "1e4 layers", "1e5 wall"), [tmp_path / name for name in ("1e4", "1e5", "before")]
    for file, limit in zip(files, (5.0, 50.0, 9.0), strict=True):
        log = runner.Log(file, HEAD | {"limit": limit})
        for name in names:
            slow = name == "1e5 wall" and file.name == "1e5"
            if name.startswith(file.name) or (file.name == "before" and name != "1e4 layers"):
                log.keep({"family": name, "seed": 0, **record("timeout" if slow else "stable", 2.0 * limit)})
    page, (begin, end) = tmp_path / "page.md", marks(MAKER)
    page.write_text(f"{begin}\n{end}\n")
    assert main(["table", *map(str, files[:2]), "--against", str(files[2]), "--into", str(page)]) == 0
    rows = [line.split(" | ") for line in page.read_text().splitlines() if line.startswith("| 1e")]
    found = {row[0][2:]: (row[5], row[-2], row[-1][:4]) for row in rows}
    assert list(found) == list(names)
    assert found["1e4 wall"] == ("10.0", "18.0", "0.56")
    assert found["1e5 wall"][:2] == ("over 50.0", "18.0")
    assert found["1e5 wall"][2].strip("| ") == ""  # the ratio to a run that was stopped is none
    assert "at most 5 processor seconds a model: 1e4 wall, 1e4 layers. Commit" in page.read_text()
    assert "at most 9 processor seconds" in page.read_text().partition("### ")[2]


def test_large_scenes_stand_beside_the_stored_large_ones_by_default(tmp_path, capsys):
    runner.Log(tmp_path / "log", HEAD).keep({"family": "1e4 wall", "seed": 0, **record("stable", 2.0)})
    assert main(["table", str(tmp_path / "log"), "--against"]) == 0
    head, before = store.read([LARGE])
    told = capsys.readouterr().out
    assert f"against Commit {head['commit']}" in told
    assert f"{2.0 / before['1e4 wall', 0]['seconds']:.2f}" in told.splitlines()[-1].split()


def test_methods_are_counted_where_steps_tell_them():
    records = {("a", 1): record(methods={"newton": 2}), ("a", 2): record(methods={"newton": 1, "motion": 4})}
    assert tables.of_families(records, 5.0)[1][-1] == "motion 4, newton 3"


def test_packed_records_come_back(tmp_path):
    records = {("b", 1): {"family": "b", "seed": 1}, ("a", 2): {"family": "a", "seed": 2}}
    store.pack(HEAD, records, tmp_path / "packed.jsonl.xz")
    head, found = store.read([tmp_path / "packed.jsonl.xz"])
    assert head == HEAD
    assert found == records


def test_a_page_is_written_between_its_marks(tmp_path):
    log, page = tmp_path / "log.jsonl", tmp_path / "page.md"
    begin, end = marks(MAKER)
    runner.Log(log, HEAD).keep({"family": "wall", "seed": 0, **record()})
    page.write_text(f"before\n{begin}\nold\n{end}\nafter\n")
    assert main(["table", str(log), "--into", str(page)]) == 0
    text = page.read_text()
    assert "| wall | 1 | 1 |" in text
    assert "old" not in text
    assert text.startswith("before")
    assert text.endswith("after\n")
    (tmp_path / "empty.md").write_text("no marks")
    with pytest.raises(SystemExit) as refused:
        main(["table", str(log), "--into", str(tmp_path / "empty.md")])
    assert refused.value.code == 2


def test_an_unknown_family_is_refused_in_one_sentence(capsys):
    assert main(["--families", "walls"]) == 2
    assert capsys.readouterr().err.startswith("error: there is no family 'walls'")
    assert main(["run", "--size", "1e4", "--families", "wall"]) == 2
    assert capsys.readouterr().err.startswith("error: there is no family 'wall'; there are 1e4 wall, 1e4 wall 30")


@pytest.mark.slow
def test_the_command_runs_resumes_and_compares(tmp_path):
    file = tmp_path / "log.jsonl"
    command = [sys.executable, "-m", "benchmarks.campaign", "--families", "beam", "--share", "0.02"]
    command += ["--file", str(file), "--time-limit", "20"]
    environment = {**os.environ, "PYTHONPATH": str(store.ROOT)}
    given = {"cwd": store.ROOT, "env": environment, "capture_output": True, "text": True, "check": False}
    first = subprocess.run(command, **given)
    assert first.returncode == 0, first.stderr
    assert "closed form" in first.stdout
    lines = file.read_text()
    again = subprocess.run([*command, "--against", str(file)], **given)
    assert "2 models, 2 of them done" in again.stderr
    assert "2 models in both" in again.stdout
    assert file.read_text() == lines
