"""Corner on corner: which opposing candidate is closed, against the least penetration of convex polygons."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from bsm_mesh.contact.contact_set import gather_contacts
from bsm_mesh.contact.history import History, commit
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import corner_positions
from bsm_mesh.solve.step.block_system import BlockSystem
from tests.scenes.contacts import Scene
from tests.scenes.models import model_of
from tests.scenes.shapes import grid, rectangle, square, turned

angles = st.floats(30.0, 140.0)
turns = st.floats(-25.0, 25.0)
shifts = st.floats(-0.03, 0.03)


def ways_out(p, q):
    """Return how deep two convex polygons are in each other along every way out, and that way for q, a unit vector.

    Both stay apart along the outward normal of an edge of one of them, or they overlap (separating axes).
    """
    ways = []
    for one, other, sign in ((p, q, 1.0), (q, p, -1.0)):
        for start, end in zip(one, np.roll(one, -1, axis=0), strict=True):
            tangential = (end - start) / np.hypot(*(end - start))
            normal = np.array([tangential[1], -tangential[0]])
            ways.append((-((other - start) @ normal).min(), sign * normal))
    return ways


def wedge(angle, turn, up):
    """Return a triangle with its tip of `angle` at the origin, pointing down or up."""
    half = np.radians(angle / 2)
    tip = np.array([(0.0, 0.0), (np.sin(half), np.cos(half)), (-np.sin(half), np.cos(half))])
    return turned(tip, turn + (180.0 if up else 0.0))


def force_on_upper(lower, upper, shift, first=True):
    """Return the contact force on the upper block, moved by `shift` in one step, and the contacts of the step."""
    moving = BlockSystem(model_of([lower, upper], kn=1.0, friction=0.0))
    contacts = moving.gather(History.none(), moving.start, first=first)
    position = moving.start.copy()
    position[1, :2] += shift
    return moving.evaluate(contacts, position).forces[1, :2], contacts


@pytest.mark.slow
@settings(max_examples=200, deadline=None, derandomize=True)
@given(angles, angles, turns, turns, shifts, st.floats(0.0, 0.03), st.floats(1e-3, 0.03))
def test_the_nearer_way_out_bears(below, above, turn, other_turn, aside, apart, pressed):
    """Two tips, above each other or a little aside, pressed into each other in one step; no edges nearly parallel."""
    edges = [[turn + below / 2, turn - below / 2], [other_turn + above / 2, other_turn - above / 2]]
    assume(min(abs(p - q) for p in edges[0] for q in edges[1]) > 7.0)
    lower, upper = wedge(below, turn, up=True), wedge(above, other_turn, up=False) + np.array([aside, apart])
    apart_before = [depth <= 0.0 for depth, _ in ways_out(lower, upper)]
    assume(any(apart_before))
    shift = np.array([0.0, -apart - pressed])
    force, contacts = force_on_upper(lower, upper, shift)
    ways = ways_out(lower, upper + shift)
    depth = min(deep for deep, _ in ways)
    assume(abs(depth) > 1e-9)
    if depth < 0:
        assert_allclose(force, 0.0, atol=1e-12)
        return
    soonest = [deep < 1.2 * depth + 1e-9 for deep, _ in ways]  # about; or the way that they have come
    directions = [way for (_, way), soon, came in zip(ways, soonest, apart_before, strict=True) if soon or came]
    direction = max(directions, key=lambda normal: force @ normal)
    aside_of_it = abs(force @ (-direction[1], direction[0]))
    assert aside_of_it <= RULES.parallel * np.hypot(*force), "no other edge carries, but one within 6 degrees"
    assert force @ direction <= 2 * depth * contacts.normal_stiffness.max() * (1 + 1e-9)
    if depth > 1e-2:
        assert force @ direction > 0.0


@pytest.mark.parametrize(("left", "down"), [(0.02, 0.008), (0.008, 0.02)])
def test_squares_that_meet_in_a_corner_carry_on_one_side(left, down):
    """Both ways out have parallel edges that only meet end to end: neither overlaps enough when pressed in."""
    force, contacts = force_on_upper(square(0, 0), square(1, 1), (-left, -down))
    assert not contacts.within_tolerance.any(), "at the start they carry nothing"
    expected = (0, 1) if down < left else (1, 0)
    assert_allclose(force / np.hypot(*force), expected, atol=1e-12)
    shallow, _ = force_on_upper(square(0, 0), square(1, 1), (-0.9 * RULES.min_overlap, -0.5))
    assert_allclose(shallow, 0.0, atol=0.0)


def test_rivals_name_each_other_and_stand_on_different_sides():
    scene = Scene.of(grid(2, 2))
    for pair in ((0, 3), (1, 2)):
        found = scene.detect()
        rows = np.flatnonzero(found.pair == (pair[0] << 32 | pair[1]))
        assert len(rows) == 2
        assert found.opposing_candidate[rows].tolist() == rows[::-1].tolist()
        assert abs(np.prod(scene.normals(found.edge[rows]).sum(axis=0))) == pytest.approx(1.0)
        assert_allclose(found.corner_gap[rows], RULES.min_overlap)
    faces = found.parallel_edge >= 0
    assert (found.opposing_candidate[faces & (found.corner_gap == 0)] == -1).all(), "faces have one way out"


def test_a_notch_has_no_rivals():
    notched = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)])
    scene = Scene.of([notched, rectangle(1, 1, 2, 2)]).moved(1, (0.02, 0.02))
    found = scene.detect()
    assert found.count > 0
    assert (found.opposing_candidate == -1).all()


def toe_at_a_step(x, step, rules=RULES):
    """Return what a block with a sloping front finds at the next block, which stands out by `step`."""
    toe = np.array([(-1, 0), (0, 0), (-0.7, 1), (-1, 1)])
    scene = Scene.of([rectangle(-3, -1, 0, 0), rectangle(0, -1, 3, step), toe], fixed=[0, 1]).moved(2, (x, 0.0))
    found = scene.detect(rules=rules)
    mine = (found.block_a == 2) & (found.block_b == 1) | (found.block_a == 1) & (found.block_b == 2)
    return found, mine, scene.normals(found.edge)


@pytest.mark.parametrize("x", [0.0, -0.01])
def test_the_front_of_a_low_step_lets_the_toe_in_whatever_its_slope(x):
    found, mine, normals = toe_at_a_step(x, 1e-3)
    front = mine & (np.abs(normals[:, 0]) > 0.5)
    assert front.sum() == 1
    assert found.corner_gap[front] == pytest.approx(RULES.min_overlap * np.sqrt(0.65))
    assert found.opposing_candidate[front] >= 0
    found, mine, normals = toe_at_a_step(x, 0.02)
    assert (found.corner_gap[mine & (np.abs(normals[:, 0]) > 0.5)] == 0).all(), "a real step"


def test_a_face_that_slides_on_may_penetrate_at_first_at_the_end_only():
    def rows(x, depth, rules=RULES):
        scene = Scene.of([square(0, 0), square(-1.5, 1)], fixed=[0]).moved(1, (0.5 + x, -depth))
        return scene.detect(rules=rules).count

    assert rows(0.03, 4e-3) > 0
    assert rows(0.03, 4e-3, RULES._replace(initial_penetration=1e-3)) == 0
    assert rows(0.3, 4e-3) == 0, "deep inside a face nothing may start"


@pytest.mark.parametrize("degrees", [2.0, 6.0, 10.0])
def test_an_open_corner_may_turn_onto_an_edge(degrees):
    """A slab that is on one corner falls on the next within a step."""
    slab = turned(rectangle(0, 0, 0.4, 0.2), degrees)
    scene = Scene.of([rectangle(-3, -1, 3, 0), slab, square(5, 0)])
    found = scene.detect(band=0.15)
    assert (found.block_a == 1).sum() == 2
    off = scene.detect(band=0.15, rules=RULES._replace(turn=0.0))
    assert (off.block_a == 1).sum() == (2 if degrees < 3 else 1)


@pytest.mark.parametrize(("sine", "corners"), [(0.1, 1), (RULES.entrance + 1e-3, 1), (RULES.entrance - 1e-3, 2)])
def test_a_corner_with_an_edge_into_the_other_block_closes_once_it_has_turned(sine, corners):
    """A slab aslant, pressed in deeper than its second corner is high, is on the first until its edge is level."""
    slab = turned(rectangle(0, 0, 0.4, 0.2), 6.0)
    moving = BlockSystem(model_of([rectangle(-3, -1, 3, 0), slab, square(5, 0)]))
    given = moving.model, moving.outlines, moving.catalogue, History.none(), moving.start
    contacts = gather_contacts(*given, 0.15, first=True)
    position = moving.start.copy()
    position[1] += (0.0, -0.05, np.arcsin(sine) - np.radians(6.0))
    assert (corner_positions(moving.outlines, moving.outlines.placed(position))[4:6, 1] < 0).all()
    assert moving.evaluate(contacts, position).closed.sum() == corners


def test_blocks_on_both_sides_of_a_wedge_that_has_gone_are_a_face():
    """They met in its tip without force; closed on each other they have one."""
    lower, upper = np.array([(0, 0), (3, -1), (3, 0)]), np.array([(0, 0), (3, 0.3), (2, 2)])
    scene = Scene.of([lower, np.array([(0, 0), (3, 0), (3, 0.3)]), upper])
    closed = scene.moved(1, (9, 0)).moved(2, degrees=-np.degrees(np.arctan2(0.3, 3)), about=(0, 0))
    found = closed.detect()
    assert len(closed.within_tolerance(found)) == 2
    assert (found.corner_gap[closed.within_tolerance(found)] == 0).all()
    assert len(scene.moved(1, (9, 0)).within_tolerance(scene.moved(1, (9, 0)).detect())) == 0


def test_the_initial_penetration_of_a_contact_is_remembered_until_it_has_come_out():
    """Forgotten in a step in which it carries nothing, it was too deep to start anew: the block fell through."""
    moving = BlockSystem(model_of([square(0, 0), square(-1.5, 1)], friction=0.0))
    pressed, eased, out = (moving.start + np.array([(0, 0, 0), (0.53, -y, 0)]) for y in (4e-3, 1.5e-3, -1e-3))

    def taken(history, position):
        contacts = moving.gather(history, position, first=False)
        return commit(contacts, moving.evaluate(contacts, position), position, moving.outlines.size)[0]

    first = taken(History.none(), pressed)
    assert_allclose(first.offset, -3e-3)
    second = taken(first, eased)
    assert second.active.key.tolist() == first.active.key.tolist()
    assert_allclose(second.offset, -1.5e-3, err_msg="what it has come out it is not let in again")
    assert len(taken(first, out).offset) == 0


@pytest.mark.slow
def test_beside_a_closed_contact_its_opposing_one_does_not_close():
    """Of both the next search would keep one: steps flipped between the two for ever."""
    rng, beside = np.random.default_rng(3), 0
    for _ in range(300):
        lower, upper = (wedge(rng.uniform(60, 120), rng.uniform(-25, 25), up=up) for up in (True, False))
        moving = BlockSystem(model_of([lower, upper + np.array([rng.uniform(-0.02, 0.02), 0.005])], friction=0.0))

        def moved(size, start, rng=rng):
            return start + np.array([(0.0, 0.0, 0.0), (*rng.uniform(-size, size, 2), rng.uniform(-0.05, 0.05))])

        first = moving.gather(History.none(), moving.start, first=False)
        position = moved(0.01, moving.start - np.array([(0, 0, 0), (0, 0.01, 0)]))
        history, _ = commit(first, moving.evaluate(first, position), position, moving.outlines.size)
        contacts = moving.gather(history, position, first=False)
        other = contacts.candidates.opposing_candidate[contacts.opposing]
        carries = contacts.candidates.history[other] >= 0
        for _ in range(20):
            closed = moving.evaluate(contacts, moved(0.01, position)).closed
            assert not (closed[contacts.opposing] & closed[other])[carries].any()
            beside += int(closed[other][carries].sum())
    assert beside > 100, "or nothing was tried"
