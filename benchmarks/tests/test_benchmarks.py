"""The benchmark suite: it runs, its times add up, its split leaves the program as it was."""

import argparse
import importlib
import json
import os
import subprocess
import sys
from argparse import Namespace
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from benchmarks import damped_slopes, engines, measure, pages, programs, report, shaken_walls, tables, tall_walls
from benchmarks.cases import CASES
from tests.scenes import large

ROOT = Path(__file__).parents[2]
PEER = "import json; print(json.dumps({'verdict': 'at rest', 'note': 'none', 'residual': 0.5}))"


@pytest.mark.slow
def test_run(tmp_path):
    command = [sys.executable, "-m", "benchmarks", "--scene", "wall", "--sizes", "100", "--folder", str(tmp_path)]
    command += ["--programs", "bsm", "--peer", f'none={sys.executable} -c "{PEER}"']
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = json.loads((tmp_path / "rows.json").read_text(encoding="utf-8"))["cases"]["wall"]
    (ours,), (other,) = rows["bsm"], rows["none"]
    assert ours["verdict"] == "stable"
    assert ours["blocks"] == other["blocks"] == 106
    assert ours["residual"] < 1e-6
    assert sum(ours["parts"].values()) == pytest.approx(ours["processor"], rel=1e-6)
    assert all(seconds >= 0 for seconds in ours["parts"].values())
    assert ours["factorizations"] > 0
    assert other["residual"] == 0.5
    assert (tmp_path / "wall.png").stat().st_size > 1000
    assert "factorizations" in done.stdout


@pytest.mark.heavy
def test_factorizations_are_those_of_all_blocks():
    """Not those of the few that are solved apart: a wall of a million bricks has a thousand of these."""
    given = Namespace(solver="auto", threads=1, max_steps=50, trace=False)
    row = programs.run_bsm(large.tilted_wall, 1000, given)
    results = bsm.run(large.tilted_wall(1000).model(), bsm.Options(scheme="continuation", threads=1))
    assert row["factorizations"] == sum(step.factorizations for step in results.stages[-1].steps) < 10


def test_split_counts_inner_work_once_and_leaves_no_trace():
    pattern = importlib.import_module("bsm_mesh.solve.algebra.block_matrix")
    system = importlib.import_module("bsm_mesh.solve.linear.system")
    before = pattern.block_pattern
    split = measure.Split()
    with split.watch():
        assert system.block_pattern is pattern.block_pattern is not before
        system.block_pattern(2, *(np.array([k], dtype="int32") for k in (0, 1)))
    assert system.block_pattern is pattern.block_pattern is before
    assert 0 < split.seconds["assembly"] < split.processor
    assert sum(split.seconds.values()) == pytest.approx(split.processor)


def test_a_page_is_written_from_stored_rows(tmp_path):
    row = {"blocks": 1000, "asked": 1000, "verdict": "stable", "seconds": 9.0, "processor": 4.0, "memory": 0.5}
    row |= {"factorizations": 3, "parts": {"factorization": 1.0, "contacts": 1.0, "assembly": 1.0, "rest": 1.0}}
    larger = row | {"blocks": 10_000, "asked": 1e4, "processor": 40.0}
    late = {"blocks": 1000, "asked": 1000, "verdict": "no answer", "note": "stopped"}
    start = {"blocks": 106, "asked": 106, "verdict": "done", "seconds": 1.0, "note": "x"}
    stale = larger | {"processor": 99.0}
    first = {"wall": {"bsm": [row, stale], "pymunk": [late]}}
    for name, cases in (("a", first), ("b", {"start": {"help": [start]}, "wall": {"bsm": [larger]}})):
        (tmp_path / name).write_text(json.dumps({"where": f"Commit {name}", "cases": cases}))
    page, (begin, end) = tmp_path / "page.md", pages.marks(tables.MAKER)
    page.write_text(f"{begin}\n{end}\n")
    tables.write_into(page, [tmp_path / "a", tmp_path / "b"])
    text = page.read_text()
    assert "Commit a; Commit b" in text
    assert "| model |  | 1000 blocks | 10000 blocks |" in text
    assert "| Half-bond wall tilted by 5 degrees | bsm | 4 s, 0.50 GB, stable | 40 s, 0.50 GB, stable |" in text
    assert "| wall | bsm | 1000 | stable | 4.00 | 0.50 | 3 | 25 % | 0 % | 50 % | 0 % | 25 % |" in text
    assert "| wall | bsm | 1.00 | 10000 | 4 | 52 |" in text
    assert "| start | help | 106 | 1.00 |" in text
    assert "pymunk" not in text


