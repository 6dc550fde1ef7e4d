"""Starters: what `bsm-mesh new` writes runs, and can be changed."""

from __future__ import annotations

import pytest
from small_case import Case

import bsm_mesh as bsm
from bsm_mesh.app.starters import starter_names


@pytest.mark.parametrize("name", starter_names())
def test_every_starter_runs(case: Case, name: str) -> None:
    assert case.run("new", name, "mine").code == 0
    model = case.folder / "mine/model.toml"
    outcome = case.run("run", "mine/model.toml", "-q")
    assert outcome.code == 0
    assert all(path.startswith("mine/out") for path in outcome.new)
    assert bsm.Results.load(case.folder / "mine/out").check().ok
    model.write_text(model.read_text().replace("radius = 2.0", "radius = 3.0"))
    assert bsm.load(model).blocks.moments.area.sum() == pytest.approx(24 * 24 - 9 * 3.14159, rel=1e-2)


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
