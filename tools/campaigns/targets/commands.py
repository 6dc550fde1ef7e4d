"""Command lines: options doubled, missing, misspelt, with values of any kind."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
from pathlib import Path
from random import Random

from tests.scenes.model_folders import BOLT_TABLE
from tests.scenes.more_models import PLANE, RECORD, SPACE
from tests.scenes.small_models import MESH, MODELS

from ..inputs import CONTROL, OK, REFUSED, AcceptedError, ControlError, Input
from ..mutations import mutate, mutate_tree
from ..values import NUMBERS, TEXTS, text
from .models import written
from .results import good

GOOD: tuple[tuple[str, ...], ...] = (
    ("run", "model.toml", "-o", "new"),
    ("run", "model.toml", "-o", "new", "--json"),
    ("run", "-q", "model.toml", "-o", "new"),
    ("run", "model.toml"),
    ("check", "model.toml"),
    ("check", "model.toml", "--json", "--threshold", "tiny=0.1"),
    ("check", "model.toml", "--repair", "new.vtu", "--snap", "0.01"),
    ("limit", "model.toml", "-o", "new", "--json"),
    ("limit", "model.toml", "-o", "new", "--load", "1"),
    ("limit", "model.toml", "-o", "new", "--tilt", "left"),
    ("compare", "model.toml", "-o", "new", "--order", "1"),
    ("compare", "model.toml", "-o", "new", "--joints", "--json"),
    ("mesh", "--list"),
    ("mesh", "column", "--list"),
    ("mesh", "column", "-o", "new.msh", "--set", "count=2"),
    ("new", "tunnel", "new"),
    ("schema",),
    ("safety", "model.toml", "-o", "new", "--tolerance", "0.2", "--json"),
    ("key-blocks", "model.toml", "-o", "new", "--proof"),
    ("newmark", "model.toml", "-o", "new", "--record", "record.csv", "--alone"),
    ("kinematics", "planes.csv", "--face", "60", "300", "--friction", "25", "-o", "new"),
    ("liner", "new", "--rock", "gneiss", "--compressive-strength", "25 MPa", "--tensile-strength", "2 MPa"),
    ("joint-test", "model.toml", "--joint", "J1", "--normal-stress", "100 kPa", "-o", "new"),
    ("export", "model.toml", "--to", "abaqus", "-o", "new"),
    ("plot", "nothing"),
    ("--help",),
    ("--version",),
)
GIVEN = [*((tree, {}) for tree in MODELS), *PLANE, *SPACE]
PLANES = b"dip,dip_direction,set\n34,298,bedding\n37,305,bedding\n62,252,J1\n58,247,J1\n"
HARMLESS = ("new", "new.msh", "new.vtu", "model.toml", "mesh.msh", "nothing")
KEPT = {"kept/other.txt": b"of somebody else"}
LINKS = tuple(f"{name}.{state}" for name in ("new", "out") for state in ("running", "former", "interrupted"))
CODES = (0, 2, 3, 130)


def draw(random: Random, folder: Path) -> Input:
    """Return a command line with a few changes, on a model that is good or changed."""
    words = list(random.choice(GOOD))
    for _ in range(random.choice((0, 1, 1, 1, 2))):
        _change(random, words)
    given, beside = random.choice(GIVEN)
    data = written(given if random.random() < 0.5 else mutate_tree(random, given))
    if random.random() < 0.1:
        data = mutate(random, data, binary=False)
    mesh = MESH if random.random() < 0.8 else mutate(random, MESH, binary=False)
    table = BOLT_TABLE if random.random() < 0.8 else mutate(random, BOLT_TABLE, binary=False)
    tables = {"planes.csv": PLANES, "record.csv": RECORD, **beside}
    for name in tables:
        if random.random() < 0.2:
            tables[name] = mutate(random, tables[name], binary=False)
    files = {"model.toml": data, "mesh.msh": mesh, "bolts.csv": table, **tables}
    if random.random() < 0.2:  # an old run is there
        files |= {f"new/{name}": content for name, content in good(folder)[0][0].items()}
    link = random.choice(LINKS) if random.random() < 0.2 else ""
    return Input(
        (f"{link} -> kept; " if link else "") + "bsm-mesh " + " ".join(words),
        lambda: _linked(link, words) if link else _command(words, "--json" in words),
        {**files, **KEPT},
        ("new", "new.msh", "new.vtu", "out", "*"),
    )


def _change(random: Random, words: list[str]) -> None:
    at, kind = random.randrange(len(words)), random.random()
    if kind < 0.2:
        del words[at]
        words.extend([] if words else ["run"])
    elif kind < 0.35:
        words.insert(at, words[random.randrange(len(words))])
    elif kind < 0.45:
        random.shuffle(words)
    elif kind < 0.6:
        words.insert(
            at,
            random.choice(
                (
                    "--json",
                    "-q",
                    "--pictures=x",
                    "--set",
                    "radius=2",
                    "--order",
                    "3",
                    "--snap",
                    "nan",
                    "--load",
                    "99",
                    "-o",
                    "mesh.msh",
                    "--",
                    "-x",
                )
            ),
        )
    elif kind < 0.8:
        words[at] = str(text(random, words[at]))
    else:
        words[at] = random.choice(
            [str(random.choice(NUMBERS)), random.choice(TEXTS), f"{words[at]}={random.choice(TEXTS)}"]
        )
    words[:] = [_harmless(word) for word in words]


def _harmless(word: str) -> str:
    """Return a word that, taken as a path, stays within the folder."""
    return word.replace("/", "_").replace("..", "_")[:3000]


def _linked(link: str, words: list[str]) -> str:
    """Do a command where a link beside the results leads elsewhere: nothing may be written or removed there."""
    Path(link).symlink_to("kept")
    kept = Path("kept").absolute()
    done = _command(words, "--json" in words)
    if {path.name: path.read_bytes() for path in kept.iterdir()} != {"other.txt": KEPT["kept/other.txt"]}:
        raise AcceptedError(f"{link.partition('.')[2]}: a link was followed")
    return done


def _command(words: list[str], as_json: bool) -> str:
    from bsm_mesh.commands.cli import main

    out, err = io.TextIOWrapper(io.BytesIO(), encoding="utf-8"), io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
    code: object = 0
    here, before = Path.cwd(), _tree()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(words)
    except SystemExit as leaving:
        code = leaving.code or 0
    finally:
        os.chdir(here)
        sys.stdout.flush()
    said, told = (_text(stream) for stream in (out, err))
    name = words[0] if words[0].isalpha() and len(words[0]) < 9 else "?"
    if code not in CODES:
        raise AcceptedError(f"{name}: exit code {code!r}\n{told[-2000:]}")
    if "Traceback" in told:
        raise AcceptedError(f"{name}: a traceback on stderr\n{told[-4000:]}")
    for stream, written_there in (("stdout", said), ("stderr", told)):
        found = CONTROL.search(written_there)
        if found is not None:
            raise ControlError(
                f"{name}: on {stream}\n{found[0]!r}: {written_there[max(0, found.start() - 200) :][:600]!r}"
            )
    if code == 2 and _tree() != before:
        raise AcceptedError(
            f"{name}: exit code 2, but files are changed: {sorted(_tree().keys() ^ before.keys())}\n{told}"
        )
    if as_json and code in (0, 3) and words[0] in ("run", "check", "limit", "compare") and "-h" not in words:
        try:
            json.loads(said)
        except ValueError:
            if "--help" not in words:
                raise AcceptedError(f"{name}: --json, but stdout is no JSON\n{said[:500]}") from None
    return REFUSED if code == 2 else OK


def _text(stream: io.TextIOWrapper) -> str:
    stream.flush()
    buffer = stream.buffer
    assert isinstance(buffer, io.BytesIO)
    return buffer.getvalue().decode("utf-8", "replace")


def _tree() -> dict[str, bytes | None]:
    """Return every file with its content, and every folder."""
    found = sorted(Path().rglob("*"))
    return {str(path): path.read_bytes() if path.is_file() else None for path in found}