def test_what_a_command_makes_stands_between_its_marks(tmp_path, capsys):
    page = tmp_path / "page.md"
    begin, end = pages.marks("a command")
    page.write_text(f"before\n{begin}\nold\n{end}\nafter\n")
    pages.tell("new", "a command", page)
    assert page.read_text() == f"before\n{begin}\n\nnew\n\n{end}\nafter\n"
    pages.tell("new", "a command", None)
    assert capsys.readouterr().out == "new\n"


@pytest.mark.parametrize("text", ["no marks", "{1}{0}", "{0}{0}{1}", "{0}{1}{1}", None])
def test_a_page_without_the_marks_is_refused_before_anything_is_run(tmp_path, capsys, text):
    page, parser = tmp_path / "page.md", argparse.ArgumentParser()
    pages.add_into(parser, "a command")
    if text is not None:
        page.write_text(text.format(*pages.marks("a command")))
    with pytest.raises(SystemExit) as end:
        parser.parse_args(["--into", str(page)])
    assert end.value.code == 2
    assert f"--into: {page}: " in capsys.readouterr().err


def test_growth():
    rows = [{"blocks": n, "verdict": "stable", "seconds": 1e-4 * n**1.2} for n in (10, 1000, 10_000, 100_000)]
    rows[0]["seconds"] = 5.0  # start-up
    rows.append({"blocks": 1_000_000, "verdict": "not_converged", "seconds": 60.0})
    assert report.exponent(rows) == pytest.approx(1.2)
    assert report.exponent(rows[:2]) is None


def test_scenes():
    for name in ("tilted_wall", "jointed_slope", "leaning_slope", "blocky_rock", "sliding_layers"):
        model = getattr(large, name)(200).model()
        assert 150 < model.blocks.count < 350, name


@pytest.mark.parametrize(("given", "degrees"), [(None, "35"), (30.0, "30")])
def test_titles_name_the_friction(given, degrees):
    assert CASES["slope"].at_friction(given).title.endswith(f"friction {degrees} degrees")
    assert CASES["linear"].at_friction(given) is CASES["linear"]


@pytest.mark.heavy
def test_both_engines_cut_geometries_alike():
    given, cases = list(engines.masses()), len(engines.CASES)
    assert len(given) == cases + engines.NETWORKS
    found = [engines.compared(*one) for one in given[:cases] + given[cases::5]]  # all: python -m benchmarks.engines
    assert [one.row for one in found if not one.agree] == []


@pytest.mark.heavy
def test_a_row_of_shaken_walls(monkeypatch):
    monkeypatch.setattr(shaken_walls, "LENGTH", 2.1)
    found = dict(zip(shaken_walls.HEADER, shaken_walls.row(2, "explicit", 0.5, 1), strict=True))
    assert found["blocks"] == "6"
    assert float(found["balance missed by, %"]) < 1
    assert int(found["steps"]) > 1000


@pytest.mark.slow
def test_a_row_of_damped_slopes():
    """The sums of dashpots never make the time step shorter than their greatest ratio does."""
    row = damped_slopes.row(*damped_slopes.drawn(1)[0])
    blocks, _, verdict, expected, steps, before, *_ = row
    assert (int(blocks) > 50, verdict) == (True, "stable")
    assert 0.5 * int(expected) < int(steps) <= int(before)


def test_tall_walls_are_drawn_short_of_toppling_and_of_sliding():
    for number in range(tall_walls.WALLS):
        courses, bricks, tilt, friction = tall_walls.wall(number)
        assert 4500 < courses * bricks < 10_500
        assert np.tan(np.radians(tilt)) < min(bricks / (0.5 * courses), np.tan(np.radians(friction)))
