"""The Cassiar slope (Wang 8.3.2, Table 8.4): what holds of the meshed section, and of its ten blocks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bsm_mesh as bsm
from examples.cassiar_slope import slope

pytest.importorskip("gmsh")

EXAMPLE = Path(__file__).parents[2] / "examples/cassiar_slope"
FILES = ("model", "mohr_coulomb", "ten_blocks")
TAN_FACE = np.tan(np.radians(40))


@pytest.fixture(scope="module")
def once() -> bsm.Results:
    return bsm.run(slope.load("high_water"))


@pytest.mark.heavy
def test_the_wedge_above_the_faults_moves_and_hardly_anything_else(once: bsm.Results) -> None:
    """By movement beyond that of the dry slope, whose weight closes the joints."""
    dry = bsm.run(slope.load("high_water").replace(water=None))
    moved = np.hypot(*(once.stages[-1].displacement - dry.stages[-1].displacement)[:, :2].T)
    x, y = once.blocks.moments.centroid.T
    dyke = -330 / TAN_FACE - 20 + (330 - y) / np.tan(np.radians(75))
    bend = -120 / TAN_FACE - 100, 120 + 100 * np.tan(np.radians(10))
    fault = np.maximum(*(bend[1] - (x - bend[0]) * np.tan(np.radians(dip)) for dip in (25, 10)))
    wedge = (x > dyke) & (y > fault) & (y > 120)
    assert moved[wedge].min() > 2 * moved[~wedge].max()


@pytest.mark.heavy
def test_most_at_the_top_and_little_below_the_fault(once: bsm.Results) -> None:
    """Table 8.4: point 1 moves most, 6 and 7 a tenth of it; all within a tenth of a metre of BLOSMER's on average."""
    moved = slope.at_the_end(once)
    assert moved.argmax() == 0
    assert (moved[5:] < moved[0] / 5).all()
    assert slope.from_blosmer(moved) < 0.1


@pytest.mark.heavy
def test_two_degrees_are_no_razors_edge() -> None:
    base = slope.at_once(slope.load())
    first = slope.at_the_end(bsm.run(base, slope.OPTIONS))[0]
    for dip in (23.0, 27.0):
        model, points = slope.with_geometry(base, north_fault_dip=dip)
        results = bsm.run(model, slope.OPTIONS)
        assert results.status == "stable"
        assert slope.at_the_end(results, points)[0] == pytest.approx(first, rel=0.35)


@pytest.mark.parametrize("angle", [pytest.param(38.0, marks=pytest.mark.heavy), 42.0])
def test_a_face_of_another_angle_is_a_model(angle: float) -> None:
    """The points of the histories then lie in the air, or deep inside; those of the geometry are in blocks."""
    model, points = slope.with_geometry(slope.load(), slope_angle=angle)
    found = slope.at_the_end(bsm.run(slope.at_once(model), bsm.Options(scheme="linear")), points)
    assert found.shape == (7,)
    assert np.isfinite(found).all()


def test_the_tables_of_the_model_files_are_the_assumed_ones() -> None:
    """Dupuit's parabola from 0.5 to 0.8 of the height at the crest down to the toe, never above the ground."""
    crest = -330 / TAN_FACE
    for file in FILES:
        stages = slope.load(file).stages
        assert len(stages) == 4
        for part, stage in zip((0.5, 0.6, 0.7, 0.8), stages, strict=True):
            assert stage.water is not None
            (table,) = stage.water.table
            x, y = np.array(table).T
            share = x / crest
            assert y == pytest.approx(np.minimum(part * 330 * np.sqrt(share), 330 * share), abs=0.1)


def test_few_steps(once: bsm.Results) -> None:
    """BLOSMER took 51 cycles, UDEC 12 500."""
    assert len(once.stages[-1].steps) < 51


@pytest.mark.parametrize(("friction", "stands"), [(28.0, False), (30.0, True)])
def test_ten_blocks_on_a_steep_fault_hang_on_two_degrees_and_statics_agrees(friction: float, stands: bool) -> None:
    """The report: "extremely sensitive to changes in the friction angle"; by the steps and by the linear program."""
    base, _ = slope.with_geometry(slope.at_once(slope.load("ten_blocks")), blocks="regions", north_fault_dip=35.0)
    argillite = bsm.Patton(friction=friction)
    joints = [replace(joint, law=argillite) if joint.law.friction == 30 else joint for joint in base.joints]
    model = base.replace(joints=joints)
    results = bsm.run(model, slope.OPTIONS)
    assert results.status == ("stable" if stands else "unstable")
    assert bsm.limit_analysis(model).admissible is stands
    if not stands:
        assert results.unstable_blocks.tolist() == [3, 4, 5, 6, 7]
