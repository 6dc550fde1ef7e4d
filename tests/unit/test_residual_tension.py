"""What slip leaves of the tensile strength: of joints, of faces of rock, in every way in which blocks are moved."""

from dataclasses import replace

import pytest

import bsm_mesh as bsm
from bsm_mesh.joint_test.specimen import Specimen, position_of
from bsm_mesh.model.rock_faces import residual_tension_between
from bsm_mesh.model.strength import with_strength
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.masses import MotionSettings
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle
from tests.scenes.steps import begun, still

LAW = bsm.MohrCoulomb(friction=30, cohesion=1e5, residual_cohesion=1e5)
JOINT = bsm.Joint("J", 1e9, 1e9, law=LAW, tensile_strength=40e3, residual_tensile_strength=10e3)


def pulled(slides: bool, stress: float, joint: bsm.Joint = JOINT) -> float:
    """Return the tension [Pa] that a joint carries under one that would be `stress`, after it has slid or not."""
    specimen = Specimen(joint)
    for at in (position_of(0, 0), position_of(1e-3 * slides, -1e-6), position_of(1e-3 * slides, stress / 1e9)):
        contacts = specimen.contacts(at)
        found = specimen.system.evaluate(contacts, at)
        specimen.keep(contacts, found)
    return -float(found.forces[1, 1])


@pytest.mark.parametrize(("slides", "stress", "borne"), [(False, 39e3, 39e3), (True, 9e3, 9e3), (True, 11e3, 0.0)])
def test_slip_leaves_the_residual_tensile_strength(slides, stress, borne):
    assert pulled(slides, stress) == pytest.approx(borne, rel=1e-6)


@pytest.mark.parametrize(("stress", "borne"), [(9e3, 9e3), (11e3, 0.0)])
def test_slip_takes_tension_alone_where_there_is_no_cohesion(stress, borne):
    joint = replace(JOINT, law=bsm.MohrCoulomb(friction=30, residual_friction=30))
    assert pulled(True, stress, joint) == pytest.approx(borne, rel=1e-6)


def test_what_has_opened_bears_no_tension():
    specimen = Specimen(JOINT)
    for opening in (0.0, 1e-3, -1e-6, 5e-6):
        at = position_of(0.0, opening)
        contacts = specimen.contacts(at)
        found = specimen.system.evaluate(contacts, at)
        specimen.keep(contacts, found)
    assert found.forces[1, 1] == 0.0


@pytest.mark.parametrize(("residual", "holds"), [(8e3, True), (4e3, False), (0.0, False)])
def test_a_block_that_slid_hangs_by_what_is_left(residual, holds):
    """Its joint carries 5 kPa in explicit motion, where cohesion has stopped it."""
    model = model_of([rectangle(-4, 1, 4, 2), rectangle(-2, 0.8, 2, 1)])
    law = bsm.MohrCoulomb(friction=30, cohesion=60e3, residual_cohesion=60e3)
    joint = replace(model.joints[0], law=law, tensile_strength=90e3, residual_tensile_strength=residual)
    model = model.replace(joints=[joint])
    settings = MotionSettings(damping=0.5, damps_impacts=False, real_masses=True)
    motion = ExplicitMotion(begun(model), settings, velocity=still(2, b1=(0.05, 0, 0)), ramp=400)
    for _ in range(20):
        motion.advance(100)
    assert motion.contacts.failed.any()
    assert bool(motion.residual.position[1, 1] > -1e-3) is holds


def test_a_bond_that_breaks_in_motion_leaves_nothing_when_it_closes_again():
    """A block thrown off its base by less than a contact search would tell."""
    model = model_of([rectangle(-4, -2, 4, 0), rectangle(-2, 0, 2, 0.2)])
    keys = {"law": LAW, "tensile_strength": 9e3, "residual_tensile_strength": 8e3}
    settings = MotionSettings(damping=0.0, damps_impacts=False, real_masses=True)
    step = begun(model.replace(joints=[replace(model.joints[0], **keys)]))
    motion, heights = ExplicitMotion(step, settings, velocity=still(2, b1=(0, 0.02, 0))), []
    for _ in range(6):
        motion.advance(20)
        heights.append(motion.residual.position[1, 1])
    assert max(heights) > 1e-4
    assert min(heights) < 0  # closed again
    assert not motion.contacts.tension.any()


def test_of_two_rocks_the_weaker_governs():
    keys = {"unit_weight": 25e3, "cohesion": 1e6, "residual_cohesion": 0.0, "tensile_strength": 2e5}
    strong, weak = (bsm.Rock(n, **keys, residual_tensile_strength=t) for n, t in (("s", 1e5), ("w", 2e4)))
    assert residual_tension_between(strong, weak) == 2e4
    assert residual_tension_between(strong, bsm.Rock("never fails", 25e3)) == 1e5


def test_strength_reduction_divides_it():
    model = model_of([rectangle(-4, 1, 4, 2), rectangle(-0.5, 0, 0.5, 1)])
    reduced = with_strength(model.replace(joints=[replace(JOINT, name=model.joints[0].name)]), {"*": 0.5})
    assert reduced.joints[0].residual_tensile_strength == 5e3


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ({"tensile_strength": 5e3}, "is above tensile_strength = 5000 Pa.*grows no stronger by failing"),
        *(
            ({"law": law}, "never acts: by its law slip takes no tension away; give mohr_coulomb residual_cohesion")
            for law in (
                bsm.MohrCoulomb(friction=30, cohesion=1e5),
                bsm.Patton(friction=30),
                bsm.BartonBandis(jrc=8, jcs=60e6, residual_friction=28, roughness_wears=True),
                bsm.LadanyiArchambault(friction=30, dilation=10, jcs=60e6),
            )
        ),
    ],
)
def test_what_never_acts_is_refused(keys, text):
    with pytest.raises(bsm.ModelError, match=text):
        replace(JOINT, **keys)
    with pytest.raises(bsm.ModelError, match=r"rock 'r': residual_tensile_strength = 20000 Pa is above"):
        bsm.Rock("r", 25e3, cohesion=1e5, residual_cohesion=0, tensile_strength=1e4, residual_tensile_strength=2e4)


@pytest.mark.parametrize(
    "law",
    [
        bsm.MohrCoulomb(friction=30, residual_friction=30),
        bsm.MohrCoulomb(friction=30, residual_friction=25, softening_slip=5.0),
        bsm.Patton(friction=30, dilation=5, cohesion=5e6),
    ],
)
def test_what_acts_in_the_end_is_not_refused(law):
    assert replace(JOINT, law=law).residual_tensile_strength == 10e3
