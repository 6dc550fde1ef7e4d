"""Compiled cycles: what a contact bears while its blocks are driven, and what it keeps from one call to the next."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from step_scenes import begun, block_on_a_base

from bsm_mesh.solve.motion.damped_motion import DampedMotion
from bsm_mesh.solve.motion.kernels import relax_cycles


class DrivenContact:
    """A contact with a corner above a horizontal edge, its blocks driven in unit cycles."""

    def __init__(self, pressure: float, strength: float, tension: float = 0.0) -> None:
        self.frame = np.array([[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0]], np.float32)  # n is up: out of b, which is below
        self.spring = np.array([[10.0, 10.0, pressure, strength, strength, 0.0]], np.float32)
        self.tension, self.shear_offset = np.full(1, tension, np.float32), np.zeros(1, np.float32)
        self.contacted, self.slipped = np.zeros(1, bool), np.zeros(1, bool)

    def drive(self, *movements: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """Move a by each of some movements in a cycle; return the changes of its shear force and of forces on it."""
        place, sides = np.zeros((2, 3)), (np.zeros(1, np.int32), np.ones(1, np.int32))
        none, free = np.zeros((2, 3)), (np.zeros(0, np.int32), np.zeros((0, 3, 3)))
        shears, forces = [], []
        for u, v in movements:
            place[0] += u, v, 0.0
            kept = self.tension, self.shear_offset, self.contacted, self.slipped
            given = self.frame, self.spring, *kept, none, none, np.ones((2, 3)), *free, 0.0
            push = np.zeros((2, 3))
            relax_cycles(np.zeros(1), 0, np.arange(2), *sides, *given, none.copy(), push, np.stack([place, place]))
            forces.append(push[0])
            shears.append(-push[0, 0])
        return np.array(shears), np.array(forces)


def test_slip_is_kept_in_every_cycle():
    """Half the way there and half of it back: a contact that slipped 0.3 m unloads from its strength at once."""
    contact = DrivenContact(pressure=5.0, strength=2.0)
    shears, _ = contact.drive((0.1, 0.0), (0.4, 0.0), (-0.1, 0.0), (-0.4, 0.0))
    assert_allclose(np.abs(shears), [1.0, 2.0, 1.0, 2.0], rtol=1e-6)
    assert_allclose(np.sign(shears), np.sign(shears[0]) * np.array([1, 1, 1, -1]))


def test_contacts_that_slipped_at_any_time_are_known():
    """It slips in the second cycle, and sticks in the last."""
    contact = DrivenContact(pressure=5.0, strength=2.0)
    contact.drive((0.1, 0.0))
    assert not contact.slipped.any()
    contact.drive((0.4, 0.0), (-0.1, 0.0))
    assert contact.slipped.all()


def test_a_contact_pushes_as_far_as_it_is_closed_and_pulls_until_it_breaks():
    contact = DrivenContact(pressure=1.0, strength=0.0, tension=2.0)
    _, forces = contact.drive((0.0, 0.2), (0.0, 0.2), (0.0, -0.15), (0.0, -0.35))
    assert_allclose(forces[:, 1], [-2.0, -1.0, -1.0, 1.0], atol=1e-6)  # of 1 N/m at first: -1, gone, gone, 2


def test_contacts_closed_at_any_time_are_known():
    """It opens in the second cycle; the other never closes."""
    contact = DrivenContact(pressure=1.0, strength=0.0)
    contact.drive((0.0, 0.05), (0.0, 0.5))
    assert contact.contacted.all()
    contact.contacted[:] = False
    contact.drive((0.0, 0.1))
    assert not contact.contacted.any()


@pytest.mark.parametrize("tilt", [20.0, 40.0])
def test_it_does_not_matter_how_many_cycles_go_by_at_once(tilt):
    """A block that swings about its rest, and one that slides: springs that forgot a cycle would let both go on."""
    ways = {}
    for at_once in (1, 5, 100):
        motion, ways[at_once] = DampedMotion(begun(block_on_a_base(tilt)), 300, 0.1), []
        while motion.done < 600:
            motion.advance(at_once)
            if motion.done % 100 == 0:
                ways[at_once].append(motion.residual.position[1, 0])
    for at_once in (1, 5):
        assert_allclose(ways[at_once], ways[100], atol=2e-3 * max(ways[100]))
