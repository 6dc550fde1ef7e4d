"""In a checkout `geometries` and `converters` mean the package's own modules. Each case in a fresh Python."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.scenes.small_case import environment

TWICE = """
import sys
for name, module in list(sys.modules.items()):
    if name.partition(".")[0] in ("geometries", "converters"):
        assert module is sys.modules["bsm_mesh." + name], name
        assert module.__name__ == module.__spec__.name == "bsm_mesh." + name
"""


def python(code: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize(
    "statements",
    [
        "import geometries, bsm_mesh.geometries as package; assert geometries is package",
        "import bsm_mesh.geometries as package, geometries; assert geometries is package",
        "import geometries.cutting.cut as one; from bsm_mesh.geometries.cutting import cut; assert one is cut",
        "from bsm_mesh.geometries.cutting import cut; import geometries.cutting.cut as one; assert one is cut",
        "from geometries import JointSet; from bsm_mesh.geometries import JointSet as Same; assert JointSet is Same",
        "import converters; from bsm_mesh import converters as same; assert converters.read_blocks is same.read_blocks",
        "import converters.meshes.report, geometries.errors, converters.meshes.convert",
        "import importlib, geometries.cases; importlib.reload(geometries.cases)",
    ],
)
def test_both_names_mean_the_same_modules(statements: str, tmp_path: Path) -> None:
    python(statements + TWICE, tmp_path)


def test_an_error_is_caught_by_either_name(tmp_path: Path) -> None:
    code = (
        "import geometries, bsm_mesh.geometries as package\n"
        "try: package.find_case('no_such')\n"
        "except geometries.GeometryError: print('caught')"
    )
    assert python(code, tmp_path) == "caught"


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    code = "import geometries\ntry: import geometries.no_such\nexcept ModuleNotFoundError as fault: print(fault)"
    assert "no_such" in python(code, tmp_path)


def test_a_public_name_that_is_nearly_right_is_told(tmp_path: Path) -> None:
    code = "import bsm_mesh\ntry: bsm_mesh.safety\nexcept AttributeError as fault: print(fault)"
    assert "has no attribute 'safety'; did you mean 'factor_of_safety'?" in python(code, tmp_path)


def test_a_neighbour_of_that_name_is_the_users(tmp_path: Path) -> None:
    """A script's own `geometries.py` is what it imports, and the package continues with its own."""
    (tmp_path / "geometries.py").write_text("mine = True\n", encoding="utf-8")
    (tmp_path / "converters.py").write_text("mine = True\n", encoding="utf-8")
    code = (
        "import geometries, converters, bsm_mesh.converters, bsm_mesh.geometries.cases as cases; "
        "assert geometries.mine and converters.mine; print(bsm_mesh.converters.__all__, cases.case_names())"
    )
    said = python(code, tmp_path)
    assert "read_blocks" in said
    assert "circular_tunnel" in said
