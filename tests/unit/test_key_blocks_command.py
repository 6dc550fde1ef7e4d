"""The command ``key-blocks``: a model file of three dimensions, the printed text, told as JSON, written and refused."""

import csv
import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.modelfile.space_file import load_space_file
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.pictures.joint_net import joint_net
from tests.scenes.polyhedra import on_incline
from tests.scenes.rock_3d import WEDGES, wedge_factor, wedge_rock
from tests.scenes.small_case import Case
from tests.unit.test_quantities import numbers_without_range

JOINT = """
[joint.{name}]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = {friction}
cohesion = {cohesion}
"""
ROOF = (
    """
dimensions = 3
title = "Pyramid over a cavern"

[mesh]
box = [[-6, -6, -1], [6, 6, 6]]

[rock.gneiss]
unit_weight = "26 kN/m^3"
"""
    + JOINT.format(name="J1", friction=30, cohesion=0)
    + "".join(
        f'\n[[joint_plane]]\nname = "J1"\ndip = 60\ndip_direction = {d}\npoint = [{x}, {y}, 2]\n'
        for d, x, y in ((0, 0, 1), (90, 1, 0), (180, 0, -1), (270, -1, 0))
    )
    + """
[[excavation]]
name = "cavern"
polygon = [[-5, 0], [5, 0], [5, 2], [-5, 2]]
from = -5
to = 5
"""
)


@pytest.mark.heavy
def test_the_terminal_shows_what_is_at_work_unless_quiet(case: Case) -> None:
    case.write("roof.toml", ROOF)
    words = "key-blocks", "roof.toml", "--no-picture"
    at_work = [line.partition("] ")[2] for line in case.run(*words).err.splitlines() if line.startswith("[")]
    assert at_work == ["blocks", "key blocks", "files"]
    assert not any(line.startswith("[") for line in case.run(*words, "-q", "-o", "second").err.splitlines())


@pytest.mark.heavy
def test_what_falls_is_printed_and_written(case: Case) -> None:
    case.write("roof.toml", ROOF)
    outcome = case.run("key-blocks", "roof.toml")
    assert outcome.code == 0
    said = " ".join(outcome.out.split())
    assert "1 fall and 0 slide below a factor of 1: 2.309 m3 in all" in said
    assert "falls 0.000 2.309 60.04 kN 15.01 kPa" in said
    assert {name for name in outcome.new if name.startswith("out/roof")} >= {
        f"out/roof-key-blocks/{name}"
        for name in (
            "key_blocks.json",
            "key_blocks.csv",
            "blocks.vtu",
            "contacts.vtu",
            "key_blocks.png",
            "stereonet.png",
        )
    }
    with (case.folder / "out/roof-key-blocks/key_blocks.csv").open(encoding="utf-8", newline="") as file:
        (row,) = [row for row in csv.DictReader(file) if row["mode"] == "falls"]
    assert float(row["volume [m^3]"]) == pytest.approx(4 / np.sqrt(3))
    told = json.loads(case.run("key-blocks", "roof.toml", "--json", "--no-picture", "-o", "second").out)
    assert told["falls"] == [int(row["block"])]
    assert told["slides"] == {}
    assert any(note.endswith("give rounds = 2 in [key_blocks]") for note in told["notes"])
    assert len(told["files"]) == 5
    case.write("roof.toml", f"{ROOF}\n[key_blocks]\nrounds = 2\n")
    told = json.loads(case.run("key-blocks", "roof.toml", "--json", "--no-picture", "-o", "third").out)
    assert not any("are not examined" in note for note in told["notes"])


