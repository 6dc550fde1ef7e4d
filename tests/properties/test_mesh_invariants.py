"""How a mesh is numbered, turned and split does not change the blocks made of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from bsm_mesh.converters import convert_mesh
from bsm_mesh.model import Blocks

Array = npt.NDArray[Any]
seeds = st.integers(min_value=0, max_value=2**32 - 1)


def random_mesh(seed: int) -> tuple[Array, Array, Array, Array, Array]:
    """Return points, triangles, lines, and the rock (0, 1) and joint (0, 1) of each."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-10, 10, (int(rng.integers(4, 40)), 2)) + rng.uniform(-1e4, 1e4, 2)
    triangles = Delaunay(points).simplices
    sides = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    lines = sides[rng.random(len(sides)) < 0.3]
    return points, triangles, lines, rng.integers(0, 2, len(triangles)), rng.integers(0, 2, len(lines))


def blocks_of(points: Array, triangles: Array, lines: Array, rock: Array, joint: Array) -> Blocks:
    sets = {
        "rock:a": [np.flatnonzero(rock == 0), None],
        "rock:b": [np.flatnonzero(rock == 1), None],
        "joint:J": [None, np.flatnonzero(joint == 0)],
        "joint:K": [None, np.flatnonzero(joint == 1)],
        "boundary:all": [None, np.arange(len(lines))],
    }
    return convert_mesh(points, [("triangle", triangles), ("line", lines)], sets)[0]


def described(blocks: Blocks) -> list[Any]:
    """Return the blocks as a sorted list: rock, then every edge with its joint and whether it is of the boundary."""
    joints = np.array([*blocks.joint_names, ""])[blocks.edge_joint]
    marked = np.zeros(len(blocks.vertices), dtype=bool)
    if "all" in blocks.boundaries:
        marked[blocks.boundaries["all"]] = True
    found = []
    for b in range(blocks.count):
        edges = range(blocks.offsets[b], blocks.offsets[b + 1])
        outline = [(*blocks.vertices[e].tolist(), str(joints[e]), bool(marked[e])) for e in edges]
        lowest = outline.index(min(outline))
        found.append((blocks.rock_names[blocks.rock[b]], outline[lowest:] + outline[:lowest]))
    return sorted(found)


def neighbours(blocks: Blocks) -> set[tuple[float, float, float]]:
    """Return every point with the number of corners that share it."""
    count = np.bincount(blocks.nodes)
    return {(*v.tolist(), float(count[n])) for v, n in zip(blocks.vertices, blocks.nodes, strict=True)}


@pytest.mark.heavy
@settings(max_examples=60, deadline=None)
@given(seeds, seeds)
def test_renumbering_nodes_and_elements_changes_nothing(seed: int, other: int) -> None:
    points, triangles, lines, rock, joint = random_mesh(seed)
    rng = np.random.default_rng(other)
    new = rng.permutation(len(points))  # new number of each node
    moved = np.empty_like(points)
    moved[new] = points
    t, k = rng.permutation(len(triangles)), rng.permutation(len(lines))
    rolled = np.array([np.roll(row, rng.integers(3)) for row in triangles])
    first = blocks_of(points, triangles, lines, rock, joint)
    second = blocks_of(moved, new[rolled][t], new[lines][k][:, ::-1], rock[t], joint[k])
    assert described(first) == described(second)
    assert neighbours(first) == neighbours(second)


@pytest.mark.heavy
@settings(max_examples=60, deadline=None)
@given(seeds, seeds)
def test_turning_elements_round_changes_nothing(seed: int, other: int) -> None:
    points, triangles, lines, rock, joint = random_mesh(seed)
    turned = triangles.copy()
    which = np.random.default_rng(other).random(len(triangles)) < 0.5
    turned[which] = turned[which][:, ::-1]
    first = blocks_of(points, triangles, lines, rock, joint)
    assert described(first) == described(blocks_of(points, turned, lines, rock, joint))


@pytest.mark.heavy
@settings(max_examples=60, deadline=None)
@given(seeds, seeds)
def test_giving_every_element_nodes_of_its_own_changes_nothing(seed: int, other: int) -> None:
    points, triangles, lines, rock, joint = random_mesh(seed)
    used = np.concatenate([triangles.ravel(), lines.ravel()])
    n = triangles.size
    first = blocks_of(points, triangles, lines, rock, joint)
    own = np.arange(len(used))
    second = blocks_of(points[used], own[:n].reshape(-1, 3), own[n:].reshape(-1, 2), rock, joint)
    assert described(first) == described(second)
    assert neighbours(first) == neighbours(second)


@pytest.mark.heavy
@settings(max_examples=40, deadline=None)
@given(seeds, seeds)
def test_repeating_elements_changes_nothing(seed: int, other: int) -> None:
    points, triangles, lines, rock, joint = random_mesh(seed)
    rng = np.random.default_rng(other)
    t = np.concatenate([np.arange(len(triangles)), rng.integers(0, len(triangles), 5)])
    k = np.concatenate([np.arange(len(lines)), rng.integers(0, max(len(lines), 1), 5 * (len(lines) > 0))])
    first = blocks_of(points, triangles, lines, rock, joint)
    assert described(first) == described(blocks_of(points, triangles[t], lines[k], rock[t], joint[k]))


@settings(max_examples=40, deadline=None)
@given(seeds)
def test_every_line_between_two_corners_marks_both_sides(seed: int) -> None:
    points, triangles, lines, rock, joint = random_mesh(seed)
    blocks = blocks_of(points, triangles, lines, rock, joint)
    uses = {tuple(line): 0 for line in np.sort(lines, axis=1).tolist()}
    for triangle in triangles.tolist():
        for a, b in ((0, 1), (1, 2), (2, 0)):
            side = tuple(sorted((triangle[a], triangle[b])))
            if side in uses:
                uses[side] += 1
    assert np.count_nonzero(blocks.edge_joint >= 0) == sum(uses.values())
