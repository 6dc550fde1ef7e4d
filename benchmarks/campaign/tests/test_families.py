"""Random models: the same ones every time, sound, and of closed forms that limit analysis confirms."""

from __future__ import annotations

import numpy as np
import pytest

import bsm_mesh as bsm
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.families.rocking import level_limits, tilt_at_rest
from benchmarks.campaign.scene import box
from benchmarks.campaign.sizes import SIZES, families_of, scene_of
from benchmarks.campaign.trial import trial_of

RIGID = ("incline", "column", "tower", "plane", "arch", "layers")  # forms that limit analysis knows exactly
NEAR = 1e-4  # margins that rounding of the table of arches and of the program could turn


def test_a_campaign_has_at_least_two_thousand_models():
    assert sum(family.models for family in FAMILIES.values()) >= 2000


@pytest.mark.heavy
@pytest.mark.parametrize("name", FAMILIES)
def test_the_same_seed_makes_the_same_sound_model(name):
    models = [trial_of(FAMILIES[name], seed).scene.model() for seed in (3, 3, 4)]
    assert models[0].digest == models[1].digest != models[2].digest
    scenes = [trial_of(FAMILIES[name], seed).scene.digest for seed in (3, 3, 4)]
    assert scenes[0] == scenes[1] != scenes[2]
    scene = trial_of(FAMILIES[name], 3).scene
    assert scene.free.size > 0
    assert models[0].blocks.count == scene.count
    left = scene.at_the_end()
    assert left.count == scene.count - sum(dig.blocks.size for dig in scene.digs)
    assert not left.digs
    assert left.model().blocks.count == left.count


@pytest.mark.heavy
@pytest.mark.parametrize("name", RIGID)
def test_limit_analysis_confirms_the_closed_form(name):
    signs = set()
    for seed in range(30):
        trial = trial_of(FAMILIES[name], seed)
        if trial.expected is None or abs(trial.expected.margin) < (5e-3 if name == "arch" else NEAR):
            continue
        admissible = bsm.limit_analysis(trial.scene.model()).admissible
        assert admissible == (trial.expected.margin > 0), (seed, trial.expected)
        signs.add(admissible)
    assert signs == {True, False}


def test_the_limit_of_a_flat_arch_is_where_its_load_has_no_rest():
    """By another way than the family: the balance of a stone, found by following the load up."""
    trial = trial_of(FAMILIES["beam"], 1)
    scene, given = trial.scene, trial.parameters
    length, height, k = given["length"], given["height"], scene.kn * given["height"] / 2
    weight = scene.unit_weight * length * height
    rise = np.linspace(1e-6, height, 200_001)  # left of the diagonal of a stone
    run = np.sqrt(length**2 + height**2 - rise**2)
    thrust = k * (run - length) / 1.5
    limit = (2 * thrust * rise / run).max()
    assert trial.expected.margin == pytest.approx(1 - weight / limit, abs=1e-5)


def test_large_scenes_are_as_many_as_promised():
    assert {size: len(families_of(size)) for size in SIZES} == {"1e4": 20, "1e5": 6, "1e6": 1, "random": 30}


def test_a_random_large_scene_is_the_same_every_time():
    names = list(families_of("random"))
    assert len({name.split()[2] for name in names}) == 6  # kinds
    for name in names[:2]:
        first, again = (trial_of(families_of("random")[name], 0).scene for _ in range(2))
        assert first.digest == again.digest
        assert 4500 < first.count < 11_500


@pytest.mark.parametrize("number", [2, pytest.param(13, marks=pytest.mark.heavy), 17, 18])
def test_a_scene_of_the_benchmark_suite_stays_what_it_is(number):
    """In situ, excavated, with layers and with bolts: the same blocks, loads and bolts, so the same limit analysis."""
    named = SIZES["1e4"][1][number]
    given = named.build(200).model(named.k0)
    made = scene_of(named, 200).model()
    assert made.blocks.count == given.blocks.count
    assert made.bolts == given.bolts
    np.testing.assert_allclose(made.gravity_forces, given.gravity_forces)
    assert (made.in_situ is None) == (given.in_situ is None)
    assert len(made.stages) == len(given.stages)
    if given.stages:
        ours, theirs = (bsm.run(model, bsm.Options(scheme="linear")).stages[-1].present for model in (made, given))
        assert (ours == theirs).all()


@pytest.mark.heavy
def test_a_column_on_water_leaves_its_heel_where_the_moments_balance():
    """By hand: b/2 of the weight against a triangle of pressure at a third, and an uplift at two thirds of the base."""
    b, h, tail = 2.0, 8.0, 0.0
    column = [box(-b, 0, 0, h)]
    leaves, falls = level_limits(column, tail)
    assert 9810 * (leaves**3 / 6 + leaves * b / 2 * 2 * b / 3) == pytest.approx(25e3 * b * h * b / 2)
    assert tilt_at_rest(column, leaves - 1e-6, tail) == 0.0
    assert 0 < tilt_at_rest(column, (leaves + falls) / 2, tail) < tilt_at_rest(column, falls - 1e-3, tail)
    assert tilt_at_rest(column, falls + 1e-3, tail) is None
