"""Every block of code of README, docs and examples runs as it is printed, or is named here with the reason.

Pages of docs are followed from top to bottom in a folder of their own: files are written, lines are typed, Python is
run. What takes minutes (``python -m benchmarks ...``) or installs is looked at only: the command and its options exist.
Model files of examples are run by test_examples; here their pages' lines are looked at.
"""

from __future__ import annotations

import inspect
import re
import shlex
import shutil
import tomllib
from functools import cache
from importlib.util import find_spec
from typing import Any

import click
import pytest
from pydantic import ValidationError

from bsm_mesh import geometries
from bsm_mesh.commands.cli import cli
from bsm_mesh.commands.study_file import StudyFile, flat_keys
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.processes import python_command
from docs.code_blocks import ROOT, Block, blocks_of
from tests.scenes.here import run_here
from tests.scenes.small_case import Case
from tests.scenes.typed_lines import type_line

SLOPE = ["bsm-mesh new slope ."]
RUN = [*SLOPE, "bsm-mesh run model.toml"]
SURVEY = """python -c "open('survey.csv', 'w').write('history,v [mm]\\ncrest,-3\\n')" """
OF_A_MESH = [  # without a script, for --no-scripts
    "bsm-mesh new slope .",
    "bsm-mesh mesh slope.py -o dupont.msh",
    """python -c "from pathlib import Path; p = Path('model.toml'); t = p.read_text();"""
    """ a, b = t.index('geometry ='), t.index('[rock.'); blocks = 'blocks = \\'regions\\'';"""
    """ p.write_text(t[:a] + 'file = \\'dupont.msh\\'\\n' + blocks + '\\n' + t[b:])" """,
    "bsm-mesh run model.toml",
    "bsm-mesh run model.toml -o out/steep",
]
QUAKE = (
    """python -c "open('quake.csv', 'w').write('time [s],acceleration [g]\\n0,0\\n0.1,0.3\\n0.3,-0.3\\n0.4,0\\n')" """
)
SHAKEN = (
    """python -c "open('model.toml', 'a').write('\\n[[stage]]\\nname = \\'quake\\'\\n[stage.shaking]\\n"""
    """record = \\'quake.csv\\'\\n')" """
)
LONG = {f"docs/{name}.md" for name in ("earthquakes", "how_to", "limits", "pictures", "tutorial")}  # of a minute
PAGES = {  # pages that are followed, and what their reader has done before
    "docs/earth_pressure.md": [],
    "docs/earthquakes.md": [*SLOPE, QUAKE, SHAKEN],
    "docs/how_to.md": [],
    "docs/import_section.md": [],
    "docs/kinematics.md": [],
    "docs/limits.md": ["bsm-mesh new slope s"],
    "docs/liner.md": [],
    "docs/other_programs.md": ["bsm-mesh new arch ."],
    "docs/pictures.md": [*RUN, SURVEY, "bsm-mesh new roof roof", "bsm-mesh run roof/model.toml -o out/block"],
    "docs/safety.md": [],
    "docs/bolts_3d.md": [],
    "docs/key_blocks.md": [],
    "docs/meshes_3d.md": [],
    "docs/python_3d.md": [],
    "docs/three_dimensions.md": [],
    "docs/tutorial.md": [],
    "docs/user_guide.md": OF_A_MESH,
    "docs/arrays.md": RUN,
    "docs/certificates.md": RUN,
    "docs/compare.md": SLOPE,
    "docs/explore.md": RUN,
    "docs/falls.md": SLOPE,
    "docs/histories.md": [*RUN, "bsm-mesh run model.toml -o out/steep", SURVEY],
    "docs/in_python.md": SLOPE,
    "docs/joint_keys.md": SLOPE,
    "docs/runs.md": RUN,
    "docs/untrusted_files.md": OF_A_MESH,
    "docs/zones_shaken.md": [],
}
FOLLOWED_ELSEWHERE = {  # more is asserted of them there
    "README.md": "tests/examples/test_readme.py",
    "docs/jointed_rock.md": "tests/examples/test_jointed_rock.py",
    "docs/own_mesh.md": "tests/examples/test_jointed_rock.py",
    "docs/from_udec_and_rs2.md": "tests/examples/test_from_udec.py",
    "docs/first_problems.md": "tests/examples/test_jointed_rock.py",
    "docs/notebook.md": "tests/examples/test_notebook_page.py",
}
STYLE, A_METHOD = "shows a style", "tests/unit/test_add_a_method.py"
NOT_RUN = {  # page, and how a block begins that is no program by itself: why
    ("CONTRIBUTING.md", "@dataclass(frozen=True"): STYLE,
    ("CONTRIBUTING.md", "# Pardiso dies where"): STYLE,
    ("CONTRIBUTING.md", "expected = 26e3"): STYLE,
    ("docs/extending.md", '"""Damped Newton\'s method'): A_METHOD,
    ("docs/extending.md", "    Phase.NEAR_REST: (DampedNewton()"): A_METHOD,
    ("docs/theory_joint_laws.md", "import numpy as np"): "tests/unit/test_own_laws.py",
    ("docs/flow.md", "import bsm_mesh as bsm"): "tests/unit/test_flow_results.py reads these",
    ("docs/performance.md", "from bsm_mesh.solve.cluster import ranks"): "needs MPI: tests/unit/test_pardiso_mpi.py",
    ("docs/studies.md", "import pyarrow.parquet as pq"): "tests/unit/test_study.py reads that table",
}
INSTALLS = (
    "pip ",
    ".venv/bin/pip ",
    ".venv/bin/python -m pip ",
    ".venv/bin/pre-commit ",
    "sudo ",
    "python3 -m venv ",
    ". ",
    "dask ",
    "mpiexec ",
    "gmsh ",
)
FOLDERS = ("examples/", "tests/", "docs/")
MODULES = ("benchmarks", "tests", "examples", "docs", "bsm_mesh")


