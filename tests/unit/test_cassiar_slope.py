"""The geometry of the Cassiar slope: areas by formula, all discontinuities as groups, faults of the parameters."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gmsh")

from bsm_mesh import converters
from bsm_mesh.geometries import GeometryError, cassiar_slope
from bsm_mesh.model.locate import blocks_at

TAN_FACE = math.tan(math.radians(40))


def test_blocks_groups_and_areas(tmp_path: Path) -> None:
    blocks = converters.read_blocks(cassiar_slope.build(tmp_path / "slope.msh"), blocks="regions")
    assert set(blocks.joint_names) == {"dyke", "contact", "north_fault", "fault_a1", *"BCDEF"}
    assert set(blocks.boundaries) >= {"left", "right", "bottom", "ground"}
    crest = 330 / TAN_FACE
    whole = (crest + 250 + 200) * 150 + 250 * 330 + crest * 330 / 2
    assert blocks.moments.area.sum() == pytest.approx(whole, rel=1e-9)
    dyke = 15 / math.sin(math.radians(75)) * (330 + 150)
    at_floor = 10 / TAN_FACE + 10 / math.tan(math.radians(60))  # the contact, left of the toe
    at_bottom = 10 / TAN_FACE + 160 / math.tan(math.radians(60))
    ore = 150 * (200 + (at_floor + at_bottom) / 2) + 10 * at_floor / 2
    serpentinite = blocks.moments.area[blocks.rock == blocks.rock_names.index("serpentinite")]
    assert np.sort(serpentinite) == pytest.approx([dyke, ore], rel=1e-9)


def test_one_point_a_layer_and_two_below_the_fault(tmp_path: Path) -> None:
    blocks = converters.read_blocks(cassiar_slope.build(tmp_path / "slope.msh"), blocks="regions")
    points = cassiar_slope.monitoring_points()
    on = [blocks_at(blocks, point, tolerance=1e-6).tolist() for point in points]
    assert all(len(found) == 1 for found in on)
    numbers = [found[0] for found in on]
    assert len(set(numbers[:5])) == 5
    assert numbers[5] == numbers[6] not in numbers[:5]
    assert np.allclose([x for x, _ in points], [-y / TAN_FACE for _, y in points])


def test_steeper_faults_and_sizes_are_built(tmp_path: Path) -> None:
    path = cassiar_slope.build(tmp_path / "slope.msh", north_fault_dip=25, fault_a1_dip=5, size=60.0)
    assert converters.read_blocks(path).count > 50
    assert converters.read_blocks(path, blocks="regions").count == 10


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"north_fault_dipp": 30}, "north_fault_dip"),
        ({"joint_f_level": 130}, "joint_f_level = 130 m must be below fault_level = 120 m"),
        ({"fault_a1_length": 400}, "reaches the dyke"),
        ({"north_fault_dip": 39.9, "fault_a1_dip": 39}, "which must lie between joint F"),
        ({"contact_dip": 20}, "the contact reaches the dyke"),
        ({"behind": 30}, "does not reach beyond the dyke"),
        ({"joint_dip": 45}, "joint_dip = 45"),
        ({"height": -1, "dyke_dip": 90}, "height = -1"),
        ({"size": 0}, "size = 0"),
    ],
)
def test_faults(tmp_path: Path, parameters: dict[str, float], says: str) -> None:
    with pytest.raises(GeometryError) as caught:
        cassiar_slope.build(tmp_path / "slope.msh", **parameters)
    assert says in str(caught.value)
    assert not list(tmp_path.iterdir())
