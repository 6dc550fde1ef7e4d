"""Model files of three dimensions that are run: stages, supports, loads, the printed text and reported as JSON."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.modelfile.model_text import tables_of
from tests.scenes.small_case import Case, check_refusal
from tests.unit.test_key_blocks_command import JOINT

SLOPE = (
    """
dimensions = 3
title = "Block under a lid"

[mesh]
box = [[0, 0, 0], [2, 2, 3]]
default_joint = "J1"

[rock.granite]
unit_weight = "26 kN/m^3"
"""
    + JOINT.format(name="J1", friction=35, cohesion=0)
    + """
[[joint_plane]]
name = "J1"
dip = 30
dip_direction = 90
point = [1, 1, 1]

[[excavation]]
name = "lid"
polygon = [[-2, 2.5], [2, 2.5], [2, 3], [-2, 3]]
origin = [1, 1, 0]

[[support]]
boundary = "bottom"
fix = "all"

[solver]
threads = 1

[[stage]]
name = "lid off"
excavate = ["lid"]
"""
)
WEAKER = """
[[stage]]
name = "weaker"
strength = {J1 = 0.7}
"""


@pytest.mark.heavy
def test_stages_of_a_model_file_are_run_and_told(case: Case) -> None:
    """Weights of 10 and 2 m3; at 0.7 of its strength the joint holds to 26.1 degrees, and dips 30."""
    case.write("slope.toml", SLOPE + WEAKER)
    outcome = case.run("run", "slope.toml")
    assert outcome.code == 0
    said = " ".join(outcome.out.split())
    assert "lid off stable 2" in said
    assert "falls 1 block, 6 m3 (60 % of all), 156 kN" in said
    assert "weights and loads (x, y, z) 0 N, 0 N, -260 kN" in said
    assert "J1 4.619 m2 0 % 100 % 0 Pa" in said
    assert "blocks.pvd, contacts.pvd, supports.pvd" in said


def test_json_tells_verdicts_and_joints(case: Case) -> None:
    case.write("slope.toml", SLOPE)
    told = json.loads(case.run("run", "slope.toml", "--json").out)
    assert [stage["status"] for stage in told["stages"]] == ["stable", "stable"]
    assert told["stages"][0]["total_reaction"] == pytest.approx([0, 0, 12 * 26e3])
    (joint,) = told["joints"]
    assert joint["length"] == pytest.approx(8 / np.sqrt(3))  # 4 m2 of floor over cos 30
    assert joint["pressure"] == pytest.approx(6 * 26e3 * 3 / 16)  # weight times cos 30, over that area
    assert joint["open"] == 0


@pytest.mark.heavy
def test_check_reports_on_blocks_and_refuses_what_run_refuses(case: Case) -> None:
    case.write("slope.toml", SLOPE)
    outcome = case.run("check", "slope.toml")
    said = " ".join(outcome.out.split())
    assert (outcome.code, outcome.new) == (0, [])
    assert "the model is valid blocks 3 volume (least, median, greatest) 2, 4, 6 m3 total volume 12 m3" in said
    assert "joint J1 4.619 m2 unjointed rock 4 m2" in said
    assert "excavation lid 1 block stage lid off 2 blocks slivers" in said
    assert "no support on these sides of the box: west, east, south, north; blocks are free to leave there" in said
    told = json.loads(case.run("check", "slope.toml", "--json").out)
    assert told["touching_pairs"] == 0
    assert (told["weight"], told["supported_blocks"], told["unsupported"]) == (pytest.approx(12 * 26e3), 1, [])
    assert told["joint_areas"]["J1"] == pytest.approx(8 / np.sqrt(3))
    case.refuses("check", "slope.toml", "--threshold", "thin=0.1", says=["--threshold is for models of the plane"])
    case.write("free.toml", SLOPE.replace('[[support]]\nboundary = "bottom"\nfix = "all"\n', "[falls]\n"))
    case.refuses("run", "free.toml", says=["no support holds it"])
    assert "for bsm-mesh key-blocks only" in case.run("check", "free.toml").out
    case.write("linear.toml", SLOPE.replace("[solver]", '[solver]\nscheme = "linear"'))
    case.write("rigid.toml", SLOPE.replace('default_joint = "J1"', ""))
    for command in ("check", "run"):
        case.refuses(command, "linear.toml", says=["scheme"])
        case.refuses(command, "rigid.toml", says=["meet without a joint", "give the rock young and poisson"])


@pytest.mark.heavy
def test_safety_finds_the_factor_of_a_block_on_a_plane(case: Case) -> None:
    """The block slides where tan(35) over the factor is tan(30)."""
    case.write("slope.toml", SLOPE)
    outcome = case.run("safety", "slope.toml", "--json", "--tolerance", "0.002")
    assert outcome.code == 0
    told = json.loads(outcome.out)
    exact = np.tan(np.radians(35)) / np.tan(np.radians(30))
    assert told["stable"] <= exact <= told["unstable"] * (1 + 1e-3)
    assert told["unstable"] - told["stable"] <= 0.002 * exact * 1.01
    assert "upper bound" in told["limit_analysis"]["text"]
    assert exact <= told["limit_analysis"]["factor"] <= exact * (1 + 1e-3)
    names = {"safety.json", "trials.csv", "movement.png", "stable/blocks.pvd", "unstable/blocks.pvd"}
    assert names <= {name.partition("-safety/")[2] for name in outcome.new}


def test_the_file_and_python_build_equal_models(case: Case) -> None:
    loads = """
