"""The script of ``bsm-mesh paraview`` in ParaView: everything is opened, moved, coloured, and every state is named."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import bsm_mesh as bsm
from bsm_mesh.converters.result_files import corner_displacement
from bsm_mesh.pages.paraview import write_paraview
from bsm_mesh.results import Results
from tests.scenes.openings import opening
from tests.unit.test_space_pictures import ROOF

PVPYTHON, XVFB = shutil.which("pvpython"), shutil.which("xvfb-run")
LACKING = "needs ParaView and Xvfb: on Debian 'apt-get install paraview python3-paraview xvfb xauth'"
pytestmark = [pytest.mark.slow, pytest.mark.skipif(not (PVPYTHON and XVFB), reason=LACKING)]
ASKED = """
import json, runpy, sys
from paraview import servermanager, simple
script, picture = sys.argv[1:]
sys.argv = [script, picture]
given = runpy.run_path(script)
view, scene = given["view"], given["scene"]
told = {"sources": sorted(name for name, _ in simple.GetSources()), "states": [], "corners": [], "colours": {}}
for time in scene.TimeKeeper.TimestepValues:
    state, moved = simple.FindSource("state"), simple.FindSource("blocks, moved")
    state.UpdatePipeline(time)
    moved.UpdatePipeline(time)
    told["states"].append(servermanager.Fetch(state).GetColumn(0).GetValue(0))
    grid = servermanager.Fetch(moved)
    told["corners"].append([grid.GetPoint(k)[:2] for k in range(grid.GetNumberOfPoints())])
names = {proxy: name for (name, _), proxy in simple.GetSources().items()}
for shown in view.Representations:
    name = names.get(getattr(shown, "Input", None), "")
    if shown.Visibility and name.endswith(", moved"):
        told["colours"][name.split(",")[0]] = list(shown.ColorArrayName)
told["exaggeration"] = given["EXAGGERATION"]
print("TOLD" + json.dumps(told))
"""


@pytest.fixture(scope="module", params=[True, False], ids=["bolted", "unbolted"])
def shown(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Path, Any]:
    """Return results, the picture, and what ParaView tells of what it opened."""
    place = tmp_path_factory.mktemp("paraview")
    results = bsm.run(opening(bolted=request.param))
    results.save(place / "out")
    return results, place / "picture.png", opened(place)


def opened(place: Path) -> Any:
    """Open the results in the folder ``out`` of a place in ParaView, draw ``picture.png`` there; return the state."""
    script, picture, asked = write_paraview(place / "out"), place / "picture.png", place / "asked.py"
    asked.write_text(ASKED, encoding="utf-8")
    command = [
        str(XVFB),
        "-a",
        "-s",
        "-screen 0 1600x1000x24 -noreset",
        str(PVPYTHON),
        str(asked),
        str(script),
        str(picture),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    line = next(line for line in done.stdout.splitlines() if line.startswith("TOLD"))
    return json.loads(line[4:])


def test_all_is_opened_and_moved(shown: tuple[Results, Path, Any]) -> None:
    results, _, told = shown
    kinds = ["blocks", "joints", "contacts", "supports", "water", *(["bolts"] if results.stages[0].bolts.count else [])]
    assert set(told["sources"]) == {"heading", "state", *kinds, *(f"{kind}, moved" for kind in kinds)}
    for stage, drawn in zip(results.stages, told["corners"], strict=True):
        moved = corner_displacement(results.blocks, stage.displacement)
        corners = results.blocks.vertices + told["exaggeration"] * moved
        np.testing.assert_allclose(drawn, corners[stage.present[results.blocks.owner]], atol=1e-12)


def test_states_are_named(shown: tuple[Results, Path, Any]) -> None:
    results, _, told = shown
    assert told["states"] == [f"stage {stage.name}: {stage.status.value}" for stage in results.stages]


def test_what_is_shown_and_by_what_it_is_coloured(shown: tuple[Results, Path, Any]) -> None:
    results, _, told = shown
    bolts = {"bolts": ["CELLS", "axial_force"]} if results.stages[0].bolts.count else {}
    shown = {"blocks": ["CELLS", "displacement"], "joints": ["CELLS", "status"], **bolts, "water": ["POINTS", ""]}
    assert told["colours"] == shown
    assert bool(bolts) == (told["exaggeration"] > 1)  # unstable blocks are drawn true to scale


def test_the_picture(shown: tuple[Results, Path, Any]) -> None:
    with Image.open(shown[1]) as image:
        assert image.size == (1600, 1000)
        assert len(image.convert("RGB").getcolors(maxcolors=10**7) or []) > 50


def test_polyhedra_are_seen_and_the_one_that_falls_through_the_others(tmp_path: Path) -> None:
    """Before ParaView 6.0 polyhedra as VTK 9.4 and later write them have no faces: nothing was seen."""
    (tmp_path / "roof.toml").write_text(ROOF, encoding="utf-8")
    bsm.run(tmp_path / "roof.toml", output=tmp_path / "out")
    told = opened(tmp_path)
    assert told["colours"] == {"blocks": ["CELLS", "displacement"]}
    assert "blocks that fall" in told["sources"]
    with Image.open(tmp_path / "picture.png") as image:
        red, green, blue = np.asarray(image.convert("RGB")).astype(int).reshape(-1, 3).T
    assert (np.maximum(np.maximum(red, green), blue) < 240).mean() > 0.2
    assert (red > blue + 80).mean() > 0.005
