"""Contact rules: the wrong answer that each one corrects.

Every test of a rule is made twice, with the rule and with the rule switched off by its tolerance: without the rule
the wrong answer comes out.
"""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.faces import find_faces
from tests.scenes.contacts import Scene, column, delaunay_triangles, jagged_interface
from tests.scenes.shapes import grid, rectangle, square, turned


def test_one_contact_where_two_corners_meet_not_two():
    scene = column()
    assert len(scene.within_tolerance(scene.detect())) == 2
    assert len(scene.within_tolerance(scene.detect(rules=RULES._replace(dual_distance=0.0)))) == 4


@pytest.mark.parametrize("shift", [-0.01, 0.01])
@pytest.mark.parametrize("polygons", [[square(0, 0), square(0, 1)], [square(0, 1), square(0, 0)]])
def test_of_two_new_duals_the_closed_one_is_kept(polygons, shift):
    scene = Scene.of(polygons).moved(1, (shift, 0.0))
    found = scene.detect()
    assert found.count == 2
    assert len(scene.within_tolerance(found)) == 2


def test_parallel_edges_without_overlap_do_not_support():
    """Seen: a slope that was stable at phi = 5, held by blocks that only met end to end."""
    start = Scene.of(grid(2, 2))

    def diagonal(rules, shift=-1.0):  # the upper row moved on by a whole block: other corners meet
        moved = start.moved(2, (shift, 0.0)).moved(3, (shift, 0.0))
        found = moved.detect(rules=rules)
        pairs = {(int(p) >> 32, int(p) & 0xFFFFFFFF) for p in found.pair[moved.within_tolerance(found)]}
        assert (0, 3) in pairs
        return pairs - {(0, 1), (2, 3), (0, 3)}

    assert diagonal(RULES) == set()
    assert diagonal(RULES._replace(min_overlap=0.0)) == {(0, 2), (1, 3)}
    assert diagonal(RULES, -0.996) == set()
    assert diagonal(RULES, -0.994) == {(0, 2), (1, 3)}, "a real overlap"


def slide(step, rules, penetration=1e-4):
    """Slide a block over the joint of two others; return the steepest normal that will stop it, and the least support.

    The second block stands out by `step`; the moved block sinks in by `penetration`, as elastic blocks do.
    """
    start = Scene.of([rectangle(-4, -1, 0, 0), rectangle(0, -1, 4, step), rectangle(-2, 0, -0.005, 1)], fixed=[0, 1])
    active, steepest, support, pace = start.activated(start.detect()), 0.0, 2, 0.0007
    for x in np.arange(0.0, 0.1, pace):
        scene = start.moved(2, (x, -penetration))
        found = scene.detect(active, rules=rules)
        rows = np.flatnonzero(found.in_range & (found.gap < pace))  # those that close before the next place
        sign = np.where(found.block_a[rows] == 2, 1.0, -1.0)[:, None]
        normals = sign * scene.normals(found.edge[rows])
        closed = found.gap[rows] < -1e-9
        steepest = max(steepest, np.abs(normals[:, 0]).max(initial=0.0))
        support = min(support, int((normals[closed, 1] > 0.99).sum()))
        active = scene.activated(found, rows[closed])
    return steepest, support


@pytest.mark.heavy
def test_a_block_does_not_snag_at_a_flush_joint_but_at_a_step():
    """Seen: falsely stable at x = 0.5008 of 2.5."""
    steepest, support = slide(0.0, RULES)
    assert steepest < 1e-6
    assert support >= 2
    assert slide(0.0, RULES._replace(min_overlap=0.0))[0] > 0.99
    assert slide(0.0, RULES, penetration=8e-4)[0] < 1e-6
    assert slide(0.03, RULES)[0] > 0.99, "0.02 of the median size, 1.5 m"
    assert slide(0.03, RULES._replace(min_overlap=0.05))[0] < 1e-6


