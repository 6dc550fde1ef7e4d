"""The model as a whole: cross-checks collected, names with the nearest known one, equality."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.faults import fault
from tests.scenes.models import framed
from tests.scenes.shapes import grid, square

BLOCKS = framed(bsm.Blocks.from_polygons(grid(2, 1), rock=["granite", "schist"]), 2, 1)
ROCKS = (bsm.Rock("granite", unit_weight=26e3), bsm.Rock("schist", unit_weight=20e3))
JOINT = bsm.Joint("J1", 1e9, 1e9)


def model(**changes):
    given = {"blocks": BLOCKS, "rocks": ROCKS, "joints": (JOINT,), "default_joint": "J1"}
    return bsm.Model(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"rocks": (bsm.Rock("granit", unit_weight=0), ROCKS[1])},
            "rock 'granite' of 1 block (at (0.5, 0.5)) is not defined; define it, [rock.granite] in a model file; did",
        ),
        (
            {"rocks": ()},
            "rock 'schist' of 1 block (at (1.5, 0.5)) is not defined; define it, [rock.schist] in a model file",
        ),
        ({"rocks": (*ROCKS, ROCKS[0])}, "rock 'granite' is defined more than once; remove all but one"),
        ({"joints": (JOINT, JOINT)}, "joint 'J1' is defined more than once; remove all but one"),
        ({"default_joint": "J2"}, "default_joint: there is no joint 'J2'; did you mean 'J1'? (known: J1)"),
        (
            {"blocks": BLOCKS.with_joint("SZ", lambda x, y: abs(x - 1) < 1e-9)},
            "joint 'SZ' of 2 block edges (at (1, 0.5)) is not defined; define it, [joint.SZ] in a model file",
        ),
        ({"gravity_direction": np.inf}, "model: gravity_direction = inf is not a finite number [degrees]"),
        (
            {"contact_points": "end"},
            "model: contact_points = 'end' is unknown; did you mean 'ends'? (known: both, corners, ends, gauss)",
        ),
        (
            {"supports": (bsm.Fixed(boundary="tp"),)},
            "support 1 (Fixed): there is no boundary 'tp'; did you mean 'top'?",
        ),
        (
            {"loads": (bsm.Pressure(boundary="tp", pressure=1.0),)},
            "load 1 (Pressure): there is no boundary 'tp'; did you mean 'top'?",
        ),
        (
            {"loads": (bsm.PointLoad(block=2, point=(0, 0), force=(1, 0)),)},
            "load 1 (PointLoad): there is no block 2; blocks are numbered 0 to 1",
        ),
        (
            {"loads": (bsm.PointLoad(block=1, point=(0.5, 0.5), force=(1, 0)),)},
            "load 1 (PointLoad): the point (0.5, 0.5) is not in block 1, whose centroid is (1.5, 0.5)",
        ),
    ],
)
def test_cross_checks(changes, message):
    with fault(message):
        model(**changes)


def test_all_faults_come_at_once():
    with pytest.raises(bsm.ModelError) as caught:
        model(
            rocks=(),
            default_joint="x",
            supports=(bsm.Fixed(boundary="x"),),
            loads=(bsm.Pressure(boundary="x", pressure=1),),
        )
    assert len(caught.value.faults) == 5


def test_many_faults_are_cut_short_in_the_message_only():
    loads = [bsm.PointLoad(block=9, point=(0, 0), force=(1, 0))] * 20
    with pytest.raises(bsm.ModelError) as caught:
        model(loads=loads)
    assert len(caught.value.faults) == 20
    message = str(caught.value)
    assert message.count("\n") == 1
    assert message.endswith(
        "[19 more of this kind: load 2 (PointLoad), load 3 (PointLoad), load 4 (PointLoad), ...]"
    ), message


def test_unused_rocks_and_joints_are_welcome():
    assert len(model(rocks=(*ROCKS, bsm.Rock("spare", unit_weight=0))).rocks) == 3


def test_weights_follow_rock_and_direction():
    m = model(gravity_direction=-60.0)
    assert_allclose(m.weights, [26e3, 20e3])
    assert_allclose(m.gravity_forces, np.outer([26e3, 20e3], (0.5, -np.sqrt(3) / 2)))


def test_equality_and_digest():
    assert model() == model(title="another name")
    assert hash(model()) == hash(model())
    assert model() != model(gravity_direction=-89.0)
    assert model() != model(supports=(bsm.Fixed(blocks=[0]),))
    assert model() != model(joints=(bsm.Joint("J1", 1e9, 2e9),))
    moved = framed(bsm.Blocks.from_polygons([square(0, 0), square(1.0, 1e-12)], rock=["granite", "schist"]), 2, 1)
    assert model() != model(blocks=moved)
    assert model() != 3


def test_replace_checks_anew():
    with fault("default_joint: there is no joint 'J9'"):
        model().replace(default_joint="J9")


def test_models_and_results_are_shown_in_five_lines_at_most():
    results = bsm.run(model(supports=[bsm.Fixed(blocks=[0])]))
    (stage,) = results.stages
    for thing in (results.model, results.blocks, results, stage, stage.contacts, stage.evidence):
        text = repr(thing)
        assert text.count("\n") < 4
        assert max(map(len, text.splitlines())) < 5 * 80
    assert repr(results.blocks).startswith("Blocks: 2 blocks of 1 to 1 m2, (0, 0) to (2, 1) m")
    assert repr(results).startswith(f"Results: {results.status.value}")
