"""Average stress of a block (Wang Eq. 3.45, Appendix B) and principal stresses."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.results.records import SupportForces
from bsm_mesh.results.stress import (
    block_stress,
    extreme_stresses,
    extreme_zone_stresses,
    principal_stresses,
    stress_is_known,
)
from tests.scenes.shapes import square, turned

ROCK = bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2)
RTOL = 1e-12


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


def test_blocks_that_supports_hold_and_slivers_have_no_stress_to_tell():
    """Block 0 is held at two points, 1 is on a roller, 2 is held as a whole, 3 is a sliver, 4 is none of these."""
    blocks = bsm.Blocks.from_polygons(
        [square(0, 0), square(2, 0), square(4, 0), square(6, 0) * [1.0, 1e-4], square(8, 0)], rock="r"
    )
    supports = SupportForces(
        block=np.array([0, 0, 1, 1, 2]),
        point=np.zeros((5, 2)),
        reaction=np.array([(1.0, 2.0), (-1.0, 2.0), (0.0, 3.0), (0.0, 3.0), (0.0, 6.0)]),
        moment=np.array([0.0, 0.0, 0.0, 0.0, 1.0]),
    )
    stage = SimpleNamespace(present=np.ones(5, dtype=bool), supports=supports, zones=None)
    known = stress_is_known(blocks, stage)
    assert known.tolist() == [False, True, False, False, True]


def stud_on_a_slab(joint, stiffness):
    """Return the last stage and blocks of a slab with a stud of 0.5 % of the mean area, which carries 1 MPa."""
    slab = [(0, 0), (3, 0), (3, 1), (2, 1), (1.45, 1), (1.4, 1), (0, 1)]
    stud = [(1.4, 1), (1.45, 1), (1.45, 1.05), (1.4, 1.05)]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons([slab, stud, square(2, 1)], rock="r")
        .with_boundary("bottom", lambda x, y: y < 1e-9)
        .with_boundary("top", lambda x, y: (x < 1.6) & (y > 1.05 - 1e-9)),
        rocks=[bsm.Rock("r", unit_weight=0.0, young=1e9, poisson=0.0, zones=bsm.Zones(order=1))],
        joints=[bsm.Joint("J", normal_stiffness=stiffness, shear_stiffness=stiffness)],
        default_joint=joint,
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=1e6)],
    )
    return bsm.run(model).stages[-1], model.blocks


@pytest.mark.parametrize("joint", [None, "J"])
def test_a_small_block_counts_where_it_is_one_piece_with_a_large_one(joint):
    """On a joint of its own the stud is a sliver."""
    stage, blocks = stud_on_a_slab(joint, 1e12)
    part_of_the_slab = joint is None
    assert stage.small_blocks.tolist() == ([] if part_of_the_slab else [1])
    assert (extreme_zone_stresses(stage)[0] < -0.9e6) == part_of_the_slab
    assert (extreme_stresses(blocks, stage)[0] < -0.9e6) == part_of_the_slab


def test_a_sliver_that_moves_far_does_not_end_small_displacements():
    """It closes its joint by 2 % of its size, where 1 % is the limit of blocks that count."""
    stage, _ = stud_on_a_slab("J", 1e9)
    assert abs(stage.displacement[1, 1]) > 0.01 * 0.05
    assert (stage.status, stage.small_blocks.tolist()) == ("stable", [1])
