"""Contact search: what is found, and the wrong answer that each contact rule mends.

Every test of a rule is made twice, with the rule and with the rule switched off by its tolerance: without the rule
the wrong answer comes out.
"""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from contact_scenes import Scene, brute_candidates, near_scene
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scenes import gmsh_triangles, grid, rectangle, running_bond, square, turned

import bsm_mesh as bsm
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import ActiveContacts
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.model.faces import find_faces

ATOL = 1e-9  # m, of blocks about 1 m large near the origin
seeds = st.integers(min_value=0, max_value=2**32 - 1)


# --- the start: every face is two contacts -----------------------------------------------------------------------


def voronoi_cells(rng, n):
    """Return the cells of n random points in the unit square, mirrored at its sides so that they fill it."""
    from scipy.spatial import Voronoi

    p = rng.random((n, 2))
    mirrored = [p, p * (-1, 1), p * (1, -1), (2, 0) + p * (-1, 1), (0, 2) + p * (1, -1)]
    diagram = Voronoi(np.concatenate(mirrored))
    return [diagram.vertices[diagram.regions[r]] for r in diagram.point_region[:n]]


def delaunay_triangles(rng, n):
    from scipy.spatial import Delaunay

    p = rng.random((n, 2)) * 5
    return [q for q in p[Delaunay(p).simplices] if np.abs(np.linalg.det(np.column_stack([q, np.ones(3)]))) > 1e-3]


def random_wall(rng, courses):
    """Return courses of bricks of random length: joints of neighbouring courses at least 0.05 m apart."""
    wall, below = [], np.array([0.0, 10.0])
    for j in range(courses):
        joints = rng.uniform(0.1, 9.9, 14)
        kept = [0.0]
        for x in np.sort(joints):
            if x - kept[-1] > 0.1 and np.abs(below - x).min() > 0.05:
                kept.append(x)
        below = np.array([*kept, 10.0])
        wall += [rectangle(x0, 0.5 * j, x1, 0.5 * j + 0.5) for x0, x1 in pairwise(below)]
    return wall


def jagged_interface(rng, depth):
    """Return two concave blocks that meet along a zigzag, and one beside them."""
    zigzag = np.column_stack([np.arange(9.0), rng.uniform(-depth, depth, 9)])
    lower = np.vstack([[(0, -2), (8, -2)], zigzag[::-1]])
    upper = np.vstack([zigzag, [(8, 2), (0, 2)]])
    return [lower, upper, rectangle(8, -2, 9, zigzag[-1, 1]), rectangle(8, zigzag[-1, 1], 9, 2)]


STARTS = {
    "conforming grid": lambda rng: grid(5, 4),
    "uneven grid": lambda rng: grid(np.cumsum(rng.uniform(0.1, 3, 7)), np.cumsum(rng.uniform(0.1, 3, 6))),
    "running bond": lambda rng: running_bond(6, 5),
    "random bricks": lambda rng: random_wall(rng, 8),
    "triangles": lambda rng: delaunay_triangles(rng, 60),
    "gmsh": lambda rng: list(gmsh_triangles(4.0, 3.0, 0.5)),
    "voronoi": lambda rng: voronoi_cells(rng, 60),
    "one wide block under many": lambda rng: [rectangle(-1, -3, 30, 0), *grid(29, 3)],
    "concave blocks": lambda rng: jagged_interface(rng, 0.7),
    "zigzag of a degree or two": lambda rng: jagged_interface(rng, 0.015),
    "block in a notch": lambda rng: [np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]), rectangle(1, 1, 2, 2)],
    "two flat corners at one point": lambda rng: [
        np.array([(0, 0), (2, 0), (2, 1), (1.2, 1), (0, 1)]),
        np.array([(0, 1), (1.2, 1), (2, 1), (2, 2), (0, 2)]),
    ],
}


def place_rows(pair_low, pair_high, point, length):
    """Return rows (lower block, higher block, x, y, length) in a fixed order."""
    rows = np.column_stack([pair_low, pair_high, np.round(point, 7) + 0.0, length])
    return rows[np.lexsort(rows.T[::-1])]


