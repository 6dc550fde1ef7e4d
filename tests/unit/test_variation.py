"""A model file whose keys take other values: keys, faults, blocks that are shared, and what pickles."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from bsm_mesh.modelfile import variation as module
from bsm_mesh.modelfile.variation import Variation
from tests.scenes.small_case import MODEL, Case

STAGES = """
[[stage]]
name = "crown"
excavate = [3]
relaxation = [0.5, 1.0]
pressure = "1 kPa"
[[stage]]
name = "bench"
excavate = [2]
"""
BRICKS = """
[mesh]
geometry = "brick_wall"
[mesh.parameters]
courses = 2
bricks = 3
[rock.rock]
unit_weight = 26000
[joint.bed]
normal_stiffness = 1e9
shear_stiffness = 1e9
friction = 30
[joint.head]
normal_stiffness = 1e9
shear_stiffness = 1e9
friction = 30
[[support]]
blocks = [0]
fix = "all"
"""


@pytest.fixture
def varied(case: Case) -> Variation:
    case.write("model.toml", MODEL + STAGES)
    return Variation(Path("model.toml"))


def test_values_are_those_that_the_file_could_give(case: Case, varied: Variation) -> None:
    values = {
        "joint.J1.friction": np.float64(21.5),
        "rock.gneiss.unit_weight": "20 kN/m^3",
        "load.1.pressure": "2 MPa",
        "stage.crown.pressure": 3.0,
        "stage.2.pressure": 4.0,
        "gravity.direction": -80,
        "solver.tolerance": 1e-5,
        "joint.J1.law": "mohr_coulomb",
    }
    loaded = varied.model(values)
    text = (case.folder / "model.toml").read_text()
    for old, new in (
        ("friction = 35", "friction = 21.5\nlaw = 'mohr_coulomb'"),
        ("26 kN/m^3", "20 kN/m^3"),
        ("1 MPa", "2 MPa"),
        ("1 kPa", "3 Pa"),
        ('name = "bench"', 'name = "bench"\npressure = 4'),
    ):
        text = text.replace(old, new)
    case.write("model.toml", text + "[gravity]\ndirection = -80\n[solver]\ntolerance = 1e-5\n")
    expected = bsm.load("model.toml")
    assert loaded.model == expected
    assert loaded.options == expected.options


def test_a_value_in_a_list_is_told_by_its_number(case: Case) -> None:
    case.change('pressure = "1 MPa"', "traction = [0, [-1e6, 0, 0]]")
    load = Variation(Path("model.toml")).model({"load.1.traction.2.1": "-3 MPa"}).model.loads[0]
    assert isinstance(load, bsm.Traction)
    assert load.traction[1][0] == -3e6


def test_a_name_in_quotes(case: Case) -> None:
    case.change("[joint.J1]", '[groups]\n"joint:J1" = "joint:J.1"\n[joint."J.1"]')
    (joint,) = Variation(Path("model.toml")).model({'joint."J.1".friction': 12}).model.joints
    assert joint.law == bsm.Patton(friction=12.0)


@pytest.mark.parametrize(
    ("key", "says"),
    [
        ("joint.J1.fricton", "joint.J1 has no key 'fricton'; did you mean 'friction'?"),
        ("joint.J2.friction", "the model file has no [joint.J2]; did you mean 'J1'?"),
        ("joints.J1.friction", "a model file has no key 'joints'; did you mean 'joint'?"),
        ("joint.J1", "'joint.J1' is a table; add one of its keys"),
        ("load.2.pressure", "which load is meant by its number, 1 to 1"),
        ("load.top.pressure", "which load is meant by its number, 1 to 1"),
        ("stage.crwn.pressure", "no stage has the name 'crwn'; did you mean 'crown'?"),
        ("bolt.1.diameter", "the model file has no bolt"),
        ("joint.J1.friction.x", "joint.J1.friction is a value, which has no keys"),
        ("joint..friction", "is no key"),
        ("", "is no key"),
    ],
)
def test_a_key_that_is_not_known(varied: Variation, key: str, says: str) -> None:
    for ask in (lambda: varied.model({key: 1.0}), lambda: varied.check([key])):
        with pytest.raises(ModelError) as caught:
            ask()
        assert says in str(caught.value)
        assert str(caught.value).startswith(f"model.toml: '{key}'")


def test_all_faults_come_together(varied: Variation) -> None:
    with pytest.raises(ModelError) as caught:
        varied.model({"joint.J1.frict": 1, "rock.slate.young": 2})
    assert len(caught.value.faults) == 2
    with pytest.raises(ModelError, match=r"\[joint.J1\] friction = 95: .*"):
        varied.model({"joint.J1.friction": 95})


def test_blocks_are_read_once(varied: Variation, monkeypatch: pytest.MonkeyPatch) -> None:
    read = []
    monkeypatch.setattr(module, "read_blocks", lambda *given, old=module.read_blocks: read.append(1) or old(*given))
    one = varied.model({"joint.J1.friction": 20}).model
    two = varied.model({"joint.J1.friction": 30, "mesh.default_joint": "J1", "mesh.contact_points": "gauss"}).model
    assert one.blocks is two.blocks
    assert two.contact_points == "gauss"
    assert len(read) == 1
    varied.model({"mesh.unit": "mm"})
    assert varied.model({}).model.blocks is one.blocks
    assert len(read) == 2


def test_a_mesh_built_anew(tmp_path: Path) -> None:
    (tmp_path / "wall.toml").write_text(BRICKS)
    varied = Variation(tmp_path / "wall.toml")
    few, many = (varied.model({"mesh.parameters.courses": courses}).model.blocks for courses in (1, 4))
    assert many.count > varied.model({}).model.blocks.count > few.count
    varied.check(["mesh.parameters.courses"])
    with pytest.raises(ModelError, match="brick_wall has no parameter 'corses'; did you mean 'courses'"):
        varied.check(["mesh.parameters.corses"])


def test_the_file_stays_as_it_was_read(varied: Variation) -> None:
    before, digest = varied.model({}).model, varied.digest
    varied.model({"joint.J1.friction": 20, "gravity.direction": -60})
    assert varied.model({}).model == before
    assert varied.digest == digest
    assert varied.base("joint.J1.friction") == 35
    assert varied.base("stage.crown.pressure") == "1 kPa"
    assert varied.base("gravity.direction") is None


def test_it_pickles_small_and_from_any_folder(varied: Variation, monkeypatch: pytest.MonkeyPatch) -> None:
    before = varied.model({"joint.J1.friction": 20}).model
    sent = pickle.dumps(varied)
    assert len(sent) < 20_000
    monkeypatch.chdir("/")
    assert pickle.loads(sent).model({"joint.J1.friction": 20}).model == before


def test_the_kind_of_number_of_a_key(varied: Variation) -> None:
    units = {
        "joint.J1.friction": "degrees",
        "rock.gneiss.unit_weight": "N/m^3",
        "load.1.pressure": "Pa",
        "stage.crown.relaxation.1": "",
        "water.joint_pressure.J1": "Pa",
        "load.1.factor": "",
        "stage.crown.load.1.factor": "",
        "water.rise": "m",
        "tilt.left": "degrees",
        "tilt.right": "degrees",
    }
    for key, unit in units.items():
        quantity = varied.quantity(key)
        assert quantity is not None
        assert quantity.unit == unit
    assert varied.unit("joint.J1.friction") == "degrees"
    assert varied.unit("gravity.horizontal") == "of the weight"
    assert varied.unit("load.1.factor") == ""
    assert varied.quantity("joint.J1.law") is None
    assert varied.quantity("mesh.parameters.seed") is None


POINT_LOAD = """
[[load]]
block = 3
point = [1, 1]
force = ["1 kN/m", 0]
"""


def test_numbers_of_a_list_have_its_unit(case: Case) -> None:
    case.write("model.toml", MODEL + POINT_LOAD)
    varied = Variation(Path("model.toml"))
    assert varied.ends("load.2.force.1", ["2 kN/m", 3.0]) == (2e3, 3.0)
    assert varied.unit("load.2.point.2") == "m"


def test_numbers_that_no_key_holds(case: Case) -> None:
    """A load's factor, the rise of the water and a tilt, beside a key."""
    case.write("model.toml", MODEL + "[water]\ntable = [[-1, 0.5], [3, 0.5]]\n" + STAGES)
    varied = Variation(Path("model.toml"))
    values = {"load.1.factor": 2, "water.rise": "50 cm", "tilt.right": 3.0, "joint.J1.friction": 30}
    varied.check([*values])
    model = varied.model(values).model
    assert model.loads[0].pressure[0] == 2e6  # type: ignore[union-attr]
    assert model.water is not None
    assert model.water.table == (((-1.0, 1.0), (3.0, 1.0)),)
    assert model.gravity_direction == -87.0
    assert model.joints[0].law.friction == 30  # type: ignore[union-attr]
    assert varied.with_value("tilt.left", 3.0).gravity_direction == -93.0
    assert pickle.loads(pickle.dumps(varied)).with_value("water.rise", 0.5).water.table == model.water.table


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("load.2.factor", "load.2.factor = 1.0: there is no [[load]] number 2; there are 1"),
        ("stage.crwn.load.1.factor", "there is no stage 'crwn'; did you mean 'crown'"),
        ("water.rise", "the model has no water table"),
        ("tilt.lft", "in addition to keys of the file there are load.N.factor"),
        ("a..b", "is no key"),
    ],
)
def test_numbers_that_the_model_does_not_have(varied: Variation, name: str, says: str) -> None:
    with pytest.raises(ModelError) as caught:
        varied.check([name])
    assert says in str(caught.value)


def test_ends_of_a_search_are_no_whole_numbers(varied: Variation) -> None:
    with pytest.raises(ModelError, match="is a whole number, between two of which"):
        varied.ends("solver.max_steps", [10, 20])


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("water.table.2.2", "m"),
        ("stage.crown.water.table.1.2.1", "m"),  # of several tables
        ("in_situ.surface.1.2", "m"),
        ("in_situ.surface", "m"),
        ("water.table.2", ""),  # a point is no number
    ],
)
def test_coordinates_in_lists_of_points_have_their_unit(case: Case, key: str, unit: str) -> None:
    stages = STAGES.replace("[0.5, 1.0]", "[0.5, 1.0]\nwater = { table = [[[0, 1], [2, 1]], [[0, 3], [2, 4]]] }")
    ground = '[water]\ntable = [[0, 1], ["6 ft", 2]]\n[in_situ]\nsurface = [[0, "7 ft"], [2, 2]]\n'
    case.write("model.toml", MODEL + ground + stages)
    varied = Variation(Path("model.toml"))
    assert varied.unit(key) == unit
    if key == "water.table.2.2":
        assert varied.ends(key, ["1 ft", 2.0]) == pytest.approx((0.3048, 2.0))
