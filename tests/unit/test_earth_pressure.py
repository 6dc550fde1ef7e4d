"""Earth pressure as it is given: messages, the model file, factors."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.changes import with_load_factor
from bsm_mesh.model.loads import edge_tractions, point_forces_of
from tests.scenes.models import framed
from tests.scenes.shapes import grid
from tests.scenes.small_case import LOAD, Case

BLOCKS = framed(bsm.Blocks.from_polygons(grid(2, 2), rock="r"), 2, 2)
IN_FILE = """\
[boundary.right]
right_of = 1.99
[[load]]
boundary = "right"
[load.earth_pressure]
state = "active"
theory = "coulomb"
unit_weight = "19 kN/m^3"
friction = 32
wall_friction = 20
surface = [[2, "2 m"], [12, 3]]
surcharge = "10 kPa"
"""


def soil(**changes):
    given = {"boundary": "right", "state": "active", "unit_weight": 19e3, "friction": 32, "surface": 2.0}
    return bsm.EarthPressure(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"state": "activ"}, "earth pressure on 'right': state = 'activ' is unknown; did you mean 'active'?"),
        ({"theory": "terzaghi"}, "theory = 'terzaghi' is unknown"),
        ({"friction": 95}, "friction = 95 degrees must be at least 0 and below 90 degrees"),
        ({"surface": "high"}, "surface = 'high' is not a finite number [m]"),
        ({"surface": [(0, 0), (1, 1), (2, 1)]}, "surface has 3 points; give a level, or two points of a line"),
        ({"surface": [(1, 0), (0, 1)]}, "points go from left to right"),
        ({"surface": [(0, 0), (1, 1)]}, "slopes by 45 degrees, more than friction = 32"),
        ({"wall_friction": 20}, 'wall_friction has no effect here; give theory = "coulomb"'),
        ({"theory": "coulomb", "wall_friction": 33}, "wall_friction = 33 is above friction = 32 degrees"),
        ({"theory": "coulomb", "cohesion": 1e3}, 'cohesion has no effect here; give theory = "rankine"'),
        ({"cohesion": 1e3, "surface": [(0, 0), (9, 1)]}, "cohesion needs level ground"),
        ({"overconsolidation": 2}, "overconsolidation belongs to the state at_rest, not active"),
        ({"factor": -1}, "factor = -1 must be 0 to 1e9; soil presses and does not pull"),
        ({"boundary": 3}, "load: boundary = 3 must be a text"),
    ],
)
def test_faults(changes, message):
    with pytest.raises(bsm.ModelError, match=re.escape(message)):
        soil(**changes)


@pytest.mark.parametrize(
    ("load", "message"),
    [
        (soil(surface=-1.0), "surface lies below the whole boundary; nothing acts on it"),
        (soil(boundary="top", surface=5.0, theory="coulomb"), "faces of the boundary are level or look both ways"),
        (soil(boundary="rigth"), "did you mean 'right'?"),
    ],
)
def test_faults_that_need_the_blocks(load, message):
    with pytest.raises(bsm.ModelError, match=re.escape(message)):
        point_forces_of([load], BLOCKS)


def test_no_wedge_on_a_flat_back():
    flat = bsm.Blocks.from_polygons([[(0, 0), (9, 0), (0, 1)]], rock="r").with_boundary(
        "back", lambda x, y: x + 9 * y > 8.9
    )
    with pytest.raises(bsm.ModelError, match="no active wedge on a face that is inclined by 83"):
        point_forces_of([soil(boundary="back", theory="coulomb", wall_friction=20, surface=1.0)], flat)
    forces = point_forces_of([soil(boundary="back", surface=1.0)], flat)  # the weight of what lies on it
    assert_allclose(forces.force[:, 1].sum(), -19e3 * 9 / 2, rtol=1e-12)


def test_both_sides_of_a_buried_block_balance():
    """Rankine's and the stress at rest act on faces of any direction; horizontal forces of the two sides are equal."""
    for side in ("left", "right"):
        forces = [point_forces_of([soil(boundary=name, state="at_rest")], BLOCKS) for name in (side, "right")]
        assert_allclose(np.abs(forces[0].force[:, 0].sum()), np.abs(forces[1].force[:, 0].sum()), rtol=1e-12)


def test_a_load_without_weight_is_the_surcharge_alone():
    _, _, traction = edge_tractions(soil(unit_weight=0, surcharge=9e3), BLOCKS)
    assert_allclose(traction[..., 0], -soil().coefficient() * 9e3, rtol=1e-12)


def test_the_model_file_builds_the_same_load(case: Case) -> None:
    case.change(LOAD, IN_FILE)
    (load,) = bsm.load("model.toml").loads
    line = ((2.0, 2.0), (12.0, 3.0))
    assert load == soil(theory="coulomb", wall_friction=20, surface=line, surcharge=10e3)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('state = "active"\n', "", ["[[load]] number 1, earth_pressure: needs the key 'state'"]),
        ("wall_friction", "wal_friction", ["'wal_friction'", "did you mean 'wall_friction'"]),
        ("[load.earth_pressure]", "pressure = 3\n[load.earth_pressure]", ["[[load]] number 1", "earth_pressure"]),
    ],
)
def test_faults_of_the_model_file(case: Case, old: str, new: str, words: list[str]) -> None:
    case.change(LOAD, IN_FILE.replace(old, new))
    outcome = case.run("check", "model.toml")
    assert outcome.code == 2
    assert all(word in outcome.err for word in words), outcome.err
    assert "Traceback" not in outcome.err


def test_a_factor_multiplies_it():
    model = bsm.Model(
        blocks=BLOCKS, rocks=[bsm.Rock("r", unit_weight=26e3)], joints=[bsm.Joint("J", 1e9, 1e9)], default_joint="J",
        supports=[bsm.Fixed(boundary="bottom")], loads=[soil(factor=1.2)],
    )  # fmt: skip
    once, twice = (point_forces_of(m.loads, BLOCKS).force for m in (model, with_load_factor(model, 2.0, number=1)))
    assert_allclose(twice, 2 * once, rtol=1e-14)
    assert_allclose(once, 1.2 * point_forces_of([soil()], BLOCKS).force, rtol=1e-14)
