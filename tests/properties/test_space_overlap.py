"""Overlap of random convex polyhedra: no pair is dropped that shares volume, none counted that a plane separates.

The reference knows corners alone: a linear program looks for a plane between two sets of corners, and SciPy's hulls
and half spaces give the volume that they share.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.spatial.transform import Rotation

import bsm_mesh as bsm
from bsm_mesh.geometries import three_d
from bsm_mesh.three_d.overlap import LEAST, unexplained_overlap
from tests.scenes.polyhedra import hull

PAIRS = 12  # a seed
STEEPEST = 1e8  # 1/m: planes between corners that are nearer than its inverse are rounding
VOLUME = 1e-9  # relative: two sums over the same corners
APART = 10.0  # m between blocks as given


def random_hull(rng, centre):
    """Return corners and faces of the hull of random points, faces counter-clockwise seen from outside."""
    points, faces = hull(rng.normal(size=(rng.integers(4, 13), 3)) * rng.uniform(0.3, 1.5, size=3))
    return points + centre, faces


def moved(points, centroid, movement):
    """Return points (k, 3) where a movement of six numbers about a centroid brings them."""
    return centroid + movement[:3] + Rotation.from_rotvec(movement[3:]).apply(points - centroid)


def separated(one, other):
    """Return whether a plane keeps two sets of corners apart, by more than rounding: n x + d <= -1 and >= 1."""
    rows = np.vstack([np.column_stack([one, np.ones(len(one))]), -np.column_stack([other, np.ones(len(other))])])
    found = linprog([0] * 4, A_ub=rows, b_ub=-np.ones(len(rows)), bounds=[(-STEEPEST, STEEPEST)] * 3 + [(None, None)])
    return found.status == 0


def shared(one, other):
    """Return the volume that the hulls of two sets of corners share [m3], and the radius of a ball in it [m]."""
    rows = np.vstack([ConvexHull(one).equations, ConvexHull(other).equations])
    inside = np.column_stack([rows[:, :3], np.ones(len(rows))])
    ball = linprog([0, 0, 0, -1], A_ub=inside, b_ub=-rows[:, 3], bounds=[(None, None)] * 4).x
    if ball[3] < 1 / STEEPEST:
        return 0.0, ball[3]
    return ConvexHull(HalfspaceIntersection(rows, ball[:3]).intersections).volume, ball[3]


def corner_into_corner(rng, one, other):
    """Return the shift that brings a corner of the other to one of the first, up to 0.1 m into it or away [m]."""
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    return one[np.argmax(one @ way)] - other[np.argmin(other @ way)] - rng.uniform(-0.1, 0.1) * way


def overlap(blocks, movement, present=None):
    """Return the overlap of blocks after a movement (n, 6), over their median volume."""
    stage = SimpleNamespace(
        origin=np.zeros((blocks.count, 6)),
        displacement=movement,
        present=np.ones(blocks.count, dtype=bool) if present is None else present,
        contacts=SimpleNamespace(**{name: np.zeros(0, int) for name in ("block_a", "block_b", "opening", "length")}),
    )
    return unexplained_overlap(blocks, stage)


@pytest.mark.parametrize("seed", range(4))
def test_pairs_overlap_where_no_plane_separates_them(seed):
    """Random hulls at random places, every second pair corner to corner: the volume that SciPy finds, or none."""
    rng = np.random.default_rng(seed)
    seen = []
    for pair in range(PAIRS):
        solids = [random_hull(rng, (APART * k, 0, 0)) for k in range(2)]
        blocks = bsm.Polyhedra.from_solids(solids, rock="granite", joint="J1")
        centroid = blocks.moments.centroid
        movement = np.concatenate([rng.normal(size=(2, 3)) * 0.8, rng.uniform(-3, 3, size=(2, 3))], axis=1)
        movement[1, 0] -= APART
        one, other = (moved(corners, centroid[k], movement[k]) for k, (corners, _) in enumerate(solids))
        if pair % 2:
            shift = corner_into_corner(rng, one, other)
            movement[1, :3] += shift
            other += shift
        found, unit = overlap(blocks, movement), float(np.median(blocks.moments.volume))
        small = LEAST * blocks.moments.size.min()
        apart = separated(one, other)
        volume, radius = shared(one, other)
        assert apart == (volume == 0)  # both references agree
        if apart:
            assert found == 0
        elif radius > small / 2:  # deeper than contact along any face's normal
            assert_allclose(found, volume / unit, rtol=VOLUME)
        seen.append(apart)
    assert 0.1 < np.mean(seen) < 0.9


@pytest.mark.parametrize("seed", range(3))
def test_the_worst_pair_of_many_blocks_is_found(seed):
    """Eight hulls thrown together, some of them excavated: the greatest of all pairs, whatever the boxes say."""
    rng = np.random.default_rng(100 + seed)
    solids = [random_hull(rng, (APART * k, 0, 0)) for k in range(8)]
    blocks = bsm.Polyhedra.from_solids(solids, rock="granite", joint="J1")
    movement = np.concatenate([rng.uniform(-1, 1, size=(8, 3)), rng.uniform(-3, 3, size=(8, 3))], axis=1)
    movement[:, 0] -= APART * np.arange(8)
    present = rng.uniform(size=8) < 0.8
    placed = [moved(corners, blocks.moments.centroid[k], movement[k]) for k, (corners, _) in enumerate(solids)]
    there = np.flatnonzero(present)
    worst = max(shared(placed[i], placed[j])[0] for i in there for j in there if i < j)
    assert_allclose(overlap(blocks, movement, present), worst / np.median(blocks.moments.volume), rtol=VOLUME)


@pytest.mark.parametrize("push", [0.02, 0.3])
@pytest.mark.parametrize("seed", range(3))
def test_cells_of_one_rock_overlap_by_their_relative_movement_alone(seed, push):
    """Rock cut by random planes, turned and shifted as a whole: nothing. One block pushed on: its pair by SciPy."""
    rng = np.random.default_rng(200 + seed)
    planes = [
        three_d.JointPlane(
            name="J1",
            dip=float(rng.uniform(0, 90)),
            dip_direction=float(rng.uniform(0, 360)),
            point=tuple(rng.uniform(0.6, 1.4, 3)),
        )
        for _ in range(3)
    ]
    rock = three_d.cut_cells(three_d.RockMass(box=((0, 0, 0), (2, 2, 2)), joints=planes))
    blocks = bsm.Polyhedra.from_cells(rock)
    centroid, count = blocks.moments.centroid, blocks.count
    whole = np.concatenate([rng.normal(size=3), rng.uniform(-2, 2, 3)])
    together = np.tile(whole, (count, 1))
    together[:, :3] = moved(centroid, np.zeros(3), whole) - centroid
    assert overlap(blocks, together) == 0
    pushed = int(rng.integers(count))
    together[pushed, :3] += Rotation.from_rotvec(whole[3:]).apply(centroid.mean(axis=0) - centroid[pushed]) * push
    placed = [moved(corners_of(blocks, k), centroid[k], together[k]) for k in range(count)]
    worst = max(shared(placed[pushed], placed[k])[0] for k in range(count) if k != pushed)
    assert worst > 0
    assert_allclose(overlap(blocks, together), worst / np.median(blocks.moments.volume), rtol=1e-7)


def corners_of(blocks, block):
    """Return the corners of a block, (k, 3) [m]."""
    faces = np.flatnonzero((blocks.face_blocks == block).any(axis=1))
    rows = [np.arange(blocks.face_offsets[f], blocks.face_offsets[f + 1]) for f in faces]
    return blocks.vertices[np.unique(blocks.face_vertices[np.concatenate(rows)])]
