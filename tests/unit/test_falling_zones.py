"""Blocks with zones that fall: taken away as rigid ones are, chips that do not count, and a limit of displacement."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh import solving
from bsm_mesh.solve.zones import following, zone_kernels
from tests.scenes.kinked_plane import KinkedPlane
from tests.scenes.large_zones import pushed
from tests.scenes.meeting_zones import beside, meeting
from tests.scenes.shaken_zones import unwatched
from tests.scenes.shapes import rectangle

FLOOR, ON_IT = rectangle(-1, -1, 3, 0), rectangle(0, 0, 1, 1)
REMOVE = bsm.Options(falls=bsm.Falls(on_fall="remove"))


@pytest.mark.parametrize("displacement", [pytest.param("large", marks=pytest.mark.heavy), "small"])
def test_blocks_that_fall_are_taken_away_and_the_others_go_on(displacement):
    model = beside(displacement=displacement)
    results = bsm.run(model)
    assert (results.status, list(results.stages[0].unstable_blocks)) == ("unstable", [2])
    results = bsm.run(model, REMOVE)
    stage = results.stages[0]
    assert results.status == "stable_after_falls", stage.reason
    assert [fall.block for fall in stage.falls] == [2]
    assert list(stage.present) == [True, True, False]
    assert_allclose(stage.reactions.sum(axis=0)[1], 25e3 * (4 + 1), rtol=1e-6)
    assert results.check().ok


@pytest.mark.parametrize("displacement", [pytest.param("large", marks=pytest.mark.heavy), "small"])
def test_a_chip_that_falls_does_not_count(displacement):
    results = bsm.run(beside(0.05, displacement=displacement))
    stage = results.stages[0]
    assert results.status == "stable", stage.reason
    assert list(stage.present) == [True, True, False]
    assert any("too small to count" in note for note in stage.notes)
    everything = bsm.Options(falls=bsm.Falls(ignore_below=0.0))
    assert bsm.run(beside(0.05, displacement=displacement), everything).status == "unstable"


def test_a_block_taken_away_is_gone_in_later_stages():
    load = bsm.PointLoad(block=1, point=(0.5, 1.0), force=(0.0, -1e3))
    results = bsm.run(beside(stages=[bsm.Stage(name="later", loads=[load])]), REMOVE)
    assert [stage.status for stage in results.stages] == ["stable_after_falls", "stable"]
    last = results.stages[-1]
    assert list(last.present) == [True, True, False]
    assert_allclose(last.reactions.sum(axis=0)[1], 25e3 * 5 + 1e3, rtol=1e-6)


def test_all_that_may_move_can_fall():
    model = meeting([FLOOR, rectangle(4, 0, 5, 1)], young=1e10)
    stage = bsm.run(model, REMOVE).stages[0]
    assert stage.status == "stable_after_falls"
    assert list(stage.present) == [True, False]


@pytest.mark.parametrize("gap", [0.02, pytest.param(0.09, marks=pytest.mark.heavy)])
def test_a_displacement_limit_is_kept_as_by_rigid_blocks(gap):
    """The block falls by the gap onto the floor."""
    model = meeting([FLOOR, rectangle(0.2, gap, 1.2, 1 + gap)], young=1e10)
    for limit, status in ((0.9 * gap, "unstable"), (1.1 * gap, "stable")):
        stage = bsm.run(model, bsm.Options(displacement_limit=limit)).stages[0]
        assert stage.status == status, stage.reason
        assert status == "stable" or stage.reason == f"a block moved more than {limit:.3g} m"


def test_a_limit_that_small_movements_reach():
    """Springs yield by the weight over their stiffness, in one step of Newton's method."""
    model = meeting([FLOOR, ON_IT], young=1e13, kn=1e6)
    for limit, status in ((0.024, "unstable"), (0.026, "stable")):
        assert bsm.run(model, bsm.Options(displacement_limit=limit)).status == status


