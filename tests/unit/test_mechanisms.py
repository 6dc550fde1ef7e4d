"""Parts that supports leave free are named with the motion, the reason and the cure."""

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.models import framed
from tests.scenes.shapes import grid, square, turned

ROCK = bsm.Rock("r", unit_weight=26e3, young=1e9, poisson=0.2)
LINEAR = bsm.Options(scheme="linear")


def faults(supports, polygons=None, frame=True):
    blocks = bsm.Blocks.from_polygons(grid(2, 2) if polygons is None else polygons, rock="r")
    if frame and polygons is None:
        blocks = framed(blocks, 2, 2)
    try:
        bsm.run(bsm.Model(blocks=blocks, rocks=[ROCK], supports=supports), LINEAR)
    except bsm.ModelError as error:
        return error.faults
    return ()


HELD = "its supports do not hold it; add a support across that motion"


@pytest.mark.parametrize(
    ("supports", "motion"),
    [
        ([bsm.NormalRoller(boundary="bottom")], "slide in the direction 0 degrees"),
        ([bsm.NormalRoller(boundary="left")], "slide in the direction 90 degrees"),
        ([bsm.NormalRoller(boundary="bottom"), bsm.NormalRoller(boundary="top")], "slide in the direction 0 degrees"),
        ([bsm.Roller(boundary="bottom", direction=30)], "slide in the direction 120 degrees"),
        ([bsm.Fixed(point=(0, 0))], "turn about (0, 0)"),
        ([bsm.Fixed(point=(0.5, 0.25))], "turn about (0.5, 0.25)"),
        ([bsm.Roller(point=(0, 0), direction=90), bsm.Roller(point=(2, 0), direction=0)], "turn about (0, 0)"),
        ([bsm.Roller(point=(0, 0), direction=45), bsm.Roller(point=(2, 0), direction=135)], "turn about (1, 1)"),
        ([bsm.Roller(point=(0, 0), direction=20)], "slide in the direction 110 degrees"),
    ],
)
def test_motion_is_named(supports, motion):
    (fault,) = faults(supports)
    assert fault == f"the model is free to {motion}: {HELD}"


def test_no_support_at_all():
    (fault,) = faults([])
    assert fault.startswith(
        "the model is free to move in any direction: no support holds it; hold a boundary, some blocks or a point: "
    )


@pytest.mark.parametrize(
    "supports",
    [
        [bsm.Fixed(blocks=[2])],
        [bsm.Fixed(point=(0, 0)), bsm.Roller(point=(2, 0), direction=90)],
        [bsm.NormalRoller(boundary="bottom"), bsm.NormalRoller(boundary="left")],
        [
            bsm.Roller(point=(0, 0), direction=90),
            bsm.Roller(point=(2, 0), direction=90),
            bsm.Roller(point=(1, 1), direction=0),
        ],
    ],
)
def test_enough_supports(supports):
    assert faults(supports) == ()


def test_every_free_part_is_named():
    polygons = [square(0, 0), square(1, 0), square(5, 0), square(8, 0), square(9, 1)]  # the last two share a corner
    found = faults([bsm.Fixed(blocks=[1]), bsm.Roller(blocks=[2], direction=0)], polygons)
    assert len(found) == 3
    assert found[0].startswith(
        "block 2 at (5.5, 0.5) is free to slide in the direction 90 degrees: its supports do not"
    )
    assert found[1].startswith("block 3 at (8.5, 0.5) is free to move in any direction: no support holds it")
    assert found[2].startswith("block 4 at (9.5, 1.5) is free to move in any direction")


def test_members_of_a_free_part_are_listed():
    polygons = [square(0, 0), *[square(5 + i, 0) for i in range(12)]]
    (found,) = faults([bsm.Fixed(blocks=[0])], polygons)
    assert found.startswith("block 1, 2, 3, 4, 5, 6, 7, 8, ... (12 in all) at (5.5, 0.5) is free to move")


@pytest.mark.parametrize("offset", [1e6, 2e7])
def test_far_from_the_origin(offset):
    polygons = [turned(0.05 * p, 30, (offset, -offset)) for p in grid(3, 3)]
    ends = [bsm.Roller(point=tuple(polygons[i][i]), direction=30) for i in (0, 1)]
    (found,) = faults(ends, polygons)
    assert "slide in the direction 120 degrees" in found
    assert faults([bsm.Fixed(blocks=[4])], polygons) == ()
    (found,) = faults([bsm.Fixed(point=tuple(polygons[4][0]))], polygons)
    assert "turn about" in found


@pytest.mark.parametrize("degrees", [7.0, 30.0, 61.3])
@pytest.mark.parametrize("offset", [1e6, 5e6, 2e7])
def test_a_bar_through_a_pin_holds_no_rotation_far_from_the_origin(offset, degrees):
    """The pin and the bar are on different blocks: only the part as a whole can tell."""
    polygons = [turned(0.05 * p, degrees, (offset, -offset)) for p in grid(3, 1)]
    supports = [
        bsm.Fixed(point=tuple(polygons[0][0])),
        bsm.Roller(point=tuple(polygons[2][1]), direction=degrees),
    ]
    (found,) = faults(supports, polygons)
    assert "turn about" in found


def test_the_message_of_an_unconnected_pile_stays_short():
    polygons = [square(2 * i, 0) for i in range(300)]
    found = faults([bsm.Fixed(blocks=[0])], polygons)
    assert 100 <= len(found) <= 102
    assert np.char.str_len(found).max() < 200
