"""Slices of the plane's models: the same verdicts, supports, loads and joints; models without a slice are refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from benchmarks.extruded import compared, models, table
from benchmarks.slices import NoSliceError, extruded
from tests.scenes.models import model_of

WALL = [[(0, -1), (4, -1), (4, 0), (0, 0)], [(1, 0), (2, 0), (2, 1), (1, 1)], [(2, 0), (3, 0), (3, 1), (2, 1)]]


def test_corners_on_an_edge_divide_it():
    """Two blocks on the middle of another: three contacts of 1 m2; the same settlement and tilt of gravity."""
    plane = model_of(WALL, friction=40, kn=1e9, gamma=26e3, fixed=[0]).replace(gravity_direction=-100.0)
    space = extruded(plane, depth=1.0)
    assert_allclose(space.blocks.contact_polygons.area, [1, 1, 1])
    assert_allclose(space.blocks.moments.volume, plane.blocks.moments.area)
    flat, deep = (bsm.run(model, bsm.Options(threads=1)) for model in (plane, space))
    assert flat.status == deep.status == "stable"
    turn = np.radians(10)
    along = flat.stages[0].displacement[:, :2] @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert_allclose(deep.stages[0].displacement[:, [0, 2]], along, atol=1e-9 * np.abs(along).max())


def test_a_slice_is_as_thick_as_the_free_blocks_are_large_or_as_bolts_are_spaced():
    """Blocks of 2 m2: 1.414 m, where the cube root of the volume is the square root of the area."""
    large = [[(0, -1), (4, -1), (4, 0), (0, 0)], [(1, 0), (2, 0), (2, 2), (1, 2)]]
    plane = model_of(large, friction=40, fixed=[0])
    assert_allclose(extruded(plane).blocks.moments.size[1], plane.blocks.moments.size[1])
    bolt = bsm.Bolt(start=(1.5, 1), end=(1.5, -0.5), diameter=0.02, spacing=1.7)
    bolted = extruded(plane.replace(bolts=[bolt]))
    assert np.ptp(bolted.blocks.vertices[:, 1]) == pytest.approx(1.7)
    assert bolted.bolts[0].start == pytest.approx((1.5, 0.85, 1))


def test_a_block_that_is_not_convex_is_one_of_several_cells():
    bent = [[(0, 0), (2, 0), (2, 2), (1, 0.5)], [(0, -1), (2, -1), (2, 0), (0, 0)]]
    plane = model_of(bent, friction=40, kn=1e9, gamma=26e3, fixed=[1])
    space = extruded(plane, depth=2.0)
    assert space.blocks.count == 2
    assert_allclose(space.blocks.moments.volume, 2 * plane.blocks.moments.area)
    assert_allclose(space.weights, 2 * plane.weights)


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["six blocks of which two go", "retaining_wall/model", "opening, with bolts"])
def test_stages_loads_bolts_and_water_are_those_of_the_plane(name):
    found = compared(models()[name]())
    assert found["slice"] == found["plane"]
    assert len(found["plane"]) > 1
    assert found["off"] < 1e-3
    assert "All verdicts are equal in 1 of 1 models" in table([{"name": name, **found}])


@pytest.mark.heavy
@pytest.mark.parametrize(("part", "status"), [(1.05, "unstable"), (0.95, "stable")])
def test_columns_topple_in_a_slice_beyond_the_known_factor_and_only_there(part, status):
    model = models()[f"toppling, Goodman & Bray, friction 42; {part:g} of the known factor"]()
    assert bsm.run(extruded(model), bsm.Options(threads=1)).status == status


def test_walls_keep_a_slice_from_moving_across():
    plane = model_of(WALL, friction=40, kn=1e9, gamma=26e3, fixed=[0]).replace(gravity_direction=-100.0)
    space = extruded(plane, walls=True)
    pushed = space.replace(gravity_horizontal=0.1, gravity_trend=0.0)
    for model, moves in ((pushed, False), (pushed.replace(supports=extruded(plane).supports), True)):
        across = bsm.run(model, bsm.Options(threads=1)).stages[0].displacement[1:, 1]
        assert (np.abs(across).max() > 1e-6) == moves


def test_models_without_a_slice_are_left_out():
    plane = model_of(WALL, friction=40, kn=1e9, gamma=26e3, fixed=[0])
    bent = bsm.Water(table=[(0, 0), (2, 1), (4, 0)])
    for given, said in (
        ({"in_situ": bsm.InSitu(surface=[(0, 2), (4, 3)])}, "below ground that is not level"),
        ({"water": bent}, "water table that is not straight"),
        ({"gravity_horizontal": 0.1, "gravity_direction": -100.0}, "where gravity is turned"),
        ({"contact_points": "gauss"}, "has Gauss points"),
    ):
        with pytest.raises(NoSliceError, match=said):
            extruded(plane.replace(**given))