@pytest.mark.heavy
def test_a_wedge_in_a_slope_has_its_factor(case: Case) -> None:
    first, second, face, top, height, friction, cohesion, unit_weight = WEDGES["Hoek and Bray"]
    _, _, volume, areas = wedge_rock(first, second, face, top, height)
    planes = "".join(
        f'\n[[joint_plane]]\nname = "{name}"\ndip = {dip}\ndip_direction = {direction}\npoint = [0, 0, 0]\n'
        for name, (dip, direction) in (("A", first), ("B", second))
    )
    joints = "".join(
        JOINT.format(name=n, friction=f, cohesion=c) for n, f, c in zip("AB", friction, cohesion, strict=True)
    )
    text = f"""
dimensions = 3

[mesh]
box = [[-110, -110, -20], [110, 110, 80]]

[rock.granite]
unit_weight = {unit_weight}
{joints}{planes}
[slope]
toe = [0, 0, 0]
face = {{dip = {face[0]}, dip_direction = {face[1]}}}
top = {{dip = {top[0]}, dip_direction = {top[1]}}}
height = {height}

[key_blocks]
required = 2.0
"""
    case.write("wedge.toml", text)
    told = json.loads(case.run("key-blocks", "wedge.toml", "--json", "--no-picture").out)
    (factor,) = told["slides"].values()
    assert factor == pytest.approx(
        wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion), abs=1e-6
    )
    assert told["volume"] == pytest.approx(volume)
    case.write("wedge.toml", text.replace("required = 2.0", "required = 1.0"))  # no block is below it
    said = case.run("key-blocks", "wedge.toml", "--no-picture").out
    assert f"least factor {factor:.3f}: block " in said
    assert "slides on B, A" in said


@pytest.mark.heavy
def test_the_file_has_gravity_water_and_loads_and_what_is_not_considered_is_noted(case: Case) -> None:
    case.write("roof.toml", ROOF)
    plain = json.loads(case.run("key-blocks", "roof.toml", "--json", "--no-picture", "-o", "plain").out)
    (block,) = plain["falls"]
    stages = '\n[[stage]]\nname = "rain"\nstrength = {J1 = 0.5}\n\n[[stage]]\nname = "dig"\nexcavate = ["cavern"]\n'
    for key, table in {
        "gravity": "[gravity]\nvertical = 1.5",
        "load": f'[[load]]\nblock = {block}\npoint = [0, 0, 2.5]\nforce = [0, 0, "70 kN"]',
    }.items():
        case.write(f"{key}.toml", f"{ROOF}\n{table}\n")
        told = json.loads(case.run("key-blocks", f"{key}.toml", "--json", "--no-picture", "-o", key).out)
        assert told["falls"] == []
    case.write("noted.toml", f'{ROOF}\n[in_situ.stress]\nzz = "-1 MPa"\n{stages}')
    told = json.loads(case.run("key-blocks", "noted.toml", "--json", "--no-picture", "-o", "noted").out)
    assert told["falls"] == plain["falls"]
    assert sum("is not considered; a run does" in note for note in told["notes"]) == 1
    (noted,) = [note for note in told["notes"] if "those before the stages" in note]
    assert noted.startswith("stage 'rain' changes strength:")


@pytest.mark.parametrize(("level", "noted"), [(3, 1), (-3, 0)])
def test_water_over_an_opening_is_noted(case: Case, level: int, noted: int) -> None:
    stage = '[[stage]]\nname = "dig"\nexcavate = ["cavern"]\n\n[[support]]\nboundary = "top"\nfix = "all"\n'
    rock = ROOF.replace("box =", 'default_joint = "J1"\nbox =')
    case.write("wet.toml", f"{rock}\n{stage}\n[water]\nplane = {{point = [0, 0, {level}]}}\n")
    told = json.loads(case.run("key-blocks", "wet.toml", "--json", "--no-picture").out)
    assert sum("lies up to 3 m above free faces: the water presses" in note for note in told["notes"]) == noted
    notes = json.loads(case.run("check", "wet.toml", "--json").out)["notes"]
    says = "stage 'dig': the water plane lies up to 3 m above excavated surfaces, deepest at (0, 0, 0)"
    assert sum(note.startswith(says) for note in notes) == noted


