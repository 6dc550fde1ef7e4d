"""The qualitative findings on the Cassiar slope (Wang 8.3.2, Table 8.4), for both joint laws."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.arrays import FloatArray

pytest.importorskip("gmsh")

EXAMPLE = Path(__file__).parents[2] / "examples/cassiar_slope"
PUBLISHED = 0.73  # point 1 under high water, BLOSMER (Table 8.4) [m]
SAME = 2e-3  # [m]
UPLIFT = 0.02  # by which the water may lift what it does not move, from zero stress [m]


@dataclass(frozen=True)
class Run:
    """Displacements [m] of the points, a row a condition, from zero stress and from the dry state."""

    results: bsm.Results
    whole: FloatArray
    since_dry: FloatArray


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLE / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module", params=["model.toml", "mohr_coulomb.toml"])
def run(request: pytest.FixtureRequest) -> Run:
    return Run(*script("conditions").as_the_water_rises(bsm.load(EXAMPLE / request.param)))


def test_every_condition_ends_at_rest(run: Run) -> None:
    assert [stage.status.value for stage in run.results.stages] == ["stable"] * 5
    assert run.results.check().ok


def test_the_wedge_above_the_fault_moves_and_nothing_else(run: Run) -> None:
    moved = np.hypot(*run.results.stages[-1].displacement[:, :2].T)
    wedge = moved > moved.max() / 2
    x, y = run.results.blocks.moments.centroid.T
    dyke = -393.3 - 20 + (330 - y) / np.tan(np.radians(75))
    fault = np.maximum(137.6 - (x + 243) * np.tan(np.radians(35)), 137.6 - (x + 243) * np.tan(np.radians(10)))
    assert wedge.sum() == 5
    assert np.array_equal(wedge, (x > dyke) & (y > fault) & (y > 120))
    assert (moved[~wedge] < moved.max() / 5).all()


def test_most_at_the_top_and_little_below_the_fault(run: Run) -> None:
    high = run.whole[-1]
    assert high.argmax() == 0
    assert (high[5:] < high[0] / 5).all()
    assert (run.since_dry[-1, 5:] < run.since_dry[-1, 0] / 5).all()


def test_the_bottom_of_the_wedge_feels_the_water_most(run: Run) -> None:
    """Wang 8.3.2: the bottom of the wedge, point 5, "was especially sensitive to the groundwater level"."""
    assert run.since_dry[-1].argmax() == 4
    assert (run.whole[-1] / run.whole[0]).argmax() == 4


def test_more_water_more_movement(run: Run) -> None:
    assert (np.diff(run.since_dry[:, :5], axis=0) > -SAME).all()
    assert (np.diff(run.whole, axis=0) > -UPLIFT).all()
    assert (run.whole[-1, :5] > run.whole[:-1, :5].max(axis=0) + 0.1).all()


def test_point_1_within_a_factor_of_two(run: Run) -> None:
    assert PUBLISHED / 2 < run.whole[-1, 0] < 2 * PUBLISHED


def test_the_tables_of_the_model_files_are_the_assumed_ones() -> None:
    """Dupuit's parabola from 0.5 to 0.8 of the height at the crest down to the toe, never above the ground."""
    crest = -330 / np.tan(np.radians(40))
    for file in ("model.toml", "mohr_coulomb.toml"):
        stages = bsm.load(EXAMPLE / file).stages
        assert len(stages) == 4
        for part, stage in zip((0.5, 0.6, 0.7, 0.8), stages, strict=True):
            assert stage.water is not None
            (table,) = stage.water.table
            x, y = np.array(table).T
            share = x / crest
            assert y == pytest.approx(np.minimum(part * 330 * np.sqrt(share), 330 * share), abs=0.1)


def test_few_steps() -> None:
    """BLOSMER took 51 cycles, UDEC 12 500."""
    stage = bsm.run(bsm.load(EXAMPLE / "high_water.toml"), bsm.Options(scheme="continuation")).stages[-1]
    assert stage.status == "stable"
    assert len(stage.steps) < 51


@pytest.mark.parametrize(("friction", "stands"), [(28.0, False), (30.0, True)])
def test_two_degrees_of_friction_decide_and_statics_agrees(friction: float, stands: bool) -> None:
    """The report: "extremely sensitive to changes in the friction angle"; by the steps and by the linear program."""
    model = bsm.load(EXAMPLE / "high_water.toml")
    argillite = bsm.Patton(friction=friction)
    joints = [replace(joint, law=argillite) if joint.law.friction == 30 else joint for joint in model.joints]
    model = replace(model, joints=joints)
    results = bsm.run(model, bsm.Options(scheme="continuation", displacement_limit=10.0))
    assert results.status == ("stable" if stands else "unstable")
    assert bsm.limit_analysis(model).admissible is stands
    if not stands:
        assert results.unstable_blocks.tolist() == [3, 4, 5, 6, 7]
