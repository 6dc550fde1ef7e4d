"""Names come from strangers' files and go to other programs: no line break in them is a command, no cell a formula."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.exports import PROGRAMS, export
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.result_tables import OutputForm
from bsm_mesh.folder.storage import save_results
from bsm_mesh.pictures.figures import entitle, paper, save
from bsm_mesh.reading import as_given_text
from bsm_mesh.text.csv_tables import CsvWriter
from tests.scenes.arch import arch
from tests.scenes.small_case import LINEAR, MODEL, Case
from tests.scenes.square_mesh import msh

STRANGE = ["J\nsystem touch PWNED\n;", "J\r*INCLUDE", "J\x1b[2J", "J\u2028x", "J\u202egpj", "J\t1", "J\x85x"]
SIGNS = ["J1 (süd)", "=1+1", "J \"one\" 'two'", "J &", "J ...", "<b>", "$x$", "J\u00a01", "*STEP", "; J", "関節"]
ENDINGS = {"3dgrid": ".3dgrid", "abaqus": ".inp", "udec": ".dat", "lmgc90": ".py", "compas_dem": ".py"}
STEEL = {"kind": "end_anchored", "start": (0, 0), "end": (1, 0), "diameter": 0.025, "yield_strength": 5e8}


def blocks(**changes: Any) -> bsm.Blocks:
    return replace(arch(3, 0.3).blocks, **changes)


MADE: list[Callable[[str], Any]] = [
    lambda name: bsm.Rock(name, unit_weight=0),
    lambda name: bsm.Joint(name, normal_stiffness=1e9, shear_stiffness=1e9),
    lambda name: bsm.Stage(name=name),
    lambda name: bsm.Stage(name="a", strength={name: 0.5}),
    lambda name: bsm.Fixed(boundary=name),
    lambda name: bsm.Pressure(boundary=name, pressure=1.0),
    lambda name: bsm.Water(joint_pressure={name: 1.0}),
    lambda name: bsm.History(name="h", joint=name),
    lambda name: bsm.History(name="h", bolt=name),
    lambda name: bsm.Beside(quantity="u", value=1.0, source=name),
    lambda name: bsm.Bolt(name=name, **STEEL),
    lambda name: blocks(joint_names=(name,)),
    lambda name: blocks(rock_names=(name,)),
    lambda name: blocks(boundaries={name: np.array([0], np.int32)}),
    lambda name: blocks(excavations={name: np.array([0], np.int32)}),
]


@pytest.mark.parametrize("name", STRANGE)
@pytest.mark.parametrize("number", range(len(MADE)))
def test_a_name_is_one_line_of_plain_text(number: int, name: str) -> None:
    with pytest.raises(ModelError, match="holds a line break or a control character, as no name may") as caught:
        MADE[number](name)
    assert all(bsm.errors.one_line(fault) == fault for fault in caught.value.faults)


@pytest.mark.parametrize("number", range(len(MADE)))
def test_signs_may_be_in_it(number: int) -> None:
    for name in SIGNS:
        MADE[number](name)


def test_names_of_a_mesh_and_of_a_model_file(case: Case) -> None:
    """Told in one line; [groups] gives a group of a mesh another name."""
    says = ["holds a line break or a control character"]
    case.write("mesh.msh", msh(surface="rock:g\x1b[2Jneiss"))
    case.refuses("check", "model.toml", says=says)
    case.write("model.toml", MODEL + LINEAR + '[groups]\n"rock:g\\u001b[2Jneiss" = "rock:gneiss"\n')
    assert case.run("check", "model.toml").code == 0
    case.write("mesh.msh", msh())
    named = MODEL.replace("[joint.J1]", '[joint."J\\nsystem"]')
    case.write("model.toml", named + '[groups]\n"joint:J1" = "joint:J\\nsystem"\n')
    case.refuses("check", "model.toml", says=says)


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize("name", SIGNS)
def test_a_name_adds_no_line_to_what_is_exported(tmp_path: Path, program: str, name: str) -> None:
    """And ends none as a sign of continuation would (``&``, ``...``, a comma)."""

    def written(name: str, title: str) -> list[list[str]]:
        model = arch(3, 0.3, friction=40)
        named = replace(model.joints[0], name=name)
        rocks = [replace(rock, name=name) for rock in model.rocks]
        model = model.replace(
            blocks=replace(model.blocks, rock_names=(name,)),
            joints=[named],
            default_joint=name,
            rocks=rocks,
            title=title,
        )
        export(model, program, tmp_path / f"a{ENDINGS[program]}")
        return [path.read_text(encoding="utf-8").splitlines() for path in sorted(tmp_path.iterdir())]

    plain, strange = written("J", "title"), written(name, name)
    for before, after in zip(plain, strange, strict=True):
        assert len(before) == len(after)
        for line, other in zip(before, after, strict=True):
            assert line == other or line[:1] == other[:1]  # a comment stays one, and so does a command
            assert other.endswith(("&", "...", ",")) == line.endswith(("&", "...", ","))


def test_the_grid_of_3dec_has_a_plain_name(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="give one without any"):
        export(arch(3, 0.3, friction=40), "3dgrid", tmp_path / "a' 'b.3dgrid")


CELLS = ["=1+1", "+1-x", "-J1", "@SUM(A1)", "'=1+1", "''-x", "'J'", "J1", "-1.5", "", "-", "=", "a\nb", 'a"b', "a;b"]


def test_cells_are_no_formulas_and_read_as_they_were() -> None:
    file = io.StringIO(newline="")
    CsvWriter(file).writerows([[cell, -1.5, -2] for cell in CELLS])
    rows = list(csv.reader(io.StringIO(file.getvalue(), newline="")))
    assert [as_given_text(row[0]) for row in rows] == CELLS
    assert {(row[1], row[2]) for row in rows} == {("-1.5", "-2")}
    assert [row[0] for row in rows if row[0][:1] in tuple("=+-@") and row[0]] == ["-1.5"]


def test_tables_of_results_hold_no_formula(tmp_path: Path) -> None:
    model = arch(3, 0.3, friction=40)
    rocks = [replace(rock, name="=1+1") for rock in model.rocks]
    history = bsm.History(name="h", block=1, measured=[bsm.Beside(quantity="u", value=-1.0, source="@here")])
    model = model.replace(
        blocks=replace(model.blocks, rock_names=("=1+1",)),
        rocks=rocks,
        stages=[bsm.Stage(name="-2+3")],
        histories=[history],
    )
    results = bsm.run(model, bsm.Options(scheme="linear"))
    folder = save_results(results, tmp_path / "out", form=OutputForm(tables="csv"))
    seen = set()
    for path in folder.glob("*.csv"):
        for row in csv.reader(path.open(newline="", encoding="utf-8")):
            for cell in row:
                seen.add(cell)
                assert cell[:1] not in ("=", "+", "-", "@") or float(cell) < 0
    assert {"'=1+1", "'-2+3", "'@here"} <= seen
    read = bsm.results.Results.load(folder)
    assert [stage.name for stage in read.stages] == ["initial", "-2+3"]
    assert bsm.load(folder / "model.toml").histories[0].measured[0].source == "@here"


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["$x_$", "$\\frac{", "$$a$$", "$", "a$b", "\\alpha"])
def test_a_name_in_a_picture_is_no_formula(tmp_path: Path, name: str) -> None:
    """Labels of logarithmic axes are."""
    figure = paper((4, 3))
    axes = figure.add_subplot()
    axes.loglog([1, 1e4], [1, 1e4], label=name)
    axes.annotate(name, (10, 10))
    axes.set_ylabel(name)
    axes.set_title(name)
    axes.legend(title=name)
    entitle(figure, f"{name} {'word ' * 30}\nsecond")
    assert save(figure, tmp_path / "a.png").stat().st_size > 0
    assert figure.get_suptitle().replace("\n", " ").split() == [*name.split(), *["word"] * 30, "second"]
    labels = axes.get_xticklabels()
    assert all(label.get_parse_math() for label in labels)
    assert any("mathdefault" in label.get_text() for label in labels)