def pages() -> list[str]:
    """Return the pages of the checkout that show code."""
    found = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("examples/*/README.md")]
    return sorted(path.relative_to(ROOT).as_posix() for path in found if blocks_of(path.read_text(encoding="utf-8")))


def blocks(page: str) -> list[Block]:
    return blocks_of((ROOT / page).read_text(encoding="utf-8"))


def is_left_out(page: str, block: Block) -> bool:
    return any(page == where and block.text.startswith(words) for where, words in NOT_RUN)


@pytest.mark.usefixtures("drawn_here")
@pytest.mark.parametrize(
    "page", [pytest.param(page, marks=pytest.mark.slow if page in LONG else pytest.mark.heavy) for page in PAGES]
)
def test_a_page_is_followed(case: Case, page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("MPLBACKEND", "Agg")
    for name in ("model.toml", "mesh.msh"):
        (case.folder / name).unlink()
    names: dict[str, Any] = {}
    text = (ROOT / page).read_text(encoding="utf-8")
    for name in set(re.findall(r"^    bsm-mesh .*\b(examples/\w+)/", text, re.MULTILINE)):
        shutil.copytree(ROOT / name, case.folder / name, ignore=shutil.ignore_patterns("out"))
    for line in PAGES[page]:
        type_line(case, line, page, look_at)
    for block in blocks(page):
        place = f"{page}, line {block.line}"
        if block.file:
            case.write(block.file, block.text)
        elif block.language == "sh":
            for line in block.lines:
                type_line(case, line, place, look_at)
        elif block.language == "python" and not is_left_out(page, block):
            exec(compile(block.text, place, "exec"), names)


@pytest.mark.parametrize("page", [page for page in pages() if page not in {*PAGES, *FOLLOWED_ELSEWHERE}])
def test_a_page_is_looked_at(page: str) -> None:
    for block in blocks(page):
        place = f"{page}, line {block.line}"
        if block.language == "sh":
            for part in (part for line in block.lines for part in line.split(" && ")):
                look_at(part, place)
        elif block.language == "python":
            assert is_left_out(page, block), f"{place}: who runs it?"


@pytest.mark.parametrize("page", [page for page in pages() if any(b.language == "toml" for b in blocks(page))])
def test_parts_of_model_files_have_known_keys_and_values(page: str) -> None:
    for block in blocks(page):
        if block.language == "toml":
            table = tomllib.loads(block.text)
            study = {k: dict(flat_keys(v)) if k in ("vary", "scatter") else v for k, v in table.items()}
            faults = min(unknown(ModelFile, table), unknown(StudyFile, study), unknown(SpaceFile, table), key=len)
            assert not faults, f"{page}, line {block.line}: {faults}"


def unknown(kind: type[ModelFile] | type[StudyFile] | type[SpaceFile], table: dict[str, Any]) -> list[str]:
    """Return the faults of a part of a file, besides that more is needed."""
    try:
        kind.model_validate(table)
    except ValidationError as fault:
        return [f"{e['loc']}: {e['msg']}" for e in fault.errors() if e["type"] != "missing"]
    return []


def look_at(line: str, place: str) -> None:
    """Assert that a command and its options exist."""
    if line.startswith("sh bootstrap.sh"):
        script = (ROOT / "bootstrap.sh").read_text(encoding="utf-8")
        assert re.search(rf"\b{shlex.split(line)[2]}\b", script), f"{place}: {line}"
        return
    if line.startswith(INSTALLS):
        extras = re.findall(r"\[([\w,]+)\]", line)
        known = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
        assert {name for names in extras for name in names.split(",")} <= set(known), f"{place}: {line}"
        return
    program, *arguments = shlex.split(line)
    named = [a.partition("::")[0] for a in arguments if a.startswith(FOLDERS) and "/out/" not in a]
    assert [a for a in named if not (ROOT / a).exists()] == [], f"{place}: {line}"
    if program == "bsm-mesh":
        command = cli.commands[arguments[0]]
        command.make_parser(click.Context(command)).parse_args(arguments[1:])
        return
    assert program == "python", f"{place}: {line}"
    if arguments[0] != "-m":
        assert (ROOT / arguments[0]).is_file(), f"{place}: {line}"
    elif arguments[1].split(".")[0] in MODULES:
        assert find_spec(arguments[1]) is not None, f"{place}: {line}"
        options = [a for a in arguments[2:] if a.startswith("--")]
        words = help_of(arguments[1], *(a for a in arguments[2:3] if a.isalpha())) if options else ""
        for option in options:
            assert option in words, f"{place}: {option} of {line}"


@cache
def help_of(module: str, *given: str) -> str:
    """Return what ``--help`` says of a command of the checkout, and of the subcommands that it names or is given."""
    words = said(module)
    named = re.search(r"{([\w,]+)}", words)
    return words + "".join(said(module, name) for name in (named[1].split(",") if named else given))


@cache
def said(module: str, *words: str) -> str:
    done = run_here(python_command(module, *words, "--help"), cwd=ROOT)
    assert done.returncode == 0, done.stderr
    return done.stdout


CALL = re.compile(r"`((?:g\.)?([A-Za-z_]\w*)\((?:[^`]*)\))`")  # in a row of a table
WITHOUT_FILES = ("read_traces", "read_fractures", "mesh_blocks", "quarter_blocks", "close_short_sides")


def calls_in_tables() -> list[Any]:
    """Return the calls of geometries in tables of the docs, with the page and the line of each."""
    public = [name for name in dir(geometries) if not name.startswith("_")]
    return [
        pytest.param(call, name, id=f"{page.name}:{number}:{name}")
        for page in sorted((ROOT / "docs").glob("*.md"))
        for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1)
        if line.startswith("|")
        for call, name in CALL.findall(line)
        if name in public and name != "abutting_sets"  # of a network by fractopo
    ]


@pytest.mark.parametrize(("call", "name"), calls_in_tables())
def test_calls_in_tables_run(call: str, name: str) -> None:
    """Of functions that read or write files the arguments are checked."""
    known = {each: getattr(geometries, each) for each in dir(geometries)}
    known |= dict.fromkeys(("cut", "outlines"))
    if name in WITHOUT_FILES:
        known[name] = inspect.signature(known[name]).bind
    assert eval(call, {"g": geometries, **known}) is not None
