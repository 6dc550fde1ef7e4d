"""Scripts as the pages write them pass a strict type checker: lists and numbers where the program keeps tuples."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.scenes.small_case import ROOT

SCRIPT = """
import numpy as np
import bsm_mesh as bsm

base = np.array([[-1.0, -1.0], [2.0, -1.0], [2.0, 0.0], [-1.0, 0.0]])
model = bsm.Model(
    blocks=bsm.Blocks.from_polygons([base, [(0, 0), (1, 0), (1, 1), (0, 1)]], rock="r"),
    rocks=[bsm.Rock("r", unit_weight=25e3)],
    joints=[bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30))],
    default_joint="J",
    supports=[bsm.Fixed(blocks=[0])],
    in_situ=bsm.InSitu(surface=[[-1, 1], [2, 1]], k0=0.5),
    water=bsm.Water(table=[(0, 0.5)]),
    stages=[
        bsm.Stage(name="a", excavate=[1], relaxation=[0.5, 1.0]),
        bsm.Stage(name="b", shaking=bsm.Shaking(record=(np.zeros(3), np.zeros(3)))),
    ],
    histories=[bsm.History(name="top", point=(0.5, 0.9)), bsm.History(name="wall", line=[[0.5, 0.1], [0.5, 0.9]])],
)
loads = [bsm.Pressure(boundary="top", pressure=1e3), bsm.Traction(boundary="top", traction=(0, [1e3, 0, -9810]))]
flow = bsm.Flow(head={"left": 1.0}, seepage=["top"], wells=[bsm.Well(point=(0, 0), discharge=1e-6)])
quiet = bsm.Shaking(waveform="sine", frequency=1.0, amplitude=1.0, quiet=["left"])
steady: tuple[float, ...] = bsm.Pressure(boundary="top", pressure=1e3).pressure
soil = bsm.EarthPressure(boundary="left", surface=[(0, 1), (1, 1)], state="active", unit_weight=18e3, friction=30)
level: tuple[float, float, float] = bsm.InSitu(surface=1.0).k0
"""


def checked(script: Path) -> str:
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(ROOT / ".mypy_cache"), script.name]
    return subprocess.run(command, cwd=script.parent, capture_output=True, text=True, check=False).stdout


@pytest.mark.slow
def test_lists_and_numbers_have_the_right_types(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    assert checked(script).startswith("Success")
    script.write_text(f"{SCRIPT}\nmodel.replace(rocks=3)\nbsm.Water(table=5)\nbsm.InSitu(k0=[1])\n")
    assert "Found 2 errors" in checked(script)
