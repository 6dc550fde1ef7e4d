"""Arguments of another kind, given to public functions: one message that names the argument, and no traceback."""

from __future__ import annotations

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh import converters
from tests.scenes.pushed_block import example_2

MODEL = example_2(1e9)
CORNERS = [(0, 0), (1, 0), (0, 1)]


@pytest.fixture(scope="module")
def results():
    return bsm.run(MODEL)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bsm.limit_analysis(MODEL, stage=1), r"there is no stage 1 \(known: initial\)"),
        (lambda: bsm.factor_of_safety(MODEL, rocks=["schist"]), r"safety: rocks = \['schist'\] must be True or False"),
        (lambda: bsm.factor_of_safety(MODEL, bolts=2), "safety: bolts = 2 must be True or False"),
        (lambda: bsm.factor_of_safety(MODEL, joints=3), "safety: joints = 3 must be a list of texts"),
        (lambda: bsm.factor_of_safety(MODEL, options="linear"), "safety: options = 'linear' must be"),
        (lambda: bsm.newmark(MODEL, "record.csv"), "newmark: shaking = 'record.csv' must be"),
        (lambda: bsm.limit_value(lambda part: MODEL, "0", 1.0), "the range '0' to 1.0 must have two"),
        (lambda: converters.convert_meshio("mesh.msh"), "mesh = 'mesh.msh' must be a meshio.Mesh"),
        (lambda: converters.convert_mesh(CORNERS, [None]), r"cells = \[None\] must be pairs"),
        (lambda: converters.solve_continuum(None), "continuum: model = None must be"),
        (lambda: triangle(unit_scale="mm"), "unit_scale 'mm': must be a length above 0 m"),
        (lambda: triangle(merge_tolerance=None), "merge_tolerance None: must be 0 m or more"),
        (lambda: triangle(groups="rock:r"), "groups: the names of groups and their meanings must be texts"),
        (lambda: MODEL.plot(window=3), "window .* 3 must be X0 Y0 X1 Y1"),
        (lambda: MODEL.plot(figure=[]), "figure is of the kind list"),
    ],
)
def test_arguments_of_another_kind_are_named(call, message):
    with pytest.raises(bsm.ModelError, match=message):
        call()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda results: results.plot(0), "there is no picture 0"),
        (lambda results: results.plot(""), "there is no picture ''"),
        (lambda results: results.plot(window=[0, 1, "a", 2]), "window .* 0 1 'a' 2 must be X0 Y0 X1 Y1"),
        (lambda results: results.to_pandas([]), r"there is no table \[\] of results"),
        (lambda results: bsm.liner_forces(results, None), "there is no rock None"),
        (lambda results: bsm.liner_forces(results, results.blocks.rock_names[0], "cut"), "there is no stage 'cut'"),
        (lambda results: converters.compare(MODEL, "out/model"), "results = 'out/model' must be bsm.Results"),
    ],
)
def test_arguments_of_results_of_another_kind_are_named(results, call, message):
    with pytest.raises(bsm.ModelError, match=message):
        call(results)


def triangle(**given):
    return converters.convert_mesh(CORNERS, [("triangle", np.array([[0, 1, 2]]))], **given)
