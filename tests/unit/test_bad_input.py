"""What a clumsy or hostile user writes into a model file: one message, exit code 2, nothing written, no traceback.

Every message must name the thing, the place and the cure; the words that must be in it are compared with each case.
"""

from __future__ import annotations

import json
import shutil

import pytest

from tests.scenes.small_case import FILE, JOINT, JUNK, LINEAR, LOAD, MODEL, ROCK, SUPPORT, Case
from tests.scenes.square_mesh import msh

KEYS = [  # old, new, words
    ("title =", "titel =", ["model.toml: top level: unknown key 'titel'", "did you mean 'title'"]),
    (
        "title =",
        "schema_version = 2\nnew_key = 1\ntitle =",
        ["schema_version = 2: is of a newer bsm-mesh; version ", "reads 1: update it"],
    ),
    ("title =", "schema_version = 0\ntitle =", ["schema_version = 0: is not known", "known: 1"]),
    ("[rock.gneiss]", "[rocks.gneiss]", ["unknown key 'rocks'", "did you mean 'rock'", "needs the key 'rock'"]),
    ("file =", "fiel =", ["[mesh]: unknown key 'fiel'", "did you mean 'file'"]),
    (
        FILE,
        f"{FILE}box = [[0, 0, 0], [1, 1, 1]]\n",
        ["[mesh]: unknown key 'box'; it is for three dimensions", "dimensions = 3"],
    ),
    ("young =", "yuong =", ["[rock.gneiss]: unknown key 'yuong'", "did you mean 'young'"]),
    ("friction =", "frction =", ["[joint.J1]: unknown key 'frction'", "did you mean 'friction'"]),
    ("fix =", "fixed =", ["[[support]] number 1: unknown key 'fixed'", "did you mean 'fix'"]),
    ("pressure =", "presure =", ["[[load]] number 1: unknown key 'presure'", "did you mean 'pressure'"]),
    (LOAD, '[solver]\nshceme = "linear"\n', ["[solver]: unknown key 'shceme'", "did you mean 'scheme'"]),
    (JOINT, "[joint.J1]\nfilling = {thicknes = 1, young = 1e9, poisson = 0.2}\n", ["did you mean 'thickness'"]),
    (FILE, "", ["[mesh] needs one of the keys 'file' and 'geometry'", "neither"]),
    (FILE, FILE + 'geometry = "circular_tunnel"\n', ["'file' and 'geometry'", "both"]),
    (FILE, FILE + "parameters = {radius = 2}\n", ["[mesh.parameters] belong to a geometry"]),
    ("[mesh]\n" + FILE, "", ["needs the key 'mesh'", 'file = "mesh.msh"']),
    (ROCK, "", ["needs the key 'rock'", "[rock.gneiss]"]),
    (ROCK, "[rock]\n", ["[rock]: needs a rock at least", "[rock.gneiss]"]),
    ("poisson = 0.25\n", "", ["rock 'gneiss': young is given without poisson"]),
]
TYPES = [
    ('"Two by two"', "3", ["title = 3", "must be a text, in quotes"]),
    ("0.25", '"0.25"', ["[rock.gneiss] poisson", "without quotes"]),
    ('"10 GPa"', "true", ["[rock.gneiss] young = true", "needs a number [Pa]"]),
    ('"10 GPa"', "[1]", ["[rock.gneiss] young = [1]", "needs a number [Pa]"]),
    ("[[support]]", "[support]", ["[support]", "[[support]], in double brackets"]),
    ("[mesh]", "[[mesh]]", ["must be a table", "[mesh], in single brackets"]),
    (ROCK, "[rock]\ngneiss = 3\n", ["[rock.gneiss]: must be a table of keys, not 3"]),
    (SUPPORT, '[[support]]\nblocks = ["0"]\nfix = "all"\n', ["[[support]] number 1", "must be a whole number"]),
    (SUPPORT, '[[support]]\nblocks = [0.5]\nfix = "all"\n', ["[[support]] number 1", "must be a whole number"]),
    (ROCK, ROCK + '[groups]\n"joint:J1" = 3\n', ['[groups] "joint:J1" = 3', "must be a text"]),
    (FILE, FILE + 'contact_points = "end"\n', ["[mesh] contact_points", "did you mean 'ends'"]),
    (LOAD, '[solver]\nlinear_solver = "mumps"\n', ["linear_solver", "known: auto, cluster, pardiso, superlu"]),
    (LOAD, '[solver]\ntolerance = "1e-6"\n', ["[solver] tolerance", "without quotes"]),
    (LOAD, '[output]\nfolder = ""\n', ["[output] folder", "must be the name of a file or folder"]),
    ("mesh.msh", "me\\u0000sh.msh", ["[mesh] file", "must be the name of a file or folder"]),
]
UNITS = [
    ('"10 GPa"', '"10 GPa/m"', ["[rock.gneiss] young", "is in GPa/m", "does not convert to Pa"]),
    ('"26 kN/m^3"', '"2700 kg/m^3"', ["unit_weight", "is in kg/m³", "density", "9.81", '"26 kN/m^3"']),
    ('"10 GPa"', '"10 Gigapa"', ["the unit Gigapa is unknown", "give Pa"]),
    ('"10 GPa"', '"10 Kpa"', ["the unit Kpa is unknown", '"20 GPa"']),
    ('"10 GPa"', '"10e9"', ["a text without a unit", "plain number (in Pa)"]),
    ('"10 GPa"', '"10,5 GPa"', ["a comma is no decimal point"]),
    ('"10 GPa"', '"GPa"', ["not a number with a unit"]),
    ('"10 GPa"', '"stiff"', ["not a number with a unit"]),
    ("friction = 35", 'friction = "35"', ["[joint.J1] friction", "a text without a unit", '"35 deg"']),
    ("friction = 35", 'friction = "35 kPa"', ["does not convert to degree"]),
    (FILE, FILE + 'unit = "mmm"\n', ['model.toml: [mesh] unit = "mmm"', "unknown"]),
    (FILE, FILE + 'unit = "kPa"\n', ["[mesh] unit", "does not convert to m"]),
    (LOAD, '[[load]]\nblock = 3\npoint = ["1 kPa", 1]\nforce = [1, 2]\n', ["[[load]] number 1, point", "m"]),
    (LOAD, '[[load]]\nblock = 3\npoint = [1.5, 1.5]\nforce = ["1 kN", 2]\n', ["number 1, force", '"120 kN/m"']),
]
BARTON = 'law = "barton_bandis"\njcs = "50 MPa"\nresidual_friction = 28\n'
VALUES = [
    ('"10 GPa"', "nan", ["[rock.gneiss] young = nan", "no finite number"]),
    ('"10 GPa"', '"inf GPa"', ["[rock.gneiss] young", "no finite number"]),
    ('"10 GPa"', "1e400", ["[rock.gneiss] young", "no finite number"]),
    ('"10 GPa"', "-1", ["[rock.gneiss] young = -1: must be 1e-6 to 1e18 Pa", '"20 GPa"']),
    ('"10 GPa"', "0", ["[rock.gneiss] young = 0: must be 1e-6 to 1e18 Pa"]),
    ("0.25", "0.5", ["[rock.gneiss] poisson = 0.5: must be 0 to 0.499"]),
    ("friction = 35", "friction = 90", ["[joint.J1] friction = 90: must be at least 0 and below 90 degrees"]),
    ("friction = 35", "friction = 35\ndilation = 60", ["joint 'J1'", "friction + dilation = 95"]),
    ('"26 kN/m^3"', '"-26 kN/m^3"', ['unit_weight = "-26 kN/m^3": must be 0 to 1e12 N/m^3']),
    (
        '"26 kN/m^3"',
        "26",
        [
            "[rock.gneiss] unit_weight = 26: a number without a unit is in N/m^3",
            'write the unit, for example "26 kN/m^3", or "26 N/m^3" if that is meant',
        ],
    ),
    ('"5 GPa/m"', "0", ["[joint.J1] normal_stiffness = 0: must be 1 to 1e18 Pa/m", '"5 GPa/m"']),
    ('"1 MPa"', "1e300", ["[[load]] number 1, pressure = 1e+300: must be -1e10 to 1e10 Pa"]),
    (
        JOINT,
        JOINT.replace('"5 GPa/m"', "1e-20") + LINEAR,
        ["[joint.J1] normal_stiffness = 1e-20: must be 1 to 1e18 Pa/m"],
    ),
    (JOINT, "[joint.J1]\n", ["joint 'J1': needs normal_stiffness and shear_stiffness", "or filling"]),
    (JOINT, JOINT + 'law = "mohr_coulomb"\ndilation = 5\n', ["joint 'J1'", "no dilation", "choose 'patton'"]),
    ("friction = 35", "cohesion = 5", ["joint 'J1'", "needs the key 'friction'"]),
    (
        "friction = 35",
        "friction = 35\ncohesion = 1e4",
        ["a joint with cohesion needs the key 'law'. The usual one is \"mohr_coulomb\": friction and cohesion carry"],
    ),
    ("friction = 35", "jrc = 8", ["joint 'J1'", "a joint with jrc needs the key 'law'", '"barton_bandis" (jrc, jcs']),
    ("friction = 35", 'law = "barton_bandis"\njrc = 8', ["law 'barton_bandis' needs the key 'jcs' [Pa]"]),
    ("friction = 35", BARTON + "friction = 35", ["law 'barton_bandis' has no friction; remove it or choose"]),
    (
        "friction = 35",
        BARTON + "jrc = 25",
        ["[joint.J1] jrc = 25: must be 0 to 20", "Barton's profiles end"],
    ),
    ("friction = 35", BARTON + "jrc = 8\nroughness_wears = 1.5", ["[joint.J1] roughness_wears = 1.5"]),
    ("friction = 35", BARTON + "jrc = 8\nmax_closure = 0", ["[joint.J1] max_closure = 0: must be 1e-6 to 1 m"]),
    (
        "friction = 35",
        'law = "ladanyi_archambault"\nfriction = 35',
        ["needs the key 'dilation' [degrees]", "'jcs' [Pa]"],
    ),
    (JOINT, JOINT + 'law = "mohr_coulomb"\nsoftening_slip = "5 mm"\n', ["softening_slip = 0.005 m never acts"]),
    (FILE, FILE + "merge_tolerance = 10\n", ["[mesh] merge_tolerance = 10: must be 0 to 1 m"]),
    (FILE, FILE + "merge_tolerance = 1\n", ["mesh.msh: none of the 4 surface elements has an area", "1 m"]),
    (LOAD, "[solver]\nthreads = -1\n", ["[solver] threads = -1: must be a whole number, 0 to 4096"]),
]
NAMES = [
    ("[rock.gneiss]", "[rock.gnies]", ["rock 'gneiss' of 4 blocks", "[rock.gneiss]", "did you mean 'gnies'"]),
    (
        "[joint.J1]",
        "[joint.J2]",
        ["joint 'J1' of 4 block edges (at (0.5, 1), (1.5, 1))", "[joint.J1]", "did you mean 'J2'"],
    ),
    (FILE, FILE + 'default_joint = "J2"\n', ["model.toml: default_joint: there is no joint 'J2'", "'J1'"]),
    ('"bottom"', '"botom"', ["support 1", "there is no boundary 'botom'", "did you mean 'bottom'"]),
    ('"top"', '"tpo"', ["load 1", "there is no boundary 'tpo'", "did you mean 'top'"]),
    (ROCK, ROCK + '[groups]\n"Schist" = "rock:schist"\n', ["mesh.msh: has no group 'Schist'", "known: "]),
    (ROCK, ROCK + '[groups]\n"gmsh:geometrical=9" = "joint:J"\n', ["gmsh:geometrical=1, ", "gmsh:geometrical=4"]),
    (ROCK, ROCK + '[groups]\n"joint:J1" = "jiont:J1"\n', ["'jiont:J1' is not of the form kind:name", "joint"]),
    (ROCK, ROCK + '[groups]\n"joint:J1" = "rock:J1"\n', ["holds 2 line elements", "rock:NAME is for surfaces"]),
]
SUPPORTS = [
    (SUPPORT, "", ["the model is free to move in any direction", "no support holds it", "hold a boundary"]),
    (SUPPORT, "[[support]]\n", ["[[support]] number 1: say where it holds"]),
    (SUPPORT, '[[support]]\nboundary = "bottom"\n', ["[[support]] number 1: say its content"]),
    ('fix = "all"', 'fix = "z"', ['[[support]] number 1, fix = "z"', '["x", "y"]']),
    (SUPPORT, SUPPORT.replace('"all"', '"normal"') + LINEAR, ["free to slide in the direction 0 deg", "add a support"]),
    (SUPPORT, '[[support]]\npoint = [0, 0]\nfix = "all"\n' + LINEAR, ["free to turn about (0, 0)", "add a support"]),
    (SUPPORT, '[[support]]\nblocks = [0]\nfix = "normal"\n', ['fix = "normal" needs a boundary']),
    (SUPPORT, '[[support]]\nblocks = [99]\nfix = "all"\n', ["support 1", "no block 99", "0 to 3"]),
    (SUPPORT, '[[support]]\npoint = [9, 9]\nfix = "all"\n', ["support 1", "(9, 9) lies in no block"]),
    (SUPPORT, '[[support]]\nboundary = "botom"\nfix = ["x", "y"]\n', ["error: model.toml: support 1", "'bottom'"]),
    (SUPPORT, SUPPORT + '[[support]]\nboundary = "bottom"\ndirection = 90\ndisplacement = 0.1\n', ["contradicts"]),
    (SUPPORT, SUPPORT.replace("fix", "displacement = 0.1\nfix"), ["displacement needs a direction"]),
    (LOAD, "[[load]]\n", ["[[load]] number 1: give boundary with pressure"]),
    (LOAD, "[[load]]\nblock = 0\npoint = [5, 5]\nforce = [1, 2]\n", ["(5, 5) is not in block 0", "centroid"]),
    (ROCK, '[rock.gneiss]\nunit_weight = "26 kN/m^3"\n', ["blocks 0 and 1 meet at", "default_joint"]),
]


