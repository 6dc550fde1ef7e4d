"""Bolts installed in stages (Wang 4.5.2, 5.5): they feel what moves after them, and go with excavated blocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results import BoltStatus, Results
from tests.scenes.models import LINEAR, model_of
from tests.scenes.shapes import rectangle

CONTINUATION = bsm.Options(scheme="continuation", tolerance=1e-9)
GAMMA, K = 26e3, 1e8
COLUMN = [rectangle(0, -j, 1, 1 - j) for j in range(4)]  # from the roof down; the lowest is on the floor


def run(stages, bolts, options, polygons=COLUMN, supports=None, **keys):
    joint = bsm.Joint("J", normal_stiffness=K, shear_stiffness=K, law=bsm.Patton(friction=30))
    given = {"supports": supports, "bolts": bolts, "stages": stages, **keys}
    return bsm.run(model_of(polygons, gamma=GAMMA, joint=joint, fixed=(0, 3), **given), options)


def roof_bolt(**keys):
    return bsm.Bolt(**{"start": (0.5, -0.8), "end": (0.5, 0.6), "diameter": 0.02, **keys})


def test_bolt_holds_the_roof_when_the_rock_below_is_taken_away():
    """Block 1 sags on block 2 before the bolt comes; of that the bolt feels nothing, of the excavation all.

    It hangs from above its centroid, as a pendulum.
    """
    stages = [bsm.Stage(name="support"), bsm.Stage(name="open", excavate=[2])]
    results = run(stages, [roof_bolt(stage="support", start=(0.5, -0.3))], CONTINUATION)
    assert results.status == "stable"
    assert results.check().ok
    forces = [stage.bolts.axial_force[0] for stage in results.stages]
    assert [stage.bolts.status[0] for stage in results.stages] == [
        BoltStatus.ABSENT,
        BoltStatus.SLACK,
        BoltStatus.ELASTIC,
    ]
    assert_allclose(forces, [0, 0, GAMMA], rtol=1e-6, atol=1e-3)
    stretch = GAMMA * 0.9 / (200e9 * np.pi * 0.02**2 / 4)
    assert_allclose(results.stages[-1].stage_displacement[1, 1], -stretch, rtol=1e-3)


def test_a_block_that_hangs_from_below_its_centroid_leans_on_the_rock_above():
    """Upright it is in equilibrium, an unstable one: it tilts until a corner closes the gap left by the bolt's stretch.

    Corners at the end of a face are let in by a thousandth of the block size first.
    """
    stages = [bsm.Stage(name="support"), bsm.Stage(name="open", excavate=[2])]
    stage = run(stages, [roof_bolt(stage="support")], CONTINUATION).stages[-1]
    assert stage.status == "stable"
    stretch = GAMMA * 1.4 / (200e9 * np.pi * 0.02**2 / 4)
    assert 2 * stretch < abs(stage.stage_displacement[1, 2]) < 2 * (stretch + 1e-3)
    assert stage.bolts.axial_force[0] - GAMMA == pytest.approx(-stage.contacts.normal_force.sum(), rel=1e-3)
    assert stage.bolts.axial_force[0] > GAMMA


def test_without_the_bolt_it_falls():
    results = run([bsm.Stage(name="open", excavate=[2])], [], CONTINUATION)
    assert results.status == "unstable"
    assert results.unstable_blocks.tolist() == [1]


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_pretension_at_its_stage(options):
    """Springs in series: the bolt loses to the joint it closes; what the ground did before does not count."""
    stages = [bsm.Stage(name="bolt"), bsm.Stage(name="rest")]
    blocks = [rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)]
    bolt = bsm.Bolt(start=(0.5, 1.7), end=(0.5, 0.2), diameter=0.03, kind="end_anchored", pretension=5e4, stage="bolt")
    results = run(stages, [bolt], options, blocks, [bsm.Fixed(blocks=[0])])
    k = 200e9 * np.pi * 0.03**2 / 4 / 1.5
    expected = 5e4 * K / (K + k)
    for stage, compression in zip(results.stages, (GAMMA, GAMMA + expected, GAMMA + expected), strict=True):
        assert_allclose(-stage.contacts.normal_force.sum(), compression, rtol=1e-5)
    assert_allclose([stage.bolts.axial_force[0] for stage in results.stages], [0, expected, expected], rtol=1e-5)
    assert results.check().ok


@pytest.mark.parametrize("options", [LINEAR, CONTINUATION])
def test_bolt_is_cut_at_the_new_face(options):
    """A bolt through four blocks in a row; the last is taken away: the rest of the bolt works on."""
    row = [rectangle(i, 0, i + 1, 1) for i in range(4)]
    bolt = bsm.Bolt(start=(0, 0.5), end=(4, 0.5), diameter=0.02, pretension=1e4)
    supports = [bsm.Fixed(blocks=range(4))]
    results = run([bsm.Stage(name="cut", excavate=[3])], [bolt], options, row, supports)
    before, after = results.stages[0].bolts, results.stages[1].bolts
    assert_allclose(before.axial_force, 1e4)
    assert_allclose(after.axial_force, [1e4, 1e4, 0])
    assert after.alive.tolist() == [True, True, False]
    assert_allclose(after.bond_force, [1e4, 0, -1e4, 0], atol=1e-6)
    assert results.check().ok


def test_end_anchored_bolt_dies_with_its_anchorage():
    row = [rectangle(i, 0, i + 1, 1) for i in range(4)]
    bolt = bsm.Bolt(start=(0, 0.5), end=(3.5, 0.5), diameter=0.02, kind="end_anchored", pretension=1e4)
    between = run([bsm.Stage(name="cut", excavate=[1])], [bolt], LINEAR, row, [bsm.Fixed(blocks=range(4))])
    assert_allclose(between.stages[1].bolts.axial_force, [1e4])
    anchorage = run([bsm.Stage(name="cut", excavate=[3])], [bolt], LINEAR, row, [bsm.Fixed(blocks=range(4))])
    assert anchorage.stages[1].bolts.status.tolist() == [BoltStatus.ABSENT]


def test_bolt_must_lie_in_what_is_there_at_its_stage():
    stages = [bsm.Stage(name="open", excavate=[2])]
    with pytest.raises(bsm.ModelError, match=r"start in the void, 0\.5 m before the rock"):
        run(stages, [roof_bolt(start=(0.5, -1.5), stage="open")], LINEAR)
    with pytest.raises(bsm.ModelError, match="there is no stage 'opne'; did you mean 'open'"):
        run(stages, [roof_bolt(stage="opne")], LINEAR)


@pytest.mark.heavy
def test_saved_and_read_again(tmp_path):
    stages = [bsm.Stage(name="support"), bsm.Stage(name="open", excavate=[2])]
    results = run(stages, [roof_bolt(stage="support")], CONTINUATION)
    read = Results.load(results.save(tmp_path))
    for stage, again in zip(results.stages, read.stages, strict=True):
        assert_allclose(again.bolts.axial_force, stage.bolts.axial_force, rtol=0)
        assert_allclose(again.bolts.displacement, stage.bolts.displacement, rtol=0)
        assert again.bolts.block.tolist() == stage.bolts.block.tolist()