@pytest.mark.parametrize("aside", [-2e-3, -1e-4, 1e-4, 2e-3])
@pytest.mark.parametrize("degrees", [2.0, 4.0, 5.5])
def test_a_heel_bears_beside_a_node_of_the_floor(degrees, aside):
    """Seen: a column that tips about a corner beside a node of the floor sinks through it."""
    floor = np.array([(-5, -1), (5, -1), (5, 0), (0, 0), (-5, 0)], float)
    start = Scene.of([floor, rectangle(-1, 0, 0, 4)])
    tipped = start.moved(1, (aside, -1e-5), degrees=-degrees, about=(0.0, 0.0))
    found = tipped.detect()
    rows = tipped.within_tolerance(found)
    closes = rows[found.in_range[rows] & (found.corner_gap[rows] == 0.0)]
    heel = [k for k in closes if np.hypot(*(tipped.placed[found.corner[k]] - (aside, 0))) < 0.01]
    assert heel, "nothing holds the heel"


def test_the_face_of_a_small_block_counts_as_overlap():
    """A whole edge is shared, however short: the rule must not take the support from under it."""
    for side in (0.004, 0.02):
        scene = Scene.of([rectangle(-3, -2, 0, 0), rectangle(-side, 0, 0, side), square(5, 0)])
        assert len(scene.within_tolerance(scene.detect())) == 2
    scene = Scene.of([*delaunay_triangles(np.random.default_rng(0), 10), square(9, 9)])
    assert len(scene.within_tolerance(scene.detect())) == 2 * len(find_faces(scene.blocks).edge_a)


def test_a_hinge_stays_at_an_edges_end():
    """Only parallel contacts need an overlap: a block that leans on its corner at the end of an edge is held there."""
    start = Scene.of([square(0, 0), square(1, 0)])  # they open about the upper ends of the face, (1, 1)
    hinge = start.moved(1, degrees=20.0, about=(1.0, 1.0)).moved(0, degrees=-15.0, about=(1.0, 1.0))
    first = start.detect()
    rows = start.within_tolerance(first)
    at_top = rows[start.placed[first.corner[rows], 1] > 0.9]
    active = start.activated(first, at_top)
    found = hinge.detect(active)
    assert len(hinge.within_tolerance(found)) == 1
    assert (found.history >= 0).sum() == 1
    arms = np.radians([15, 75])
    tip = turned([(0, 0), *zip(np.cos(arms), np.sin(arms), strict=True)], 0, (1, 1))
    on_the_end = Scene.of([square(0, 0), tip])  # it shares no length with the top, nor with the right side
    assert len(on_the_end.within_tolerance(on_the_end.detect())) == 1
    off = RULES._replace(parallel=2.0)  # now every edge is parallel to every other
    assert len(on_the_end.within_tolerance(on_the_end.detect(rules=off))) == 0


def test_a_corner_within_a_corner_is_closed_on_one_edge_only():
    """A sharp corner is a little within the upper right corner of a square, nearer to its right side."""
    arms = np.radians([20, 70])
    sharp = turned([(0, 0), *zip(np.cos(arms), np.sin(arms), strict=True)], 0, (3, 3))
    scene = Scene.of([sharp, square(0, 0)]).moved(0, (-2 - 4e-4, -2 - 5e-4))

    def normals(active=None, **off):
        found = scene.detect(active, rules=RULES._replace(**off))
        rows = [r for r in scene.within_tolerance(found) if found.block_a[r] == 0]
        return [tuple(np.round(n, 6) + 0.0) for n in scene.normals(found.edge[rows])], found, rows

    assert normals()[0] == [(1.0, 0.0)]
    every, found, rows = normals(closure_tol=-1.0, dual_distance=0.0)
    assert sorted(every) == [(0.0, 1.0), (1.0, 0.0)]
    on_top = scene.activated(found, [rows[every.index((0.0, 1.0))]])
    assert normals(on_top)[0] == [(0.0, 1.0)], "the active edge goes first"