def rows_of(scene, found):
    rows = scene.touching(found)
    low, high = np.minimum(found.block_a, found.block_b), np.maximum(found.block_a, found.block_b)
    return place_rows(low[rows], high[rows], scene.placed[found.corner[rows]], found.length[rows])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", STARTS)
def test_at_the_start_every_face_is_two_contacts(name, seed):
    rng = np.random.default_rng(seed)
    polygons = STARTS[name](rng)
    if seed:
        polygons = [turned(p, 57.3 * seed, (100 * seed, -30)) for p in polygons]
    scene = Scene.of(polygons)
    found = scene.detect()
    faces = find_faces(scene.blocks)
    owner, share = scene.blocks.owner, np.hypot(*(faces.end - faces.start).T) / 2
    low = np.minimum(owner[faces.edge_a], owner[faces.edge_b])
    high = np.maximum(owner[faces.edge_a], owner[faces.edge_b])
    expected = place_rows(
        np.tile(low, 2), np.tile(high, 2), np.concatenate([faces.start, faces.end]), np.tile(share, 2)
    )
    assert len(expected) > 0
    assert_allclose(rows_of(scene, found), expected, atol=1e-6)
    assert np.abs(found.gap[scene.touching(found)]).max() < ATOL


def test_the_start_has_the_points_and_lengths_of_the_contact_table():
    joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.Patton(friction=30))
    scene = Scene.of(random_wall(np.random.default_rng(7), 5))
    rock = bsm.Rock("r", unit_weight=26e3)
    table = initial_contacts(
        bsm.Model(
            blocks=scene.blocks, rocks=[rock], joints=[joint], default_joint="J", supports=[bsm.Fixed(blocks=[0])]
        )
    )
    low, high = np.minimum(table.block_a, table.block_b), np.maximum(table.block_a, table.block_b)
    assert_allclose(rows_of(scene, scene.detect()), place_rows(low, high, table.point, table.length), atol=1e-6)


def test_what_a_candidate_says():
    scene = Scene.of([rectangle(0, 0, 4, 1), rectangle(1, 1, 2, 2)]).moved(1, (0.0, 0.03))
    found = scene.detect()
    assert_allclose(found.gap, 0.03, atol=ATOL)
    assert found.block_a.tolist() == [1, 1]
    assert found.block_b.tolist() == [0, 0]
    assert_allclose(scene.normals(found.edge), [(0, 1), (0, 1)], atol=ATOL)
    assert found.in_range.all()
    assert (found.history == -1).all()
    assert (found.inherits == -1).all()
    assert_allclose(sorted(found.along), [2, 3])  # the top of the lower block runs from right to left
    assert_allclose(found.edge_length, 4)
    assert_allclose(found.length, 0.5)
    assert found.pair.tolist() == [1, 1]
    assert found.key.tolist() == [(int(v) << 32) | int(e) for v, e in zip(found.corner, found.edge, strict=True)]
    assert (scene.blocks.owner[found.parallel_edge] == 1).all()
    assert scene.detect(band=0.02).count == 0


# --- against the slow, obvious search -----------------------------------------------------------------------------


