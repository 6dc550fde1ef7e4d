"""What a clumsy or hostile user gives the command line: one message, exit code 2, nothing written, no traceback.

Every message must name the thing, the place and the cure; the words that must be in it stand beside each case.
"""

from __future__ import annotations

import json
import os
import random
import shutil
from pathlib import Path

import pytest
from small_case import CURVES, MODEL, NODES, Case, check_refusal, msh, run_process
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

JUNK = random.Random(29).randbytes(3000)
SUPPORT = '[[support]]\nboundary = "bottom"\nfix = "all"\n'
LOAD = '[[load]]\nboundary = "top"\npressure = "1 MPa"\n'
ROCK = '[rock.gneiss]\nunit_weight = "26 kN/m^3"\nyoung = "10 GPa"\npoisson = 0.25\n'
LINEAR = '[solver]\nscheme = "linear"\n'
JOINT = '[joint.J1]\nnormal_stiffness = "5 GPa/m"\nshear_stiffness = "1 GPa/m"\nfriction = 35\n'
FILE = 'file = "mesh.msh"\n'

KEYS = [  # old, new, words
    ("title =", "titel =", ["model.toml: top level: unknown key 'titel'", "did you mean 'title'"]),
    ("[rock.gneiss]", "[rocks.gneiss]", ["unknown key 'rocks'", "did you mean 'rock'", "needs the key 'rock'"]),
    ("file =", "fiel =", ["[mesh]: unknown key 'fiel'", "did you mean 'file'"]),
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
    ('"10 GPa"', '"10 Kpa"', ["the unit Kpa is unknown", '"69 kPa"']),
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
VALUES = [
    ('"10 GPa"', "nan", ["[rock.gneiss] young = nan", "no finite number"]),
    ('"10 GPa"', '"inf GPa"', ["[rock.gneiss] young", "no finite number"]),
    ('"10 GPa"', "1e400", ["[rock.gneiss] young", "no finite number"]),
    ('"10 GPa"', "-1", ["rock 'gneiss': young = -1 Pa must be above 0"]),
    ('"10 GPa"', "0", ["rock 'gneiss': young = 0 Pa must be above 0"]),
    ("0.25", "0.5", ["rock 'gneiss': poisson = 0.5 must be below 0.5"]),
    ("friction = 35", "friction = 90", ["joint 'J1'", "friction = 90 degrees must be below 90"]),
    ("friction = 35", "friction = 35\ndilation = 60", ["joint 'J1'", "friction + dilation = 95"]),
    ('"26 kN/m^3"', '"-26 kN/m^3"', ["unit_weight = -26000 N/m3 must be 0 or more"]),
    ('"5 GPa/m"', "0", ["joint 'J1': normal_stiffness = 0 Pa/m must be above 0"]),
    ('"1 MPa"', "1e300", ["[[load]] number 1, pressure", "no finite number below 1e+30"]),
    (JOINT, JOINT.replace('"5 GPa/m"', "1e-20") + LINEAR, ["stiffness matrix is singular", "many orders apart"]),
    (JOINT, "[joint.J1]\n", ["joint 'J1': needs normal_stiffness and shear_stiffness", "or filling"]),
    (JOINT, JOINT + 'law = "mohr_coulomb"\ndilation = 5\n', ["joint 'J1'", "no dilation", "choose 'patton'"]),
    ("friction = 35", "cohesion = 5", ["joint 'J1'", "needs the key 'friction'"]),
    (FILE, FILE + "merge_tolerance = 10\n", ["mesh.msh: none of the 4 surface elements has an area", "10 m"]),
    (LOAD, "[solver]\nthreads = -1\n", ["solver: threads = -1 must be 0 or more"]),
]
NAMES = [
    ("[rock.gneiss]", "[rock.gnies]", ["rock 'gneiss' of 4 blocks", "[rock.gneiss]", "did you mean 'gnies'"]),
    ("[joint.J1]", "[joint.J2]", ["joint 'J1' of 4 edges", "[joint.J1]", "did you mean 'J2'"]),
    (FILE, FILE + 'default_joint = "J2"\n', ["model.toml: default_joint: there is no joint 'J2'", "'J1'"]),
    ('"bottom"', '"botom"', ["support 1", "there is no boundary 'botom'", "did you mean 'bottom'"]),
    ('"top"', '"tpo"', ["load 1", "there is no boundary 'tpo'", "did you mean 'top'"]),
    (ROCK, ROCK + '[groups]\n"Schist" = "rock:schist"\n', ["mesh.msh: has no group 'Schist'", "known: "]),
    (ROCK, ROCK + '[groups]\n"gmsh:physical=9" = "joint:J"\n', ["gmsh:physical=1, ", "gmsh:physical=4"]),
    (ROCK, ROCK + '[groups]\n"joint:J1" = "jiont:J1"\n', ["'jiont:J1' is not of the form kind:name", "joint"]),
    (ROCK, ROCK + '[groups]\n"joint:J1" = "rock:J1"\n', ["holds 2 line elements", "a rock is made of surfaces"]),
]
SUPPORTS = [
    (SUPPORT, "", ["the model is free to move in any direction", "no support holds it", "hold a boundary"]),
    (SUPPORT, "[[support]]\n", ["[[support]] number 1: say where it holds"]),
    (SUPPORT, '[[support]]\nboundary = "bottom"\n', ["[[support]] number 1: say what it holds"]),
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
    ],
    ids=["empty", "junk", "utf-16", "syntax", "double key", "double table", "truncated", "deep", "a mesh"],
)
def test_files_that_are_no_model(case: Case, content: bytes, words: list[str]) -> None:
    case.write("model.toml", content)
    case.refuses("run", "model.toml", says=words)


