"""Supports and the bars that they represent (Wang 3.3.4)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.supports import bars_of, unit_vector
from tests.scenes.faults import fault
from tests.scenes.models import framed
from tests.scenes.shapes import grid, turned

BLOCKS = framed(bsm.Blocks.from_polygons(grid(2, 2), rock="r"), 2, 2)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: bsm.Fixed(), "support Fixed: give exactly one of blocks, boundary, point; given: none"),
        (
            lambda: bsm.Roller(blocks=[0], boundary="top", direction=0),
            "support Roller: give exactly one of blocks, boundary, point; given: blocks, boundary",
        ),
        (lambda: bsm.Roller(blocks=[0], direction=None), "support Roller: direction = None is not a finite number"),
        (
            lambda: bsm.PrescribedDisplacement(blocks=[0], direction=0, displacement=np.inf),
            "support PrescribedDisplacement: displacement = inf is not a finite number [m]",
        ),
        (
            lambda: bsm.NormalRoller(blocks=[0]),
            "support NormalRoller: needs a boundary; blocks and points have no normal",
        ),
        (lambda: bsm.Fixed(point=(1, 2, 3)), "support Fixed: point = (1, 2, 3) must be two numbers (x, y) [m]"),
        (lambda: bsm.Fixed(blocks=[0.5]), "support Fixed: blocks must be block numbers"),
    ],
)
def test_faults(make, message):
    with fault(message):
        make()


def test_a_mask_is_not_taken_for_the_blocks_0_and_1():
    with fault("of a mask give np.flatnonzero(mask)"):
        bsm.Fixed(blocks=np.array([False, False, True]))


def test_faults_name_the_support():
    supports = (
        bsm.Fixed(boundary="botom"),
        bsm.Fixed(blocks=[4, 1, -1]),
        bsm.Roller(point=(5, 5), direction=0),
    )
    with pytest.raises(bsm.ModelError) as caught:
        bars_of(supports, BLOCKS)
    assert caught.value.faults == (
        "support 1 (Fixed): there is no boundary 'botom'; did you mean 'bottom'? (known: bottom, left, right, top)",
        "support 2 (Fixed): there is no block 4, -1; blocks are numbered 0 to 3",
        "support 3 (Roller): the point (5, 5) lies in no block",
    )


def test_fixed_blocks_hold_both_components_and_the_rotation():
    bars = bars_of((bsm.Fixed(blocks=[3, 1]),), BLOCKS)
    assert sorted(bars.block.tolist()) == [1, 1, 1, 3, 3, 3]
    assert bars.holds_rotation.sum() == 2
    assert_allclose(bars.direction[bars.holds_rotation], 0)
    assert_allclose(bars.point, BLOCKS.moments.centroid[bars.block])


def test_fixed_boundary_holds_both_ends_of_each_edge():
    bars = bars_of((bsm.Fixed(boundary="bottom"),), BLOCKS)
    assert len(bars.block) == 2 * 2 * 2
    assert not bars.holds_rotation.any()
    assert_allclose(bars.point[:, 1], 0)


def test_a_corner_holds_every_block_that_has_it_and_another_point_one_block():
    assert bars_of((bsm.Roller(point=(1, 1), direction=0),), BLOCKS).block.tolist() == [0, 1, 2, 3]
    assert bars_of((bsm.Roller(point=(0.5, 0.5), direction=0),), BLOCKS).block.tolist() == [0]
    assert bars_of((bsm.Roller(point=(1, 0.5), direction=0),), BLOCKS).block.tolist() == [0, 1]


def test_normal_roller_follows_the_edges():
    angle = 30.0
    corners = [turned(p, angle) for p in grid(2, 2)]
    bottom = turned(np.array([(0, 1.0)]), angle)[0]
    blocks = bsm.Blocks.from_polygons(corners, rock="r").with_boundary(
        "bottom", lambda x, y: x * bottom[0] + y * bottom[1] < 1e-9
    )
    bars = bars_of((bsm.NormalRoller(boundary="bottom"),), blocks)
    assert_allclose(bars.direction, np.tile(-bottom, (4, 1)), atol=1e-15)


def test_prescribed_displacement_keeps_value_and_number():
    supports = (bsm.Fixed(blocks=[0]), bsm.PrescribedDisplacement(boundary="top", direction=210, displacement=0.02))
    bars = bars_of(supports, BLOCKS)
    chosen = bars.support == 1
    assert_allclose(bars.value, np.where(chosen, 0.02, 0))
    assert_allclose(bars.direction[chosen], np.tile((-np.sqrt(3) / 2, -0.5), (4, 1)))


def test_no_support_gives_no_bars():
    assert len(bars_of((), BLOCKS).block) == 0


@pytest.mark.parametrize("degrees", [-450, -90, 0, 90, 180, 270, 360, 720])
def test_unit_vectors_along_the_axes_are_exact(degrees):
    found = unit_vector(degrees)
    assert set(np.abs(found).tolist()) == {0.0, 1.0}
    assert_allclose(found, (np.cos(np.radians(degrees)), np.sin(np.radians(degrees))), atol=1e-14)


@pytest.mark.parametrize("offset", [0.0, 1e6, 2e7])
def test_points_on_edges_are_found_far_from_the_origin(offset):
    from bsm_mesh.model.locate import blocks_at

    corners = [turned(p, 17, (offset, -offset)) for p in grid(3, 3)]
    blocks = bsm.Blocks.from_polygons(corners, rock="r")
    on_edge = tuple(corners[4][1] + 0.3 * (corners[4][2] - corners[4][1]))
    assert blocks_at(blocks, on_edge).tolist() == [4, 5]
    assert blocks_at(blocks, tuple(corners[4].mean(axis=0))).tolist() == [4]
    assert blocks_at(blocks, tuple(corners[4][2])).tolist() == [4, 5, 7, 8]
