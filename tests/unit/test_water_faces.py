"""Water along faces: the distribution that pictures and files show is that whose resultants load the blocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters.result_files import grid_of_stage
from bsm_mesh.pictures.pictures import figure_of
from bsm_mesh.results.joint_faces import joint_faces
from bsm_mesh.results.water_faces import wet_parts
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import grid, turned

WATER = 9810.0  # N/m3
ROUNDING = 1e-9  # of the greatest force
TABLES = {
    "level": {"table": [(0, 2.3)]},
    "bent": {"table": [(-1, 2.7), (1.3, 2.1), (2.2, 0.4), (4, 0.6)]},
    "parallel": {"table": [(0, 2.7), (3, 1.1), (4, 1.1)], "head": "parallel"},
    "falls to a point": {"table": [(0, 3.5), (3, -0.5)]},
}


def wet(water, options=LINEAR, **more):
    """Return the results of three by three blocks on their lowest row, turned by 10 degrees, under water."""
    shapes = [turned(shape, 10.0) for shape in grid(3, 3)]
    return bsm.run(model_of(shapes, fixed=(0, 1, 2), water=bsm.Water(**water), **more), options)


def resultants(stage, vertices, following, owner, joint, centroid, count):
    """Return force and moment of the wet parts of all edges on their blocks, (count, 3), by Simpson's rule."""
    parts = wet_parts(stage, vertices, following, joint)
    ends, block = parts.at(vertices, following), owner[parts.line]
    along = ends[:, 1] - ends[:, 0]
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    total = np.zeros((count, 3))
    for t, weight in ((0.0, 1 / 6), (0.5, 4 / 6), (1.0, 1 / 6)):  # exact: moments are quadratic
        point = ends[:, 0] + t * along
        force = weight * ((1 - t) * parts.pressure[:, :1] + t * parts.pressure[:, 1:]) * inward
        arm = point - centroid[block]
        np.add.at(total, block, np.column_stack([force, arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]]))
    return total


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("scheme", ["linear", "continuation"])
def test_their_resultants_are_the_waters_forces_on_the_blocks(table, scheme):
    """Of faces in joints and outer ones, wet, partly wet and dry, under bends of the table."""
    results = wet(TABLES[table], bsm.Options(scheme=scheme))
    blocks, stage = results.blocks, results.stages[0]
    moved = 0.0 if scheme == "linear" else stage.displacement
    assert scheme == "linear" or np.abs(moved).max() > 1e-6
    angle = 0.0 if scheme == "linear" else stage.displacement[blocks.owner, 2]
    centroid = blocks.moments.centroid + (0.0 if scheme == "linear" else stage.displacement[:, :2])
    arm = blocks.vertices - blocks.moments.centroid[blocks.owner]
    c, s = np.cos(angle), np.sin(angle)
    vertices = centroid[blocks.owner] + np.column_stack([c * arm[:, 0] - s * arm[:, 1], s * arm[:, 0] + c * arm[:, 1]])
    none = np.full(len(vertices), -1)
    found = resultants(stage, vertices, vertices[blocks.following], blocks.owner, none, centroid, blocks.count)
    assert_allclose(found, stage.water, atol=ROUNDING * np.abs(stage.water).max())


def test_a_joint_with_a_pressure_of_its_own():
    """It is in its faces alone, and outlives the way to a folder and back."""
    results = wet({"table": [(0, 2.0)], "joint_pressure": {"J": 5e4}})
    faces = joint_faces(results, results.stages[0])
    assert_allclose(faces.water_pressure, 5e4)
    assert wet({"table": [(0, 2.0)]}).stages[0].joint_water.tolist() == pytest.approx([np.nan], nan_ok=True)


def test_the_mean_of_a_face_that_is_half_dry():
    """An upright face of 1 m with the table at its middle: a triangle over half a metre."""
    results = bsm.run(model_of(grid(2, 1), fixed=(0,), water=bsm.Water(table=[(0, 0.5)])), LINEAR)
    assert_allclose(joint_faces(results, results.stages[0]).water_pressure, [WATER * 0.5**2 / 2])


def test_files_have_it_and_give_it_back(tmp_path):
    for water in ({"table": TABLES["parallel"]["table"], "head": "parallel"}, {"joint_pressure": {"J": 5e4}}):
        results = wet(water)
        results.save(tmp_path / "out")
        again = bsm.Results.load(tmp_path / "out")
        for name in ("water_table", "water_gradient", "joint_water"):
            assert_allclose(getattr(again.stages[0], name), getattr(results.stages[0], name))
        grid_of_joints = grid_of_stage("joints", again, again.stages[0], 0)
        assert_allclose(
            grid_of_joints.cell_data["water_pressure"], joint_faces(results, results.stages[0]).water_pressure
        )
        assert grid_of_joints.cell_data["water_pressure"].max() > 1e4


def test_the_picture_is_as_wide_as_the_pressure():
    """Bands along the faces, whose width over the greatest is the pressure over the greatest."""
    results = wet({"table": [(0, 2.0)]})
    figure = figure_of(results, "water_pressure")
    bands = next(c for c in figure.axes[0].collections if (c.get_gid() or "") == "water")
    values, corners = np.asarray(bands.get_array()), [path.vertices[:4] for path in bands.get_paths()]
    width = np.array([np.hypot(*(c[0] - c[1] + c[3] - c[2])) / 2 for c in corners])
    assert_allclose(width / width.max(), values / values.max(), atol=1e-6)
    assert "water pressure along the faces, kPa" in [axes.get_ylabel() for axes in figure.axes]
    assert figure_of(wet({"table": []}), "water_pressure") is None


def test_a_table_through_corners_leaves_parts_without_length_out_of_the_picture():
    """Their direction was divided by nothing: a warning, which is an error here."""
    shapes = [turned(shape, 51.676001087219646) for shape in grid(3, 3)]
    table = [(-1.7334424141934228, 2.644839767675024), (0.4556986767408008, 2.1891410909342235)]
    results = bsm.run(model_of(shapes, fixed=(0, 1, 2), water=bsm.Water(table=table)), LINEAR)
    assert figure_of(results, "water_pressure") is not None
