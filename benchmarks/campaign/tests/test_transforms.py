"""A scene in other words has the same elastic answer: what the oracle of symmetry rests on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.scene import DOWN, polygon_area, turn
from benchmarks.campaign.transforms import mirrored, noded, renumbered, scaled, turned
from benchmarks.campaign.trial import trial_of

LINEAR = bsm.Options(scheme="linear", threads=1)
RTOL = 1e-6  # of the greatest displacement: rounding of a stiff system
EVERYTHING = [
    pytest.param("slope+bolts", 1, marks=pytest.mark.heavy),
    ("tunnel+water", 0),
    ("wall+stages", 2),
    ("arch", 5),
    ("plane", 7),
    ("slope+water", 3),
]
UPRIGHT = [("slope+bolts", 0), ("wall+bolts", 1), ("arch+stages", 1)]


def displacement(scene):
    return bsm.run(scene.model(), LINEAR).stages[-1].displacement


def scene_of(family, seed):
    return trial_of(FAMILIES[family], seed).scene


def assert_same(found, expected):
    assert_allclose(found, expected, rtol=0, atol=RTOL * np.abs(expected).max())


@pytest.mark.parametrize(("family", "seed"), EVERYTHING)
def test_mirrored(family, seed):
    scene = scene_of(family, seed)
    assert_same(displacement(mirrored(scene)), displacement(scene) * (-1, 1, -1))


@pytest.mark.parametrize(("family", "seed"), EVERYTHING)
def test_renumbered(family, seed):
    scene = scene_of(family, seed)
    other = renumbered(scene, np.random.default_rng(0))
    order = np.random.default_rng(0).permutation(scene.count)
    assert_same(displacement(other), displacement(scene)[order])


@pytest.mark.parametrize(("family", "seed"), EVERYTHING)
def test_scaled(family, seed):
    scene = scene_of(family, seed)
    assert_same(displacement(scaled(scene, 7.0, 0.3)), displacement(scene) * (7.0, 7.0, 1.0))


@pytest.mark.parametrize(("family", "seed"), UPRIGHT)
def test_turned(family, seed):
    scene = replace(scene_of(family, seed), surface=(), k0=None)
    plain, other = displacement(scene), displacement(turned(scene, 40.0))
    assert_same(other[:, :2], turn(plain[:, :2], 40.0))
    assert_same(other[:, 2], plain[:, 2])


def test_ground_cannot_be_turned():
    with pytest.raises(ValueError, match="cannot be turned"):
        turned(scene_of("tunnel", 0), 10.0)


def test_nodes_lie_on_edges_and_wherever_others_have_corners():
    scene = scene_of("wall", 3)
    there = noded(scene, np.random.default_rng(0))
    assert_allclose([polygon_area(p) for p in there.polygons], [polygon_area(p) for p in scene.polygons], rtol=1e-12)
    base = there.polygons[0]
    for corners in scene.polygons[1:]:  # bricks of the lowest course are on the base
        for corner in corners[np.abs(scene_height(scene, corners)) < 1e-9]:
            assert np.hypot(*(base - corner).T).min() < 1e-9
    assert sum(map(len, there.polygons)) > 1.5 * sum(map(len, scene.polygons))


def scene_height(scene, points):
    """Return the height (k,) of points over the top of the base."""
    third, fourth = scene.polygons[0][2:4]
    along = (third - fourth) / np.hypot(*(third - fourth))
    return (points - fourth) @ np.array([-along[1], along[0]])


@pytest.mark.parametrize("family", ["wall+tilted", "column+tilted", "incline+tilted"])
def test_what_is_tilted_in_stages_ends_as_what_is_tilted_at_once(family):
    """Weights turn from across the base to downwards, none greater or less: linear solutions add up."""
    scene = scene_of(family, 1)
    assert scene.gravity != DOWN
    assert scene.at_the_end().gravity == pytest.approx(DOWN)
    stages = bsm.run(scene.model(), LINEAR).stages
    found = stages[-1].origin + stages[-1].displacement
    assert_same(found, displacement(scene.at_the_end()))
