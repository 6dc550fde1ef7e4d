"""What `run` says in an engineer's words: every unstable block, how far blocks moved, nothing wider than a terminal."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.commands.demo import without_bolts
from bsm_mesh.results.movement import part_of_size
from bsm_mesh.text.tables import (
    STAGE_HEADER,
    bolt_rows,
    describe,
    down_rows,
    engineering,
    falling,
    print_table,
    stage_rows,
    weights,
)
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.small_case import Case


@pytest.fixture(scope="module")
def falls() -> bsm.results.Results:
    """Return the results of two blocks of 1 and 0.25 m2 in the air beside one that rests."""
    shapes = [
        rectangle(0, 0, 10, 1),
        rectangle(1, 1, 3, 2),
        rectangle(5, 4, 6, 5),
        rectangle(8, 4, 8.5, 4.5),
    ]
    options = bsm.Options(falls=bsm.Falls(ignore_below=0), displacement_limit=0.5)
    return bsm.run(model_of(shapes, friction=30.0), options)


def test_what_comes_down_is_told_with_place_area_weight_and_part(falls: bsm.results.Results) -> None:
    stage, weight = falls.stages[-1], -falls.stages[-1].evidence.weight[:, 1]
    assert stage.unstable_blocks.tolist() == [2, 3]
    rows = down_rows(falls)
    assert [row[:3] for row in rows] == [("2", "(5.5, 4.5) m", "1 m2"), ("3", "(8.25, 4.25) m", "0.25 m2")]
    assert [row[3] for row in rows] == [f"{weight[b] / 1e3:.4g} kN/m" for b in (2, 3)]
    assert [row[4] for row in rows] == ["7.5 %", "1.9 %"]  # of 13.25 m2
    assert falling(falls, stage).startswith("2 blocks, 1.25 m2 (9.4 % of all), ")


def test_the_weight_of_a_block_is_without_an_earthquake(falls: bsm.results.Results) -> None:
    """Weights, in tables and pictures, are unit weight times area, whatever pulls besides."""
    quake = bsm.Stage(name="quake", gravity=(0.3, -0.2))
    shaken = bsm.run(falls.model.replace(stages=[quake], gravity_horizontal=0.1), falls.options)
    calm = falls.model.weights
    for number in range(len(shaken.stages)):
        assert weights(shaken, shaken.stages[number]) == pytest.approx(calm)
    assert [row[3] for row in down_rows(shaken)] == [row[3] for row in down_rows(falls)]
    told = "".join(text.get_text() for axes in shaken.plot("final_position").axes for text in axes.texts)
    assert f"1 m2, {engineering(float(calm[2]), 'N/m')}" in told


def test_words_of_the_solver_are_told_where_they_are_asked_for(falls: bsm.results.Results) -> None:
    short, long = dict(describe(falls)), dict(describe(falls, verbose=True))
    assert "weights and loads (x, y)" in short
    assert not any("factorization" in row or "residual" in row for row in short)
    assert {"steps, factorizations", "greatest unbalanced force of a block"} <= set(long)
    assert short["greatest displacement"].endswith("(of the other blocks)")


def test_where_all_blocks_fall_there_is_no_displacement_of_others(falls: bsm.results.Results) -> None:
    stage = falls.stages[-1]
    all_down = replace(stage, unstable_blocks=np.flatnonzero(stage.present).astype(np.int32))
    assert dict(describe(falls, all_down))["greatest displacement"] == "not available: all blocks fall"


def test_stages_behind_an_unstable_one_are_named(falls: bsm.results.Results) -> None:
    assert "stages not computed" not in dict(describe(falls))
    later = [bsm.Stage(name=name) for name in ("bolts", "earthquake")]
    results = bsm.run(falls.model.replace(stages=later), falls.options)
    assert results.status == "unstable"
    assert dict(describe(results))["stages not computed"] == "bolts, earthquake"
    assert repr(results).endswith("not computed: bolts, earthquake")
    assert "stages not computed" not in dict(describe(results, results.stages[0])) or len(results.stages) == 1


def test_lengths_as_parts_of_a_block() -> None:
    blocks = bsm.Blocks.from_polygons([rectangle(0, 0, 4, 1)], rock="rock")
    assert part_of_size(blocks, 0, 0.5) == "0.25 of the block's size"
    assert part_of_size(blocks, 0, 5.0) == "2.5 times the block's size"


def test_greatest_force_and_greatest_utilisation_are_told_of_their_own_bolts() -> None:
    """The strong bolt carries more, the weak one has used more of its strength."""
    model = model_of([rectangle(0, 0, 4, 1), rectangle(0, 1, 2, 3), rectangle(2, 1, 4, 3)], friction=30.0)
    kind = {"diameter": 0.02, "bond_strength": 1e6}
    strong = bsm.Bolt(name="strong", start=(1, 2.5), end=(1, 0.5), yield_strength=500e6, pretension=60e3, **kind)
    weak = bsm.Bolt(name="weak", start=(3, 2.5), end=(3, 0.5), yield_strength=100e6, pretension=30e3, **kind)
    rows = dict(describe(bsm.run(model.replace(bolts=[strong, weak]))))
    assert rows["greatest force in a bolt"].endswith("(strong)")
    assert re.search(
        r"\(weak, \S+ m from its head, where its force is \S+ kN\)$", rows["greatest utilisation of a bolt"]
    )
    assert rows["bolts"] == "2 elastic"
    stage = bsm.run(model.replace(bolts=[strong, weak])).stages[-1]
    used = np.where(stage.bolts.bolt == 1, 0.999997, 0.5)  # it slipped, and rests a hair below its strength
    told = dict(bolt_rows(replace(stage.bolts, utilisation=used)))
    assert told["bolts"] == "2 elastic (within 1 % of their strength: weak)"


def test_a_displacement_is_since_the_start_as_in_the_files() -> None:
    """A block settles in the first stage and rests in the second: the movement in a stage has another name."""
    model = model_of([rectangle(-5, -1, 5, 0), rectangle(0, 0, 1, 1)], friction=30.0, stages=[bsm.Stage(name="later")])
    results = bsm.run(model)
    rows = [dict(zip(STAGE_HEADER, row, strict=True)) for row in stage_rows(results)]
    assert rows[1]["displacement"] == engineering(results.stages[1].max_displacement, "m") != "0 m"
    assert rows[0]["in the stage"] == rows[0]["displacement"]
    assert rows[1]["in the stage"] == "0 m"


def test_the_displacement_of_what_comes_down_is_since_the_start() -> None:
    """The upper block settles by centimetres, then the lower one is excavated."""
    shapes = [rectangle(0, -1, 3, 0), rectangle(1, 0, 2, 1), rectangle(1, 1, 2, 2)]
    model = model_of(shapes, friction=30.0, kn=1e6, stages=[bsm.Stage(name="dig", excavate=[1])])
    results = bsm.run(model, bsm.Options(displacement_limit=0.5))
    stage = results.stages[-1]
    whole, part = (float(np.hypot(*d[2, :2])) for d in (stage.displacement, stage.stage_displacement))
    assert whole > part + 0.01
    ((*_, told),) = down_rows(results)
    assert told == engineering(whole, "m")


def test_bolts_that_are_not_installed_yet_have_no_force() -> None:
    bolt = bsm.Bolt(start=(0.5, 0.9), end=(0.5, -0.5), diameter=0.02, stage="bolts")
    shapes = [rectangle(-5, -1, 5, 0), rectangle(0, 0, 1, 1)]
    results = bsm.run(model_of(shapes, friction=30.0, bolts=[bolt], stages=[bsm.Stage(name="bolts")]))
    assert bolt_rows(results.stages[0].bolts) == [("bolts", "1 absent")]
    assert dict(bolt_rows(results.stages[1].bolts))["greatest force in a bolt"].startswith("0 N (")


def test_numbers_that_are_too_wide_for_a_terminal_keep_their_units(capsys: pytest.CaptureFixture[str]) -> None:
    row = ("greatest displacement", "10", *["0.5833 mm"] * 5)
    print_table("Answers", ("", "runs", "mean", "deviation", "5 %", "50 %", "95 %"), [row])
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= 80 for line in lines)
    assert " ".join(lines).split().count("mm") == 5


def test_a_thing_wider_than_a_terminal_leaves_room_for_its_value(capsys: pytest.CaptureFixture[str]) -> None:
    wide = "of these after blocks fell or moved by more than a tenth of their size (movement_limit makes them failures)"
    print_table("A study", ("", ""), [("runs", "60"), (wide, "5"), ("probability of failure", "0.1685 to 0.4159")])
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= 80 for line in lines)
    words = " ".join(lines).split()
    assert [word for word in words if word[0].isdigit()] == ["60", "5", "0.1685", "0.4159"]
    assert " ".join(words).startswith("A study runs 60 of these after blocks fell")
    assert words.count("failures)") == 1


@pytest.mark.heavy
def test_tables_fit_a_terminal(case: Case, capsys: pytest.CaptureFixture[str]) -> None:
    print_table("A title that is longer than its table by far", ("a", "b"), [("1", "2")])
    title, *_ = capsys.readouterr().out.splitlines()
    assert title == "A title that is longer than its table by far"  # not broken at the table's width
    case.run("new", "tunnel", "mine")
    for command in (["run", "mine/model.toml", "-q"], ["check", "mine/model.toml", "-q"], ["limit", "mine/model.toml"]):
        for line in case.run(*command).out.splitlines():
            told = line.startswith(
                ("stage ", "note: ", "written ", "next: ", "mesh: ", "admissible", "No limit", "Beyond")
            )
            assert told or len(line) <= 80, line


@pytest.mark.slow
def test_what_fell_and_what_is_compared_is_told_whole(case: Case) -> None:
    """A table of what was taken away, and one with wide numbers: 80 columns, nothing cut, no word broken."""
    case.run("new", "cavern", "mine")
    text = without_bolts((case.folder / "mine/model.toml").read_text(encoding="utf-8"))
    case.write("mine/model.toml", text + '\n[falls]\non_fall = "remove"\n')
    said = case.run("run", "mine/model.toml", "-q").out
    table = said[said.index("Blocks that fell and were taken away") : said.index("stage heading")]
    assert all(len(line) <= 80 for line in table.splitlines())
    assert "…" not in said
    assert ": blocks 92, 94: " in said
    told = case.run("compare", "mine/model.toml").out
    assert "…" not in told
    assert all(len(line) <= 80 for line in told.splitlines() if line.startswith("  "))


@pytest.mark.parametrize(("asked", "on"), [((), "weights and loads"), (("--load", "1"), "load 1")])
def test_a_limit_says_what_it_is(case: Case, asked: tuple[str, ...], on: str) -> None:
    outcome = case.run("limit", "model.toml", *asked)
    assert f"No limit: for every factor on {on}, statics alone does not prove" in outcome.out
    assert "That is no factor of safety" in outcome.out
