"""A Python of our own takes no module from the current folder: what happens to lie there is never run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.pictures.plot import draw_in_subprocess
from bsm_mesh.processes import python_command, run_with_lines
from tests.scenes.small_case import LINEAR, MODEL, ROOT, run_process
from tests.scenes.square_mesh import msh

pytestmark = pytest.mark.robust

EVIL = "from pathlib import Path\nPath(__file__).with_name('was_run').touch()\nraise SystemExit('a stranger was run')\n"
PROBE = (
    "import random, bsm_mesh.errors, sys\nprint(random.__file__, bsm_mesh.errors.__file__, sys.argv[1:], sep='\\n')\n"
)


@pytest.fixture
def among_strangers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, where modules lie that have the names of libraries, and settings of theirs."""
    for name in ("pyvista", "random", "numpy", "json", "vtkmodules", "matplotlib", "bsm_mesh"):
        (tmp_path / f"{name}.py").write_text(EVIL)
    (tmp_path / "matplotlibrc").write_text("backend: no_such_backend\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_modules_come_from_elsewhere(among_strangers: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    own = tmp_path_factory.mktemp("own")
    (own / "probe.py").write_text(PROBE)
    environment = {**os.environ, "PYTHONPATH": str(own)}  # this checkout is found without it
    done = subprocess.run(
        python_command("probe", "a", "b c"), env=environment, capture_output=True, text=True, check=True
    )
    library, ours, arguments = done.stdout.splitlines()
    assert not Path(library).is_relative_to(among_strangers)
    assert Path(ours) == ROOT / "bsm_mesh" / "errors.py"
    assert arguments == "['a', 'b c']"
    assert not (among_strangers / "was_run").exists()


@pytest.mark.parametrize("animate", [False, True])
def test_pictures_run_no_stranger(among_strangers: Path, animate: bool) -> None:
    (among_strangers / "model.toml").write_text(MODEL + LINEAR)
    (among_strangers / "mesh.msh").write_text(msh())
    bsm.run("model.toml")
    (among_strangers / "out" / "model" / "blocks.pvd").unlink()
    with pytest.raises(ModelError, match=r"blocks\.pvd: there is no such file"):
        draw_in_subprocess(Path("out/model"), animate=animate)
    assert not (among_strangers / "was_run").exists()


def test_inside_another_program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "")
    with pytest.raises(ModelError, match="part of another program"):
        python_command("probe")


@pytest.mark.slow
def test_settings_of_a_stranger_draw_no_picture(tmp_path: Path) -> None:
    for name, settings in (("ours", None), ("strangers", "figure.facecolor: black\n")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "model.toml").write_text(MODEL + LINEAR)
        (tmp_path / name / "mesh.msh").write_text(msh())
        if settings is not None:
            (tmp_path / name / "matplotlibrc").write_text(settings)
        assert run_process(tmp_path / name, "check", "model.toml", "--picture", "a.png").code == 0
    assert (tmp_path / "ours" / "a.png").read_bytes() == (tmp_path / "strangers" / "a.png").read_bytes()


COUNTING = """
import sys
for k in range(3):
    print("line", k, flush=True)
    print("x" * 100_000, file=sys.stderr)
raise SystemExit(7)
"""


def test_lines_are_heard_as_they_are_written(tmp_path: Path) -> None:
    heard: list[str] = []
    done = run_with_lines([sys.executable, "-c", COUNTING], heard.append, cwd=tmp_path)
    assert heard == ["line 0", "line 1", "line 2"]
    assert done.returncode == 7
    assert done.stdout.splitlines() == heard
    assert len(done.stderr) > 300_000  # more than a pipe holds


def test_a_process_whose_lines_are_refused_is_killed(tmp_path: Path) -> None:
    waits = "print('line', flush=True)\nimport time\ntime.sleep(600)\n"

    def refuse(_: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_with_lines([sys.executable, "-c", waits], refuse, cwd=tmp_path)