@pytest.mark.parametrize("command", ["run", "check", "compare", "limit"])
def test_model_files_that_are_not_there(case: Case, command: str) -> None:
    case.refuses(command, "modell.toml", says=["modell.toml: there is no such file", "did you mean 'model.toml'"])
    case.refuses(command, ".", says=["is a folder", "model.toml"])
    case.refuses(command, "mesh.msh/model.toml", says=["mesh.msh/model.toml"])


def moved(node: int, *place: object) -> str:
    return msh([*NODES[:node], place, *NODES[node + 1 :]])


def only(*quads: tuple[int, ...]) -> str:
    return msh(quads=quads)


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (moved(4, "nan", 1), ["1 nodes have coordinates that are no numbers", "4", "mend the mesh"]),
        (moved(4, "inf", 1), ["coordinates that are no numbers"]),
        (moved(4, 1e200, 1), ["coordinates that are no numbers below 1e+12"]),
        (moved(4, "abc", 1), ["meshio cannot read it", "damaged"]),
        (moved(4, 1, 1, 1), ["the mesh is not plane", "take one cross-section"]),
        (msh([(x, y, x + y) for x, y in NODES]), ["tilted to the axes", "rotate it into the xy plane"]),
        (only((0, 1, 3, 4)), ["1 elements cross themselves", "near (0, 0)", "corners in order"]),
        (msh([*NODES, (2.5, 0.2)], [(0, 1, 3, 9)]), ["crosses or touches itself", "in order round the block"]),
        (msh([*NODES, (1.5, 0.5)], [(0, 9, 4, 3), (1, 2, 5, 4)]), ["overlap by", "near"]),
        (only((0, 1, 2, 1)), ["none of the 1 surface elements has an area"]),
        (only((0, 1, 44, 3)), ["meshio cannot read it"]),
        (only(), ["no surface elements", "6 line", "mesh the surfaces"]),
        (msh(surface="Granite"), ["no element is in a rock", "Granite (4 elements)", '"Granite" = "rock:granite"']),
        (msh(curves={"joint:J1": CURVES["joint:J1"]}), ["there is no boundary 'bottom'"]),
        (msh()[: len(msh()) // 2], ["mesh.msh: ", "cut off"]),
        (msh()[:-40], ["mesh.msh: ", "cut off"]),
        (msh()[:20], ["mesh.msh: cut off"]),
        ("", ["mesh.msh: is empty", "write the mesh again"]),
        (JUNK, ["mesh.msh: meshio cannot read it", "damaged"]),
        ("<html>404</html>", ["mesh.msh: meshio cannot read it"]),
        (msh().replace("2.2 0 8", "9.9 0 8"), ["Need mesh format in", "9.9"]),
        (msh().replace("2.2 0 8", "4.1 0 8"), ["cut off or damaged"]),
    ],
)
def test_faulty_meshes(case: Case, mesh: str | bytes, words: list[str]) -> None:
    case.write("mesh.msh", mesh)
    case.refuses("run", "model.toml", says=words)


