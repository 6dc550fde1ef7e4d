"""Folders of strangers: a file of theirs is a command, a link or a lie.

No command is run, and no file of another folder is read or written.
"""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from .foreign import CHECK, JOINT, RUN, Foreign, abaqus, along, command, coordinates, done, groups, lines, meshes, model
from .place import Place
from .seeds import SCRIPT, SECRET, VIRTUAL
from .targets.results import forged

COLUMN = {"geometry": "column", "parameters": {"count": 4, "dip": 5.0}}
STUDY = b"""model = "model.toml"
title = "x"
sampling = "monte_carlo"
runs = 2
[vary]
joint.joint.friction = { distribution = "uniform", lower = 50, upper = 60 }
"""
MINE = {"../victim/model.toml": b"mine", "../victim/joints.csv": b"mine"}
CODE = "</script><script>document.title='PWNED'</script>"
FORMULA = '=HYPERLINK("http://127.0.0.1/","x")'


def column(**tables: Any) -> bytes:
    """Return the model file of four blocks on an incline, which stay."""
    return model(COLUMN, rock="rock", joints={"joint": JOINT}, support=[{"blocks": [0], "fix": "all"}], **tables)


def _script_ran(folder: Path) -> str:
    return "the script was run" if (folder / "PWNED").exists() else ""


def _victim_changed(folder: Path) -> str:
    there = {f"../victim/{path.name}": path.read_bytes() for path in (folder.parent / "victim").iterdir()}
    return "" if there == MINE else f"the other folder holds {sorted(there)}"


def scripts() -> Iterator[Foreign]:
    """Yield files that are commands by another name."""
    for words in (CHECK, (*CHECK, "--no-scripts")):
        files = {"rock.Unv": SCRIPT, "model.toml": model({"file": "rock.Unv"})}
        name = " ".join(["a Gmsh script named rock.Unv", *words[2:]])
        yield Foreign("scripts", name, "refused, not run", files, (words,), 2, ("no mesh",), after=_script_ran)
    for name, source in (("a path", SECRET), ("the network", {})):
        path = "secret.csv" if source else "/vsicurl/http://127.0.0.1:9/secret.csv"
        files = {**along("t.gpkg", VIRTUAL.replace(b"secret.csv", path.encode()), None), **source}
        yield Foreign(
            "scripts", f"a GDAL VRT of {name} named t.gpkg", "refused", files, (CHECK,), 2, ("no GeoPackage",)
        )
    wild = "J\nsystem touch PWNED\n;"
    files = {"model.toml": model(COLUMN, rock="rock", joints={wild: JOINT}, groups={"joint:joint": f"joint:{wild}"})}
    yield Foreign("scripts", "a joint's name with line breaks", "refused", files, (CHECK,), 2, ("line break",))


def links() -> Iterator[Foreign]:
    """Yield links beside results, which lead to a folder of the user."""
    files = {**MINE, "model.toml": column(output={"folder": "out"})}
    for name in ("out.running", "out.former", "out.interrupted"):
        for words in (("run", "model.toml"), ("run", "model.toml", "--no-scripts")):
            told = " ".join([f"{name} -> elsewhere", *words[2:]])
            says = (f"{name} is a link",)
            yield Foreign("links", told, "refused", files, (words,), 2, says, {name: "../victim"}, _victim_changed)
    words = ("study", "study.toml", "--no-scripts")
    yield Foreign(
        "links",
        "study --no-scripts, out -> elsewhere",
        "refused",
        {**files, "study.toml": STUDY},
        (words,),
        2,
        ("leads out of the folder",),
        {"out": "../victim"},
        _victim_changed,
    )


def names() -> Iterator[Foreign]:
    """Yield names that are code of a page, or a formula of a spreadsheet; and a folder's that is no UTF-8."""
    text = model(
        COLUMN,
        rock=FORMULA,
        joints={CODE: JOINT},
        support=[{"blocks": [0], "fix": "all"}],
        title=CODE,
        groups={"joint:joint": f"joint:{CODE}", "rock:rock": f"rock:{FORMULA}"},
        stage=[{"name": "=1+1"}],
        history=[{"name": "h", "block": 1}],
    )
    done = (RUN[:-1], ("report", "out"), ("view", "out"))
    yield Foreign(
        "names", "code and formulas as names", "texts in all files", {"model.toml": text}, done, 0, after=_obeyed
    )
    folder = os.fsdecode(b"B\xf6schung")
    files = {f"{folder}/model.toml": column(output={"folder": "out"})}
    words = ("run", f"{folder}/model.toml")
    yield Foreign("names", "a folder's name in Latin-1", "refused before it is solved", files, (words,), 2, ("UTF-8",))


def _obeyed(folder: Path) -> str:
    pages = [path for path in (folder / "out").rglob("*.html") if CODE in path.read_text()]
    cells = [
        cell
        for path in (folder / "out").glob("*.csv")
        for row in csv.reader(path.read_text().splitlines())
        for cell in row
        if cell[:1] in "=@" and cell
    ]
    missing = [f"no {name}" for name in ("report.html", "view.html") if not (folder / "out" / name).exists()]
    return "; ".join([*(f"{path.name} holds the code" for path in pages), *cells, *missing])


@cache
def _results() -> dict[str, bytes]:
    """Return the files of the column's results."""
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            Path("model.toml").write_bytes(column())
            command(*RUN)
            return {path.name: path.read_bytes() for path in Path("out").iterdir()}
        finally:
            os.chdir(here)


def forgeries() -> Iterator[Foreign]:
    """Yield results with a file that lies of its size, or is something else; all checksums are right."""
    given = _results()
    grid = given["blocks_0000.vtu"].replace(b'NumberOfPoints="', b'NumberOfPoints="19000000')
    lies = {
        "arrays that are none": ("certificate_0000.npz", b"PK\x03\x04junkjunk"),
        "1e8 points in a grid": ("blocks_0000.vtu", grid),
        "a list in 1e5 lists": ("certificate.json", b"[" * 100_000),
        "no history": ("history.csv", b""),
    }
    for told, (name, content) in lies.items():
        folder = forged({**given, name: content}, name)
        files = {"model.toml": column(), **{f"out/{name}": data for name, data in folder.items()}}
        for words in (("report", "out"), ("verify", "out")):
            yield Foreign("forged results", f"{words[0]}: {told}", "refused in words", files, (words,), 2, ("out",))


KINDS: dict[str, Callable[[], Iterator[Foreign]]] = {
    form.__name__: form for form in (groups, coordinates, lines, abaqus, meshes, scripts, links, names, forgeries)
}


def rows(there: Place) -> Iterator[tuple[str, bool]]:
    """Yield a row of a table for each file, and whether the program does what is expected."""
    yield "| kind | file | expected | exit code | result |\n|---|---|---|---:|---|", True
    for form in KINDS.values():
        for given in form():
            _, wrong = done(there, given)
            cells = (given.kind, given.name, given.expected, str(given.code), "; ".join(wrong) or "as expected")
            yield f"| {' | '.join(cells)} |", not wrong
