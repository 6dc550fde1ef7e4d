"""A model whose mesh is a file needs no Gmsh, which is under the GPL: nor does a process that the command starts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.scenes.small_case import FILE, LINEAR, MODEL, command, environment
from tests.scenes.square_mesh import msh, msh22

NO_GMSH = (
    "from pathlib import Path\nPath(__file__).with_name('was_loaded').touch()\nraise ImportError('no Gmsh here')\n"
)


def without_gmsh(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a command where ``import gmsh`` finds a module that leaves a mark and fails, in every process."""
    place = folder / "in_place_of_gmsh"
    place.mkdir(exist_ok=True)
    (place / "gmsh.py").write_text(NO_GMSH, encoding="utf-8")
    around = environment()
    around["PYTHONPATH"] = f"{place}{os.pathsep}{around['PYTHONPATH']}"
    return subprocess.run(words, cwd=folder, env=around, capture_output=True, text=True, check=False, timeout=120)


SEVERAL = """
import sys
from bsm_mesh.commands.cli import main
for name, model in zip(sys.argv[1::2], sys.argv[2::2]):
    try:
        main([name, model])
    except SystemExit as end:
        assert not end.code, (name, model)
"""


@pytest.mark.slow
def test_commands_on_a_mesh_file_load_no_gmsh(tmp_path: Path) -> None:
    """Both meshes that are read here and by meshio; the commands one after the other in one process."""
    (tmp_path / "by_meshio.toml").write_text((MODEL + LINEAR).replace("mesh.msh", "msh22.msh"), encoding="utf-8")
    (tmp_path / "msh22.msh").write_text(msh22(), encoding="utf-8")
    (tmp_path / "model.toml").write_text(MODEL + LINEAR, encoding="utf-8")
    (tmp_path / "mesh.msh").write_text(msh(), encoding="utf-8")
    names = ("run", "check", "compare", "limit")
    words = [word for name in names for word in (name, "model.toml")] + ["run", "by_meshio.toml"]
    done = without_gmsh(tmp_path, sys.executable, "-c", SEVERAL, *words)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "in_place_of_gmsh" / "was_loaded").exists()
    assert (tmp_path / "out/by_meshio/summary.json").exists()


@pytest.mark.heavy
def test_a_geometry_does_load_it(tmp_path: Path) -> None:
    """The mark is seen where Gmsh is needed, and its absence is said in one line."""
    (tmp_path / "model.toml").write_text(
        MODEL.replace(FILE, 'geometry = "circular_tunnel"\n') + LINEAR, encoding="utf-8"
    )
    done = without_gmsh(tmp_path, *command("run", "model.toml"))
    assert done.returncode == 2
    assert (tmp_path / "in_place_of_gmsh" / "was_loaded").exists()
    assert "Traceback" not in done.stderr