@pytest.mark.parametrize("floor", [[3, 1], [3, 2, 1.5, 1], [3, 1.01, 1]])
def test_a_corner_in_a_notch_is_closed_on_floor_and_wall(floor):
    notched = np.vstack([[(0, 0), (3, 0)], np.column_stack([floor, np.ones(len(floor))]), [(1, 3), (0, 3)]])
    start = Scene.of([notched, rectangle(1, 1, 2, 2)], fixed=[0])
    pressed = start.moved(1, (-1e-5, -2e-5))
    active = start.activated(start.detect())
    for found in (pressed.detect(), pressed.detect(active)):
        rows = pressed.within_tolerance(found)
        corner = np.abs(pressed.placed[found.corner[rows]] - 1.0).max(axis=1) < 0.01
        assert corner.sum() == 2
        assert_allclose(np.abs(pressed.normals(found.edge[rows[corner]]).sum(axis=0)), 1.0)
    near = start.moved(1, (0.02, -2e-5))  # a wall within the band does not take away the floor
    assert (near.normals(near.detect().edge[near.within_tolerance(near.detect())])[:, 1] > 0.9).sum() >= 2


def test_a_tip_in_a_notch_is_closed_on_both_sides():
    notched = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)])
    arms = np.radians([20, 70])
    tip = turned([(0, 0), *zip(np.cos(arms), np.sin(arms), strict=True)], 0, (1, 1))
    pressed = Scene.of([notched, tip], fixed=[0]).moved(1, (-1e-5, -2e-5))
    assert len(pressed.within_tolerance(pressed.detect())) == 2


def test_a_new_contact_does_not_start_with_a_large_penetration():
    """A contact that is first seen deep would push its blocks apart; only one that takes over may be deep."""
    start = Scene.of([rectangle(0, 0, 3, 1), rectangle(1, 1, 2, 2)])
    assert start.moved(1, (0.0, -0.9e-3)).detect().count == 2
    deep = start.moved(1, (0.0, -3e-3))
    assert deep.detect().count == 0
    assert deep.detect(rules=RULES._replace(new_penetration=0.2)).count == 2
    assert deep.detect(start.activated(start.detect())).count == 2, "with history it stays"
    slid = column().moved(1, (2e-3, -3e-3))
    assert len(slid.within_tolerance(slid.detect(column().activated(column().detect())))) == 2, (
        "a dual takes over deep, too"
    )


def test_only_convex_corners_touch():
    """A corner that turns inwards by less than the tolerance of entrance would double the contacts of a zigzag."""
    rng = np.random.default_rng(0)
    scene = Scene.of(jagged_interface(rng, 0.015))
    faces = len(find_faces(scene.blocks).edge_a)
    assert len(scene.within_tolerance(scene.detect())) == 2 * faces
    off = RULES._replace(flat=2.0, dual_distance=0.0)
    assert len(scene.within_tolerance(scene.detect(rules=off))) > len(
        scene.within_tolerance(scene.detect(rules=off._replace(flat=1e-6)))
    )
    bridge = np.array([(0, 1), (1, 1.02), (2, 1), (2, 2), (0, 2)])  # its lower side is hollow
    over = Scene.of([rectangle(0, 0, 2, 1), bridge])
    assert over.detect().count == 2
    assert over.detect(rules=RULES._replace(flat=2.0)).count > 2


def test_a_corner_touches_only_edges_that_its_own_edges_lead_away_from():
    """A block that slides down along another does not hang by its upper corner on the other's top."""
    scene = Scene.of([square(0, 0), square(1, 0)]).moved(1, (0.02, 0.03))

    def tops(rules):
        found = scene.detect(rules=rules)
        return ((scene.normals(found.edge)[:, 1] > 0.99) & (found.gap > 0.0)).sum()

    assert tops(RULES) == 0
    assert tops(RULES._replace(entrance=2.0)) > 0


def vertex_cluster(turn=0.0):
    """Return seven triangles round the origin."""
    angles = np.radians(turn + np.cumsum([0, 40, 61, 52, 47, 66, 38]))
    rim = 2 * np.column_stack([np.cos(angles), np.sin(angles)])
    return [np.array([(0, 0), rim[k], rim[(k + 1) % 7]]) for k in range(7)]