def random_scene(seed, depth=0.02):
    """Return convex and concave blocks of different size, packed so that corners touch and overlap a little."""
    rng = np.random.default_rng(seed)
    shapes = []
    for _ in range(int(rng.integers(2, 9))):
        kind, scale = rng.integers(0, 4), 10 ** rng.uniform(-0.7, 0.7)
        angles = np.sort(rng.uniform(0, 2 * np.pi, int(rng.integers(3, 8))))
        if kind == 0 and np.diff(np.append(angles, angles[0] + 2 * np.pi)).max() < 2.8:
            shapes.append(scale * np.column_stack([np.cos(angles), np.sin(angles)]))
        elif kind == 1:
            shapes.append(scale * np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float))
        elif kind == 2:
            shapes.append(
                scale * np.array([(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
            )
        else:
            shapes.append(scale * rectangle(0, 0, rng.uniform(0.3, 2), 1))
    position = np.column_stack([rng.uniform(-2, 2, (len(shapes), 2)), rng.choice([0, 0.02, np.pi / 2, 1], len(shapes))])
    return near_scene(shapes, position)


@settings(max_examples=150, deadline=None)
@given(seeds)
def test_finds_what_the_slow_search_finds(seed):
    scene = random_scene(seed)
    band = 0.1 * scene.outlines.size
    found = scene.detect(band=band)
    brute = brute_candidates(scene, band)
    keys = list(zip(found.corner.tolist(), found.edge.tolist(), strict=True))
    assert len(set(keys)) == len(keys)
    assert (np.diff(found.pair) >= 0).all()
    assert set(keys) <= set(brute)
    for name in ("gap", "along", "edge_length", "length"):
        assert_allclose(getattr(found, name), [brute[k][name] for k in keys], atol=1e-9, err_msg=name)
    for k, key in enumerate(keys):
        if found.play[k] == 0:
            assert found.in_range[k] == brute[key]["in_range"]
            assert not brute[key]["end_to_end"]
        elif not brute[key]["end_to_end"]:  # the front of a low step: the face beyond is another way out
            levels = [brute[other] for other in brute if set(blocks_of(brute, other)) == set(blocks_of(brute, key))]
            assert any(row["parallel"] and abs(row["gap"]) < RULES.seam * row["h"] for row in levels)
    assert ((found.parallel_edge >= 0) == [brute[k]["parallel"] for k in keys]).all()
    for key in set(brute) - set(keys):
        assert reason_to_drop(scene, key, brute, set(keys), band), key


def blocks_of(brute, key):
    return brute[key]["a"], brute[key]["b"]


def reason_to_drop(scene, key, brute, kept, band):
    """Whether one of the rules that weigh candidates against each other explains that one is missing."""
    row, placed, following = brute[key], scene.placed, scene.blocks.following
    if row["gap"] < -RULES.fresh * row["h"] or row["end_to_end"]:
        return True
    for other in kept:
        rival = brute[other]
        same_corner = other[0] == key[0] and rival["b"] == row["b"] and rival["in_range"] and row["in_range"]
        closed, better = row["gap"] <= RULES.closed * row["h"], rival["gap"] >= row["gap"] - RULES.rounding * row["h"]
        if same_corner and closed and better:
            return True
        near = np.hypot(*(placed[other[0]] - placed[key[0]])) < RULES.dual * band
        swapped = other[0] in (key[1], following[key[1]]) and key[0] in (other[1], following[other[1]])
        if near and swapped and rival["in_range"] and rival["gap"] <= RULES.fresh * rival["h"]:
            return True
    return False


@settings(max_examples=60, deadline=None)
@given(seeds)
def test_turning_and_moving_everything_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    scene = Scene.of(random_wall(rng, 4))
    scene = Scene(scene.outlines, scene.position + rng.normal(0, 0.01, scene.position.shape), scene.blocks)
    angle, shift = rng.uniform(-180, 180), rng.uniform(-50, 50, 2)
    position = np.column_stack([turned(scene.position[:, :2], angle, shift), scene.position[:, 2] + np.radians(angle)])
    one, other = scene.detect(), Scene(scene.outlines, position, scene.blocks).detect()
    assert (one.key == other.key).all()
    for name in ("gap", "along", "length"):
        assert_allclose(getattr(one, name), getattr(other, name), atol=1e-8)


@settings(max_examples=60, deadline=None)
@given(seeds)
def test_history_is_carried_on_or_handed_over_never_twice(seed):
    rng = np.random.default_rng(seed)
    scene = Scene.of(random_wall(rng, 4) if seed % 2 else delaunay_triangles(rng, 25))
    active = scene.activated(scene.detect())
    for _ in range(4):
        position = scene.position + rng.normal(0, 5e-4, scene.position.shape)
        scene = Scene(scene.outlines, position, scene.blocks)
        found = scene.detect(active)
        goes_on, taken = found.history[found.history >= 0], found.inherits[found.inherits >= 0]
        rows = np.concatenate([goes_on, taken])
        assert len(np.unique(rows)) == len(rows)
        assert ((found.history < 0) | (found.inherits < 0)).all()
        assert (active.key[goes_on] == found.key[found.history >= 0]).all()
        assert (active.pair[taken] == found.pair[found.inherits >= 0]).all()
        keys = list(zip(found.pair.tolist(), found.key.tolist(), strict=True))
        assert len(set(keys)) == len(keys)
        active = scene.activated(found)


# --- the rules ----------------------------------------------------------------------------------------------------


def column():
    """Return two unit squares one on the other; the upper one is block 1."""
    return Scene.of([square(0, 0), square(0, 1)])


def test_one_contact_where_two_corners_meet_not_two():
    scene = column()
    assert len(scene.touching(scene.detect())) == 2
    assert len(scene.touching(scene.detect(rules=RULES._replace(dual=0.0)))) == 4


@pytest.mark.parametrize("shift", [-5e-4, 5e-4, 2e-3])
def test_no_swapped_role_while_the_active_contact_is_in_range(shift):
    """Seen: the dual appeared in the same step with zero shear and halved the friction."""
    start = column()
    active = start.activated(start.detect())
    moved = start.moved(1, (shift, -1e-5))

    found = moved.detect(active)
    assert len(moved.touching(found)) == 2
    if abs(shift) < 1e-3:
        assert (found.history[moved.touching(found)] >= 0).all()
        off = moved.detect(active, rules=RULES._replace(dual=0.0))
        assert sorted(off.history[moved.touching(off)]) == [-1, 0, 1]


@pytest.mark.parametrize("shift", [-0.01, 0.01])
@pytest.mark.parametrize("polygons", [[square(0, 0), square(0, 1)], [square(0, 1), square(0, 0)]])
def test_of_two_fresh_duals_the_one_that_touches_stands(polygons, shift):
    scene = Scene.of(polygons).moved(1, (shift, 0.0))
    found = scene.detect()
    assert found.count == 2
    assert len(scene.touching(found)) == 2


def test_history_of_two_goes_to_one_from_the_nearer():
    scene = Scene.of([rectangle(0, 0, 3, 1), rectangle(1, 1, 2, 2)])
    found = scene.detect()
    row = int(np.argmin(scene.placed[found.corner, 0]))  # at (1, 1)
    for points in ([(1.05, 1), (1.02, 1)], [(1.02, 1), (1.05, 1)]):
        ended = active_on_top(found.pair[0], [1 << 20, 2 << 20], points)
        assert scene.detect(ended).inherits[row] == [x for x, _ in points].index(1.02)
        assert (scene.detect(ended).inherits >= 0).sum() == 1


def active_on_top(pair, keys, points):
    """Return active contacts of block 1 on the top of block 0 under keys that no candidate has."""
    return ActiveContacts(
        pair=np.full(len(keys), pair),
        key=(np.array([4] * len(keys)) << 32) | np.array(keys),
        pressure=np.ones(len(keys)),
        point=np.array(points),
        normal=np.tile([0.0, 1.0], (len(keys), 1)),
    )


def test_an_open_dual_waits_until_the_contact_that_stands_has_gone():
    start = column()
    active = start.activated(start.detect())
    found = start.moved(1, (0.03, -1e-5)).detect(active)
    left, right = np.sort(start.placed[found.corner, 0])[[0, -1]]
    assert left == pytest.approx(0.03, abs=1e-3) or left == pytest.approx(0.0, abs=1e-3)
    assert right == pytest.approx(1.0, abs=0.04)
    assert found.count == 2


def test_a_contact_ends_when_it_leaves_the_edge_and_its_dual_takes_over_the_history():
    start = column()
    active = start.activated(start.detect())
    inside, outside = start.moved(1, (0.9e-3, -1e-5)), start.moved(1, (1.1e-3, -1e-5))
    assert sorted(inside.detect(active).history) == [0, 1]
    assert sorted(inside.detect(active, rules=RULES._replace(leave=0.0)).history) == [-1, 0], "it flickers"
    found = outside.detect(active)
    assert sorted(found.history) == [-1, 0] or sorted(found.history) == [-1, 1]
    (new,) = np.flatnonzero(found.history < 0)
    assert found.inherits[new] == 1 - found.history.max()
    assert found.block_a[new] != found.block_a[1 - new], "corner and edge are swapped"
    assert (outside.detect(active, rules=RULES._replace(leave=1.0)).history >= 0).all(), "it hangs in the air"


@pytest.mark.parametrize("off", [{"near": 0.0}, {"aligned": 1.1}])
def test_without_near_and_aligned_contacts_no_history_is_handed_over(off):
    start = column()
    active = start.activated(start.detect())
    outside = start.moved(1, (2e-3, -1e-5))
    assert (outside.detect(active).inherits >= 0).sum() == 1
    assert (outside.detect(active, rules=RULES._replace(**off)).inherits >= 0).sum() == 0


def test_history_is_not_handed_round_a_corner():
    """A block that slips off the top and comes to lean on the side starts there without shear force."""
    start = Scene.of([square(0, 0), rectangle(0.9, 1, 1.9, 2)])
    active = start.activated(start.detect())
    assert len(active.key) == 2
    beside = start.moved(1, (0.1, -0.05))
    assert len(beside.touching(beside.detect(active))) == 2
    assert (beside.detect(active).inherits < 0).all()
    assert (beside.detect(active, rules=RULES._replace(aligned=-1.0, near=0.3)).inherits >= 0).any()


def test_history_goes_along_an_outline_from_edge_to_edge():
    floor = np.array([(-2, -1), (2, -1), (2, 0), (0, 0), (-2, 0)], dtype=float)  # its top has a flat corner at x = 0
    start = Scene.of([floor, rectangle(-1, 0, -0.001, 1)], held=[0])
    active = start.activated(start.detect())
    found = start.moved(1, (0.02, -1e-5)).detect(active)
    rows = start.touching(found)
    assert len(rows) == 3, "the flat corner of the floor has come under the block"
    assert found.length[rows].sum() == pytest.approx(0.999)
    right = rows[start.placed[found.corner[rows], 0] > -0.01]
    assert sorted(found.history[rows]) == [-1, -1, found.history.max()]
    assert found.inherits[rows].max() == 1 - found.history.max()
    assert found.inherits[right].max() == found.inherits[rows].max()


def test_parallel_edges_that_share_no_length_do_not_support():
    """Seen: a slope that was stable at phi = 5, held by blocks that only met end to end."""
    start = Scene.of(grid(2, 2))

    def diagonal(rules, shift=-1.0):  # the upper row has moved on by a whole block: other corners meet
        moved = start.moved(2, (shift, 0.0)).moved(3, (shift, 0.0))
        found = moved.detect(rules=rules)
        pairs = {(int(p) >> 32, int(p) & 0xFFFFFFFF) for p in found.pair[moved.touching(found)]}
        assert (0, 3) in pairs
        return pairs - {(0, 1), (2, 3), (0, 3)}

    assert diagonal(RULES) == set()
    assert diagonal(RULES._replace(seam=0.0)) == {(0, 2), (1, 3)}
    assert diagonal(RULES, -0.996) == set()
    assert diagonal(RULES, -0.994) == {(0, 2), (1, 3)}, "a real overlap"


def slide(step, rules, penetration=1e-4):
    """Slide a block over the joint of two others; return the steepest normal that will stop it, and the least support.

    The second block stands out by `step`; the moved block sinks in by `penetration`, as elastic blocks do.
    """
    start = Scene.of([rectangle(-4, -1, 0, 0), rectangle(0, -1, 4, step), rectangle(-2, 0, -0.005, 1)], held=[0, 1])
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


def test_a_block_does_not_snag_at_a_flush_joint_but_at_a_step():
    """Seen: falsely stable at x = 0.5008 of 2.5."""
    steepest, support = slide(0.0, RULES)
    assert steepest < 1e-6
    assert support >= 2
    assert slide(0.0, RULES._replace(seam=0.0))[0] > 0.99
    assert slide(0.0, RULES, penetration=8e-4)[0] < 1e-6
    assert slide(0.03, RULES)[0] > 0.99, "0.02 of the median size, 1.5 m"
    assert slide(0.03, RULES._replace(seam=0.05))[0] < 1e-6


def test_the_face_of_a_small_block_is_no_seam():
    """A whole edge is shared, however short: the rule must not take the support from under it."""
    for side in (0.004, 0.02):
        scene = Scene.of([rectangle(-3, -2, 0, 0), rectangle(-side, 0, 0, side), square(5, 0)])
        assert len(scene.touching(scene.detect())) == 2
    scene = Scene.of([*delaunay_triangles(np.random.default_rng(0), 10), square(9, 9)])
    assert len(scene.touching(scene.detect())) == 2 * len(find_faces(scene.blocks).edge_a)


def test_a_hinge_stays_at_an_edges_end():
    """Only parallel contacts have a seam: a block that leans on its corner at the end of an edge is held there."""
    start = Scene.of([square(0, 0), square(1, 0)])  # they open about the upper ends of the face, (1, 1)
    hinge = start.moved(1, degrees=20.0, about=(1.0, 1.0)).moved(0, degrees=-15.0, about=(1.0, 1.0))
    first = start.detect()
    rows = start.touching(first)
    at_top = rows[start.placed[first.corner[rows], 1] > 0.9]
    active = start.activated(first, at_top)
    found = hinge.detect(active)
    assert len(hinge.touching(found)) == 1
    assert (found.history >= 0).sum() == 1
    arms = np.radians([15, 75])
    tip = turned([(0, 0), *zip(np.cos(arms), np.sin(arms), strict=True)], 0, (1, 1))
    on_the_end = Scene.of([square(0, 0), tip])  # it shares no length with the top, nor with the right side
    assert len(on_the_end.touching(on_the_end.detect())) == 1
    off = RULES._replace(parallel=2.0)  # now every edge is parallel to every other
    assert len(on_the_end.touching(on_the_end.detect(rules=off))) == 0


def test_a_corner_within_a_corner_bears_on_one_edge_only():
    """A sharp corner is a little within the upper right corner of a square, nearer to its right side."""
    arms = np.radians([20, 70])
    sharp = turned([(0, 0), *zip(np.cos(arms), np.sin(arms), strict=True)], 0, (3, 3))
    scene = Scene.of([sharp, square(0, 0)]).moved(0, (-2 - 4e-4, -2 - 5e-4))

    def normals(active=None, **off):
        found = scene.detect(active, rules=RULES._replace(**off))
        rows = [r for r in scene.touching(found) if found.block_a[r] == 0]
        return [tuple(np.round(n, 6) + 0.0) for n in scene.normals(found.edge[rows])], found, rows

    assert normals()[0] == [(1.0, 0.0)]
    every, found, rows = normals(closed=-1.0, dual=0.0)
    assert sorted(every) == [(0.0, 1.0), (1.0, 0.0)]
    on_top = scene.activated(found, [rows[every.index((0.0, 1.0))]])
    assert normals(on_top)[0] == [(0.0, 1.0)], "the active edge goes first"


@pytest.mark.parametrize("floor", [[3, 1], [3, 2, 1.5, 1], [3, 1.01, 1]])
def test_a_corner_in_a_notch_bears_on_floor_and_wall(floor):
    notched = np.vstack([[(0, 0), (3, 0)], np.column_stack([floor, np.ones(len(floor))]), [(1, 3), (0, 3)]])
    start = Scene.of([notched, rectangle(1, 1, 2, 2)], held=[0])
    pressed = start.moved(1, (-1e-5, -2e-5))
    active = start.activated(start.detect())
    for found in (pressed.detect(), pressed.detect(active)):
        rows = pressed.touching(found)
        corner = np.abs(pressed.placed[found.corner[rows]] - 1.0).max(axis=1) < 0.01
        assert corner.sum() == 2
        assert_allclose(np.abs(pressed.normals(found.edge[rows[corner]]).sum(axis=0)), 1.0)
    near = start.moved(1, (0.02, -2e-5))  # a wall within the band does not take away the floor
    assert (near.normals(near.detect().edge[near.touching(near.detect())])[:, 1] > 0.9).sum() >= 2


def test_a_tip_in_a_notch_bears_on_both_sides():
    notched = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)])
    arms = np.radians([20, 70])
    tip = turned([(0, 0), *zip(np.cos(arms), np.sin(arms), strict=True)], 0, (1, 1))
    pressed = Scene.of([notched, tip], held=[0]).moved(1, (-1e-5, -2e-5))
    assert len(pressed.touching(pressed.detect())) == 2


