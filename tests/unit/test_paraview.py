"""The script for ParaView: Python that compiles, with what is in the folder; run by ParaView in tests/viewers."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import bsm_mesh as bsm
from bsm_mesh.commands.cli import cli
from bsm_mesh.folder.own_files import own_files
from tests.scenes.known_factors import incline
from tests.scenes.openings import opening


def constants(folder: Path) -> dict[str, Any]:
    """Return what the script of a folder says in capitals."""
    outcome = CliRunner().invoke(cli, ["paraview", str(folder)])
    assert (outcome.exit_code, outcome.stdout) == (0, f"{folder / 'in_paraview.py'}\n")
    tree = ast.parse((folder / "in_paraview.py").read_text(encoding="utf-8"))
    found = {}
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id.isupper():
            found[node.targets[0].id] = ast.literal_eval(node.value)
    return found


@pytest.mark.heavy
@pytest.mark.parametrize("bolted", [True, False])
def test_what_it_opens(tmp_path: Path, bolted: bool) -> None:
    folder = tmp_path / "out"
    results = bsm.run(opening(bolted=bolted))
    results.save(folder)
    told = constants(folder)
    assert told["KINDS"] == ["blocks", "joints", "contacts", "supports", *["bolts"] * bolted, "water"]
    assert told["STATES"][0] == "stage initial: stable"
    assert told["STATES"][1].startswith(f"stage dig: {results.status.value}")
    assert ("fall" in told["STATES"][1]) == (results.status == "unstable")
    assert told["FOLDER"] == str(folder)
    assert told["SIZE"] == pytest.approx(np.hypot(6, 4))
    stays = np.setdiff1d(np.arange(24), results.unstable_blocks)
    moved = np.hypot(*results.stages[-1].displacement[stays, :2].T).max()
    assert told["GREATEST"] == pytest.approx(moved)
    assert bolted == (told["EXAGGERATION"] > 1)
    assert told["EXAGGERATION"] * told["GREATEST"] <= 0.1 * 2  # of the opening of two by two
    assert "in_paraview.py" in own_files(folder)


def test_a_title_is_a_text_and_never_code(tmp_path: Path) -> None:
    title = '\'; import os #\n"""\\'
    bsm.run(replace(incline(40.0, 30.0), title=title)).save(tmp_path / "out")
    assert title in constants(tmp_path / "out")["HEADING"]


def test_the_next_run_takes_it_away(tmp_path: Path) -> None:
    results = bsm.run(incline(40.0, 30.0))
    results.save(tmp_path / "out")
    constants(tmp_path / "out")
    results.save(tmp_path / "out")
    assert not (tmp_path / "out" / "in_paraview.py").exists()
