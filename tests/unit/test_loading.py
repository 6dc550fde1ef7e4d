"""Whether anything loads a model: rest of a model that nothing loads is no verdict."""

from __future__ import annotations

import pytest

import bsm_mesh as bsm
from bsm_mesh.model.loading import faults_of_loading
from tests.scenes.models import framed, model_of
from tests.scenes.shapes import grid
from tests.scenes.small_case import MODEL, Case

BLOCKS = framed(bsm.Blocks.from_polygons(grid(2, 2), rock="rock"), 2, 2)
WEIGHTLESS = model_of(BLOCKS, gamma=0, friction=30, supports=[bsm.Fixed(boundary="bottom")])
FLOATING = {"rocks": [bsm.Rock("rock", unit_weight=26e3)], "gravity_vertical": 1.0}  # all of the weight is taken away
STRESS = bsm.InSitu(stress={"yy": -1e6})
NO_STRESS = bsm.InSitu(stress={"yy": 0.0})


@pytest.mark.parametrize(
    "changes",
    [
        {"rocks": [bsm.Rock("rock", unit_weight=26e3)]},
        {"loads": [bsm.Pressure(boundary="top", pressure=1e3)]},
        {"loads": [bsm.PointLoad(block=2, point=(0.5, 1.5), force=(1.0, 0.0))]},
        {"in_situ": STRESS},
        {"in_situ": bsm.InSitu(surface=5.0, surcharge=1e4)},
        {"in_situ": bsm.InSitu(method="gravity", stress={"yy": -1e6}), "loads": [bsm.InSituTraction(boundary="top")]},
        {"water": bsm.Water(table=[(0, 1)])},
        {"water": bsm.Water(joint_pressure={"J": 1e3})},
        {"bolts": [bsm.Bolt(start=(0.5, 1.8), end=(0.5, 0.2), diameter=0.02, pretension=1e3)]},
        {"supports": [bsm.PrescribedDisplacement(boundary="bottom", direction=0, displacement=1e-3)]},
        {"stages": [bsm.Stage(name="a", loads=[bsm.Pressure(boundary="top", pressure=1e3)])]},
        {"stages": [bsm.Stage(name="a", water=bsm.Water(table=[(0, 1)]))]},
        {"stages": [bsm.Stage(name="a", excavate=[3], pressure=1e3)]},
        {**FLOATING, "stages": [bsm.Stage(name="a", gravity=(0.0, 0.5))]},
        {**FLOATING, "gravity_horizontal": 0.1},
    ],
)
def test_what_loads(changes: dict[str, object]) -> None:
    assert faults_of_loading(WEIGHTLESS.replace(**changes)) == []


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"loads": [bsm.Pressure(boundary="top", pressure=0.0)]},
        {"in_situ": bsm.InSitu(surface=5.0, k0=0.5)},
        {"in_situ": NO_STRESS, "loads": [bsm.InSituTraction(boundary="top")]},
        {"in_situ": bsm.InSitu(method="gravity", stress={"yy": -1e6})},
        {"water": bsm.Water(table=[(0, -5)], joint_pressure={"J": 0.0})},
        {"bolts": [bsm.Bolt(start=(0.5, 1.8), end=(0.5, 0.2), diameter=0.02)]},
        {"stages": [bsm.Stage(name="a", excavate=[3])]},
        {"gravity_horizontal": 0.5},
        FLOATING,
    ],
)
@pytest.mark.parametrize("scheme", ["linear", "continuation", "wang"])
def test_where_nothing_loads_there_is_no_verdict(changes: dict[str, object], scheme: str) -> None:
    model = WEIGHTLESS.replace(**changes)
    assert len(faults_of_loading(model)) == 1
    with pytest.raises(bsm.ModelError, match=r"nothing loads the model.*give the rocks their unit_weight, or a load"):
        bsm.run(model, bsm.Options(scheme=scheme))


def test_weights_that_gravity_cancels_are_told_as_such() -> None:
    assert "gravity is zero, and there is no load" in faults_of_loading(WEIGHTLESS.replace(**FLOATING))[0]


@pytest.mark.parametrize("command", ["run", "check", "compare"])
def test_commands_refuse_what_nothing_loads(case: Case, command: str) -> None:
    text = MODEL.replace('"26 kN/m^3"', "0")
    case.write("model.toml", text[: text.index("[[load]]")])
    case.refuses(command, "model.toml", says=["nothing loads the model", "unit_weight"])


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_forgotten_unit_weight_is_told(case: Case, command: str) -> None:
    case.change('unit_weight = "26 kN/m^3"\n', "")
    case.refuses(
        command,
        "model.toml",
        says=["[rock.gneiss]: needs the key 'unit_weight', for example unit_weight = \"26 kN/m^3\""],
    )
    with pytest.raises(TypeError, match="unit_weight"):
        bsm.Rock("gneiss")  # type: ignore[call-arg]


def test_a_weight_of_0_may_be_written_out(case: Case) -> None:
    case.change('"26 kN/m^3"', "0")
    outcome = case.run("run", "model.toml")
    assert outcome.code == 0
    assert "rock 'gneiss' has no weight" in outcome.out
