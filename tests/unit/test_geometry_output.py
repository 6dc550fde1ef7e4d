"""Lines that a geometry script prints: on stderr, and nowhere in a quiet command."""

from __future__ import annotations

import json

import pytest

import bsm_mesh as bsm
from tests.scenes.small_case import GEOMETRY, Case, run_process


@pytest.mark.slow
def test_what_a_geometry_prints_does_not_get_into_the_json(case: Case) -> None:
    """Gmsh prints past Python, so that only a process of its own shows it."""
    case.write("g.py", GEOMETRY)
    case.change('file = "mesh.msh"', 'geometry = "g.py"')
    case.change("[mesh]\n", "[mesh]\nallow_unused = true\n")  # it has no joint
    outcome = run_process(case.folder, "run", "model.toml", "--json")
    assert json.loads(outcome.out)["status"] == "stable"
    assert outcome.err == ""  # as quiet as with -q
    outcome = run_process(case.folder, "check", "model.toml")
    assert "from Python" in outcome.err
    assert "Info" not in outcome.err  # Gmsh has hundreds of them


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_quiet_command_drops_what_a_geometry_prints(case: Case, command: str) -> None:
    case.write("g.py", GEOMETRY)
    case.change('file = "mesh.msh"', 'geometry = "g.py"')
    case.change("[mesh]\n", "[mesh]\nallow_unused = true\n")  # it has no joint
    assert "from Python" in case.run("check", "model.toml").err
    assert case.run(command, "model.toml", "-q").err == ""


def test_python_drops_it_too_and_errors_remain(case: Case) -> None:
    case.write("g.py", GEOMETRY)
    case.change('file = "mesh.msh"', 'geometry = "g.py"')
    case.change("[mesh]\n", "[mesh]\nallow_unused = true\n")
    bsm.load("model.toml")
    assert case.capsys.readouterr() == ("", "")
    case.write("g.py", GEOMETRY.replace("gmsh.write", "gmsh.rite"))
    with pytest.raises(bsm.ModelError, match="rite"):
        bsm.load("model.toml")


def test_check_reports_time_steps_of_shaken_stages_only(case: Case) -> None:
    assert "time steps" not in case.run("check", "model.toml").err
