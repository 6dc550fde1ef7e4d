"""Elements and interfaces halved, and the limit to which they tend."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters import solve_continuum
from bsm_mesh.converters.continuum import compare_stages, solve_continuum_stages
from bsm_mesh.converters.continuum.refinement import refinement_of
from tests.scenes.continuum import cantilever, sag
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import rectangle

H, L, K, PUSH = 2.0, 1.0, 1e9, 10e3


def pushed(options):
    """Return a rigid block on an elastic joint, pushed at its centroid: it turns about the joint."""
    model = model_of(
        [rectangle(0, -1, L, 0), rectangle(0, 0, L, H)],
        loads=[bsm.PointLoad(block=1, point=(L / 2, H / 2), force=(PUSH, 0.0))],
    )
    model = model.replace(joints=[bsm.Joint("J", normal_stiffness=K, shear_stiffness=K)])
    return model, bsm.run(model, options)


def test_two_points_hold_a_face_three_times_as_stiffly_against_rotation_as_it_is():
    """N pieces with points at their ends: K L^3 / 12 (1 + 2 / n^2); all at once the limit, K L^3 / 12."""
    model, results = pushed(LINEAR)
    (stage,) = compare_stages(model, results, refinements=3)
    study = stage.comparison.refinement

    def movement(stiffness):
        return PUSH / (K * L) + PUSH * H / 2 / stiffness * H / 2

    sideways = [movement(K * L**3 / 12 * (1 + 2 / n**2)) for n in (1, 2, 4, 8)]
    settlement = 25e3 * H / K
    assert_allclose([level.greatest for level in study.levels], np.hypot(sideways, settlement), rtol=1e-3)
    assert_allclose(
        study.limit[1], [movement(K * L**3 / 12), -settlement], rtol=2e-2
    )  # the series is not quite geometric
    assert [level.cells for level in study.levels] == [2 * 4**k for k in range(4)]
    assert [level.points for level in study.levels] == [2 * 2**k for k in range(4)]
    assert study.too_coarse.tolist() == [1]
    assert stage.sentence.endswith("the blocks' own contact points are too coarse for block 1.")
    assert "halving elements and interfaces 3 times takes the greatest displacement from" in stage.sentence


def test_fine_enough():
    """Without a push the face is under uniform pressure, and two points are as good as many."""
    model, _ = pushed(LINEAR)
    model = model.replace(loads=[])
    (stage,) = compare_stages(model, bsm.run(model, LINEAR), refinements=2)
    assert stage.comparison.refinement.too_coarse.size == 0
    assert "the blocks' own contact points are fine enough" in stage.sentence


def test_elements_that_are_too_coarse_are_not_called_contact_points():
    """A cantilever with joints that hardly yield: refining changes what it changes without any joint."""
    model = cantilever(8, 0.45, mixed=False)
    whole = model.replace(joints=[bsm.Joint("J", normal_stiffness=1e14, shear_stiffness=1e14)], default_joint="J")
    results = bsm.run(whole, LINEAR)
    (stage,) = compare_stages(whole, results)
    coarse, fine = (sag(model, solve_continuum(model, order=order).displacement) for order in (1, 2))
    assert_allclose(stage.comparison.refined, 1 - coarse / fine, rtol=0.1)
    assert stage.sentence.endswith("the elements, or the contact points of both, are too coarse for displacements.")
    (stage,) = compare_stages(whole, results, refinements=1)
    assert "the elements, or the blocks' own contact points, are too coarse for block" in stage.sentence
    model, results = pushed(LINEAR)
    (stage,) = compare_stages(model, results)
    assert stage.sentence.endswith(": the contact points of both are too coarse for displacements.")


def test_without_interfaces_elements_are_halved():
    model = cantilever(8, 0.2, mixed=False)
    (stage,) = compare_stages(model, bsm.run(model, LINEAR), refinements=1)
    assert "; halving elements once takes the greatest displacement from" in stage.sentence


@pytest.fixture(scope="module")
def solved():
    model, _ = pushed(LINEAR)
    (stage,) = solve_continuum_stages(model, order=1, joints=True)
    return model, stage


def study_of(solved, sizes, asked):
    model, stage = solved
    stages = [dataclasses.replace(stage, displacement=stage.displacement * size) for size in sizes]
    return refinement_of(stages, asked, model.blocks.moments.area, np.array([True, False]), True)


def test_changes_that_do_not_fall_have_no_limit(solved):
    study = study_of(solved, [1.0, 1.1, 1.3], 2)
    assert study.limit is None
    assert "and its changes do not fall yet" in study.sentence


def test_where_it_ends_without_equilibrium(solved):
    assert "halved once more they find no equilibrium" in study_of(solved, [1.0, 1.1], 3).sentence
    assert "halved the finite elements find no equilibrium" in study_of(solved, [1.0], 3).sentence
    assert study_of(solved, [0.0, 0.0], 1) is None


def test_geometric_series(solved):
    study = study_of(solved, [1.0, 1.5, 1.75], 2)
    assert_allclose(study.limit, 2.0 * solved[1].displacement[:, :2], rtol=1e-12)
