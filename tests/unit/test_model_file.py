"""The model file: what it may hold beside what `test_bad_input.py` shows to be refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import MeshWarning, ModelError
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.modelfile.model_file import read_model_file
from tests.scenes.small_case import MODEL, Case
from tests.scenes.square_mesh import msh


@pytest.mark.parametrize("content", [MODEL.replace("\n", "\r\n").encode(), b"\xef\xbb\xbf" + MODEL.encode()])
def test_files_of_windows(case: Case, content: bytes) -> None:
    expected = bsm.load("model.toml")
    case.write("model.toml", content)
    assert bsm.load("model.toml") == expected


def test_defaults(case: Case) -> None:
    file = read_model_file(Path("model.toml"))
    assert (file.mesh.unit, file.mesh.contact_points, file.gravity.direction) == ("m", "ends", -90.0)
    assert (file.solver.tolerance, file.solver.linear_solver, file.output.folder) == (1e-6, "auto", None)
    (joint,) = bsm.load("model.toml").joints
    assert isinstance(joint.law, bsm.Patton)  # where friction is given without a law


def test_paths_are_relative_to_the_model_file(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    (case.folder / "elsewhere").mkdir()
    monkeypatch.chdir(case.folder / "elsewhere")
    loaded = load_model_file(Path("../model.toml"))
    assert loaded.model.blocks.count == 4
    assert loaded.output_folder.resolve() == case.folder / "out/model"


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
    assert "note: excavation '1' (4 blocks) is left in place" in case.run("check", "model.toml").out


def test_a_great_merge_tolerance_is_told(case: Case) -> None:
    case.change("[mesh]\n", "[mesh]\nmerge_tolerance = 0.1\n")
    for command, before in (("check", "mesh: note: "), ("run", "mesh: ")):
        outcome = case.run(command, "model.toml")
        note = f"{before}merge_tolerance = 0.1 m is unusual (0 to 0.01 m is usual); check the number and its unit"
        assert note in (outcome.out + outcome.err).splitlines()


GROUND = """
[in_situ]
surface = [[0, "2 m"], ["1 m", 2]]
surcharge = "10 kPa"
k0 = { a = 3, b = 0.5 }

[water]
table = [[[0, 1], [1, 1.5]], [["1.2 m", 1], [2, 0.5]]]
unit_weight = "10 kN/m^3"
head = "parallel"
joint_pressure = { J1 = "5 kPa" }

[[stage]]
name = "dug"
excavate = ["1", 2, [[0, 1], [1, 1], [1, 2], [0, "2 m"]]]
relaxation = [0.5, 1]
pressure = "7 kPa"
water = { table = [] }
load = [{ boundary = "top", in_situ = true }]

[[stage]]
name = "filled"
fill = [2]
"""


def test_ground_and_stages_in_the_file_and_in_python(case: Case) -> None:
    text = MODEL.replace('[[load]]\nboundary = "top"\npressure = "1 MPa"\n', "") + GROUND.replace('"1", 2', "2")
    case.write("model.toml", text)
    read = bsm.load("model.toml")
    dry = read.replace(in_situ=None, water=None, stages=())
    built = dry.replace(
        in_situ=bsm.InSitu(surface=[(0, 2), (1, 2)], surcharge=10e3, k0={"a": 3, "b": 0.5}),
        water=bsm.Water(
            table=[[(0, 1), (1, 1.5)], [(1.2, 1), (2, 0.5)]],
            unit_weight=10e3,
            head="parallel",
            joint_pressure={"J1": 5e3},
        ),
        stages=[
            bsm.Stage(
                name="dug",
                excavate=[2, [(0, 1), (1, 1), (1, 2), (0, 2)]],
                relaxation=[0.5, 1.0],
                pressure=7e3,
                water=bsm.Water(),
                loads=[bsm.InSituTraction(boundary="top")],
            ),
            bsm.Stage(name="filled", fill=[2]),
        ],
    )
    assert read == built
    assert read != dry
    assert [stage.status for stage in bsm.run(read).stages] == ["stable"] * 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("surface = [[0", "surfaec = [[0", ["[in_situ]", "unknown key 'surfaec'", "did you mean 'surface'"]),
        ("k0 = {", "k0 = { d = 1,", ["[in_situ] k0", "a / h"]),
        ("k0 = { a = 3, b = 0.5", "k0 = { a = 3, b = -5", ["[in_situ] k0", ": b must be 0 to 20"]),
        ('"10 kPa"', '"10 m"', ["[in_situ] surcharge", "does not convert"]),
        ("table = [[[0, 1]", "table = [[[0]", ["[water] table", "points [[x, y], ...]"]),
        ('head = "parallel"', 'head = "along"', ["[water] head", "not known"]),
        ("[1, 1.5]]", "[-1, 1.5]]", ["water: table", "from left to right"]),
        ("J1 = ", "J2 = ", ["joint_pressure", "no joint 'J2'", "J1"]),
        ('excavate = ["1"', 'excavate = [1.5, "1"', ["[[stage]] number 1", "excavation group"]),
        ('["1", 2', '["one", 2', ["stage 'dug'", "no excavation 'one'"]),
        ("fill = [2]", "fil = [2]", ["[[stage]] number 2", "unknown key 'fil'", "did you mean 'fill'"]),
        (
            "fill = [2]",
            "table = [[0, 3]]",
            ["[[stage]] number 2: unknown key 'table'; it belongs in water = { table = ... }"],
        ),
        ("fill = [2]", "zones = {}", ["[[stage]] number 2: unknown key 'zones'; it belongs in [rock.NAME]"]),
        ("relaxation = [0.5, 1]", "relaxation = [1, 0.5]", ["stage 'dug'", "must rise"]),
        ("in_situ = true", "in_situ = false", ["stage 'dug': load 1", "in_situ = true"]),
        ("in_situ = true", 'pressur = "1 kPa"', ["[[stage]] number 1, load.0", "did you mean 'pressure'"]),
    ],
)
def test_faults_of_ground_and_stages(case: Case, old: str, new: str, words: list[str]) -> None:
    text = MODEL + GROUND
    assert old in text
    case.write("model.toml", text.replace(old, new).replace('"1", 2', "2"))
    with pytest.raises(ModelError) as caught:
        bsm.load("model.toml")
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_mesh_in_the_place_of_a_model_file(case: Case) -> None:
    with pytest.raises(bsm.ModelError, match=r"is a mesh, no model file; name it in one \(\[mesh\] file = "):
        bsm.load("mesh.msh")
