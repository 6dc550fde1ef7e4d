"""What a file holds never steers the terminal; a terminal of any encoding, or none, ends no command."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import UNPRINTABLE, MeshWarning, ModelError
from bsm_mesh.geometries import GeometryError
from bsm_mesh.text.terminal import say, say_json
from tests.scenes.small_case import FILE, JOINT, LINEAR, LOAD, MODEL, ROCK, Case, command, environment
from tests.scenes.square_mesh import CURVES, msh

TITLE = 'title = "Two by two"'
STEERING = r"\u001b[31m\u009b2J\u202e\u0007"


def steers(text: str) -> bool:
    return UNPRINTABLE.search(text.replace("\n", "")) is not None


@pytest.mark.parametrize(
    ("old", "new", "arguments"),
    [
        (TITLE, f'title = "{STEERING}"', ("run", "model.toml", "-q")),
        (TITLE, f'title = "{STEERING}"', ("limit", "model.toml")),
        ("rock.gneiss", f'rock."{STEERING}"', ("check", "model.toml")),
        ("joint.J1", f'joint."{STEERING}"', ("check", "model.toml")),
        ('boundary = "top"', f'boundary = "{STEERING}"', ("check", "model.toml")),
        ("friction = 35", f'friction = "{STEERING}"', ("check", "model.toml")),
        ("friction = 35", f'"{STEERING}" = 1', ("check", "model.toml")),
        (FILE, f'file = "{STEERING}"\n', ("check", "model.toml")),
        (FILE, f'geometry = "{STEERING}"\n', ("check", "model.toml")),
        (FILE, f'{FILE}default_joint = "{STEERING}"\n', ("check", "model.toml")),
        (JOINT, f'{JOINT}\n[groups]\n"{STEERING}" = "rock:a"\n', ("check", "model.toml")),
        (LOAD, f'{LOAD}[[stage]]\nname = "{STEERING}"\n[[stage]]\nname = "b"\n', ("run", "model.toml", "-q")),
        (ROCK, f"{ROCK}\x1b[31m\n", ("check", "model.toml")),  # as no TOML
        (ROCK, f'{ROCK}"\x1b[31m" = 1\n', ("check", "model.toml")),
    ],
)
def test_texts_of_a_model_file(case: Case, old: str, new: str, arguments: tuple[str, ...]) -> None:
    case.write("model.toml", (MODEL + LINEAR).replace(old, new))
    outcome = case.run(*arguments)
    assert not steers(outcome.out), outcome.out
    assert not steers(outcome.err), outcome.err
    assert r"\x1b" in outcome.out + outcome.err


def test_names_of_groups(case: Case) -> None:
    case.write("mesh.msh", msh(surface="rock:\x1b[31m\x07"))
    err = case.refuses("check", "model.toml", says=[r"'\x1b[31m\x07' holds a line break or a control character"])
    assert not steers(err)


@pytest.mark.parametrize("arguments", [("check", "\x1b[2J.toml"), ("run", "model.toml", "--\x1b[2J"), ("\x1b[2J",)])
def test_names_on_the_command_line(case: Case, arguments: tuple[str, ...]) -> None:
    outcome = case.run(*arguments)
    assert outcome.code == 2
    assert r"\x1b[2J" in outcome.err
    assert not steers(outcome.err)


@pytest.mark.parametrize("path", ["\0", "a\ud800"])
def test_what_is_no_path(case: Case, path: str) -> None:
    outcome = case.run("check", path)
    assert outcome.code == 2
    assert "is no path" in outcome.err


def test_an_option_that_lost_its_word_takes_no_other(case: Case) -> None:
    outcome = case.run("run", "model.toml", "-o", "--json")
    assert outcome.code == 2
    assert "'--json' is an option, not a path; a file of that name is ./--json" in outcome.err
    assert not outcome.out


def test_a_name_of_bytes_that_are_no_text(case: Case) -> None:
    (case.folder / os.fsdecode(b"gr\xf6sse.toml")).write_text(MODEL)
    outcome = case.run("check", os.fsdecode(b"gr\xf6sse.toml"))
    assert outcome.code == 0, outcome
    assert r"gr\udcf6sse.toml" in outcome.out


def test_a_name_forges_no_line_of_ours(case: Case) -> None:
    case.write("model.toml", MODEL.replace("rock.gneiss", r'rock."a\nerror: none"'))
    case.refuses("check", "model.toml", says=[r"a\nerror: none"])


def test_errors_and_warnings_from_python(case: Case) -> None:
    assert not steers(str(ModelError(["a\x1b[31m", "b\x9b"])))
    assert not steers(str(GeometryError("set '\x1b[31m' has no line")))
    assert ModelError("a\x1b[31m").faults == ("a\x1b[31m",)
    curves = {**CURVES, "bolt:\x1b[31m": [(0, 4)]}
    case.write("mesh.msh", msh(curves=curves))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", MeshWarning)
        bsm.load(case.folder / "model.toml")
    assert any(r"\x1b[31m" in str(warning.message) for warning in caught)
    assert not any(steers(str(warning.message)) for warning in caught)


def test_json_is_ascii(capsys: pytest.CaptureFixture[str]) -> None:
    say_json({"Größe": "\x1b\x7f\x9b"})
    said = capsys.readouterr().out
    assert said.isascii()
    assert not steers(said)
    assert json.loads(said) == {"Größe": "\x1b\x7f\x9b"}


def test_tabs_stay_and_lines_are_one(capsys: pytest.CaptureFixture[str]) -> None:
    say("a\tb\nc")
    assert capsys.readouterr().out == "a\tb\\nc\n"


@pytest.mark.heavy
@pytest.mark.parametrize(
    "encoding", ["ascii", *(pytest.param(name, marks=pytest.mark.slow) for name in ("latin-1", "cp437"))]
)
def test_streams_that_are_not_utf8(case: Case, encoding: str) -> None:
    case.write("model.toml", (MODEL + LINEAR).replace("Two by two", "Größe 岩"))
    done = subprocess.run(
        command("run", "model.toml", "-q", "-o", "Größe"),
        cwd=case.folder,
        env={**environment(), "PYTHONIOENCODING": encoding},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    assert b"\\u5ca9" in done.stdout
    assert (case.folder / "Größe" / "summary.json").exists()


@pytest.mark.heavy
@pytest.mark.skipif(os.name == "nt", reason="POSIX's way to close them")
def test_streams_that_are_closed(case: Case) -> None:
    case.write("model.toml", MODEL + LINEAR)
    line = f'"{sys.executable}" -m bsm_mesh.commands.cli run model.toml -o out <&- >&- 2>&-'
    done = subprocess.run(["sh", "-c", line], cwd=case.folder, env=environment(), check=False)
    assert done.returncode == 0
    assert (case.folder / "out" / "summary.json").exists()
    assert Path(case.folder / "model.toml").read_text() == MODEL + LINEAR
