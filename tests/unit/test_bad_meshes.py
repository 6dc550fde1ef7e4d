"""Meshes and geometries that cannot be used: one message, exit code 2, as in test_bad_input."""

from __future__ import annotations

import os

import pytest

from tests.scenes.small_case import FILE, JUNK, LINEAR, LOAD, Case
from tests.scenes.square_mesh import CURVES, NODES, msh22


def moved(node: int, *place: object) -> str:
    return msh22([*NODES[:node], place, *NODES[node + 1 :]])


def only(*quads: tuple[int, ...]) -> str:
    return msh22(quads=quads)


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (moved(4, "nan", 1), ["coordinates of 1 node are no numbers", "4", "correct the mesh"]),
        (moved(4, "inf", 1), ["are no numbers below 1e+12"]),
        (moved(4, 1e200, 1), ["are no numbers below 1e+12"]),
        (moved(4, "abc", 1), ["meshio cannot read it", "damaged"]),
        (moved(4, 1, 1, 1), ["the mesh is not plane", "take one cross-section"]),
        (msh22([(x, y, x + y) for x, y in NODES]), ["tilted to the axes", "rotate it into the xy plane"]),
        (only((0, 1, 3, 4)), ["1 elements cross themselves", "near (0, 0)", "corners in order"]),
        (msh22([*NODES, (2.5, 0.2)], [(0, 1, 3, 9)]), ["crosses or touches itself", "in order round the block"]),
        (msh22([*NODES, (1.5, 0.5)], [(0, 9, 4, 3), (1, 2, 5, 4)]), ["overlap by", "near"]),
        (only((0, 1, 2, 1)), ["none of the 1 surface elements has an area"]),
        (only((0, 1, 44, 3)), ["meshio cannot read it"]),
        (only(), ["no surface elements", "6 line", "mesh the surfaces"]),
        (msh22(surface="Granite"), ["no element is in a rock", "Granite (4 elements)", '"Granite" = "rock:granite"']),
        (msh22(curves={"joint:J1": CURVES["joint:J1"]}), ["there is no boundary 'bottom'"]),
        (msh22()[: len(msh22()) // 2], ["mesh.msh: ", "cut off"]),
        (msh22()[:-40], ["mesh.msh: ", "cut off"]),
        (msh22()[:20], ["mesh.msh: cut off"]),
        ("", ["mesh.msh: is empty", "write the mesh again"]),
        (JUNK, ["mesh.msh: meshio cannot read it", "damaged"]),
        ("<html>404</html>", ["mesh.msh: meshio cannot read it"]),
        (msh22().replace("2.2 0 8", "9.9 0 8"), ["Need mesh format in", "9.9"]),
        (msh22().replace("2.2 0 8", "4.1 0 8"), ["cut off or damaged"]),
    ],
)
def test_faulty_meshes(case: Case, mesh: str | bytes, words: list[str]) -> None:
    case.write("mesh.msh", mesh)
    case.refuses("run", "model.toml", says=words)


def test_a_part_of_the_mesh_that_hangs_in_the_air(case: Case) -> None:
    case.write("mesh.msh", msh22([*NODES, (5, 0), (6, 0), (6, 1), (5, 1)], [(0, 1, 4, 3), (9, 10, 11, 12)]))
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
        (f"{3000 * 'x'}.msh", ["cannot be opened (File name too long)"]),
        (".", [": is a folder", "give the mesh file in it"]),
        ("mesh.xyz", ["no mesh format has the ending '.xyz'", ".msh"]),
        ("mesh.geo", ["a script of Gmsh", "gmsh -2 -format msh41 mesh.geo"]),
        ("mesh.py", ["[mesh] file is a script", 'geometry = "mesh.py"']),
        ("model.toml", ["no mesh format has the ending '.toml'"]),
        ("loop.msh", ["cannot be opened"]),
    ],
)
def test_mesh_files_that_are_none(case: Case, name: str, words: list[str]) -> None:
    os.symlink("loop.msh", case.folder / "loop.msh")
    for ending in ("xyz", "geo", "py"):
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
        ('geometry = "column"\nparameters = {dip = inf}', ["parameters.dip", "must be a finite number"]),
        ('geometry = "column"\nparameters = {dip = [1.0, nan]}', ["parameters.dip", "must be a finite number"]),
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
