"""Pictures: drawn in a process of their own, with something on them; a renderer that dies is told of."""

from __future__ import annotations

import os
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

from bsm_mesh.app.canvas import WIDTH
from bsm_mesh.app.headings import heading
from bsm_mesh.app.pictures import PICTURES
from bsm_mesh.app.plot import draw_in_subprocess
from bsm_mesh.errors import ModelError
from tests.scenes.small_case import Case


@pytest.fixture
def results(case: Case) -> Case:
    assert case.run("run", "model.toml", "-q").code == 0
    return case


def test_every_picture_shows_something(results: Case) -> None:
    from matplotlib.image import imread

    outcome = results.run("plot", "out/model")
    assert outcome.code == 0, outcome.err
    paths = [Path(line) for line in outcome.out.splitlines()]
    assert {path.stem for path in paths} == set(PICTURES)
    noted = "out/model/.bsm-mesh-results"
    assert sorted(outcome.new) == sorted([noted, "out/model/pictures", *map(str, paths)])
    for path in paths:
        width, height = struct.unpack(">II", path.read_bytes()[16:24])
        assert width == WIDTH
        assert 0.4 * WIDTH < height < 1.5 * WIDTH
        middle = imread(path)[int(0.3 * height) : int(0.7 * height), int(0.4 * width) : int(0.6 * width), :3]
        colours = np.unique((255 * middle).astype(int) @ (1 << 16, 1 << 8, 1))
        assert len(colours) > 1
        assert (middle < 0.99).any(axis=2).mean() > 0.5  # not white paper


def test_lines_are_drawn_over_a_model_of_kilometres(case: Case) -> None:
    """What lies over the blocks, here the water table, is in front of the camera at every size."""
    from matplotlib.image import imread

    text = Path("model.toml").read_text(encoding="utf-8").replace("[mesh]", '[mesh]\nunit = "km"')
    case.write("model.toml", f"{text}\n[water]\ntable = [[0, 1500]]\n")
    assert case.run("run", "model.toml", "--pictures", "-q").code == 0
    shown = imread("out/model/pictures/deformation.png")[..., :3]
    blue = np.abs(shown - np.array([0x1F, 0x6F, 0xD0]) / 255).max(axis=2) < 0.02
    assert blue.sum() > 0.3 * WIDTH


def test_headings() -> None:
    """A stage is named where there are several."""
    only, second = {"name": "initial", "status": "stable"}, {"name": "crown", "status": "not_converged"}
    one, two = {"status": "stable", "stages": [only]}, {"status": "not_converged", "stages": [only, second]}
    assert heading({"title": "Tunnel", **one}) == "Tunnel: stable"
    fallen = {**one, "stages": [{**one["stages"][-1], "verdict": "stable_after_falls, after moving 3.8 m"}]}
    assert heading({"title": "Tunnel", **fallen}) == "Tunnel: stable after falls, after moving 3.8 m"
    assert heading({"title": "", **two}) == "bsm-mesh: stage crown, not converged"
    assert heading({"title": "Tunnel", **one}, "on its way") == "Tunnel: on its way"
    unfinished = {"title": "Tunnel", **one, "status": "unfinished"}
    assert heading(unfinished) == "Tunnel: stage initial, stable, of an unfinished run"  # no verdict on the whole


def test_run_with_pictures(results: Case) -> None:
    outcome = results.run("run", "model.toml", "--pictures", "-q", "-o", "again")
    assert outcome.code == 0, outcome.err
    assert outcome.out.count(".png") == len(PICTURES)


def fake(code: int, error: str = "") -> object:
    def run(*_: object, **__: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], code, "", error)

    return run


@pytest.mark.parametrize("code", [-11, -6, 3221225477])  # the last: Windows's access violation
def test_a_renderer_that_dies(results: Case, monkeypatch: pytest.MonkeyPatch, code: int) -> None:
    monkeypatch.setattr("bsm_mesh.app.plot.subprocess.run", fake(code))
    results.refuses("plot", "out/model", says=["out/model: the renderer died", "libegl1", "without pictures"])


def test_a_renderer_that_really_dies(results: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """As VTK does without its libraries: of a segmentation fault while it is imported."""
    results.write("fake/pyvista.py", "import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    monkeypatch.syspath_prepend(str(results.folder / "fake"))
    monkeypatch.setenv("PYTHONPATH", f"{results.folder / 'fake'}{os.pathsep}{os.environ['PYTHONPATH']}")
    results.refuses("plot", "out/model", says=["the renderer died of signal 11", "libegl1"])


def test_a_renderer_that_fails(results: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bsm_mesh.app.plot.subprocess.run", fake(1, "Traceback ...\nImportError: libGL.so.1"))
    with pytest.raises(ModelError, match=r"could not be drawn: ImportError: libGL\.so\.1; .*libegl1"):
        draw_in_subprocess(Path("out/model"))


def test_a_folder_that_takes_no_pictures(results: Case) -> None:
    results.write("out/model/pictures", "a file of this name")
    message = results.refuses(
        "plot", "out/model", says=["cannot write out/model/pictures/displacement.png", "choose another folder"]
    )
    assert "apt-get" not in message