@pytest.mark.heavy
def test_a_block_that_slides_on_is_followed_up_to_the_limit(monkeypatch):
    """Gravity pulls it along the floor with more than its friction. Progress of the motion is reported."""
    monkeypatch.setattr(solving, "SILENCE", 0.0)
    model, said = meeting([FLOOR, ON_IT], young=1e10, friction=20.0, gravity_horizontal=0.5), []
    stage = bsm.run(model, bsm.Options(displacement_limit=0.3), report=said.append).stages[0]
    far = [float(text.split()[5]) for text in said if text.startswith("blocks move: by up to ")]
    assert 0 < far[0] < far[len(far) // 2] < 0.3 < far[-1]
    assert (stage.status, stage.reason) == ("unstable", "a block moved more than 0.3 m")
    assert 0.3 < np.abs(stage.displacement[1, 0]) < 0.5


def test_the_search_for_equilibrium_is_reported(monkeypatch):
    monkeypatch.setattr(solving, "SILENCE", 0.0)
    said: list[str] = []
    assert bsm.run(meeting([FLOOR, ON_IT], young=1e10), report=said.append).status == "stable"
    left = [float(text.split()[4]) for text in said if text.startswith("correction ")]
    assert left
    assert left[-1] < 1e-6


def test_blocks_without_equilibrium_are_where_they_were_last_at_rest():
    """Rock without mass is not followed. A load pushes the block over its friction; an iteration took it 0.6 m away."""
    load = bsm.PointLoad(block=1, point=(0.5, 0.5), force=(2e4, -2e4))
    model = meeting([FLOOR, ON_IT], young=1e10, loads=[load])
    light = model.replace(rocks=[dataclasses.replace(rock, unit_weight=0.0) for rock in model.rocks])
    stage = bsm.run(light).stages[0]
    assert stage.status == "not_converged"
    assert not stage.displacement.any()


def test_what_moved_before_it_came_to_rest_is_said():
    """Limit analysis finds no equilibrium above a gap; and walls are crushed under the block."""
    model = meeting([FLOOR, rectangle(0.2, 0.02, 1.2, 1.02)], young=1e10)
    weak = [bsm.Joint("J", 1e9, 5e8, law=bsm.MohrCoulomb(friction=35.0), crushing_strength=1e4)]
    notes = " ".join(bsm.run(model.replace(joints=weak)).stages[0].notes)
    assert "block 1 cannot be at rest where given; before rest came a movement of up to 0.02 m" in notes
    assert "crushing_strength = 10000 Pa" in notes


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("by", [0.302, 0.306, pytest.param(0.31, marks=pytest.mark.heavy)])
def test_the_corner_of_a_joint_below_holds_no_block_that_slides_over_it(by, order):
    """Two blocks of the base share the load by friction alone, whatever their corners rise."""
    results = bsm.run(pushed(by, order=order, base=(0.0, 2.3, 4.0)))
    contacts = results.stages[0].contacts
    mine = contacts.block_a == 2
    forces = np.where(mine, 1, -1)[:, None] * contacts.force
    on = mine | (contacts.block_b == 2)
    assert_allclose(forces[on].sum(axis=0), (14433.0, -25e3), rtol=1e-3)


def in_motion(model):
    """Return the blocks of a model in motion to rest, where they were given."""
    run = unwatched(model)._run
    present = run.of.presence[0]
    return run.of, following._in_motion(run, run.equations(present, run.loads_on(present)), present)


def test_a_block_that_bounces_is_held_though_it_is_open_at_the_last_look():
    of, motion = in_motion(meeting([FLOOR, rectangle(0, 0.1, 1, 1.1)], young=1e10))
    assert list(following._held(of, motion)) == [True, False]
    motion.touched = np.array([[1, 0]], dtype=np.int32)
    assert list(following._held(of, motion)) == [True, True]


def test_points_that_close_and_open_between_two_looks_are_remembered():
    """The block falls by 2 mm, and stiff rock rebounds."""
    _, motion = in_motion(meeting([FLOOR, rectangle(0, 2e-3, 1, 1.002)], young=1e10))
    motion.go_on(0.01)
    assert not len(motion.touched)
    motion.go_on(0.04)
    assert [1, 0] in np.sort(motion.touched, axis=1)[:, ::-1].tolist()


def test_forces_by_which_rock_vibrates_do_not_drag_a_block_that_slides():
    """Two nodes of a piece, the second one three times as heavy, under opposite forces; another without a piece."""
    velocity, forces, room = np.ones((3, 3)), np.zeros((3, 3)), np.zeros((1, 5))
    forces[:, 0] = 6.0, -6.0, 6.0
    inverse = np.repeat([[1.0], [1 / 3], [1.0]], 3, axis=1)
    damping = (0.5, 0.5, np.array([0, 0, -1], dtype=np.int32), room)
    zone_kernels._damp(damping, inverse, velocity, np.zeros((3, 3)), forces)
    assert_allclose(forces[:2, 0].sum(), 0.0, atol=1e-12)
    assert_allclose(forces[2, 0], 3.0)
    forces[:, 0] = 2.0, 6.0, 0.0  # of a motion as a whole
    zone_kernels._damp(damping, inverse, velocity, np.zeros((3, 3)), forces)
    assert_allclose(forces[:, 0], (1.0, 3.0, 0.0))


def test_vibrations_of_rock_are_damped_where_a_piece_of_it_is_hardly():
    """Two nodes of a piece: they vibrate against each other, and slide together."""
    velocity, forces, inverse = np.zeros((2, 3)), np.zeros((2, 3)), np.ones((2, 3))
    velocity[:, 0], velocity[:, 1] = (1.0, -1.0), 1.0
    forces[:, 0], forces[:, 1] = (6.0, -6.0), 10.0
    damping = (0.02, 0.5, np.zeros(2, dtype=np.int32), np.zeros((1, 5)))
    zone_kernels._damp(damping, inverse, velocity, np.zeros((2, 3)), forces)
    assert_allclose(forces[:, 0], (3.0, -3.0))
    assert_allclose(forces[:, 1], 9.8)


def test_masses_of_held_ground_do_not_decide_how_fast_a_block_moves():
    """Large zones of the ground allow a long time step. The block on it was 950 times as heavy as it is."""
    _, motion = in_motion(meeting([rectangle(-40, -40, 40, 0), ON_IT], young=1e10, size=60.0))
    rock = motion._rock
    assert_allclose(rock.mass[rock.moves].sum(), 25e3 / 9.81, rtol=0.05)


@pytest.mark.slow
def test_a_slab_slides_over_a_kink_between_loose_blocks():
    """Its rear hits the plane below the kink. Rock vibrates then."""
    model = KinkedPlane.drawn(4, loose=True, bare=False).model()
    zones = bsm.Zones(size=8.0, order=1, displacement="large")
    results = bsm.run(model.replace(rocks=[dataclasses.replace(model.rocks[0], zones=zones)]))
    assert results.status == "unstable", results.stages[0].reason


@pytest.mark.heavy
def test_sizes_of_the_ground_do_not_count_where_a_block_falls():
    """It falls freely from the edge of ground of 20 m: by a tenth of its own size until it is unstable."""
    model = meeting([rectangle(-20, -20, 0, 0), rectangle(0.1, -1, 1.1, 0)], young=1e10)
    stage = bsm.run(model).stages[0]
    assert stage.status == "unstable"
    assert list(stage.unstable_blocks) == [1]
    assert 0.1 < -stage.displacement[1, 1] < 0.5