@pytest.mark.parametrize(("old", "new", "words"), KEYS + TYPES + UNITS + VALUES + NAMES + SUPPORTS)
def test_faulty_models(case: Case, old: str, new: str, words: list[str]) -> None:
    case.change(old, new)
    case.refuses("run", "model.toml", "-o", "new/folder", says=words)


@pytest.mark.parametrize("command", ["check", "compare", "limit"])
@pytest.mark.parametrize(("old", "new", "words"), [KEYS[0], UNITS[0], VALUES[0], NAMES[0], SUPPORTS[0]])
def test_other_commands_refuse_them_too(case: Case, command: str, old: str, new: str, words: list[str]) -> None:
    if (command, new) == ("limit", ""):
        pytest.skip("for statics alone, too few supports are an answer")
    case.change(old, new)
    case.refuses(command, "model.toml", says=words)


def test_all_faults_of_a_file_are_told_at_once(case: Case) -> None:
    case.change("young =", "yuong =")
    case.change('"5 GPa/m"', '"5 GPa"')
    case.change("title =", "titel =")
    case.refuses("run", "model.toml", says=["3 faults", "'yuong'", "normal_stiffness", "'titel'"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ["needs the key 'mesh'", "needs the key 'rock'"]),
        (JUNK, ["model.toml: not a text file", "TOML"]),
        (MODEL.encode("utf-16"), ["not a text file", "UTF-8"]),
        (MODEL.replace("young =", "young = =").encode(), ["not valid TOML", "line 8", "young = ="]),
        (MODEL.replace("poisson", "young").encode(), ["a key is given twice", "line 9", "young = 0.25"]),
        (f"{ROCK}{MODEL}".encode(), ["('rock', 'gneiss') twice", "[rock.gneiss]"]),
        (MODEL[:-12].encode(), ["not valid TOML", "at end of document"]),
        (b"a = " + b"[" * 5000, ["brackets nested too deep"]),
        (msh().encode(), ["not valid TOML", "line 1"]),
        (MODEL.replace("poisson = 0.25", "poisson = 0,25").encode(), ["a comma is no decimal point", "line 9"]),
    ],
    ids=["empty", "junk", "utf-16", "syntax", "double key", "double table", "truncated", "deep", "a mesh", "comma"],
)
def test_files_that_are_no_model(case: Case, content: bytes, words: list[str]) -> None:
    case.write("model.toml", content)
    case.refuses("run", "model.toml", says=words)


def test_a_geometry_script_is_no_model(case: Case) -> None:
    case.write("cutting.py", "def build(path):\n    pass\n")
    case.refuses("check", "cutting.py", says=["is a Python script, no model file", "[mesh] geometry = 'cutting.py'"])


@pytest.mark.parametrize("command", ["run", "check", "compare", "limit"])
def test_model_files_that_are_not_there(case: Case, command: str) -> None:
    case.refuses(command, "modell.toml", says=["modell.toml: there is no such file", "did you mean 'model.toml'"])
    case.refuses(command, ".", says=["is a folder", "model.toml"])
    case.refuses(command, "mesh.msh/model.toml", says=["mesh.msh/model.toml"])


def test_a_good_model_is_not_refused(case: Case) -> None:
    """So that the cases above are refused for what they change."""
    outcome = case.run("run", "model.toml", "--json")
    assert outcome.code == 0
    assert json.loads(outcome.out)["status"] == "stable"
    assert outcome.err == ""
    shutil.rmtree(case.folder / "out")
