"""Polyhedra that have passed into each other: the volume by closed forms, the check of a stage, faces passed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.movements import turned
from bsm_mesh.three_d.contacts.history import PointHistory
from bsm_mesh.three_d.overlap import overlap_faults, unexplained_overlap
from bsm_mesh.three_d.record import notes_on_passed
from bsm_mesh.three_d.step.block_system import BlockSystem
from tests.scenes.polyhedra import box, model_in_space

TABLE, CUBE = box((-2, -2, -1), (2, 2, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 1))


def overlap_of(solids, movement, opening=(), area=()):
    """Return the overlap of moved solids with contacts of the last two, in m3."""
    blocks = bsm.Polyhedra.from_solids(solids, rock="granite", joint="J1")
    count = blocks.count
    a, b = (np.full(len(opening), k) for k in (0, 1))
    stage = SimpleNamespace(
        origin=np.zeros((count, 6)),
        displacement=np.asarray(movement, float),
        present=np.ones(count, dtype=bool),
        contacts=SimpleNamespace(block_a=a, block_b=b, opening=np.array(opening), length=np.array(area)),
    )
    return unexplained_overlap(blocks, stage) * float(np.median(blocks.moments.volume))


@pytest.mark.parametrize(("depth", "turn"), [(0.02, 0.0), (0.02, 0.3), (0.3, 1.0), (0.0005, 0.0), (-0.01, 0.0)])
def test_a_cube_sunk_into_a_table(depth, turn):
    """Its area times the depth; less than a thousandth of its size is contact."""
    found = overlap_of([TABLE, CUBE], [np.zeros(6), (0.3, 0, -depth, 0, 0, turn)])
    assert_allclose(found, depth if depth > 1e-3 else 0, rtol=1e-9)


def test_an_edge_that_cuts_into_a_table():
    """A cube turned by 45 degrees about y, its edge 0.1 m deep: a prism of area 0.1 squared."""
    lift = np.sqrt(0.5) - 0.5 - 0.1
    assert_allclose(overlap_of([TABLE, CUBE], [np.zeros(6), (0, 0, lift, 0, np.pi / 4, 0)]), 0.01, rtol=1e-9)


def test_the_closure_of_contacts_explains_it():
    moved = [np.zeros(6), (0, 0, -0.02, 0, 0, 0)]
    assert_allclose(overlap_of([TABLE, CUBE], moved, (-0.015,), (1.0,)), 0.005, rtol=1e-9)
    assert overlap_of([TABLE, CUBE], moved, (-0.02, 0.1), (1.0, 1.0)) < 1e-12


def test_crossed_edges_apart_share_nothing():
    """Two cubes edge over edge, crosswise: no face of either separates them, and there is a gap of 0.05 m."""
    up = 2 * np.sqrt(0.5) + 0.05
    middle = [box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), box((-0.5, -0.5, -0.5 + 3), (0.5, 0.5, 0.5 + 3))]
    moved = [(0, 0, 0, 0, np.pi / 4, 0), (0, 0, up - 3, np.pi / 4, 0, 0)]
    assert overlap_of(middle, moved) == 0
    moved[1] = (0, 0, up - 0.15 - 3, np.pi / 4, 0, 0)
    assert_allclose(overlap_of(middle, moved), 0.1**3 * 2 / 3, rtol=1e-9)


def test_blocks_that_move_together_do_not_overlap():
    lower, upper = box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))
    turn = np.array([0.3, -0.2, 0.5])
    up = turned(np.array([[0, 0, 1.0]]), turn[None])[0] - (0, 0, 1)
    assert overlap_of([lower, upper], [(1, 2, 3, *turn), (*(np.array([1, 2, 3]) + up), *turn)]) == 0


def test_a_stage_whose_blocks_overlap_is_not_at_rest():
    """A cube at rest on a table, moved 0.02 m into it: the check says so in words."""
    model = model_in_space([TABLE, CUBE], friction=30, fixed=[0])
    results = bsm.run(model, bsm.Options(threads=1))
    assert results.check().ok
    assert results.check().overlap == 0
    (stage,) = results.stages
    sunk = stage.displacement - np.array([[0] * 6, [0, 0, 0.02, 0, 0, 0]])
    faults = replace(results, stages=(replace(stage, displacement=sunk),)).check().faults
    assert any("blocks have passed into each other by 0.0024 of a block's volume" in fault for fault in faults)


def test_stones_that_overlap_as_given_are_refused():
    """A cube 0.1 m deep in one below it would find no contact and fall through it."""
    sunk = box((-0.2, -0.5, 0.9), (0.8, 0.5, 1.9))
    fault = "blocks 1 and 2 overlap by 0.07 m3 near \\(0.15, 0, 0.95\\); remove one of them or make their faces meet"
    with pytest.raises(bsm.ModelError, match=fault):
        bsm.run(model_in_space([TABLE, CUBE, sunk], friction=30, fixed=[0]))


@pytest.mark.parametrize("origin", [(0, 0, 0), (5e5, 4.2e6, 300)])
@pytest.mark.parametrize("depth", [0.5e-3, 0, -0.1])
def test_stones_that_touch_do_not_overlap(depth, origin):
    """Side by side, on a part of a face, over a gap, or closer by less than a thousandth of their size."""
    solids = [TABLE, CUBE, box((0.5, -0.5, 0), (1.5, 0.5, 1)), box((0.1, 0.2, 1 - depth), (1.1, 1.2, 2 - depth))]
    placed = [(np.add(corners, origin), faces) for corners, faces in solids]
    assert overlap_faults(bsm.Polyhedra.from_solids(placed, rock="granite", joint="J1")) == ()


@pytest.mark.heavy
def test_a_stone_on_a_part_of_a_face_is_borne():
    """A cube on a table of 4 x 4 m, whose top is no face of the cube, rests as on one of its own.

    Pushed, it is proved to move.
    """
    stage = bsm.run(model_in_space([TABLE, CUBE], friction=30, fixed=[0]), bsm.Options(threads=1)).stages[0]
    assert stage.status == "stable"
    assert_allclose(stage.displacement[1, 2], -26e3 / 1e9, rtol=1e-6)
    pushed = model_in_space([TABLE, CUBE], friction=30, fixed=[0], gravity_horizontal=0.6)
    stage = bsm.run(pushed, bsm.Options(threads=1)).stages[0]
    assert stage.status == "unstable"
    assert "must move" in stage.proof.text


@pytest.mark.parametrize(("depth", "passed"), [(0.05, True), (0.005, False)])
def test_faces_that_pass_each_other_are_told(depth, passed):
    """A cube 1 m over a table comes to lie in it within one step; to a hundredth of its size contact is found."""
    system = BlockSystem(model_in_space([TABLE, box((-0.5, -0.5, 1), (0.5, 0.5, 2))], fixed=[0]))
    position = np.zeros((2, 6))
    position[1, 2] = -1 - depth
    contacts = system.gather(PointHistory.none(), position, first=False)
    pairs, deep = system.passed_faces(contacts, position)
    assert pairs.tolist() == [[0, 1]] * passed
    assert contacts.count == (0 if passed else 5)
    said = notes_on_passed(system.centroid[pairs], deep)
    assert len(said) == passed
    if passed:
        assert_allclose(deep, depth)
        assert (
            "faces of 1 pair of blocks have passed each other without contact, by up to 0.05 m "
            "(the blocks at (0, 0, -0.5) and (0, 0, 1.5) m)" in said[0]
        )