[[load]]
boundary = "east"
pressure = "2 kPa"

[[load]]
boundary = "west"
pressure = ["30 kPa", 0, 0, "-10 kPa/m"]

[[load]]
boundary = "top"
traction = [0, "1 kPa", [-2e3, 0, 50, 0]]

[[load]]
boundary = "north"
in_situ = true

[[load]]
block = 0
point = [1, 1, 2]
force = [0, "1 kN", 0]
"""
    ground = "\n[in_situ]\nsurface = 3\nk0 = 0.5\n"
    case.write("slope.toml", SLOPE + loads + ground)
    model = bsm.load(case.folder / "slope.toml")
    again = bsm.Model(
        blocks=model.blocks,
        rocks=[bsm.Rock("granite", unit_weight=26e3)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))],
        default_joint="J1",
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[
            bsm.Pressure(boundary="east", pressure=2e3),
            bsm.Pressure(boundary="west", pressure=(3e4, 0, 0, -1e4)),
            bsm.Traction(boundary="top", traction=(0, 1e3, (-2e3, 0, 50, 0))),
            bsm.InSituTraction(boundary="north"),
            bsm.PointLoad(block=0, point=(1, 1, 2), force=(0, 1e3, 0)),
        ],
        in_situ=bsm.InSitu(surface=3.0, k0=0.5),
        contact_points="both",
        stages=[bsm.Stage(name="lid off", excavate=["lid"])],
    )
    assert again == model
    text = (
        case.folder / "slope.toml"
    ).read_text() + "[stage.gravity]\nhorizontal = 0.1\ntrend = 20\n[gravity]\ntrend = 9\n"
    field = '\n[in_situ.stress]\nxx = "-2 MPa"\nzz = [-1e6, 0, 0, "26 kN/m^3"]\n'
    case.write("shaken.toml", text.replace(loads + ground, "") + loads + field)
    other = bsm.load(case.folder / "shaken.toml")
    (stage,) = other.stages
    assert other.in_situ == bsm.InSitu(stress={"xx": -2e6, "zz": (-1e6, 0, 0, 26e3)})
    assert (stage.gravity, stage.gravity_trend) == ((0.1, 0.0), 20.0)
    results = bsm.run(model)
    h = results_height(model)  # the sides are 2 m wide; the load on the top is gone with the lid
    west, north = 2 * (30e3 * h - 10e3 * h**2 / 2), 2 * 0.5 * 26e3 * (3 * h - h**2 / 2)
    assert_allclose(results.stages[-1].total_load, [west - 2e3 * 2 * h, 1e3 - north, -260e3])
    assert tables_of(model.options)["solver"]["threads"] == 1


def results_height(model):
    """Return the height of the rest of the side to the east [m]."""
    east = model.blocks.vertices[model.blocks.vertices[:, 0] == 2, 2]
    return np.unique(east)[-2] - east.min()


HUNG = (
    SLOPE.replace("point = [1, 1, 1]", "point = [1, 1, 1.2]").replace("friction = 35", "friction = 20")
    + """
