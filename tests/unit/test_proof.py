"""Proof that blocks must move: sought where it is cheap, and never claimed of what limit analysis leaves out."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.limit import proof
from bsm_mesh.solve.limit.proof import prove
from tests.scenes.models import model_of
from tests.scenes.shapes import grid, rectangle, turned


def block(*numbers):
    return np.array(numbers, dtype=np.int32)


def incline(friction, *more, fixed=()):
    polygons = [turned(p, 30.0) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))]
    return model_of([*polygons, *more], friction=friction, fixed=(0, *fixed))


def test_a_block_slides_by_the_mechanism():
    found = prove(incline(25.0), block(1))
    u, v, turn = found.witness.velocity[1]
    down = np.degrees(np.arctan2(v, u)) % 360  # the plane dips 30 degrees; an associated slide dilates by friction
    assert (down, turn) == pytest.approx((210.0 - 25.0, 0.0))
    assert "at most 0 times the loads" in found.text


def test_nothing_is_proved_where_forces_exist():
    found = prove(incline(35.0), block(1))
    assert found.witness is None
    assert "which proves nothing" in found.text


def test_in_a_large_model_the_part_that_comes_down_is_asked(monkeypatch):
    monkeypatch.setattr(proof, "MAX_BLOCKS", 300)
    others = [p + np.array([20.0, 0.0]) for p in grid(20, 20)]
    model = incline(25.0, *others, fixed=range(2, 402))
    found = prove(model, block(1))
    assert np.flatnonzero(found.witness.velocity.any(axis=1)).tolist() == [1]
    assert set(found.witness.block_a.tolist()) | set(found.witness.block_b.tolist()) == {0, 1}
    assert "is too large" in prove(incline(35.0, *others, fixed=range(2, 402)), block(1)).text


@pytest.mark.parametrize(("layers", "proved"), [(0, False), (1, True)])
def test_neighbours_may_move_too(monkeypatch, layers, proved):
    """A block lies level on a wedge that slides: with the wedge fixed it would rest."""
    x, y = 0.5 * np.cos(np.radians(30.0)), 0.25
    wedge = np.array([(-x, -y), (x, y), (-x, y)])
    plane = turned(rectangle(-9, -2, 3, 0), 30.0)
    others = [p + np.array([20.0, 0.0]) for p in grid(3, 3)]
    polygons = [plane, wedge, rectangle(-x, y, x - 0.2, y + 0.5), *others]
    monkeypatch.setattr(proof, "LAYERS", layers)
    monkeypatch.setattr(proof, "MAX_BLOCKS", 5)
    found = prove(model_of(polygons, friction=25.0, fixed=(0, *range(3, 12))), block(2))
    assert (found.witness is not None) == proved


@pytest.mark.parametrize(("aside", "proved"), [(0.0, False), (1.0, True)])
def test_a_square_on_its_corner_has_a_contact_without_a_face(aside, proved):
    """With its centre above the corner nothing is proved; aside it turns over the corner."""
    model = model_of([rectangle(-2, -1, 2, 0), turned(rectangle(0, 0, 1, 1), 45.0 + aside)], friction=30.0)
    found = prove(model, block(1))
    assert (found.witness is not None) == proved, found.text


@pytest.mark.parametrize(("force", "proved"), [(12.4e3, True), (12.6e3, False)])
def test_a_load_decides_to_the_digit(force, proved):
    """A block of 12.5 kN hangs from a load that pulls it up."""
    pull = bsm.PointLoad(block=1, point=(0.5, -0.25), force=(0.0, force))
    model = model_of([rectangle(0, 0, 1, 1), rectangle(0, -0.5, 1, 0)], friction=30.0, loads=[pull])
    assert (prove(model, block(1)).witness is not None) == proved


def test_bolts_of_later_stages_count_in_the_proof():
    """Friction is lost in a stage: its bolt of 0.1 kN is too weak for the 0.9 kN that the block lacks."""
    top, bottom = turned(np.array([(0.0, 0.5), (0.0, -1.5)]), 30.0).tolist()
    bolt = bsm.Bolt(start=top, end=bottom, diameter=0.005, yield_strength=5e6, bond_strength=2e5, stage="loss")
    model = incline(35.0).replace(bolts=[bolt], stages=[bsm.Stage("loss", strength={"J": 0.7})])
    stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
    assert stage.status.value == "unstable"
    assert stage.proof.witness is not None, stage.proof.text
    assert stage.proof.witness.element_yield == pytest.approx(98.2, abs=0.1)  # 5 MPa on 19.6 mm2


def test_of_a_bolt_whose_block_is_excavated_the_rest_counts():
    """The block below leaves; what is left of its bolt holds the two others together, which then fall together."""
    squares = [rectangle(-3, -1, 0, 0), *(rectangle(0, y, 1, y + 1) for y in (-1, 0, 1))]
    bolt = bsm.Bolt(start=(0.5, -0.5), end=(0.5, 1.5), diameter=0.025, yield_strength=5e8, bond_strength=2e5)
    model = model_of(squares, friction=30.0, fixed=(0, 1)).replace(
        bolts=[bolt], stages=[bsm.Stage("out", excavate=[1])]
    )
    stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
    assert stage.unstable_blocks.tolist() == [2, 3]
    assert stage.proof.witness.node_block.tolist().count(1) == 0
    assert set(stage.proof.witness.node_block.tolist()) == {2, 3}