def test_a_part_of_the_mesh_that_hangs_in_the_air(case: Case) -> None:
    case.write("mesh.msh", msh([*NODES, (5, 0), (6, 0), (6, 1), (5, 1)], [(0, 1, 4, 3), (9, 10, 11, 12)]))
    case.change(LOAD, LINEAR)
    case.refuses("run", "model.toml", says=["block 1 at (5.5, 0.5) is free to move", "no support holds it"])


@pytest.mark.parametrize("ending", ["vtu", "vtk", "vtp", "inp", "xdmf", "stl", "nas"])
def test_junk_with_the_ending_of_a_mesh(case: Case, ending: str) -> None:
    case.write(f"mesh.{ending}", JUNK)
    case.change("mesh.msh", f"mesh.{ending}")
    message = case.refuses("run", "model.toml", says=[f"mesh.{ending}", "cannot read it", "damaged"])
    assert "0x" not in message
    assert "codec" not in message


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("mesk.msh", ["mesk.msh: there is no such file", "mesh.msh", "correct the path"]),
        (".", [": is a folder", "give the mesh file in it"]),
        ("mesh.unv", ["no mesh format has the ending '.unv'", ".msh"]),
        ("mesh.geo", ["a script of Gmsh", "gmsh -2 -format msh41 mesh.geo"]),
        ("mesh.py", ["[mesh] file is a script", 'geometry = "mesh.py"']),
        ("model.toml", ["no mesh format has the ending '.toml'"]),
        ("loop.msh", ["cannot be opened"]),
    ],
)
def test_mesh_files_that_are_none(case: Case, name: str, words: list[str]) -> None:
    os.symlink("loop.msh", case.folder / "loop.msh")
    for ending in ("unv", "geo", "py"):
        case.write(f"mesh.{ending}", "nothing")
    case.change("mesh.msh", name)
    case.refuses("run", "model.toml", says=words)


SCRIPTS = {
    "raises": ("def build(path):\n    raise RuntimeError('boom')\n", ["g.py, line 2", "RuntimeError: boom"]),
    "nothing": ("def build(path):\n    pass\n", ["g.py: build wrote no file", "gmsh.write(str(path))"]),
    "no build": ("x = 1\n", ["g.py has no function build", "define build(path"]),
    "syntax": ("def build(path:\n", ["g.py, line 1", "SyntaxError"]),
    "exit": ("import sys\ndef build(path):\n    sys.exit(3)\n", ["g.py, line 3", "SystemExit"]),
    "no path": ("def build():\n    pass\n", ["g.py: build takes no path"]),
    "import": ("import nosuchmodule\n", ["g.py, line 1", "nosuchmodule"]),
    "empty": ("def build(path):\n    open(path, 'w').close()\n", ["g", "is empty"]),
    "junk": ("def build(path):\n    open(path, 'w').write('junk')\n", ["g", "cannot read it"]),
    "required": ("def build(path, radius):\n    pass\n", ["give the parameter 'radius'"]),
    "gmsh": (
        "import gmsh\ndef build(path):\n    gmsh.initialize(interruptible=False)\n    try:\n"
        "        gmsh.option.setNumber('General.Terminal', 0)\n"
        "        gmsh.model.occ.addRectangle(0, 0, 0, -1, 0)\n    finally:\n        gmsh.finalize()\n",
        ["g.py, line 6", "zero width or height"],
    ),
}


