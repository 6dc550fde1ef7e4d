"""The movement of a run as a GIF and as the position at a step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from bsm_mesh.converters.vtk_files import read_pvd, read_vtu
from tests.scenes.small_case import Case

pytest.importorskip("gmsh")
pytestmark = pytest.mark.usefixtures("drawn_here")

PUSHED = """\
title = "Pushed"
[mesh]
geometry = "pushed_block"
[mesh.parameters]
gap = 2.5
separation = 2.0
[rock.rock]
unit_weight = "26 kN/m^3"
[joint.joint]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 30.0
[[support]]
blocks = [0, 2]
fix = "all"
[[load]]
block = 1
point = [0.0, 0.3]
force = ["30 kN/m", 0.0]
[solver]
scheme = "continuation"
[output]
snapshots = "steps"
"""
RED = (213, 94, 0)  # of unstable blocks


@pytest.fixture
def moved(case: Case) -> Case:
    case.write("model.toml", PUSHED)
    assert case.run("run", "model.toml", "-q").code == 0
    return case


def places(frame: np.ndarray) -> np.ndarray:
    """Return where the pixels of unstable blocks are, (k, 2): row and column."""
    return np.argwhere(np.abs(frame.astype(int) - RED).max(axis=2) < 40)


@pytest.mark.slow
def test_the_movement_as_a_gif(moved: Case) -> None:
    outcome = moved.run("plot", "out/model", "--animate")
    assert outcome.code == 0, outcome.err
    assert outcome.out.split() == [str(Path("out/model/pictures/movement.gif"))]
    assert sorted(outcome.new) == [
        "out/model/.bsm-mesh-results",
        "out/model/pictures",
        "out/model/pictures/movement.gif",
    ]
    with Image.open(moved.folder / "out/model/pictures/movement.gif") as gif:
        frames = []
        for number in range(gif.n_frames):
            gif.seek(number)
            frames.append(np.asarray(gif.convert("RGB")))
    assert 20 < len(frames) <= 60
    columns = [places(frame)[:, 1].mean() for frame in frames]
    assert columns[-1] > columns[0] + 100  # pixels, to the right
    assert (np.diff(columns) > -2).all()
    rows = [places(frame)[:, 0].mean() for frame in frames]
    first, *_, last = (
        read_vtu(file).cell_data["displacement"][1] for _, file in read_pvd(moved.folder / "out/model/blocks.pvd")
    )
    pixels = (columns[-1] - columns[0]) / (last - first)[0]  # per metre
    assert rows[-1] - rows[0] == pytest.approx(-pixels * (last - first)[1], abs=2)
    assert rows[-1] > rows[0] + 5  # and down


@pytest.mark.usefixtures("drawn_here")
def test_the_position_at_a_step(moved: Case) -> None:
    early, late = (moved.run("plot", "out/model", "--step", step) for step in ("5", "99999"))
    assert early.code == late.code == 0
    assert early.out.split() == [str(Path("out/model/pictures/position_00005.png"))]
    one, two = (np.asarray(Image.open(moved.folder / run.out.strip()).convert("RGB")) for run in (early, late))
    assert not len(places(one))  # it was not yet known which blocks fall
    assert len(places(two)) > 1000


def test_without_snapshots_there_is_no_movement(case: Case) -> None:
    assert case.run("run", "model.toml", "-q").code == 0
    for option in (["--animate"], ["--step", "3"]):
        case.refuses(
            "plot", "out/model", *option, says=["out/model: holds no snapshots", 'snapshots = "steps"', "[output]"]
        )
    case.refuses("plot", "out/model", "--animate", "--step", "3", says=["plot: give --animate or --step, not both"])


def test_an_unknown_word_for_snapshots(case: Case) -> None:
    case.write("model.toml", PUSHED.replace('"steps"', '"step"'))
    case.refuses("run", "model.toml", says=["[output]", "snapshots", "'steps'"])
