"""Every joint law in every way in which a model is solved: docs/joint_laws.md has the same table in words."""

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.converters.continuum import solve_continuum_stages
from bsm_mesh.converters.exports.parts import left_out
from bsm_mesh.folder.verify import grounds_in
from bsm_mesh.model.strength import with_strength
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.masses import MotionSettings
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.scenes.steps import begun

SLOPE = 20.0  # degrees
MC = {"friction": 35.0, "cohesion": 2e3}
LAWS = {
    "mohr_coulomb": {"law": bsm.MohrCoulomb(**MC)},
    "brittle, residual tension": {
        "law": bsm.MohrCoulomb(**MC, residual_friction=30.0),
        "tensile_strength": 1e4,
        "residual_tensile_strength": 2e3,
    },
    "softening": {"law": bsm.MohrCoulomb(**MC, residual_friction=30.0, softening_slip=5e-3)},
    "patton": {"law": bsm.Patton(friction=30.0, dilation=10.0, cohesion=2e5)},
    "barton_bandis": {"law": bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28.0)},
    "barton_bandis, wearing": {"law": bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28.0, roughness_wears=True)},
    "ladanyi_archambault": {"law": bsm.LadanyiArchambault(friction=30.0, dilation=10.0, jcs=60e6)},
    "closure": {"law": bsm.MohrCoulomb(**MC), "max_closure": 5e-4},
    "dilation": {"law": bsm.MohrCoulomb(**MC), "dilation_angle": 8.0, "dilation_slip": 5e-3},
    "stiffening": {"law": bsm.MohrCoulomb(**MC), "shear_stiffness_exponent": 0.5, "reference_stress": 1e5},
    "stiffening by its strength": {
        "shear_stiffness": None,
        "law": bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28.0),
        "reference_stress": 1e5,
    },
    "all at once": {
        "shear_stiffness": None,
        "reference_stress": 1e5,
        "law": bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28.0, roughness_wears=True),
        "max_closure": 5e-4,
        "dilation_angle": 8.0,
        "dilation_slip": 5e-3,
    },
}


@pytest.fixture(
    params=[pytest.param(name, marks=[pytest.mark.heavy] if name == "all at once" else []) for name in LAWS]
)
def model(request):
    """Return a block on a slope that every law holds, and a smaller one on top of it."""
    polygons = [rectangle(-9, -2, 9, 0), rectangle(-1, 0, 1, 1), rectangle(-0.5, 1, 0.5, 1.5)]
    found = model_of([turned(p, SLOPE) for p in polygons])
    joint = bsm.Joint("J", **{"normal_stiffness": 1e9, "shear_stiffness": 5e8, **LAWS[request.param]})
    return found.replace(joints=[joint])


@pytest.mark.heavy
@pytest.mark.parametrize("scheme", ["continuation", "wang"])
def test_a_block_rests_and_slides_at_less_strength(model, scheme, tmp_path):
    """Strength reduction too; verdicts hold by the certificates alone."""
    options = bsm.Options(scheme=scheme, max_steps=2000)
    at_rest = bsm.run(model, options)
    assert at_rest.status == "stable"
    assert at_rest.check().ok
    assert all(ground.holds for ground in grounds_in(at_rest.save(tmp_path / "out")))
    slides = bsm.run(with_strength(model, {"*": 0.2}), options)
    assert slides.status == "unstable"
    assert 2 in slides.unstable_blocks or 1 in slides.unstable_blocks


def test_the_linear_scheme_tells_of_its_strength(model):
    stage = bsm.run(model, bsm.Options(scheme="linear")).stages[0]
    assert stage.status == "no_verdict"
    assert 0 < stage.contacts.utilisation.max() < 1


def test_limit_analysis_by_straight_lines(model):
    assert bsm.limit_analysis(model).admissible
    assert not bsm.limit_analysis(with_strength(model, {"*": 0.2})).admissible


@pytest.mark.slow
def test_stages_weaken_it_and_in_situ_presses_it(model):
    field = bsm.InSitu(stress={"xx": -2e4, "yy": -2e4, "xy": 0.0})
    stages = [bsm.Stage(name="weaker", strength={"J": 0.9}), bsm.Stage(name="gone", strength={"J": 0.2})]
    results = bsm.run(model.replace(stages=stages), bsm.Options(displacement_limit=0.5))  # not down the whole slope
    assert [stage.status for stage in results.stages] == ["stable", "stable", "unstable"]
    pressed = bsm.run(model.replace(in_situ=field, gravity_direction=SLOPE - 90.0))
    assert pressed.stages[0].status == "stable"


def test_the_continuum_has_it_in_its_interfaces(model):
    (stage,) = solve_continuum_stages(model, order=1, joints=True)
    assert stage.converged
    results = bsm.run(model)
    assert np.hypot(*(stage.displacement - results.stages[0].displacement)[:, :2].T).max() < 2e-5


def test_blocks_that_are_followed(model):
    """Where blocks slide they are slowed, and where they rest they reach rest."""
    motion = ExplicitMotion(begun(model), MotionSettings(damping=0.5, damps_impacts=False, real_masses=True), ramp=200)
    for _ in range(40):
        motion.advance(100)
    assert motion.residual.max_norm < 1e-3
    assert np.abs(motion.residual.position[1:, :2]).max() < 5e-3


def test_what_an_export_leaves_out_is_told(model):
    law = model.joints[0].law
    plain = LAWS["mohr_coulomb"]["law"] == law
    told = " ".join(left_out(model))
    assert ("dilation" in told) == (model.joints[0].dilation_angle > 0)
    assert ("shear stiffness that grows" in told) == (model.joints[0].reference_stress is not None)
    assert ("closure" in told) == (model.joints[0].max_closure is not None)
    assert (type(law).__name__ in told) == (not plain)


def test_it_is_read_as_it_was_written(model, tmp_path):
    named = replace(model.joints[0], name="J")
    bsm.run(model, bsm.Options(scheme="linear")).save(tmp_path / "out")
    assert bsm.load(tmp_path / "out/model.toml").joints == (named,)