@pytest.mark.parametrize("script", SCRIPTS)
def test_geometry_scripts_that_fail(case: Case, script: str) -> None:
    text, words = SCRIPTS[script]
    case.write("g.py", text)
    case.change(FILE, 'geometry = "g.py"\n')
    message = case.refuses("run", "model.toml", says=words)
    assert "/bsm-mesh-" not in message  # the temporary file
    case.refuses("mesh", "g.py", says=words)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ('geometry = "circular_tunel"', ["no case 'circular_tunel'", "did you mean 'circular_tunnel'"]),
        ('geometry = "nope.py"', ["there is no script", "nope.py"]),
        ('geometry = "circular_tunnel"\nparameters = {radus = 3}', ["no parameter 'radus'", "did you mean 'radius'"]),
        ('geometry = "circular_tunnel"\nparameters = {radius = -3}', ["radius = -3", "greater than 0"]),
        ('geometry = "circular_tunnel"\nparameters = {path = "a"}', ["there is no parameter 'path'"]),
    ],
)
def test_geometries_that_cannot_be_built(case: Case, keys: str, words: list[str]) -> None:
    case.change(FILE, keys + "\n")
    case.refuses("run", "model.toml", says=words)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["circular_tunel"], ["no case 'circular_tunel'", "did you mean 'circular_tunnel'"]),
        (["nope.py"], ["there is no script nope.py", "build(path)"]),
        (["circular_tunnel", "--set", "radius"], ["--set radius: write KEY=VALUE"]),
        (["circular_tunnel", "--set", "=3"], ["--set =3: write KEY=VALUE"]),
        (["circular_tunnel", "--set", "radius=abc"], ["radius = 'abc' does not fit", "a number in SI units"]),
        (["circular_tunnel", "--set", "radus=2"], ["no parameter 'radus'", "did you mean 'radius'"]),
        (["circular_tunnel", "--set", "radius=nan"], ["radius = nan is not a positive number"]),
        (["circular_tunnel", "-o", "a.txt"], ["a.txt", "ends in .msh"]),
        (["circular_tunnel", "-o", "mesh.msh/a.msh"], ["mesh.msh is not a folder"]),
        (["circ", "--list"], ["there is no case 'circ'"]),
    ],
)
def test_mesh_command(case: Case, arguments: list[str], words: list[str]) -> None:
    case.refuses("mesh", *arguments, says=words)


def test_new_and_demo_leave_what_is_there_alone(case: Case) -> None:
    case.refuses("new", "tunel", "x", says=["there is no starter 'tunel'", "did you mean 'tunnel'"])
    case.refuses("new", "tunnel", ".", says=["exists and is not empty", "name a new folder"])
    case.refuses("new", "tunnel", "mesh.msh", says=["name a new folder"])
    case.refuses("demo", "-o", ".", says=["exists and is not empty", "name a new folder"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rnu"], ["No such command 'rnu'", "run"]),
        (["run", "model.toml", "--jsn"], ["No such option", "--json"]),
        (["run"], ["Missing argument 'MODEL'"]),
        (["run", "model.toml", "b.toml"], ["unexpected extra argument"]),
        (["compare", "model.toml", "--order", "3"], ["--order", "1<=x<=2"]),
    ],
)
def test_usage(case: Case, arguments: list[str], words: list[str]) -> None:
    outcome = case.run(*arguments)
    assert (outcome.code, outcome.out, outcome.new) == (2, "", [])
    assert all(word in outcome.err for word in words)
    assert "Traceback" not in outcome.err