[[bolt]]
table = "bolts.csv"
name = "B"
kind = "end_anchored"
yield_strength = "500 MPa"
"""
)
ROWS = "start_x,start_y,start_z,end_x,end_y,end_z,diameter [mm]\n1,0.5,2.2,0.5,0.5,0.2,25\n1,1.5,2.2,0.5,1.5,0.2,25\n"


@pytest.mark.heavy
def test_bolts_of_a_table_are_run_written_and_read(case: Case) -> None:
    case.write("hung.toml", HUNG)
    case.write("bolts.csv", ROWS)
    outcome = case.run("run", "hung.toml", "-o", "out")
    assert outcome.code == 0
    assert "greatest force in a bolt" in outcome.out
    assert "bolts.pvd, bolts.csv" in " ".join(outcome.out.split())
    results = bsm.run(bsm.load(case.folder / "hung.toml"))
    read = bsm.Results.load(case.folder / "out")
    for one, other in zip(results.stages, read.stages, strict=True):
        assert one.bolts.axial_force.min() > 1e3
        for name in ("axial_force", "point", "displacement", "original", "slip", "status"):
            assert_allclose(getattr(other.bolts, name), getattr(one.bolts, name))
        assert other.bolts.names == ("B 1", "B 2")
    assert read.check().ok
    assert case.run("verify", "out").code == 0
    header = (case.folder / "out/bolts.csv").read_text().splitlines()[0]
    assert "x [m],y [m],z [m],bond_force [N]" in header


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("1,0.5,2.2,0.5", "1,0.5,4.2,0.5", "has its start in the void, "),
        ("start_z", "start_zz", "unknown column 'start_zz'; did you mean 'start_z'?"),
        ("1,0.5,2.2,0.5,0.5,0.2", "1,0.5,2.2,0.5,0.5,", "end_z must be given"),
        (ROWS.split("\n", 1)[1], "1,0.5,2.2,1,0.5,2.4,25\n", "lies in a single block and carries nothing"),
    ],
)
def test_a_table_of_bolts_that_does_not_fit_is_refused(case: Case, old: str, new: str, said: str) -> None:
    case.write("hung.toml", HUNG)
    case.write("bolts.csv", ROWS.replace(old, new))
    case.refuses("run", "hung.toml", says=[said])


@pytest.mark.heavy
def test_what_is_for_the_plane_is_refused(case: Case) -> None:
    case.write("slope.toml", SLOPE)
    case.refuses("run", "slope.toml", "--tables", "csv", says=["tables of results are for the plane"])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('boundary = "bottom"\nfix', 'boundary = "floor"\nfix', "there is no boundary 'floor'"),
        ('boundary = "bottom"\nfix = "all"', 'blocks = [0]\nfix = "normal"', 'fix = "normal" needs a boundary'),
        ('fix = "all"', 'fix = ["x"]', "[[support]] number 1, fix"),
        ('boundary = "bottom"\nfix', "point = [0, 0]\nfix", "unknown key 'point'; it is for models of the plane"),
        (
            'excavate = ["lid"]',
            'shaking = { record = "q.csv" }',
            "unknown key 'shaking'; it is for models of the plane",
        ),
        ("dip_direction = 90", "", "needs the key 'dip_direction', for example dip_direction = 135"),
        ('excavate = ["lid"]', 'excavate = ["lod"]', "there is no excavation 'lod'; did you mean 'lid'?"),
        ('excavate = ["lid"]', "excavate = [[[0, 0], [1, 0], [1, 1]]]", "[[stage]] number 1, excavate"),
        (
            "[solver]",
            '[[load]]\nboundary = "east"\n[solver]',
            "give boundary with pressure, traction or in_situ = true, or block with point and force",
        ),
        ("[solver]", "[[load]]\nblock = 9\npoint = [1, 1, 2]\nforce = [1, 0, 0]\n[solver]", "there is no block 9"),
        (
            "[solver]",
            "[[load]]\nblock = 0\npoint = [1, 1, 9]\nforce = [1, 0, 0]\n[solver]",
            "load 1 (PointLoad): the point (1, 1, 9) is not in block 0, whose centroid is (1.1283, 1, 1.71296)",
        ),
        ("threads = 1", 'scheme = "linear"', "scheme = 'linear' is for the plane"),
        ('[[support]]\nboundary = "bottom"\nfix = "all"', "", "no support holds it"),
    ],
)
def test_what_is_wrong_is_refused(case: Case, old: str, new: str, said: str) -> None:
    assert SLOPE.count(old) == 1
    case.write("slope.toml", SLOPE.replace(old, new))
    case.refuses("run", "slope.toml", says=[said])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("J1 = 0.7", "J9 = 0.7", ["stage 'weaker': strength: there is no joint 'J9'"]),
        ("dimensions = 3", "dimensions = 4", ["dimensions = 4: must be 3; in a model of the plane leave it out"]),
        ("point = [1, 1, 1]", "point = [1, 1, 1]\nradius = -1", ["[[joint_plane]] number 1, radius = -1: must be"]),
        (
            '[[joint_plane]]\nname = "J1"\ndip = 30\ndip_direction = 90\npoint = [1, 1, 1]',
            '[[joint_set]]\nname = "J1"\ndip = 30\ndip_direction = 90\nspacing = -1',
            ["error: slope.toml: [[joint_set]] number 1, spacing = -1: must be"],
        ),
        ("dimensions = 3", 'dimensions = 3\n"list[a]" = 1', ["top level: unknown key 'list[a]'"]),
    ],
)
def test_faults_of_such_files_are_said_once_by_their_keys(case: Case, old: str, new: str, words: list[str]) -> None:
    assert old in SLOPE + WEAKER
    case.write("slope.toml", (SLOPE + WEAKER).replace(old, new))
    check_refusal(case.run("run", "slope.toml"), words)
