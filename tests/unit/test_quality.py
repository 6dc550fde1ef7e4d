"""The report of blocks that commonly make trouble."""

from __future__ import annotations

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.solve.linear.system import LinearSystem
from bsm_mesh.text.quality import Thresholds, quality_rows, quality_summary
from tests.scenes import shapes

POOR = [
    shapes.SQUARE,
    shapes.square(1, 0),
    shapes.square(0, 1),
    shapes.rectangle(1, 1, 1.02, 1.02),  # tiny
    shapes.rectangle(-5, -0.05, 0, 0),  # thin
    np.array([(2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (2.6, 0.2)]),  # concave
    np.array([(5.0, 0.0), (6.0, 0.0), (6.0, 0.005), (5.0, 1.0)]),  # short edge, without contact
]


@pytest.fixture(scope="module")
def report() -> dict[str, object]:
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(POOR, rock="granite"),
        rocks=[bsm.Rock("granite", unit_weight=26e3, young=1e9, poisson=0.2)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9)],
        supports=[bsm.Fixed(blocks=range(len(POOR)))],
    )
    return quality_summary(model, LinearSystem(model, initial_contacts(model)))


def test_poor_blocks_are_listed(report: dict[str, object]) -> None:
    assert Thresholds().tiny > 0.02**2
    assert 4 * np.pi * 0.25 / 10.1**2 < Thresholds().thin
    assert 0.005 / np.sqrt(0.5) < Thresholds().short_edged
    assert report["tiny"] == [3]
    assert report["thin"] == [4]
    assert report["concave"] == [5]
    assert report["short_edged"] == [6]
    assert report["without_contact"] == [4, 5, 6]  # 4 and 5 touch others at a corner


def test_sums(report: dict[str, object]) -> None:
    area = bsm.Blocks.from_polygons(POOR, rock="granite").moments.area.sum()
    assert report["total_area"] == pytest.approx(area)
    assert report["weight"] == pytest.approx(26e3 * area)
    assert report["blocks"] == 7
    assert report["corners_per_block"] == [4, 4]
    assert report["joint_lengths"] == {"J1": 0.0}


def test_rows_name_the_blocks(report: dict[str, object]) -> None:
    rows = dict(quality_rows(report))
    x, y = bsm.Blocks.from_polygons([POOR[5]], rock="granite").moments.centroid[0]
    assert rows["concave blocks"] == f"block 5, first at ({x:.6g}, {y:.6g})"
    assert rows["blocks without contact"].startswith("blocks 4, 5, 6, first at (")


def test_a_good_mesh_has_none() -> None:
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(shapes.grid(3, 3), rock="granite"),
        rocks=[bsm.Rock("granite", unit_weight=26e3, young=1e9, poisson=0.2)],
        supports=[bsm.Fixed(blocks=[0])],
    )
    report = quality_summary(model, LinearSystem(model, initial_contacts(model)))
    assert not any(report[key] for key in report["thresholds"] if key != "gap")
    assert not any(report[key] for key in ("concave", "without_contact", "unsupported", "gaps", "t_intersections"))
    assert report["parts"] == 1
    assert dict(quality_rows(report))["tiny blocks (area below 0.001 of the median)"] == "none"


def summary(polygons: list[np.ndarray], supported: list[int], **thresholds: float) -> dict[str, object]:
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="granite"),
        rocks=[bsm.Rock("granite", unit_weight=26e3, young=1e9, poisson=0.2)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9)],
        default_joint="J1",
        supports=[bsm.Fixed(blocks=supported)],
    )
    return quality_summary(model, LinearSystem(model, initial_contacts(model)), Thresholds(**thresholds))


def test_parts_and_blocks_without_a_path_to_a_support() -> None:
    report = summary([shapes.SQUARE, shapes.square(1, 0), shapes.square(5, 0), shapes.square(6, 0)], [0])
    assert report["parts"] == 2
    assert report["unsupported"] == [2, 3]


def test_t_intersections_are_counted() -> None:
    bricks = [shapes.rectangle(0, 0, 2, 1), shapes.rectangle(0, 1, 1, 2), shapes.rectangle(1, 1, 2, 2)]
    assert summary(bricks, [0])["t_intersections"] == 1
    assert summary([*bricks[1:], shapes.square(0, 0), shapes.square(1, 0)], [0])["t_intersections"] == 0


def test_narrow_voids_are_gaps_and_wide_ones_are_openings() -> None:
    def ring(width: float) -> list[np.ndarray]:
        left, right = shapes.rectangle(0, 0, 1, 3), shapes.rectangle(1 + width, 0, 2 + width, 3)
        return [left, right, shapes.rectangle(1, 0, 1 + width, 1), shapes.rectangle(1, 2, 1 + width, 3)]

    assert summary(ring(0.01), [0])["gaps"] == 1
    assert summary(ring(1.0), [0])["gaps"] == 0
    assert summary(ring(0.01), [0], gap=1e-3)["gaps"] == 0
    assert summary(ring(0.01), [0])["first_at"]["gaps"] == pytest.approx([1.005, 1.5])  # type: ignore[index]


def test_thresholds_have_names() -> None:
    assert Thresholds.parse(["thin=0.2", "elongated = 4"]) == Thresholds(thin=0.2, elongated=4.0)
    long = [shapes.SQUARE, shapes.rectangle(1, 0, 6, 1)]
    assert summary(long, [0], elongated=4.9)["elongated"] == [1]
    assert summary(long, [0], elongated=5.1)["elongated"] == []
    with pytest.raises(bsm.ModelError, match="there is no threshold 'thinn'; did you mean 'thin'"):
        Thresholds.parse(["thinn=1"])
    with pytest.raises(bsm.ModelError, match="no number above 0"):
        Thresholds.parse(["thin=-1"])
