"""Numbers and texts that no file of a rock engineer holds: one message, never a traceback."""

from __future__ import annotations

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from tests.scenes.small_case import FILE, LINEAR, MODEL, Case
from tests.scenes.square_mesh import msh

BOLTS = '[[bolt]]\ntable = "bolts.csv"\ndiameter = "25 mm"\nyield_strength = "500 MPa"\n'
TABLE = "start_x,start_y,end_x,end_y,name\n"
DIGITS = "1" * 5000


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("friction = 35", f"friction = {DIGITS}", "a whole number in it has more digits than TOML knows"),
        ("friction = 35", f"friction = 0x{DIGITS}", "joint.J1.friction = a whole number that has more digits"),
        ("friction = 35", f'friction = "{DIGITS}"', "friction"),
        (
            '[[load]]\nboundary = "top"',
            f"[[load]]\nblock = {DIGITS}",
            "a whole number in it has more digits than TOML knows",
        ),
        (FILE, f"{FILE}contact_points = 0x{DIGITS}\n", "mesh.contact_points = a whole number that"),
        (LINEAR, f"{LINEAR}tolerance = 0x{DIGITS}\n", "solver.tolerance = a whole number that"),
        ('pressure = "1 MPa"', "traction = [1e29, 0]", "traction"),
    ],
)
def test_numbers_of_a_model_file(case: Case, old: str, new: str, says: str) -> None:
    case.write("model.toml", (MODEL + LINEAR).replace(old, new))
    case.refuses("check", "model.toml", says=["model.toml: ", says])


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (b"1e200,0,1,1,a\n0,0,0,-1e200,b\n", ["bolts.csv, line 2", "bolts.csv, line 3"]),
        (b"nan,0,1,1,a\n", ["bolts.csv, line 2"]),
        (b"0,0,1\n", ["bolts.csv, line 2"]),
        (b"0,0,1,1,Gr\xf6\xdfe\n", ["bolts.csv, line 2: is no text in UTF-8", "save the file as UTF-8"]),
        (b'0,0,1,1,"a\n', ["is no table: unexpected end of data"]),
        (b"0,0,1,1,a\x00\n", ["bolts.csv"]),
    ],
)
def test_tables_of_bolts(case: Case, rows: bytes, says: list[str]) -> None:
    case.write("mesh.msh", msh())
    case.write("model.toml", MODEL + BOLTS)
    case.write("bolts.csv", TABLE.encode() + rows)
    if b"\x00" in rows:  # part of a name, shown as an escape
        assert "\x00" not in "".join(map(str, vars(case.run("check", "model.toml")).values()))
        return
    case.refuses("check", "model.toml", says=says)


def test_a_model_file_that_is_a_mesh(case: Case) -> None:
    with (case.folder / "model.toml").open("ab") as file:
        file.truncate(100 << 20)
    case.refuses("check", "model.toml", says=["is larger than any model file", "is it the mesh?"])


@pytest.mark.parametrize("far", [-1e200, 1e155, 1e12, np.inf, np.nan])
def test_corners_of_polygons(far: float) -> None:
    with pytest.raises(ModelError, match="block 0: corner 2 has coordinates that are no numbers below 1e\\+12 m"):
        bsm.Blocks.from_polygons([[(0, 0), (1, 0), (far, 1), (0, 1)]], rock="r")
