"""Contact search: what is found at the start and by a slow search, and that nothing but the blocks matters."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.contact import contact_set, search
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.model.faces import find_faces
from tests.scenes.contacts import (
    Scene,
    brute_candidates,
    delaunay_triangles,
    jagged_interface,
    near_scene,
    random_wall,
)
from tests.scenes.models import model_of
from tests.scenes.shapes import gmsh_triangles, grid, rectangle, running_bond, turned

ATOL = 1e-9  # m, of blocks about 1 m large near the origin
seeds = st.integers(min_value=0, max_value=2**32 - 1)


def voronoi_cells(rng, n):
    """Return the cells of n random points in the unit square, mirrored at its sides so that they fill it."""
    from scipy.spatial import Voronoi

    p = rng.random((n, 2))
    mirrored = [p, p * (-1, 1), p * (1, -1), (2, 0) + p * (-1, 1), (0, 2) + p * (1, -1)]
    diagram = Voronoi(np.concatenate(mirrored))
    return [diagram.vertices[diagram.regions[r]] for r in diagram.point_region[:n]]


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
    rows = scene.within_tolerance(found)
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
    assert np.abs(found.gap[scene.within_tolerance(found)]).max() < ATOL


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
    assert (found.predecessor == -1).all()
    assert_allclose(sorted(found.tangential), [2, 3])  # the top of the lower block runs from right to left
    assert_allclose(found.edge_length, 4)
    assert_allclose(found.length, 0.5)
    assert found.pair.tolist() == [1, 1]
    assert found.key.tolist() == [(int(v) << 32) | int(e) for v, e in zip(found.corner, found.edge, strict=True)]
    assert (scene.blocks.owner[found.parallel_edge] == 1).all()
    assert scene.detect(band=0.02).count == 0


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


@pytest.mark.heavy
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
    for name in ("gap", "tangential", "edge_length", "length"):
        assert_allclose(getattr(found, name), [brute[k][name] for k in keys], atol=1e-9, err_msg=name)
    for k, key in enumerate(keys):
        if found.corner_gap[k] == 0:
            assert found.in_range[k] == brute[key]["in_range"]
            assert not brute[key]["end_to_end"]
        elif not brute[key]["end_to_end"]:  # the front of a low step: the face beyond is another way out
            levels = [brute[other] for other in brute if set(blocks_of(brute, other)) == set(blocks_of(brute, key))]
            assert any(row["parallel"] and abs(row["gap"]) < RULES.min_overlap * row["h"] for row in levels)
    assert ((found.parallel_edge >= 0) == [brute[k]["parallel"] for k in keys]).all()
    for key in set(brute) - set(keys):
        assert reason_to_drop(scene, key, brute, set(keys), band), key


def blocks_of(brute, key):
    return brute[key]["a"], brute[key]["b"]


def reason_to_drop(scene, key, brute, kept, band):
    """Whether one of the rules that weigh candidates against each other explains that one is missing."""
    row, placed, following = brute[key], scene.placed, scene.blocks.following
    if row["gap"] < -RULES.new_penetration * row["h"] or row["end_to_end"]:
        return True
    for other in kept:
        opposed = brute[other]
        in_range = opposed["in_range"] and row["in_range"]
        same_corner = other[0] == key[0] and opposed["b"] == row["b"] and in_range
        closed = row["gap"] <= RULES.closure_tol * row["h"]
        better = opposed["gap"] >= row["gap"] - RULES.rounding * row["h"]
        if same_corner and closed and better:
            return True
        near = np.hypot(*(placed[other[0]] - placed[key[0]])) < RULES.dual_distance * band
        swapped = other[0] in (key[1], following[key[1]]) and key[0] in (other[1], following[other[1]])
        if near and swapped and opposed["in_range"] and opposed["gap"] <= RULES.new_penetration * opposed["h"]:
            return True
    return False


@pytest.mark.heavy
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
    for name in ("gap", "tangential", "length"):
        assert_allclose(getattr(one, name), getattr(other, name), atol=1e-8)


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
    assert len(scene.within_tolerance(scene.detect())) == 1200


@pytest.mark.heavy
def test_pairs_looked_at_apart_by_two_threads_find_the_same(monkeypatch):
    """Row for row, with history, heirs and rivals, at every step of bricks that slide off a base, beside squares."""
    given, real = [], search.detect_contacts

    def both(outlines, position, active, band):
        alone = real(outlines, position, active, band)
        with monkeypatch.context() as two:
            two.setattr(search, "PAIRS_AT_ONCE", 7)
            by_two = real(outlines, position, active, band)
        for field in dataclasses.fields(alone):
            assert_array_equal(getattr(by_two, field.name), getattr(alone, field.name), err_msg=field.name)
        given.append([(getattr(alone, name) >= 0).any() for name in ("history", "predecessor", "opposing_candidate")])
        return alone

    monkeypatch.setattr(contact_set, "detect_contacts", both)
    model = model_of(
        [rectangle(-1, -1, 15, 0), *running_bond(4, 4), *(np.add(square, (8, 0)) for square in grid(3, 3))],
        gamma=26e3,
        friction=10.0,
        gravity_direction=-60.0,
    )
    bsm.run(model, bsm.Options(max_steps=60))
    assert len(given) > 20
    assert np.any(given, axis=0).all()
