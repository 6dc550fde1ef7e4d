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


@pytest.mark.parametrize("ends", ["fails", "stays open"])
def test_a_script_leaves_no_entities_to_the_next(case: Case, ends: str) -> None:
    """A script that raises, or that does not end Gmsh: the next mesh had the entities of both."""
    gmsh = pytest.importorskip("gmsh")
    wrong = {"fails": ("gmsh.write", "gmsh.rite"), "stays open": ("    gmsh.finalize()\n", "")}[ends]
    case.change('file = "mesh.msh"', 'geometry = "g.py"')
    case.change("[mesh]\n", "[mesh]\nallow_unused = true\n")
    case.write("g.py", GEOMETRY.replace(*wrong).replace("width=2.0", "width=5.0"))
    if ends == "fails":
        with pytest.raises(bsm.ModelError, match="rite"):
            bsm.load("model.toml")
    else:
        assert bsm.load("model.toml").blocks.moments.area.sum() == pytest.approx(10)
    assert not gmsh.isInitialized()
    case.write("g.py", GEOMETRY)
    assert bsm.load("model.toml").blocks.moments.area.sum() == pytest.approx(4)


def test_a_script_leaves_the_callers_mesh_alone(case: Case) -> None:
    gmsh = pytest.importorskip("gmsh")
    case.change('file = "mesh.msh"', 'geometry = "g.py"')
    case.change("[mesh]\n", "[mesh]\nallow_unused = true\n")
    case.write("g.py", GEOMETRY.replace("    gmsh.finalize()\n", ""))
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("mine")
        gmsh.model.occ.addPoint(0, 0, 0)
        gmsh.model.occ.synchronize()
        assert bsm.load("model.toml").blocks.moments.area.sum() == pytest.approx(4)
        assert (gmsh.model.getCurrent(), gmsh.model.getEntities()) == ("mine", [(0, 1)])
    finally:
        gmsh.finalize()


def test_check_reports_time_steps_of_shaken_stages_only(case: Case) -> None:
    assert "time steps" not in case.run("check", "model.toml").err
