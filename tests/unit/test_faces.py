"""Faces: where two blocks touch, against a comparison of every edge with every other."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.faces import find_faces
from tests.scenes.reference import brute_faces
from tests.scenes.shapes import grid, rectangle, running_bond, square, turned

ATOL = 1e-8  # m, of faces about 1 m long whose corners carry noise of 1e-9 m at most


def blocks(polygons):
    return bsm.Blocks.from_polygons(polygons, rock="r")


def rows(b, faces):
    """Return the faces as sorted rows (lower block, higher block, two ends in a fixed order)."""
    found = []
    for ea, eb, start, end in zip(faces.edge_a, faces.edge_b, faces.start, faces.end, strict=True):
        i, j = sorted((int(b.owner[ea]), int(b.owner[eb])))
        ends = sorted([tuple(np.round(start, 6) + 0.0), tuple(np.round(end, 6) + 0.0)])
        found.append((i, j, *ends[0], *ends[1]))
    return np.array(sorted(found)).reshape(-1, 6)


def expected_rows(polygons):
    found = []
    for i, j, start, end in brute_faces(polygons):
        ends = sorted([tuple(np.round(start, 6) + 0.0), tuple(np.round(end, 6) + 0.0)])
        found.append((i, j, *ends[0], *ends[1]))
    return np.array(sorted(found)).reshape(-1, 6)


SCENES = {
    "conforming grid": (grid(3, 3), 12),
    "running bond": (running_bond(4, 3), 3 * 6 + 2 * 2 + 2 * 3),
    "T: one wide block under three": ([rectangle(0, -1, 3, 0), *grid(3, 1)], 5),
    "cross of unequal lengths": ([rectangle(0, 0, 2.3, 1), rectangle(-0.7, 1, 1.1, 2), rectangle(1.1, 1, 4, 1.4)], 3),
    "one edge within another": ([rectangle(0, 0, 5, 1), rectangle(2, 1, 3, 2)], 1),
    "overhanging at both ends": ([rectangle(1, 0, 2, 1), rectangle(0, 1, 3, 2)], 1),
    "corners only": ([square(0, 0), square(1, 1)], 0),
    "corner on an edge": ([rectangle(0, 0, 3, 1), np.array([(1, 1), (2, 2), (0, 2)])], 0),
    "apart": ([square(0, 0), square(1.1, 0)], 0),
    "single": ([square(0, 0)], 0),
    "concave": ([np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]), rectangle(1, 1, 2, 2)], 2),
    "a corner within an edge of one's own block": (
        [np.array([(0, 0), (1, 0), (2, 0), (2, 1), (0, 1)]), rectangle(0, -1, 2, 0)],
        2,
    ),
}


@pytest.mark.parametrize("degrees", [0.0, 30.0, 77.7, -135.3])
@pytest.mark.parametrize("name", SCENES)
def test_faces_of(name, degrees):
    polygons, count = SCENES[name]
    polygons = [turned(p, degrees, (12.3, -4.5)) for p in polygons]
    b = blocks(polygons)
    faces = find_faces(b)
    assert len(faces.edge_a) == count
    assert_allclose(rows(b, faces), expected_rows(polygons), atol=2e-6)  # rows are rounded to 1e-6


@pytest.mark.parametrize("noise", [1e-10, 1e-9, 1e-8])  # below, at and above the merge tolerance
@pytest.mark.parametrize("scene", [running_bond(6, 4), grid(4, 4)])
@pytest.mark.parametrize("degrees", [0.0, 30.0, 77.7])
def test_rounding_noise_changes_nothing(degrees, scene, noise):
    """Also where two blocks touch at a corner only: the noise makes no sliver of a face of it."""
    clean = [turned(p, degrees) for p in scene]
    rng = np.random.default_rng(7)
    noisy = [p + rng.uniform(-noise, noise, p.shape) for p in clean]
    exact, found = find_faces(blocks(clean)), find_faces(blocks(noisy))
    assert len(found.edge_a) == len(exact.edge_a)
    assert_allclose(rows(blocks(noisy), found), rows(blocks(clean), exact), atol=2e-6)


def test_long_and_short_edges_together():
    wide = rectangle(0, -100, 1000, 0)
    small = grid(np.arange(0, 1001, 1.0), [0, 1])
    b = blocks([turned(p, 41.3) for p in [wide, *small]])
    faces = find_faces(b)
    assert len(faces.edge_a) == 1000 + 999
    assert_allclose(np.hypot(*(faces.end - faces.start).T), 1.0, atol=ATOL)


def test_ends_run_with_edge_b_and_against_edge_a():
    for polygons, _ in SCENES.values():
        b = blocks(polygons)
        faces = find_faces(b)
        along = faces.end - faces.start
        assert ((along * b.edge_vectors[faces.edge_b]).sum(axis=1) > 0).all()
        assert ((along * b.edge_vectors[faces.edge_a]).sum(axis=1) < 0).all()


@pytest.mark.parametrize(
    "name", ["running bond", "T: one wide block under three", "one edge within another", "concave"]
)
def test_ends_are_corners_of_the_edge_that_is_named(name):
    b = blocks(SCENES[name][0])
    faces = find_faces(b)
    for at, of_a in ((faces.start, faces.start_corner_of_a), (faces.end, faces.end_corner_of_a)):
        edge = np.where(of_a, faces.edge_a, faces.edge_b)
        ends = np.stack([b.vertices[edge], b.vertices[b.following[edge]]], axis=1)
        nearest = np.hypot(*(ends - at[:, None]).transpose(2, 0, 1)).min(axis=1)
        assert_allclose(nearest, 0.0, atol=ATOL)


@pytest.mark.parametrize(
    ("triangles", "message"),
    [
        ([(0, 1, 2), (0, 1, 2)], "blocks 0 and 1 overlap: both lie on the same side of their edge at"),
        ([(0, 1, 2), (0, 1, 3)], "blocks 0 and 1 overlap"),
        ([(0, 1, 2), (1, 0, 4), (0, 1, 3)], "blocks 0 and 2 overlap"),
    ],
)
def test_overlapping_blocks_raise(triangles, message):
    points = np.array([(0, 0), (1, 0), (0.5, 1), (0.5, 2), (0.5, -1)], dtype=float)
    nodes = np.ravel(triangles)
    overlapping = bsm.Blocks(
        vertices=points[nodes],
        offsets=np.arange(0, len(nodes) + 1, 3),
        nodes=nodes,
        rock=np.zeros(len(triangles), dtype=int),
        rock_names=("r",),
        edge_joint=np.full(len(nodes), -1),
    )
    with pytest.raises(bsm.ModelError, match=re.escape(message)):
        find_faces(overlapping)


def test_scale_does_not_matter():
    for size in (1e-3, 1e3, 1e6):
        polygons = [size * turned(p, 12.0) for p in running_bond(3, 3)]
        assert len(find_faces(blocks(polygons)).edge_a) == len(find_faces(blocks(running_bond(3, 3))).edge_a)


def test_far_from_the_origin():
    polygons = [turned(p, 12.0, (1e6, 4e6)) for p in running_bond(3, 3)]
    assert len(find_faces(blocks(polygons)).edge_a) == len(find_faces(blocks(running_bond(3, 3))).edge_a)
