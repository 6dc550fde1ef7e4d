"""Water tables as they are given, and what stages and moving blocks make of them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.water_pressure import WaterLoad
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import grid, rectangle

WATER = 9810.0
CONTINUATION = bsm.Options(scheme="continuation")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"table": 3.0}, ["table = 3.0", "from left to right"]),
        ({"table": [(0, 1), (0, 2)]}, ["from left to right", "two points a little apart"]),
        ({"table": [(0, 1), (1, np.nan)]}, ["table point 2", "nan"]),
        ({"table": [[(0, 1)], [(1, 1), (2, 1)]]}, ["one point is level everywhere"]),
        ({"table": ["level"]}, ["table point 1"]),
        ({"unit_weight": 0}, ["unit_weight = 0 N/m^3 must be 1e-9 to 1e6"]),
        ({"head": "slanted"}, ["'slanted' is unknown"]),
        ({"joint_pressure": {"J": -1.0}}, ["joint_pressure of 'J' = -1 Pa must be 0 to 1e10 Pa"]),
    ],
)
def test_what_is_no_water(given, words):
    with pytest.raises(bsm.ModelError) as caught:
        bsm.Water(**given)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def level(table, x, head="vertical"):
    return bsm.Water(table=table, head=head).surface().at(np.asarray(x, dtype=float))


def test_a_table_goes_on_level_beyond_its_ends():
    assert_allclose(level([(0, 4), (2, 8), (4, 5)], [-9, 0, 1, 2, 3, 4, 99]), [4, 4, 6, 8, 6.5, 5, 5])
    assert_allclose(level([(7, 3)], [-9, 7, 99]), 3)
    assert np.isneginf(level([], [0.0])).all()


def test_several_tables():
    """The highest where they overlap, each between its own ends, gaps bridged, level beyond the last."""
    one, other, far = [(0, 2), (4, 6)], [(1, 5), (3, 3)], [(6, 1), (8, 0)]
    found = level([one, other, far], [-1, 0.5, 1.25, 1.5, 2.4, 2.6, 3.5, 5, 7, 9])
    assert_allclose(found, [2, 2.5, 4.75, 4.5, 4.4, 4.6, 5.5, 3.5, 0.5, 0])


def test_seepage_parallel_to_the_table():
    surface = bsm.Water(table=[(0, 0), (3, 3), (5, 3)], head="parallel").surface()
    assert_allclose(surface.factor, [1, 0.5, 1, 1])


def test_straight_pieces_over_the_model():
    pieces, _ = bsm.Water(table=[(0, 2), (4, 6)]).surface().between(-1.0, 2.0)
    assert_allclose(pieces, [[(-1, 2), (0, 2)], [(0, 2), (2, 4)]])
    assert len(bsm.Water().surface().between(0, 1)[0]) == 0


def two_blocks(gap=0.0, **more):
    """Return two unit blocks side by side on a fixed third, the right one free to be pushed away."""
    below = rectangle(-2, -1, 6, 0)
    return model_of([below, *grid([-1.0, 0.0], 1), *grid([gap, 1.0 + gap], 1)], gamma=26e3, friction=45, **more)


@pytest.mark.parametrize("gap", [0.0, 0.001, 0.5])
def test_an_open_joint_keeps_its_pressure(gap):
    """Water to the top on both sides of a joint that is closed, opened or wide: the same on every face."""
    stage = bsm.run(two_blocks(gap, water=bsm.Water(table=[(0, 1.0)])), CONTINUATION).stages[0]
    assert stage.status == "stable"
    assert_allclose(stage.water[1:, 0], 0, atol=1e-6)  # as much from the left as from the right
    assert_allclose(stage.water[1:, 1], WATER, rtol=1e-6)


def test_a_block_that_moves_takes_the_pressure_of_where_it_is():
    """The table falls from left to right: the right block is pushed until friction holds the rest of the push."""
    table = [(-1, 1.0), (0, 1.0), (3, 0.0)]
    model = two_blocks(
        water=bsm.Water(table=table), loads=[bsm.PointLoad(block=2, point=(0.5, 0.1), force=(17.0e3, 0))]
    )
    stage = bsm.run(model, CONTINUATION).stages[0]
    u, v, turn = stage.displacement[2]
    corners = np.array([(u, v), (1 + u, v), (1 + u, 1 + v), (u, 1 + v)])
    assert abs(turn) < 1e-4
    left, right = (max(np.interp(x, *np.array(table).T) - v, 0.0) for x in corners[[0, 1], 0])
    assert_allclose(stage.water[2, 0], WATER * (left**2 - right**2) / 2, rtol=1e-3)
    assert_allclose(stage.water[2, 1], WATER * (left + right) / 2, rtol=1e-3)


def test_pressure_of_a_joint_in_place_of_the_tables():
    """Between the two blocks 50 kPa, under them the table's."""
    model = two_blocks()
    joints = (*model.joints, bsm.Joint("K", normal_stiffness=1e9, shear_stiffness=1e9))
    blocks = model.blocks.with_joint("K", lambda x, y: (abs(x) < 1e-9) & (y >= 0))
    water = bsm.Water(table=[(0, 0.25)], joint_pressure={"K": 50e3})
    stage = bsm.run(model.replace(blocks=blocks, water=water, joints=joints), LINEAR).stages[0]
    side = WATER * 0.25**2 / 2
    assert_allclose(stage.water[1:, 0], [-50e3 + side, 50e3 - side])
    k = stage.contacts.joint == 1
    assert_allclose(stage.contacts.water_pressure[k], 50e3)
    assert_allclose(stage.contacts.water_pressure[~k], WATER * 0.25)