@pytest.mark.parametrize("command", ["run", "compare"])
def test_output_folders_that_cannot_be(case: Case, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Told before the solution, not after it."""
    monkeypatch.setattr("bsm_mesh.app.commands.run", lambda *_: pytest.fail("was solved first"))
    case.refuses(command, "model.toml", "-o", "mesh.msh", says=["cannot write results to mesh.msh", "not a folder"])
    case.refuses(command, "model.toml", "-o", "mesh.msh/out", says=["mesh.msh is not a folder"])
    monkeypatch.setattr(os, "access", lambda _, mode: not mode & os.W_OK)  # a superuser may write everywhere
    case.refuses(command, "model.toml", says=["is not writable", "choose another folder"])


def test_a_model_file_is_never_replaced(case: Case) -> None:
    """The model as run goes to the output folder as model.toml; that must not be anybody's own file."""
    text = (case.folder / "model.toml").read_bytes()
    outcome = case.run("run", "model.toml", "-o", ".", "-q")
    assert outcome.code == 0
    assert (case.folder / "model.toml").read_bytes() == text
    case.write("other.toml", text)
    case.refuses("run", "other.toml", "-o", ".", says=["model.toml is not from a run and would be replaced"])
    assert case.run("run", "other.toml", "-o", "out", "-q").code == 0
    assert case.run("run", "model.toml", "-o", "out", "-q").code == 0  # that one came from a run


def test_a_full_disk_leaves_nothing_half_written(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    assert case.run("run", "model.toml", "-q").code == 0

    def full(path: Path, text: str) -> None:
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr("bsm_mesh.app.storage.write_text", full)
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 2
    assert "cannot write results to out: No space left on device; choose another folder" in outcome.err
    assert not list(case.folder.rglob("*.tmp"))
    assert not (case.folder / "out/summary.json").exists()  # the mark of a complete run
    case.refuses("plot", "out", says=["out holds no results (no summary.json)"])


def test_a_vtu_that_cannot_be_written(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    class Failing(vtkXMLUnstructuredGridWriter):  # type: ignore[misc]
        def Write(self) -> int:  # noqa: N802 - VTK's name
            return 0

    monkeypatch.setattr("vtkmodules.vtkIOXML.vtkXMLUnstructuredGridWriter", Failing)
    outcome = case.run("run", "model.toml", "-q")
    assert outcome.code == 2
    assert "blocks_0000.vtu" in outcome.err
    assert list((case.folder / "out").iterdir()) == []


def test_pardiso_where_it_is_not_installed(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bsm_mesh.solve.pardiso._library", lambda: None)
    case.change(LOAD, '[solver]\nlinear_solver = "pardiso"\n')
    case.refuses("run", "model.toml", says=["needs the package mkl", "pip install", "choose 'superlu'"])


def test_no_continuum_of_rigid_rock(case: Case) -> None:
    case.change("young", "stiffness = 'rigid'\nyoung")
    case.change(FILE, FILE + 'default_joint = "J1"\n')
    assert case.run("check", "model.toml").code == 0
    case.refuses("compare", "model.toml", says=["rock 'gneiss': a continuum solution needs an elastic rock"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, ["out holds no results", "give the output folder of a run"]),
        ("[1, 2]", ["is not from a run of bsm-mesh"]),
        ("null", ["is not from a run of bsm-mesh"]),
        ('{"name": "npm"}', ["is not from a run of bsm-mesh"]),
        ('{"schema_version": 1}', ["is not complete", "run the model again"]),
        ('{"schema_version": 99}', ["schema version 99; this is 1", "run again"]),
        ('{"schema_ver', ["summary.json is damaged"]),
        (JUNK, ["summary.json is damaged"]),
    ],
)
def test_plot_of_what_is_no_run(case: Case, content: str | bytes | None, words: list[str]) -> None:
    if content is not None:
        case.write("out/summary.json", content)
    case.refuses("plot", "out", says=words)


@pytest.mark.parametrize("name", ["blocks.pvd", "blocks_0000.vtu"])
def test_plot_of_a_damaged_run(case: Case, name: str) -> None:
    assert case.run("run", "model.toml", "-q").code == 0
    path = case.folder / "out" / name
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    message = case.refuses("plot", "out", says=[name, "PVD" if "pvd" in name else "not a complete VTU file"])
    path.unlink()
    message += case.refuses("plot", "out", says=[name, "there is no such file"])
    assert "apt-get" not in message  # the renderer is not to blame


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "bad.toml", "-o", "new/folder", "--json"], ["bad.toml", "does not convert to Pa"]),
        (["check", "junk.toml"], ["junk.toml: not a text file"]),
        (["compare", "gone.toml"], ["gone.toml: there is no such file"]),
        (["mesh", "nope"], ["there is no case 'nope'"]),
        (["plot", "."], [". holds no results"]),
        (["new", "tunnel", "."], ["exists and is not empty"]),
    ],
)
def test_in_a_process_of_its_own(case: Case, arguments: list[str], words: list[str]) -> None:
    case.write("bad.toml", MODEL.replace("10 GPa", "10 GPa/m"))
    case.write("junk.toml", JUNK)
    check_refusal(run_process(case.folder, *arguments), words)


def test_a_good_model_is_not_refused(case: Case) -> None:
    """So that the cases above are refused for what they change."""
    outcome = case.run("run", "model.toml", "--json")
    assert outcome.code == 0
    assert json.loads(outcome.out)["status"] == "stable"
    assert outcome.err == ""
    shutil.rmtree(case.folder / "out")
