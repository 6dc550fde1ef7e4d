"""Limit analysis from polygons alone: known limits, and agreement with the program's own."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import bsm_mesh as bsm
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.scene import box, turn
from benchmarks.campaign.statics import touching, unbalanced, weights
from benchmarks.campaign.trial import trial_of

NOTHING, SOMETHING = 1e-9, 1e-4  # weights


def lack(polygons, friction, held=(0,), loads=None):
    loads = weights(polygons, 26e3, -90.0) if loads is None else loads
    free = np.setdiff1d(np.arange(len(polygons)), held)
    return unbalanced(polygons, loads, free, friction=friction, reach=1e-6, size=1.0)


@pytest.mark.parametrize(
    ("friction", "height", "rests"), [(31, 1, True), (29, 1, False), (60, 1.7, True), (60, 1.76, False)]
)
def test_a_block_on_an_incline_of_30_degrees_slides_or_topples(friction, height, rests):
    polygons = [turn(box(-3, -1, 3, 0), 30), turn(box(0, 0, 1, height), 30)]
    assert (lack(polygons, friction) < NOTHING) == rests
    assert rests or lack(polygons, friction) > SOMETHING


def test_where_every_free_block_was_taken_away_nothing_is_out_of_balance():
    scene = trial_of(FAMILIES["wall"], 0).scene
    held = replace(scene, polygons=scene.polygons[:2], held=np.arange(2))
    assert held.size > 0
    assert lack(held.polygons, 30, held=(0, 1)) == 0


@pytest.mark.parametrize(("reach", "rests"), [(0.99, True), (1.01, False)])
def test_harmonic_stack(reach, rests):
    ends = np.concatenate([[0], np.cumsum([reach / (2 * k) for k in (4, 3, 2, 1)])])
    polygons = [box(x - 1, 0.5 * k, x, 0.5 * k + 0.5) for k, x in enumerate(ends)]
    assert (lack(polygons, 45.0) < NOTHING) == rests


@pytest.mark.parametrize(("thickness", "rests"), [(0.1082, True), (0.1060, False)])
def test_arch_of_16_stones(thickness, rests):
    angle = np.linspace(np.pi, 0, 17)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    inner, outer = 1 - thickness / 2, 1 + thickness / 2
    stones = [np.array([inner * b, outer * b, outer * a, inner * a]) for a, b in pairwise(ray)]
    feet = [box(-outer, -0.2, -inner, 0), box(inner, -0.2, outer, 0)]
    assert (lack([*feet, *stones], 89.0, held=(0, 1)) < NOTHING) == rests


def test_edges_in_line_that_share_no_length_bear_nothing():
    """Where four blocks meet, one could else hang on the corner of another beside it."""
    beside = [box(0, 0, 1, 1), box(1, 1, 2, 2)]
    assert touching(beside, 1e-6, 1.0).length.size == 0
    hanging = [box(0, 0, 1, 1), box(1, 0, 2, 1)]  # side by side: pressed by nothing
    assert lack(hanging, 30.0) > 0.5


def test_a_corner_does_not_press_on_an_edge_from_inside():
    """The tips of a triangle beside a square touch the ends of its floor and roof, but lie within their lines."""
    found = touching([np.array([(0, 0.5), (1, 0), (1, 1)]), box(1, 0, 2, 1)], 1e-6, 1.0)
    assert found.length.size == 4
    assert (np.abs(found.normal[:, 0]) == 1).all()


def test_all_corners_on_edges_are_found():
    found = touching([box(0, 0, 4, 1), box(1, 1, 2, 2), box(2, 1, 3, 2)], 1e-6, 1.0)
    pairs = sorted(zip(found.corner_block.tolist(), found.edge_block.tolist(), strict=True))
    assert pairs == [(1, 0), (1, 0), (1, 2), (1, 2), (2, 0), (2, 0), (2, 1), (2, 1)]
    on_floor = found.edge_block == 0
    assert (found.normal[on_floor] == (0, 1)).all()


@pytest.mark.parametrize(
    "family", ["slope", "leaning", pytest.param("wall", marks=pytest.mark.heavy), "pile", "tower", "arch", "layers"]
)
def test_agrees_with_the_limit_analysis_of_the_program(family):
    """Two programs of which neither knows the other's contacts."""
    judged = 0
    for seed in range(6):
        scene = trial_of(FAMILIES[family], seed).scene.at_the_end()
        if scene.loads or scene.count > 250:
            continue
        loads = weights(scene.polygons, scene.unit_weight, scene.gravity)
        free = np.setdiff1d(np.arange(scene.count), scene.held)
        size = scene.size
        found = unbalanced(scene.polygons, loads, free, friction=scene.friction, reach=1e-6 * size, size=size)
        assert bsm.limit_analysis(scene.model()).admissible == (found < NOTHING), (family, seed, found)
        judged += 1
    assert judged > 1
