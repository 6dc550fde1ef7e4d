"""Slices of the plane's models: the same verdict, supports and joints; what has no slice is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from benchmarks.extruded import NoSliceError, extruded
from tests.scenes.models import model_of

WALL = [[(0, -1), (4, -1), (4, 0), (0, 0)], [(1, 0), (2, 0), (2, 1), (1, 1)], [(2, 0), (3, 0), (3, 1), (2, 1)]]


def test_corners_on_an_edge_divide_it():
    """Two blocks on the middle of another: three contacts of 1 m2; the same settlement and tilt of gravity."""
    plane = model_of(WALL, friction=40, kn=1e9, gamma=26e3, fixed=[0]).replace(gravity_direction=-100.0)
    space = extruded(plane)
    assert_allclose(space.blocks.contact_polygons.area, [1, 1, 1])
    assert_allclose(space.blocks.moments.volume, plane.blocks.moments.area)
    flat, deep = (bsm.run(model, bsm.Options(threads=1)) for model in (plane, space))
    assert flat.status == deep.status == "stable"
    turn = np.radians(10)
    along = flat.stages[0].displacement[:, :2] @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert_allclose(deep.stages[0].displacement[:, [0, 2]], along, atol=1e-9 * np.abs(along).max())


def test_models_without_a_slice_are_left_out():
    plane = model_of(WALL, friction=40, kn=1e9, gamma=26e3, fixed=[0])
    with pytest.raises(NoSliceError, match="has in_situ"):
        extruded(plane.replace(in_situ=bsm.InSitu(surface=2.0)))
    bent = [[(0, 0), (2, 0), (2, 2), (1, 0.5)]]
    with pytest.raises(NoSliceError, match="not convex"):
        extruded(model_of(bent, friction=40, kn=1e9, gamma=26e3, fixed=[0]))
