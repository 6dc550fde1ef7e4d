"""Filled blocks against closed forms: they fit the ground as it is, and take no load until the next change."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.fitted_fill import fitted_fill
from bsm_mesh.movements import carried
from tests.scenes.polyhedra import box, model_in_space

FLOOR, LEFT, RIGHT, FILL, ROOF = range(5)
OUTLINES = [(0, -1, 5, 0), (0, 0, 1, 1), (4, 0, 5, 1), (2, 0, 3, 1), (0, 1, 5, 2)]
KN, LOAD, MORE = 1e9, 5e6, 3e6  # Pa/m, Pa, Pa: the roof of 5 m sinks by 25 mm on two pillars, 2.5 % of the fill
ROUNDING = 1e-6  # of the load: convergence
STAGES = [
    bsm.Stage(name="dug", excavate=[FILL]),
    bsm.Stage(name="filled", fill=[FILL]),
    bsm.Stage(name="loaded", loads=[bsm.Pressure(boundary="top", pressure=MORE)]),
]


def in_plane(**given) -> bsm.Model:
    polygons = [[(x, y), (u, y), (u, v), (x, v)] for x, y, u, v in OUTLINES]
    blocks = bsm.Blocks.from_polygons(polygons, rock="rock").with_boundary("top", lambda x, y: y > 2 - 1e-9)
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=0.0, **given)],
        joints=[bsm.Joint("J", normal_stiffness=KN, shear_stiffness=KN, law=bsm.MohrCoulomb(friction=30.0))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[FLOOR])],
        loads=[bsm.Pressure(boundary="top", pressure=LOAD)],
        stages=STAGES,
    )


def in_space() -> bsm.Model:
    model = model_in_space([box((x, 0, y), (u, 1, v)) for x, y, u, v in OUTLINES], kn=KN, ks=KN)
    return model.replace(
        blocks=model.blocks.with_boundary("top", lambda x, y, z: z > 2 - 1e-9),
        rocks=[bsm.Rock("granite", unit_weight=0.0)],
        loads=[bsm.Pressure(boundary="top", pressure=LOAD)],
        stages=STAGES,
    )


@pytest.mark.parametrize(
    ("make", "up"), [(in_plane, 1), pytest.param(in_space, 2, marks=pytest.mark.heavy)], ids=["plane", "space"]
)
def test_a_pillar_put_back_takes_its_part_of_later_loads_alone(make, up):
    """Nothing at first; of the later load a third, for the three pillars are alike. Pillars sink by 2 N / kn."""
    results = bsm.run(make())
    assert [stage.status for stage in results.stages] == ["stable"] * 4
    assert results.check().ok
    _, dug, filled, loaded = results.stages
    sunk = 2 * 5 * LOAD / 2 / KN
    assert_allclose(dug.displacement[ROOF, up], -sunk, rtol=ROUNDING)
    assert_allclose(filled.stage_displacement[ROOF, up], 0.0, atol=ROUNDING * sunk)
    assert_allclose(filled.origin[FILL, up], -sunk / 2, rtol=ROUNDING)  # half way between floor and roof
    for stage, expected in ((filled, 0.0), (loaded, 5 * MORE / 3)):
        contacts = stage.contacts
        on_fill = {FILL, ROOF}
        rows = [{a, b} == on_fill for a, b in zip(contacts.block_a, contacts.block_b, strict=True)]
        assert_allclose(-contacts.normal_force[rows].sum(), expected, rtol=ROUNDING, atol=ROUNDING * LOAD)
    assert_allclose(loaded.displacement[FILL, up], -5 * MORE / 3 / KN, rtol=ROUNDING)


@pytest.mark.parametrize("axes", [3, 6])
def test_fill_follows_ground_that_moved_as_a_whole(axes):
    """By any rotation, exactly; a row of fill between two blocks too."""
    rng = np.random.default_rng(4)
    places = 2 if axes == 3 else 3
    centroid = np.zeros((4, places))
    centroid[:, 0] = np.arange(4)
    a, b = (np.repeat(side, 6) for side in ([0, 1, 2], [1, 2, 3]))
    point = (centroid[a] + centroid[b]) / 2 + rng.uniform(-0.5, 0.5, (18, places))
    turn = 0.6 if axes == 3 else np.array([0.3, -0.5, 0.4])
    whole = np.concatenate([np.zeros(places), np.atleast_1d(turn)])[None]
    there = np.hstack(
        [[3.0, -2.0, 1.0][:places] + carried(centroid, np.repeat(whole, 4, axis=0)), np.tile(turn, (4, 1))]
    )
    fill = np.array([False, True, True, False])
    moved = np.where(fill[:, None], 0.0, there)
    assert_allclose(fitted_fill(moved, fill, (a, b), point, np.ones(18), centroid), there, atol=1e-9)


def test_fill_where_nothing_moved_is_as_given():
    fill, none = np.array([False, True]), np.zeros((2, 3))
    sides, point = (np.array([0, 0]), np.array([1, 1])), np.array([[0.5, -0.5], [0.5, 0.5]])
    found = fitted_fill(none, fill, sides, point, np.ones(2), np.array([[0.0, 0.0], [1.0, 0.0]]))
    assert not found.any()


def test_supported_fill_is_where_it_was_given():
    model = in_plane()
    model = model.replace(supports=[*model.supports, bsm.Roller(blocks=[FILL], direction=0)])
    results = bsm.run(model)
    assert results.stages[-1].status == "stable"
    assert not results.stages[-1].origin[FILL].any()
