"""The wheel, installed: it ships one package, and neither breaks a neighbour of its script nor is broken by one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from tests.scenes.small_case import MODEL, ROOT
from tests.scenes.square_mesh import msh

pytestmark = pytest.mark.robust

SOURCES = ("bsm_mesh", "geometries", "converters", "pyproject.toml", "README.md", "LICENSE")
NOT_COPIED = ("__pycache__", "_kernels")
KERNEL = "_kernels/some_python-some_numba/some.kernel.nbc"  # as `bsm_mesh.commands.precompile` leaves them
NEIGHBOURS = ("geometries", "converters", "bsm")
SCRIPT = """
import bsm, converters, geometries
assert bsm.mine and converters.mine and geometries.mine

import bsm_mesh
from bsm_mesh import converters, geometries
assert converters.read_blocks("mesh.msh").count == 4
assert issubclass(geometries.GeometryError, Exception)
model = bsm_mesh.load("model.toml")
print(bsm_mesh.__file__, model.blocks.count)
"""


def run(*command: str | Path, folder: Path) -> str:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a wheel built from a copy of the sources: a folder build/ left in the checkout would go into it."""
    folder = tmp_path_factory.mktemp("sources")
    for name in SOURCES:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns(*NOT_COPIED))
        else:
            shutil.copy(ROOT / name, folder)
    kernel = folder / "bsm_mesh" / KERNEL
    kernel.parent.mkdir(parents=True)
    kernel.write_bytes(b"")
    pip = (sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-index", "--no-build-isolation")
    run(*pip, "-w", folder / "dist", folder, folder=folder)
    return next((folder / "dist").glob("*.whl"))


@pytest.fixture(scope="module")
def programs(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the programs of a fresh environment with the wheel, and the libraries of the one that runs the tests."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, symlinks=True)
    libraries = Path(sysconfig.get_path("purelib", vars={"base": os.fspath(folder), "platbase": os.fspath(folder)}))
    # A path file of a path file's folder is not read, so the editable install of this checkout is not there.
    (libraries / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    pip = (sys.executable, "-m", "pip", "--python", folder / "bin" / "python")
    run(*pip, "install", "-q", "--no-deps", "--no-index", "--ignore-installed", wheel, folder=folder)
    return folder / "bin"


@pytest.fixture
def neighbours(tmp_path: Path) -> Path:
    """Return a folder with a user's own modules and a small model."""
    for name in NEIGHBOURS:
        (tmp_path / f"{name}.py").write_text("mine = True\n", encoding="utf-8")
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    (tmp_path / "model.toml").write_text(MODEL, encoding="utf-8")
    (tmp_path / "mesh.msh").write_text(msh(), encoding="utf-8")
    return tmp_path


def test_it_ships_one_package_that_is_whole(wheel: Path) -> None:
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    here = {
        f"{prefix}{path.relative_to(ROOT / folder).as_posix()}"
        for folder, prefix in (
            ("bsm_mesh", "bsm_mesh/"),
            *((f, f"bsm_mesh/{f}/") for f in ("geometries", "converters")),
        )
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and not set(NOT_COPIED) & set(path.parts)
    }
    assert names == here | {f"bsm_mesh/{KERNEL}"}


def test_a_script_beside_its_own_modules_of_these_names(programs: Path, neighbours: Path) -> None:
    file, blocks = run(programs / "python", "script.py", folder=neighbours).split()
    assert Path(file).is_relative_to(programs.parent)
    assert blocks == "4"


def test_commands_in_such_a_folder(programs: Path, neighbours: Path) -> None:
    """A starter, whose script builds the mesh, beside the user's modules as well."""
    run(programs / "bsm-mesh", "new", "slope", "s", folder=neighbours)
    for name in NEIGHBOURS:
        shutil.copy(neighbours / f"{name}.py", neighbours / "s")
    run(programs / "bsm-mesh", "mesh", "s/slope.py", "-o", "slope.msh", folder=neighbours)
    assert (neighbours / "slope.msh").stat().st_size > 0
