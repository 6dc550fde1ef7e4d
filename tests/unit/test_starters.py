"""Starters: what `bsm-mesh new` writes runs, and can be changed."""

from __future__ import annotations

import json

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.commands.starters import next_command, starter_names
from tests.scenes.rock_3d import wedge_factor, wedge_rock
from tests.scenes.small_case import Case


def change(case: Case, name: str, old: str, new: str) -> None:
    """Change a text that is in the starter's model file."""
    model = case.folder / name / "model.toml"
    assert old in model.read_text()
    model.write_text(model.read_text().replace(old, new))


@pytest.mark.heavy
@pytest.mark.parametrize("name", [name for name in starter_names() if next_command(name) == "run"])
def test_every_starter_runs(case: Case, name: str) -> None:
    assert case.run("new", name, "mine").code == 0
    outcome = case.run("run", "mine/model.toml", "-q")
    assert outcome.code == 0
    assert all(path.startswith("mine/out") for path in outcome.new)
    assert bsm.Results.load(case.folder / "mine/out/model").check().ok
    assert "stable" in outcome.out
    assert all(len(script.read_text().splitlines()) < 80 for script in (case.folder / "mine").glob("*.py"))


@pytest.mark.heavy
def test_the_key_blocks_of_the_starter_are_found(case: Case) -> None:
    assert "next: bsm-mesh key-blocks mine" in case.run("new", "key_blocks", "mine").out
    outcome = case.run("key-blocks", "mine/model.toml", "--json")
    assert outcome.code == 0
    assert all(path.startswith("mine/out") for path in outcome.new)
    told = json.loads(outcome.out)
    assert told["falls"]
    assert told["slides"]
    assert told["removable"] > len(told["falls"]) + len(told["slides"])


def test_the_wedge_of_the_starter_has_the_factor_of_hoek_and_bray(case: Case) -> None:
    case.run("new", "wedge", "mine")
    told = json.loads(case.run("key-blocks", "mine/model.toml", "--json", "--no-picture").out)
    planes = (45, 130), (55, 230)
    _, _, volume, areas = wedge_rock(*planes, (70, 180), (0, 180), 10.0)  # above where they cross
    factor = wedge_factor(*planes, volume, areas, 25e3, (30, 35), (0, 0))
    assert told["volume"] == pytest.approx(volume, rel=1e-5)  # the crossing is rounded to 6e-6 m off the face
    assert list(told["slides"].values()) == [pytest.approx(factor, abs=1e-6)]
    assert 0.97 * factor < 1 < 0.98 * factor  # as its comment says


@pytest.mark.heavy
def test_the_bolts_of_the_roof_share_its_pyramid(case: Case) -> None:
    """A pyramid of 60 degrees over 2 x 2 m: 26 kN/m3 times 4 sqrt(3) / 3 m3."""
    case.run("new", "roof", "mine")
    case.run("run", "mine/model.toml", "-q")
    stage = bsm.Results.load(case.folder / "mine/out/model").stages[-1]
    np.testing.assert_allclose(stage.bolts.axial_force, 26e3 * np.sqrt(3) / 3, rtol=1e-6)
    model = case.folder / "mine/model.toml"
    text = model.read_text()
    model.write_text(text[: text.index("[[bolt]]")] + text[text.index("[key_blocks]") :])
    told = json.loads(case.run("run", "mine/model.toml", "--json").out)
    assert [(stage["status"], len(stage["unstable_blocks"])) for stage in told["stages"]] == [
        ("stable", 0),
        ("unstable", 1),
    ]