def test_a_fresh_contact_does_not_start_deep():
    """A contact that is first seen deep would push its blocks apart; only one that takes over may be deep."""
    start = Scene.of([rectangle(0, 0, 3, 1), rectangle(1, 1, 2, 2)])
    assert start.moved(1, (0.0, -0.9e-3)).detect().count == 2
    deep = start.moved(1, (0.0, -3e-3))
    assert deep.detect().count == 0
    assert deep.detect(rules=RULES._replace(fresh=0.2)).count == 2
    assert deep.detect(start.activated(start.detect())).count == 2, "with history it stays"
    slid = column().moved(1, (2e-3, -3e-3))
    assert len(slid.touching(slid.detect(column().activated(column().detect())))) == 2, "a dual takes over deep, too"


def test_an_active_contact_has_a_greatest_depth():
    start = Scene.of([rectangle(0, 0, 3, 1), rectangle(1, 1, 2, 2)])
    active = start.activated(start.detect())
    assert start.moved(1, (0.0, -0.24)).detect(active).count == 2
    assert start.moved(1, (0.0, -0.3)).detect(active).count == 0
    assert start.moved(1, (0.0, -0.3)).detect(active, rules=RULES._replace(deepest=0.5)).count == 2


def test_only_convex_corners_touch():
    """A corner that turns inwards by less than the tolerance of entrance would double the contacts of a zigzag."""
    rng = np.random.default_rng(0)
    scene = Scene.of(jagged_interface(rng, 0.015))
    faces = len(find_faces(scene.blocks).edge_a)
    assert len(scene.touching(scene.detect())) == 2 * faces
    off = RULES._replace(flat=2.0, dual=0.0)
    assert len(scene.touching(scene.detect(rules=off))) > len(
        scene.touching(scene.detect(rules=off._replace(flat=1e-6)))
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


def fan(turn=0.0):
    """Return seven triangles round the origin."""
    angles = np.radians(turn + np.cumsum([0, 40, 61, 52, 47, 66, 38]))
    rim = 2 * np.column_stack([np.cos(angles), np.sin(angles)])
    return [np.array([(0, 0), rim[k], rim[(k + 1) % 7]]) for k in range(7)]


def test_corners_of_diagonal_neighbours_do_not_support_each_other():
    """In a mesh many corners meet in one point; blocks without a common face bear there only once they are pressed."""
    scene = Scene.of(fan())
    found = scene.detect()
    assert len(scene.touching(found)) == 14
    assert len(scene.touching(scene.detect(rules=RULES._replace(tip=0.0)))) > 14
    tips = ~found.in_range & (np.abs(found.gap) < 1e-9)
    assert tips.any(), "candidates they stay"
    active = scene.activated(found, np.flatnonzero(tips))
    out = scene.position[0, :2] / np.hypot(*scene.position[0, :2])
    for depth, bears in ((0.5e-3, False), (4e-3, True)):
        pressed = scene.moved(0, -depth * out)
        again = pressed.detect(active)
        still = np.isin(again.key, found.key[tips]) & (again.gap < 0)
        assert still.any()
        assert (again.history[still] >= 0).any() == bears, "no history until it is pressed in"


def test_a_thin_block_between_two_others_keeps_them_apart():
    """Blocks on both sides of a sliver are almost parallel: they are no face of half their length."""
    wedge = [
        np.array([(0, 0), (3, -1), (3, 0)]),
        np.array([(0, 0), (3, 0), (3, 0.1)]),
        np.array([(0, 0), (3, 0.1), (2, 2)]),
    ]
    scene = Scene.of(wedge)
    assert len(scene.touching(scene.detect())) == 4
    assert len(scene.touching(scene.detect(rules=RULES._replace(tip=0.0)))) == 5


def test_corners_that_just_touch_do_support_each_other():
    """A block that is hollow below stands on its two corners, which lie on the corners of the block below."""
    hollow = np.array([(0, 1), (1, 1.05), (2, 1), (2, 2), (0, 2)])
    scene = Scene.of([rectangle(0, 0, 2, 1), hollow])
    assert len(scene.touching(scene.detect())) == 2


def test_a_tip_that_stands_on_an_edge_bears():
    tip = np.array([(1, 1), (2, 3), (0, 3)])
    scene = Scene.of([rectangle(0, 0, 3, 1), tip])
    found = scene.detect()
    (row,) = scene.touching(found)
    h = np.sqrt(2.0)  # the smaller block: the triangle
    assert found.parallel_edge[row] == -1
    assert found.length[row] == pytest.approx(0.05 * h)
    on_a_node = Scene.of([np.array([(0, 0), (3, 0), (3, 1), (1, 1), (0, 1)]), tip])  # a flat corner below the tip
    assert len(on_a_node.touching(on_a_node.detect())) == 1


def test_rules_go_with_the_smaller_block_of_a_pair():
    """A pebble 1/500 as large as the rock: a third of its base still bears, and its corners keep their own history."""
    side = 0.002
    pebble = rectangle(-side / 3, 0, 2 * side / 3, side)
    scene = Scene.of([rectangle(-1, -1, 0, 0), pebble, square(3, 3)], held=[0])
    blunt = dataclasses.replace(scene.outlines, block_size=np.ones(3))  # the same scene, rules with the median size
    assert scene.outlines.size == pytest.approx(0.5 + side / 2)
    assert len(scene.touching(scene.detect(band=side))) == 2
    assert len(scene.touching(Scene(blunt, scene.position, scene.blocks).detect(band=side))) == 0


def test_rules_between_two_large_blocks_go_with_the_median_block():
    """Steps follow the median block: a tolerance of the large ones' size would let a contact start far too deep."""
    polygons = [rectangle(-100, -100, 0, 0), rectangle(-100, 0, 0, 100), *grid(3, 1)]
    scene = Scene.of([*polygons[:2], *[turned(p, 0, (10, 0)) for p in polygons[2:]]])
    assert scene.moved(1, (0, -0.9e-3)).detect().count > 4
    deep = scene.moved(1, (0, -2e-3))
    assert not ((deep.detect().block_a < 2) & (deep.detect().gap < 0)).any()


def test_two_active_duals_at_one_point_become_one():
    start = column()
    every = start.detect(rules=RULES._replace(dual=0.0))
    rows = start.touching(every)
    assert len(rows) == 4
    active = start.activated(every, rows, pressure=np.array([1.0, 2.0, 3.0, 4.0]))
    found = start.moved(1, (0.0, -1e-5)).detect(active)
    assert found.count == 2
    assert sorted(active.pressure[found.history]) == [3.0, 4.0], "those that bear more"


def test_contacts_that_bore_nothing_are_not_active():
    start = column()
    active = start.activated(start.detect(), pressure=0.0)
    found = start.moved(1, (0.0, -1e-5)).detect(active)
    assert (found.history == -1).all()
    assert (found.inherits == -1).all()


def test_the_search_changes_nothing_it_is_given_and_repeats():
    scene = Scene.of(random_wall(np.random.default_rng(1), 3))
    active, position = scene.activated(scene.detect()), scene.position.copy()
    one, other = scene.detect(active), scene.detect(active)
    assert (scene.position == position).all()
    for field in dataclasses.fields(one):
        assert (getattr(one, field.name) == getattr(other, field.name)).all()


def test_many_candidates_of_one_pair():
    """Two blocks that meet in 600 faces: the tables grow."""
    rng = np.random.default_rng(5)
    zigzag = np.column_stack([np.arange(601.0), rng.uniform(-0.4, 0.4, 601)])
    lower, upper = np.vstack([[(0, -9), (600, -9)], zigzag[::-1]]), np.vstack([zigzag, [(600, 9), (0, 9)]])
    scene = Scene.of([lower, upper])
    assert len(scene.touching(scene.detect())) == 1200
