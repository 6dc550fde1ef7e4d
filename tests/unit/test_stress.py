"""Average stress of a block (Wang Eq. 3.45, Appendix B) and principal stresses."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.model.supports import bars_of
from bsm_mesh.results.stress import block_stress, extreme_stresses, principal_stresses, stress_is_known
from bsm_mesh.text.tables import describe
from tests.scenes.shapes import square, turned

ROCK = bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2)
RTOL = 1e-12
HEAVY = bsm.Rock("r", unit_weight=25e3, young=1e9, poisson=0.2)
LINEAR = bsm.Options(scheme="linear", threads=1)


def stress_of(polygon, points, forces):
    blocks = bsm.Blocks.from_polygons([polygon], rock="r")
    none = np.zeros(0)
    contacts = initial_contacts(bsm.Model(blocks=blocks, rocks=[ROCK]))
    acting = (np.zeros(len(points), dtype=np.int32), np.asarray(points, float), np.asarray(forces, float))
    return block_stress(blocks, blocks.moments.centroid, contacts, none, none, (acting,))[0]


def test_two_forces_that_pull_give_tension():
    found = stress_of(square(3, 4), [(4, 4.5), (3, 4.5)], [(7, 0), (-7, 0)])
    assert_allclose(found, [(7, 0), (0, 0)], atol=1e-15)


def test_a_self_balanced_shear():
    points = [(1, 0.5), (0, 0.5), (0.5, 1), (0.5, 0)]
    found = stress_of(square(0, 0), points, [(0, 2), (0, -2), (2, 0), (-2, 0)])
    assert_allclose(found, [(0, 2), (2, 0)], atol=1e-15)


def test_only_the_symmetric_part_is_returned():
    found = stress_of(square(0, 0), [(1, 0.5), (0, 0.5)], [(0, 2), (0, -2)])
    assert_allclose(found, [(0, 1), (1, 0)], atol=1e-15)


@pytest.mark.parametrize("sign", [1, -1])
def test_contact_forces_on_both_blocks(sign):
    blocks = bsm.Blocks.from_polygons([square(0, 0), square(0, 1)][::sign], rock="r")
    contacts = initial_contacts(bsm.Model(blocks=blocks, rocks=[ROCK]))
    found = block_stress(blocks, blocks.moments.centroid, contacts, np.array([-3.0, -3.0]), np.zeros(2), ())
    # 6 N over 1 m on one side only: half of it as a mean over the block, compression negative
    assert_allclose(found[:, 1, 1], -3.0, rtol=RTOL)
    assert_allclose(found[:, 0, :], 0.0, atol=1e-15)


@pytest.mark.parametrize("degrees", [0, 20, 90, 200])
def test_principal_stresses(degrees):
    turn = turned(np.eye(2), degrees).T
    found = principal_stresses((turn @ np.diag([-5.0, 2.0]) @ turn.T)[None])
    assert_allclose(found, [[-5.0], [2.0]], rtol=RTOL)


def test_fixed_blocks_have_no_stress_in_any_stage():
    """Statics leaves the place of reactions open: at two points of block 0, and of block 3, which is fixed as a whole.

    Block 1 is on rollers, 2 is held at one point. In the first stage no reaction has a part along x.
    """
    squares = [square(0, 0), square(2, 0), square(4, 0), square(6, 0), square(0, 1)]
    blocks = bsm.Blocks.from_polygons(squares, rock="r").with_boundary("base", lambda x, y: (y < 1e-9) & (x < 1.5))
    blocks = blocks.with_boundary("rollers", lambda x, y: (y < 1e-9) & (x > 1.5) & (x < 3.5))
    push = bsm.PointLoad(block=4, point=(0.5, 1.5), force=(1.0, -7.0))
    model = bsm.Model(
        blocks=blocks,
        rocks=[HEAVY],
        supports=[
            bsm.Fixed(boundary="base"),
            bsm.NormalRoller(boundary="rollers"),
            bsm.Roller(point=(2.5, 0.5), direction=0),
            bsm.Fixed(point=(4.5, 0.5)),
            bsm.Fixed(blocks=[3]),
        ],
        stages=[bsm.Stage(name="push", loads=[push])],
    )
    assert bars_of(model.supports, blocks).leave_stress_open(blocks).tolist() == [True, False, False, True, False]
    results = bsm.run(model.replace(supports=[*model.supports, bsm.Fixed(blocks=[2])]), LINEAR)
    for stage in results.stages:
        assert np.isnan(stage.stress).all(axis=(1, 2)).tolist() == [True, False, True, True, False]
        assert np.isnan(stage.stress_effective).all(axis=(1, 2)).tolist() == [True, False, True, True, False]
        assert stress_is_known(blocks, stage).tolist() == [False, True, False, False, True]
    rows = results.to_pandas("blocks")
    assert rows["sigma_1"].isna().tolist() == [True, False, True, True, False] * 2
    assert results.stages[-1].stress[4, 1, 1] < 0
    assert extreme_stresses(blocks, results.stages[-1])[2] == 3


def test_slivers_have_a_stress_that_does_not_count():
    blocks = bsm.Blocks.from_polygons([square(0, 0), square(0, 1), square(4, 0) * [1.0, 1e-4]], rock="r")
    model = bsm.Model(blocks=blocks, rocks=[HEAVY], supports=[bsm.Fixed(blocks=[0, 2])])
    stage = replace(bsm.run(model, LINEAR).stages[0], stress=np.zeros((3, 2, 2)))
    assert stress_is_known(blocks, stage).tolist() == [True, True, False]


def test_a_model_of_fixed_blocks_has_no_extreme_stress(tmp_path):
    blocks = bsm.Blocks.from_polygons([square(0, 0), square(0, 1)], rock="r")
    results = bsm.run(bsm.Model(blocks=blocks, rocks=[HEAVY], supports=[bsm.Fixed(blocks=[0, 1])]), LINEAR)
    assert ("most compressive stress (sigma_1)", "not available (2 blocks excluded: fixed, or slivers)") in describe(
        results
    )
    summary = json.loads((results.save(tmp_path / "out") / "summary.json").read_text())
    assert summary["stages"][0]["most_compressive_stress"] is None
    again = bsm.Results.load(tmp_path / "out")
    assert np.isnan(again.stages[0].stress).all()


def test_principal_stresses_in_space_are_not_known_where_the_stress_is_not():
    sigma_1, sigma_3 = principal_stresses(np.array([np.diag([-5.0, 2.0, 1.0]), np.full((3, 3), np.nan)]))
    assert_allclose(sigma_1, [-5.0, np.nan])
    assert_allclose(sigma_3, [2.0, np.nan])