def test_the_tunnel_can_be_changed(case: Case) -> None:
    case.run("new", "tunnel", "mine")
    model = case.folder / "mine/model.toml"
    change(case, "mine", "radius = 2.5\n", "radius = 3.0\n")
    change(case, "mine", "radius = 2.5,", "radius = 3.0,")
    change(case, "mine", "spacing = 3.0", "spacing = 3.5")
    loaded = bsm.load(model)
    area = loaded.blocks.moments.area
    inside = [group for group in loaded.blocks.excavations if group == "tunnel"]
    assert area.sum() == pytest.approx(24 * 24)
    assert area[loaded.blocks.excavations[inside[0]]].sum() == pytest.approx(9 * 3.14159, rel=1e-2)


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "wedge"), [("cavern", (-0.5, 12.9, 8.2)), ("tunnel", (0.2, 3.0, 2.5))])
def test_the_roof_wedge_stands_with_bolts_and_falls_without(case: Case, name: str, wedge: tuple[float, ...]) -> None:
    x, y, area = wedge
    case.run("new", name, "mine")
    with_bolts = bsm.run(case.folder / "mine/model.toml", output=False)
    assert [stage.status for stage in with_bolts.stages] == ["stable"] * len(with_bolts.stages)
    assert with_bolts.stages[-1].max_stage_displacement < 0.01  # where blocks reached rest far off, they had fallen
    without = bsm.run(with_bolts.model.replace(bolts=(), histories=()), with_bolts.options)
    down = without.unstable_blocks
    moments = without.blocks.moments
    assert (without.status, without.stages[-1].name) == ("unstable", with_bolts.stages[1].name)
    assert moments.area[down].sum() == pytest.approx(area, rel=0.05)
    centre = (moments.area[down, None] * moments.centroid[down]).sum(axis=0) / moments.area[down].sum()
    assert centre == pytest.approx((x, y), abs=0.3)


@pytest.mark.parametrize(
    ("friction", "verdict"), [pytest.param(31.5, "stable", marks=pytest.mark.heavy), (29.5, "unstable")]
)
def test_the_dam_slides_where_statics_say(case: Case, friction: float, verdict: str) -> None:
    """Water pushes with 9.81 kN/m3 h^2 / 2, and lifts with 9.81 kN/m3 h b / 2 what weighs 24 kN/m3 a square metre."""
    height, crest = 40.0, 6.0
    base = crest + height / np.tan(np.radians(52))
    weight = 24e3 * height * (crest + base) / 2
    push, lift = 9810 * height**2 / 2, 9810 * height * base / 2
    assert 30 < np.degrees(np.arctan(push / (weight - lift))) < 31
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
    assert "next: bsm-mesh run 'my tunnel/model.toml'" in case.run("new", "tunnel", "my tunnel").out


def test_the_geometry_runs_on_its_own(case: Case) -> None:
    case.run("new", "tunnel", "mine")
    outcome = case.run("mesh", "mine/tunnel.py", "--set", "spacing=4", "--set", "size=2", "-o", "t.msh")
    assert outcome.new == ["t.msh"]
    assert "joint:J1" in outcome.out


def test_the_demo_runs_again_as_changed_but_runs_nobody_elses_model(case: Case) -> None:
    case.run("new", "cavern", "demo")
    case.write("demo/model.toml", "x = ")
    assert "demo/model.toml: not valid TOML" in case.run("demo", "-o", "demo").err
    (case.folder / "demo/cavern.py").unlink()
    case.refuses("demo", "-o", "demo", says=["demo exists and is not empty", "name a new folder"])


@pytest.mark.heavy
def test_bricks_of_the_wall_may_fall_onto_free_faces(case: Case) -> None:
    """Tilted by 40 degrees. Without a joint of its free faces check names them; corners have their bricks' joint."""
    case.run("new", "wall", "mine")
    change(case, "mine", "direction = -80", "direction = -50")
    assert "unstable" in case.run("run", "mine/model.toml", "-q").out
    change(case, "mine", 'default_joint = "bed"', "")
    note = "outer faces of rigid rock without a joint: where two of them meet, a run ends with an error"
    assert note in case.run("check", "mine/model.toml").out
    assert "unstable" in case.run("run", "mine/model.toml", "-q").out