def test_the_stereonet_has_the_face_of_the_slope() -> None:
    net = joint_net(on_incline(20.0).blocks, 30.0, "slope", face=(65.0, 185.0))
    assert net is not None
    labels = net.axes[0].get_legend_handles_labels()[1]
    assert "slope 65/185" in labels


def test_the_file_and_python_build_the_same_blocks(case: Case) -> None:
    case.write("roof.toml", ROOF)
    loaded = load_space_file(case.folder / "roof.toml")
    assert loaded.blocks.rock_names == ("gneiss",)
    assert_allclose(loaded.blocks.moments.volume[loaded.blocks.excavations["cavern"]].sum(), 200.0)
    found = bsm.key_blocks(loaded.blocks, rocks=loaded.rocks, joints=loaded.joints, excavated=["cavern"])
    assert found.unstable.sum() == 1


def test_sets_have_distributions_scatter_and_discs(case: Case) -> None:
    text = ROOF.replace(
        "[[excavation]]",
        '[[joint_set]]\nname = "J1"\ndip = 20\ndip_direction = 10\nscatter = {fisher = 50}\n'
        'spacing = {law = "lognormal", mean = "3 m", deviation = "1 m"}\norigin = [0, 0, 5]\n\n'
        '[[joint_set]]\nname = "J1"\ndip = 80\ndip_direction = 200\ndensity = 0.3\nradius = "2 m"\n\n[[excavation]]',
    )
    case.write("roof.toml", text)
    assert load_space_file(case.folder / "roof.toml").blocks.count > 20


@pytest.mark.heavy
def test_limit_analysis_proves_that_the_whole_moves(case: Case) -> None:
    """Without the pyramid no block is left that could move but the rock itself, which rests on its sides."""
    joints = ROOF.replace("friction = 30", "friction = 20")  # at 30 degrees statics could clamp it between its planes
    slab = '\n[[joint_plane]]\nname = "J1"\ndip = 0\ndip_direction = 0\npoint = [0, 0, 3]\n\n[[excavation]]'
    case.write("roof.toml", joints.replace("\n[[excavation]]", slab))
    outcome = case.run("key-blocks", "roof.toml", "--proof", "--no-picture")
    said = " ".join(outcome.out.split())
    assert "whole rock: inadmissible: no forces within strength balance the loads; this geometry must move" in said
    told = json.loads(case.run("key-blocks", "roof.toml", "--proof", "--json").out)["limit_analysis"]
    assert not told["whole rock"]["admissible"]
    assert "without these blocks" in told


def test_key_blocks_are_told_where_limit_analysis_has_no_answer(case: Case) -> None:
    """Without the pyramid all blocks reach the sides of the box, and are fixed."""
    case.write("roof.toml", ROOF)
    told = json.loads(case.run("key-blocks", "roof.toml", "--proof", "--no-picture", "--json").out)
    assert len(told["falls"]) == 1
    assert told["limit_analysis"]["without these blocks"]["admissible"] is None
    assert "all blocks are fixed" in told["limit_analysis"]["without these blocks"]["text"]


def test_a_profile_is_read_from_a_table(case: Case) -> None:
    case.write("cavern.csv", "x [cm];z [cm]\n-500;0\n500;0\n500;200\n-500;200\n")
    text = ROOF.replace("polygon = [[-5, 0], [5, 0], [5, 2], [-5, 2]]", 'profile = "cavern.csv"')
    case.write("roof.toml", text)
    told = json.loads(case.run("key-blocks", "roof.toml", "--no-picture", "--json", "--no-scripts").out)
    assert told["volume"] == pytest.approx(4 / np.sqrt(3))
    case.write("roof.toml", text.replace('"cavern.csv"', '"../cavern.csv"'))
    case.refuses("key-blocks", "roof.toml", "--no-scripts", says=["leads out of the folder of the model file"])
    case.write("cavern.csv", "x;z\n-5;0\n5;high\n5;2\n")
    case.write("roof.toml", text)
    case.refuses("key-blocks", "roof.toml", says=["cavern.csv, line 3: z = 'high' is no finite number"])


