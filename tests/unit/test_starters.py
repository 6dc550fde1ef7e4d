"""Starters: what `bsm-mesh new` writes runs, and can be changed."""

from __future__ import annotations

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.app.starters import starter_names
from tests.scenes.small_case import Case


def change(case: Case, name: str, old: str, new: str) -> None:
    """Change a text that stands in the starter's model file."""
    model = case.folder / name / "model.toml"
    assert old in model.read_text()
    model.write_text(model.read_text().replace(old, new))


@pytest.mark.parametrize("name", starter_names())
def test_every_starter_runs(case: Case, name: str) -> None:
    assert case.run("new", name, "mine").code == 0
    outcome = case.run("run", "mine/model.toml", "-q")
    assert outcome.code == 0
    assert all(path.startswith("mine/out") for path in outcome.new)
    assert bsm.Results.load(case.folder / "mine/out/model").check().ok
    assert "stable" in outcome.out
    assert all(len(script.read_text().splitlines()) < 80 for script in (case.folder / "mine").glob("*.py"))


def test_the_tunnel_can_be_changed(case: Case) -> None:
    case.run("new", "tunnel", "mine")
    model = case.folder / "mine/model.toml"
    model.write_text(model.read_text().replace("radius = 2.0", "radius = 3.0"))
    assert bsm.load(model).blocks.moments.area.sum() == pytest.approx(24 * 24 - 9 * 3.14159, rel=1e-2)


@pytest.mark.parametrize(("friction", "verdict"), [(22, "stable"), (20, "unstable")])
def test_the_dam_slides_where_statics_say(case: Case, friction: int, verdict: str) -> None:
    """Water pushes with 9.81 kN/m3 h^2 / 2, the concrete weighs 24 kN/m3 (b_crest + h / (2 tan 52)) h."""
    height, crest = 40.0, 6.0
    weight = 24e3 * height * (crest + height / np.tan(np.radians(52)) / 2)
    assert 20 < np.degrees(np.arctan(9810 * height**2 / 2 / weight)) < 22
    case.run("new", "dam", "dam")
    change(case, "dam", "friction = 40                 #", f"friction = {friction} #")
    assert f"{verdict} " in case.run("run", "dam/model.toml", "-q").out


@pytest.mark.parametrize(("thickness", "answer"), [(0.56, " admissible"), (0.52, "inadmissible")])
def test_the_arch_stands_down_to_the_thickness_of_milankovitch(case: Case, thickness: float, answer: str) -> None:
    """0.1075 times the radius of the middle line: Milankovitch 1907, in Foce, Int. J. Archit. Herit. 1 (2007) 185."""
    case.run("new", "arch", "arch")
    change(case, "arch", "thickness = 0.8 ", f"thickness = {thickness} ")
    assert answer in case.run("limit", "arch/model.toml").out


def test_new_says_what_next(case: Case) -> None:
    outcome = case.run("new", "tunnel", "mine")
    assert outcome.new == ["mine", "mine/model.toml", "mine/tunnel.py"]
    assert "next: bsm-mesh run mine/model.toml" in outcome.out


def test_the_geometry_runs_on_its_own(case: Case) -> None:
    case.run("new", "tunnel", "mine")
    outcome = case.run("mesh", "mine/tunnel.py", "--set", "spacing=4", "--set", "size=2", "-o", "t.msh")
    assert outcome.new == ["t.msh"]
    assert "joint:J1" in outcome.out


def test_the_demo_runs_again_as_changed_but_runs_nobody_elses_model(case: Case) -> None:
    case.run("new", "tunnel", "demo")
    case.write("demo/model.toml", "x = ")
    assert "demo/model.toml: not valid TOML" in case.run("demo", "-o", "demo").err
    (case.folder / "demo/tunnel.py").unlink()
    case.refuses("demo", "-o", "demo", says=["demo exists and is not empty", "name a new folder"])
