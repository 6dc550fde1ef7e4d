"""A model whose mesh is a file needs no Gmsh, which is under the GPL: nor does a process that the command starts."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from tests.scenes.small_case import FILE, LINEAR, MODEL, command, environment
from tests.scenes.square_mesh import msh, msh22

NO_GMSH = (
    "from pathlib import Path\nPath(__file__).with_name('was_loaded').touch()\nraise ImportError('no Gmsh here')\n"
)


def run_without_gmsh(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command where ``import gmsh`` finds a module that leaves a mark and fails, in every process."""
    place = folder / "in_place_of_gmsh"
    place.mkdir(exist_ok=True)
    (place / "gmsh.py").write_text(NO_GMSH, encoding="utf-8")
    around = environment()
    around["PYTHONPATH"] = f"{place}{os.pathsep}{around['PYTHONPATH']}"
    return subprocess.run(
        command(*arguments), cwd=folder, env=around, capture_output=True, text=True, check=False, timeout=120
    )


@pytest.mark.parametrize(
    ("name", "content"),
    [("run", msh()), ("check", msh()), ("compare", msh()), ("limit", msh()), ("run", msh22())],
    ids=["run", "check", "compare", "limit", "run by meshio"],
)
def test_a_command_on_a_mesh_file_loads_no_gmsh(name: str, content: str, tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text(MODEL + LINEAR, encoding="utf-8")
    (tmp_path / "mesh.msh").write_text(content, encoding="utf-8")
    done = run_without_gmsh(tmp_path, name, "model.toml")
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "in_place_of_gmsh" / "was_loaded").exists()


def test_a_geometry_does_load_it(tmp_path: Path) -> None:
    """The mark is seen where Gmsh is needed, and its absence is said in one line."""
    (tmp_path / "model.toml").write_text(
        MODEL.replace(FILE, 'geometry = "circular_tunnel"\n') + LINEAR, encoding="utf-8"
    )
    done = run_without_gmsh(tmp_path, "run", "model.toml")
    assert done.returncode == 2
    assert (tmp_path / "in_place_of_gmsh" / "was_loaded").exists()
    assert "Traceback" not in done.stderr
