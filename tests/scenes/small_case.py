"""A model of four blocks in files, and ways to run the command line on it, in this process and in one of its own."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from bsm_mesh.commands.cli import main

ROOT = Path(__file__).parents[2]
MODEL = """\
title = "Two by two"

[mesh]
file = "mesh.msh"

[rock.gneiss]
unit_weight = "26 kN/m^3"
young = "10 GPa"
poisson = 0.25

[joint.J1]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
friction = 35

[[support]]
boundary = "bottom"
fix = "all"

[[load]]
boundary = "top"
pressure = "1 MPa"
"""
GEOMETRY = """\
import gmsh
def build(path, width=2.0):
    print("from Python")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 1)
    rectangle = gmsh.model.occ.addRectangle(0, 0, 0, width, 2)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [rectangle], name="rock:gneiss")
    sides = {"bottom": [1], "top": [3]}
    for name, tags in sides.items():
        gmsh.model.addPhysicalGroup(1, tags, name=f"boundary:{name}")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))
    gmsh.finalize()
"""
# Parts of the model, to be changed, and what is put there.
FILE = 'file = "mesh.msh"\n'
ROCK = '[rock.gneiss]\nunit_weight = "26 kN/m^3"\nyoung = "10 GPa"\npoisson = 0.25\n'
JOINT = '[joint.J1]\nnormal_stiffness = "5 GPa/m"\nshear_stiffness = "1 GPa/m"\nfriction = 35\n'
SUPPORT = '[[support]]\nboundary = "bottom"\nfix = "all"\n'
LOAD = '[[load]]\nboundary = "top"\npressure = "1 MPa"\n'
LINEAR = '[solver]\nscheme = "linear"\n'
JUNK = random.Random(29).randbytes(3000)


@dataclass
class Outcome:
    """What a command left behind."""

    code: int
    out: str
    err: str
    new: list[str]


@dataclass
class Case:
    """A folder with ``model.toml`` and ``mesh.msh``, which is the current folder."""

    folder: Path
    capsys: pytest.CaptureFixture[str]

    def write(self, name: str, content: str | bytes) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    def change(self, old: str, new: str) -> None:
        """Replace a part of the model file."""
        assert old in MODEL
        self.write("model.toml", (self.folder / "model.toml").read_text().replace(old, new))

    def run(self, *arguments: str) -> Outcome:
        """Run a command in this process."""
        before = tree(self.folder)
        self.capsys.readouterr()
        try:
            main(list(arguments))
            code = 0
        except SystemExit as leaving:
            code = leaving.code if isinstance(leaving.code, int) else 1
        said = self.capsys.readouterr()
        return Outcome(code, said.out, said.err, changes(before, tree(self.folder)))

    def refuses(self, *arguments: str, says: Sequence[str]) -> str:
        """Assert that a command is refused in one message with the given words, and leaves nothing behind."""
        outcome = self.run(*arguments)
        check_refusal(outcome, says)
        return outcome.err


def check_refusal(outcome: Outcome, says: Sequence[str]) -> None:
    assert outcome.code == 2, outcome
    assert outcome.out == ""
    assert outcome.new == []
    assert "Traceback" not in outcome.err
    message = [line for line in outcome.err.splitlines() if line and not line.startswith("[")]
    faults = [line for line in message if line.startswith("  - ")]
    assert message[0].startswith("error: "), outcome.err
    assert len(message) == (1 + len(faults) if "faults:" in message[0] else 1), outcome.err
    assert len(set(faults)) == len(faults)
    for words in says:
        assert words in outcome.err, f"{words!r} is not in: {outcome.err}"


def tree(folder: Path) -> dict[str, bytes | None]:
    """Return every file with its content and every folder."""
    found = sorted(folder.rglob("*"))
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None for p in found}


def changes(before: dict[str, bytes | None], after: dict[str, bytes | None]) -> list[str]:
    return sorted(name for name in {*before, *after} if name not in before or before[name] != after.get(name))


def environment() -> dict[str, str]:
    """Return the environment in which a process finds this checkout."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": path}


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "bsm_mesh", *arguments]


def run_process(folder: Path, *arguments: str) -> Outcome:
    """Run a command in a process of its own."""
    before = tree(folder)
    done = subprocess.run(
        command(*arguments), cwd=folder, env=environment(), capture_output=True, text=True, check=False, timeout=120
    )
    return Outcome(done.returncode, done.stdout, done.stderr, changes(before, tree(folder)))
