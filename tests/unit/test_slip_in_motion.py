"""Slip in explicit motion: what counts as slip, and joints that open by it."""

from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.masses import MotionSettings
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.scenes.steps import begun, still

INELASTIC = MotionSettings(damping=0.0, damps_impacts=True, real_masses=True)
BASE, BLOCK = rectangle(-5, -1, 5, 0), rectangle(-0.5, 0, 0.5, 0.2)
SOFTENING = bsm.MohrCoulomb(friction=35, residual_friction=30, softening_slip=0.05)


def thrown(law, along: float, up: float, turn: float = 0.0, kn: float = 1e8, **keys) -> ExplicitMotion:
    """Return the motion, to rest, of a block thrown along its base and off it, velocities in roots of metres."""
    model = model_of([turned(p, turn) for p in (BASE, BLOCK)], law=law, kn=kn, gravity_direction=turn - 90.0)
    model = model.replace(joints=[replace(model.joints[0], **keys)])
    (velocity,) = turned(np.array([[along, up]]), turn)
    motion = ExplicitMotion(begun(model), INELASTIC, velocity=still(2, b1=(*velocity, 0.0)))
    for _ in range(150):
        motion.advance()
    assert np.abs(motion.velocity).max() < 0.02 * along
    return motion


@pytest.mark.parametrize(
    ("turn", "up"), [(0.0, 0.03), (0.0, 0.06), (50.0, 0.03), pytest.param(50.0, 0.06, marks=pytest.mark.heavy)]
)
def test_flight_is_no_slip(turn, up):
    """It flies by twice the product of its velocities; the rest of its way is slip."""
    along = 0.05
    motion = thrown(SOFTENING, along, up, turn)
    moved = turned(motion.residual.position[1:, :2], -turn)[0, 0]
    flight = 2 * along * up
    assert moved > 1.1 * flight
    assert motion.contacts.slip_path.max() == pytest.approx(moved - flight, abs=0.03 * flight)


@pytest.mark.parametrize(
    ("turn", "last"), [(0.0, 1e-3), (0.0, 1.0), (50.0, 1e-3), pytest.param(50.0, 1.0, marks=pytest.mark.heavy)]
)
def test_a_sliding_block_rises_by_dilation(turn, last):
    """Up by tan(dilation angle) a metre of slip while it lasts; it comes no more than by friction alone."""
    motion = thrown(bsm.MohrCoulomb(friction=30), 0.07, 0.0, turn, kn=1e9, dilation_angle=4.0, dilation_slip=last)
    moved, rises = turned(motion.residual.position[1:, :2], -turn)[0]
    opened = np.tan(np.radians(4.0)) * np.minimum(motion.contacts.slip_path, last)
    sinks = 0.2 * 25e3 / 1e9  # of its weight on the springs
    assert 0.5 * moved < motion.contacts.slip_path.max() < 1.02 * moved
    assert moved < 1.02 * 0.07**2 / 2 / np.tan(np.radians(30))
    assert rises + sinks == pytest.approx(opened.mean(), rel=0.01)
