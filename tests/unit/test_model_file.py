"""The model file: what it may hold beside what `test_bad_input.py` shows to be refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_case import MODEL, Case, msh

import bsm_mesh as bsm
from bsm_mesh.app.build import load_model_file
from bsm_mesh.app.model_file import read_model_file
from bsm_mesh.errors import MeshWarning, ModelError


@pytest.mark.parametrize("content", [MODEL.replace("\n", "\r\n").encode(), b"\xef\xbb\xbf" + MODEL.encode()])
def test_files_of_windows(case: Case, content: bytes) -> None:
    expected = bsm.load("model.toml")
    case.write("model.toml", content)
    assert bsm.load("model.toml") == expected


def test_defaults(case: Case) -> None:
    file = read_model_file(Path("model.toml"))
    assert (file.mesh.unit, file.mesh.contact_points, file.gravity.direction) == ("m", "ends", -90.0)
    assert (file.solver.tolerance, file.solver.linear_solver, file.output.folder) == (1e-6, "auto", "out")
    (joint,) = bsm.load("model.toml").joints
    assert isinstance(joint.law, bsm.Patton)  # where friction is given without a law


def test_paths_are_relative_to_the_model_file(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    (case.folder / "elsewhere").mkdir()
    monkeypatch.chdir(case.folder / "elsewhere")
    loaded = load_model_file(Path("../model.toml"))
    assert loaded.model.blocks.count == 4
    assert loaded.output_folder.resolve() == case.folder / "out"


def test_a_mesh_in_millimetres(case: Case) -> None:
    case.change('file = "mesh.msh"', 'file = "mesh.msh"\nunit = "mm"')
    assert bsm.load("model.toml").blocks.moments.area.sum() == pytest.approx(4e-6)


def test_renamed_groups(case: Case) -> None:
    case.change("[rock.gneiss]", '[groups]\n"joint:J1" = "joint:S"\n"rock:gneiss" = "rock:tuff"\n[rock.tuff]')
    case.write("model.toml", (case.folder / "model.toml").read_text().replace("[joint.J1]", "[joint.S]"))
    blocks = bsm.load("model.toml").blocks
    assert (blocks.rock_names, blocks.joint_names) == (("tuff",), ("S",))


def test_what_was_mended_is_warned_of(case: Case) -> None:
    case.write("mesh.msh", (case.folder / "mesh.msh").read_text().replace('"boundary:top"', '"lid"'))
    case.change('boundary = "top"\npressure = "1 MPa"\n', "block = 3\npoint = [2, 2]\nforce = [1, 0]\n")
    with pytest.warns(MeshWarning, match="'lid' \\(2 elements\\)"):
        bsm.load("model.toml")


def test_faults_of_rocks_joints_and_supports_come_together(case: Case) -> None:
    case.change("poisson = 0.25", "poisson = 0.7")
    case.change("friction = 35", "friction = 95")
    case.change('fix = "all"', "")
    with pytest.raises(ModelError) as caught:
        bsm.load("model.toml")
    assert len(caught.value.faults) == 3
    assert all(fault.startswith("model.toml: ") for fault in caught.value.faults)


def test_a_support_given_by_axes_is_one_support(case: Case) -> None:
    """So that the numbers in messages are those of the file."""
    case.change('fix = "all"', 'fix = ["x", "y"]')
    assert bsm.load("model.toml").supports == (bsm.Fixed(boundary="bottom"),)


def test_an_excavation_that_nothing_excavates_is_told(case: Case) -> None:
    case.write("mesh.msh", msh(surface="excavation:1"))
    case.change("[rock.gneiss]", '[groups]\n"*" = "rock:gneiss"\n[rock.gneiss]')
    with pytest.warns(MeshWarning, match="excavation '1' \\(4 blocks\\) is left in place"):
        bsm.load("model.toml")
