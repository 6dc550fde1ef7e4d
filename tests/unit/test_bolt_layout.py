"""Which blocks a bolt passes, and its nodes (Wang 5.2.1, 5.3.2)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.bolt_layout import lay_out_bolts, pass_blocks
from tests.scenes.shapes import grid, rectangle, turned

ROW = [rectangle(i, 0, i + 1, 1) for i in range(4)]


def bolt(start, end, **keys):
    return bsm.Bolt(start=start, end=end, diameter=0.02, **keys)


def blocks_of(polygons):
    return bsm.Blocks.from_polygons(polygons, rock="any")


def test_nodes_at_the_head_the_tip_and_in_the_middle():
    layout = lay_out_bolts([bolt((0, 0.5), (3.5, 0.5), bond_strength=1e5)], blocks_of(ROW))
    assert layout.block.tolist() == [0, 1, 2, 3]
    assert_allclose(layout.station, [0, 1.5, 2.5, 3.5])
    assert_allclose(layout.point, np.column_stack([layout.station, np.full(4, 0.5)]))
    assert_allclose(layout.capacity, [1e5, 1e5, 1e5, 0.5e5])


def test_direction_is_from_head_to_tip():
    layout = lay_out_bolts([bolt((3.5, 0.5), (0.2, 0.5))], blocks_of(ROW))
    assert layout.block.tolist() == [3, 2, 1, 0]
    assert_allclose(layout.station, [0, 1, 2, 3.3])
    assert np.isinf(layout.capacity).all()


def test_capacity_of_the_weaker_interface():
    keys = {"hole_diameter": 0.05, "bond_steel_grout": 2e6, "bond_grout_rock": 1e6}
    layout = lay_out_bolts([bolt((0, 0.5), (2, 0.5), **keys)], blocks_of(ROW))
    assert_allclose(layout.capacity, np.pi * min(0.02 * 2e6, 0.05 * 1e6) * np.ones(2))


def test_end_anchored_has_two_nodes():
    layout = lay_out_bolts([bolt((0, 0.5), (3.5, 0.5), kind="end_anchored", anchor_capacity=8e4)], blocks_of(ROW))
    assert layout.block.tolist() == [0, 3]
    assert_allclose(layout.capacity, 8e4)


def test_plate_adds_to_the_head():
    layout = lay_out_bolts([bolt((0, 0.5), (2, 0.5), bond_strength=1e5, plate=7e4)], blocks_of(ROW))
    assert_allclose(layout.capacity, [1.7e5, 1e5])


def test_concave_block_is_passed_twice():
    notched = np.array([(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)])
    passed = pass_blocks([bolt((0.5, 1.5), (3.5, 1.5))], blocks_of([notched, rectangle(3, 0, 4, 2)]))
    assert passed.block.tolist() == [0, 0, 1]
    assert_allclose(passed.first, [0, 1.5, 2.5])
    assert_allclose(passed.last, [0.5, 2.5, 3])


def test_through_a_corner_of_four_blocks():
    passed = pass_blocks([bolt((0.25, 0.25), (1.75, 1.75))], blocks_of(grid(2, 2)))
    assert passed.block.tolist() == [0, 3]


@pytest.mark.parametrize("angle", [0.0, 17.0, 111.0])
def test_heads_on_a_face_are_in_the_rock(angle):
    """Turned and moved far off, a head on the face is off it by rounding."""
    polygons = [turned(p, angle, (1e4, -2e4)) for p in ROW]
    head, tip = turned(np.array([(0, 0.37), (2.5, 0.61)]), angle, (1e4, -2e4))
    assert pass_blocks([bolt(head, tip)], blocks_of(polygons)).block.tolist() == [0, 1, 2]


@pytest.mark.parametrize(("head", "tip"), [(-0.0009, 2.5), (1.5, 4.0009)])
def test_ends_rounded_to_millimetres_stay_where_they_are_given(head, tip):
    """0.9 mm in the void, of bolts of 2.5 m: they lie in the same blocks, and bonds are as long as in the rock."""
    layout = lay_out_bolts([bolt((head, 0.5), (tip, 0.5), bond_strength=1e5)], blocks_of(ROW))
    inside = lay_out_bolts([bolt((max(head, 0), 0.5), (min(tip, 4), 0.5), bond_strength=1e5)], blocks_of(ROW))
    assert layout.block.tolist() == inside.block.tolist()
    assert_allclose(layout.capacity, inside.capacity, rtol=1e-9)
    assert_allclose(layout.point[[0, -1], 0], [head, tip])


FAULTS = [
    (((-0.004, 0.5), (2, 0.5)), ["start in the void, 0.004 m before the rock; start it at (0, 0.5)"]),
    (
        ((-0.5, 0.5), (2, 0.5)),
        ["bolt 1 from (-0.5, 0.5)", "start in the void, 0.5 m before the rock; start it at (0, 0.5)"],
    ),
    (((0.5, 0.5), (4.25, 0.5)), ["end in the void, 0.25 m beyond the rock; end it at (4, 0.5)"]),
    (((0.35, 0.44), (-0.76, 0.43)), ["end in the void", "end it at (0, 0.4368468468)"]),
    (((9, 9), (10, 9)), ["passes no block"]),
    (((1, 0.1), (1, 0.9)), ["runs along an edge of block 0 over 0.8 m", "move it off the joint"]),
    (((0, 1), (3.5, 1)), ["runs along an edge of block"]),
    (((-1e-16, 0.1), (-1e-16, 0.9)), ["runs along an edge of block 0 over 0.8 m"]),
    (((2 + 1e-10, 0.1), (2 - 1e-10, 0.9)), ["runs along an edge of block 1 over 0.8 m"]),
]


@pytest.mark.parametrize(("ends", "words"), FAULTS)
def test_faults_name_bolt_place_and_cure(ends, words):
    with pytest.raises(bsm.ModelError) as caught:
        pass_blocks([bolt(*ends)], blocks_of(ROW))
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_all_faults_are_collected_by_the_model():
    bad = [bolt(*ends, name=f"B{k}") for k, (ends, _) in enumerate(FAULTS)]
    with pytest.raises(bsm.ModelError) as caught:
        bsm.Model(blocks=blocks_of(ROW), rocks=[bsm.Rock("any", unit_weight=0)], bolts=[bolt((0, 0.5), (2, 0.5)), *bad])
    assert len(caught.value.faults) == len(bad)
    assert "bolt 2 'B0'" in caught.value.faults[0]


KEYS = [
    ({"diameter": -1}, "diameter = -1 m must be 0.001 to 0.5 m"),
    ({"kind": "groutd"}, "did you mean 'grouted'"),
    ({"kind": "end_anchored", "bond_strength": 1e5}, "bond_strength belong to grouted bolts"),
    ({"anchor_capacity": 1e5}, "anchor_capacity belongs to end-anchored bolts"),
    ({"bond_strength": 1e5, "hole_diameter": 0.05}, "give one or the other"),
    ({"hole_diameter": 0.05}, "need bond_grout_rock and bond_steel_grout"),
    ({"hole_diameter": 0.01, "bond_steel_grout": 1e6, "bond_grout_rock": 1e6}, "less than the diameter"),
    ({"yield_strength": 1e8, "pretension": 1e5}, "is more than the bolt carries, 31415.9 N"),
    ({"spacing": 0}, "spacing = 0 m must be 0.01 to 100 m"),
    ({"end": (0, 0)}, "the same point"),
    ({"end": (0, float("nan"))}, "not a finite number"),
]


@pytest.mark.parametrize(("keys", "words"), KEYS)
def test_bolts_that_make_no_sense(keys, words):
    with pytest.raises(bsm.ModelError, match=r".") as caught:
        bsm.Bolt(**{"start": (0, 0), "end": (1, 0), "diameter": 0.02, "name": "B7", **keys})
    assert words in str(caught.value)
    assert "bolt 'B7'" in str(caught.value)


def test_elastic_bond_too_stiff_to_be_resolved_is_refused():
    """Its nodes would be millions; just below, there are as many as may be."""
    with pytest.raises(
        bsm.ModelError, match=r"bond_stiffness = 1e\+15 N/m2 is too stiff .* along 2 m; give 1.4e\+12 or"
    ):
        bolt((0, 0.5), (2, 0.5), bond_strength=1e5, bond_stiffness=1e15)
    layout = lay_out_bolts([bolt((0, 0.5), (2, 0.5), bond_strength=1e5, bond_stiffness=1.4e12)], blocks_of(ROW))
    assert 1900 < len(layout.block) <= 2002