def test_blocks_that_water_lifts_are_named():
    light = [bsm.Rock("rock", unit_weight=5e3)]
    stage = bsm.run(two_blocks(water=bsm.Water(table=[(0, 5)])).replace(rocks=light), LINEAR).stages[0]
    assert stage.uplifted_blocks.tolist() == [0, 1, 2]
    assert bsm.run(two_blocks(water=bsm.Water(table=[(0, 5)])), LINEAR).stages[0].uplifted_blocks.size == 0


def test_a_table_below_all_blocks_is_said():
    stage = bsm.run(two_blocks(water=bsm.Water(table=[(0, -50)])), LINEAR).stages[0]
    assert stage.notes == ("water: the table lies below all blocks (the lowest point of the model is at y = -1 m)",)
    assert len(WaterLoad(two_blocks()).point_forces(two_blocks().blocks.vertices)) == 0


def test_weightless_blocks_left_alone_are_idle():
    """A stage that isolates a block without load leaves it where it is: nothing pulls at it."""
    model = two_blocks(stages=[bsm.Stage(name="apart", excavate=[1])])
    light = [bsm.Rock("rock", unit_weight=26e3), bsm.Rock("foam", unit_weight=0)]
    polygons = [model.blocks.polygon(b) for b in range(3)] + [rectangle(-1, 1, 0, 2)]
    blocks = bsm.Blocks.from_polygons(polygons, rock=["rock", "rock", "rock", "foam"])
    stage = bsm.run(model.replace(blocks=blocks, rocks=light), LINEAR).stages[-1]
    assert (stage.status, stage.name) == ("no_verdict", "apart")
    assert not stage.stage_displacement[3].any()


def test_water_in_newtons_and_millimetres_is_that_in_metres():
    """A column on water, in both systems of units: the same verdict, and a thousand times the numbers of movements."""

    def column(metre, pascal):
        weight = pascal / metre
        return model_of(
            [metre * rectangle(-4, -1, 6, 0), metre * rectangle(0, 0, 2, 8)],
            gamma=25e3 * weight,
            friction=75,
            kn=1e10 * weight,
            water=bsm.Water(
                table=[(metre * x, metre * y) for x, y in ((-4, 5.85), (0, 5.85), (2, 0), (6, 0))],
                unit_weight=9810 * weight,
            ),
        )

    metres, millimetres = (bsm.run(column(*units)).stages[-1] for units in ((1.0, 1.0), (1e3, 1e-6)))
    assert metres.status == millimetres.status == "stable"
    assert_allclose(millimetres.displacement, metres.displacement * (1e3, 1e3, 1), rtol=1e-6)


@pytest.mark.parametrize("place", ["water", "flow", "stage 'wet': water"])
def test_water_a_thousand_times_too_light_is_refused(place):
    light = bsm.Water(table=[(0, 1.0)], unit_weight=9.81)
    given = {
        "water": {"water": light},
        "flow": {"flow": bsm.Flow(head={"left": 1.0}, unit_weight=9.81)},
        "stage 'wet': water": {"stages": [bsm.Stage(name="wet", water=light)]},
    }
    with pytest.raises(bsm.ModelError) as caught:
        two_blocks(**given[place])
    assert f"{place}: unit_weight = 9.81 N/m^3 is 2650 times less than that of every rock" in str(caught.value)