def test_corners_of_diagonal_neighbours_do_not_support_each_other():
    """In a mesh many corners meet in one point; without a common face they touch there only once pressed."""
    scene = Scene.of(vertex_cluster())
    found = scene.detect()
    assert len(scene.within_tolerance(found)) == 14
    assert len(scene.within_tolerance(scene.detect(rules=RULES._replace(vertex_tol=0.0)))) > 14
    tips = ~found.in_range & (np.abs(found.gap) < 1e-9)
    assert tips.any(), "candidates they stay"
    active = scene.activated(found, np.flatnonzero(tips))
    out = scene.position[0, :2] / np.hypot(*scene.position[0, :2])
    for depth, carries in ((0.5e-3, False), (4e-3, True)):
        pressed = scene.moved(0, -depth * out)
        again = pressed.detect(active)
        still = np.isin(again.key, found.key[tips]) & (again.gap < 0)
        assert still.any()
        assert (again.history[still] >= 0).any() == carries, "no history until it is pressed in"


def test_a_thin_block_between_two_others_keeps_them_apart():
    """Blocks on both sides of a sliver are almost parallel: they are no face of half their length."""
    wedge = [
        np.array([(0, 0), (3, -1), (3, 0)]),
        np.array([(0, 0), (3, 0), (3, 0.1)]),
        np.array([(0, 0), (3, 0.1), (2, 2)]),
    ]
    scene = Scene.of(wedge)
    assert len(scene.within_tolerance(scene.detect())) == 4
    assert len(scene.within_tolerance(scene.detect(rules=RULES._replace(vertex_tol=0.0)))) == 5


def test_corners_that_just_touch_do_support_each_other():
    """A block that is hollow below is on its two corners, which lie on the corners of the block below."""
    hollow = np.array([(0, 1), (1, 1.05), (2, 1), (2, 2), (0, 2)])
    scene = Scene.of([rectangle(0, 0, 2, 1), hollow])
    assert len(scene.within_tolerance(scene.detect())) == 2


def test_a_tip_that_stands_on_an_edge_is_closed():
    tip = np.array([(1, 1), (2, 3), (0, 3)])
    scene = Scene.of([rectangle(0, 0, 3, 1), tip])
    found = scene.detect()
    (row,) = scene.within_tolerance(found)
    h = np.sqrt(2.0)  # the smaller block: the triangle
    assert found.parallel_edge[row] == -1
    assert found.length[row] == pytest.approx(0.05 * h)
    on_a_node = Scene.of([np.array([(0, 0), (3, 0), (3, 1), (1, 1), (0, 1)]), tip])  # a flat corner below the tip
    assert len(on_a_node.within_tolerance(on_a_node.detect())) == 1


def test_rules_go_with_the_smaller_block_of_a_pair():
    """A pebble 1/500 as large as the rock: a third of its base still carries, its corners keep their own history."""
    side = 0.002
    pebble = rectangle(-side / 3, 0, 2 * side / 3, side)
    scene = Scene.of([rectangle(-1, -1, 0, 0), pebble, square(3, 3)], fixed=[0])
    blunt = dataclasses.replace(scene.outlines, block_size=np.ones(3))  # the same scene, rules with the median size
    assert scene.outlines.size == pytest.approx(0.5 + side / 2)
    assert len(scene.within_tolerance(scene.detect(band=side))) == 2
    assert len(scene.within_tolerance(Scene(blunt, scene.position, scene.blocks).detect(band=side))) == 0


def test_rules_between_two_large_blocks_go_with_the_median_block():
    """Steps follow the median block: a tolerance of the large ones' size would let a contact start far too deep."""
    polygons = [rectangle(-100, -100, 0, 0), rectangle(-100, 0, 0, 100), *grid(3, 1)]
    scene = Scene.of([*polygons[:2], *[turned(p, 0, (10, 0)) for p in polygons[2:]]])
    assert scene.moved(1, (0, -0.9e-3)).detect().count > 4
    deep = scene.moved(1, (0, -2e-3))
    assert not ((deep.detect().block_a < 2) & (deep.detect().gap < 0)).any()