def test_joints_without_strength_are_noted(case: Case) -> None:
    case.write("roof.toml", ROOF.replace('law = "mohr_coulomb"\nfriction = 30\ncohesion = 0\n', ""))
    outcome = case.run("key-blocks", "roof.toml", "--no-picture")
    assert "note: joint 'J1' has no strength (law, friction): nothing slides on it" in " ".join(outcome.err.split())


def test_every_number_of_the_file_has_a_range() -> None:
    assert list(numbers_without_range(SpaceFile.model_json_schema(), "model")) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("dimensions = 3", "", "is a model of the plane; key blocks are found in rock of three dimensions"),
        ("dip = 60", "dip = 95", "[[joint_plane]] number 1, dip = 95: must be 0 to 90 degrees"),
        ("point = [0, 1, 2]", "point = [0, 1]", "needs three numbers [x, y, z] in m"),
        ("[joint.J1]", "[joint.J2]", "[[joint_plane]] 'J1': there is no [joint.J1]; did you mean 'J2'?"),
        ("dip_direction = 0", "dip_dir = 0", "unknown key 'dip_dir'; did you mean 'dip_direction'?"),
        ("to = 5", "", "from and to go together"),
        ("polygon = [[-5, 0], [5, 0], [5, 2], [-5, 2]]", "", "give one of polygon and profile"),
        ("from = -5\nto = 5", "from = 40\nto = 50", "excavation 'cavern': there is no rock in it"),
        (
            "[5, 2], [-5, 2]]",
            "[-5, 2], [5, 2]]",
            "'cavern': prism: the profile is no simple polygon: it crosses",
        ),
        (
            "[rock.gneiss]",
            "[rock.a]\nunit_weight = 1\n[rock.gneiss]",
            "name the rock of the box: rock = one of 'a', 'gneiss'",
        ),
        ("friction = 30", "friction = 30\nalong = [[0, 0], [1, 1]]", "lay joints into a mesh of the plane"),
        ("[[excavation]]", "[key_blocks]\nfree = ['roof']\n[[excavation]]", "there is no boundary 'roof'"),
        (
            "[[excavation]]",
            "[key_blocks]\nrounds = 0\n[[excavation]]",
            "[key_blocks] rounds = 0: must be a whole number",
        ),
        ("box = [[-6, -6, -1], [6, 6, 6]]", "box = [[6, 6, 6], [-6, -6, -1]]", "every coordinate of the second corner"),
        ('unit_weight = "26 kN/m^3"', 'unit_weight = "26 kg"', "[rock.gneiss] unit_weight"),
    ],
)
def test_what_is_wrong_is_refused(case: Case, old: str, new: str, said: str) -> None:
    assert ROOF.count(old) >= 1
    case.write("roof.toml", ROOF.replace(old, new, 1))
    case.refuses("key-blocks", "roof.toml", says=[said])


@pytest.mark.parametrize("command", ["run", "check", "safety", "key-blocks"])
def test_every_command_refuses_names_that_lead_nowhere(case: Case, command: str) -> None:
    for keys, said in (
        ("free = ['tops']", "[key_blocks] free: there is no boundary 'tops'; did you mean 'top'?"),
        ("joint_pressure = { J7 = 1e4 }", "[key_blocks] joint_pressure: there is no joint 'J7'; did you mean 'J1'?"),
    ):
        case.write("roof.toml", ROOF.replace("[[excavation]]", f"[key_blocks]\n{keys}\n[[excavation]]", 1))
        case.refuses(command, "roof.toml", says=[said])


@pytest.mark.parametrize("command", ["compare"])
def test_other_commands_say_that_they_read_no_such_file(case: Case, command: str) -> None:
    case.write("roof.toml", ROOF)
    case.refuses(
        command,
        "roof.toml",
        says=["is a model of three dimensions, and this command is for the plane"],
    )
