"""The report of blocks that commonly make trouble."""

from __future__ import annotations

import numpy as np
import pytest
import scenes

import bsm_mesh as bsm
from bsm_mesh.app.quality import SHORT_EDGE, THIN_ASPECT, TINY_AREA, quality_rows, quality_summary
from bsm_mesh.contact.table import initial_contacts
from bsm_mesh.solve.system import LinearSystem

POOR = [
    scenes.SQUARE,
    scenes.square(1, 0),
    scenes.square(0, 1),
    scenes.rectangle(1, 1, 1.02, 1.02),  # tiny
    scenes.rectangle(-5, -0.05, 0, 0),  # thin
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
    assert TINY_AREA > 0.02**2
    assert 4 * np.pi * 0.25 / 10.1**2 < THIN_ASPECT
    assert 0.005 / np.sqrt(0.5) < SHORT_EDGE
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
    assert rows["concave blocks"] == f"5, first at ({x:.4g}, {y:.4g})"
    assert rows["blocks without contact"].startswith("4, 5, 6, first at (")


def test_a_good_mesh_has_none() -> None:
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(scenes.grid(3, 3), rock="granite"),
        rocks=[bsm.Rock("granite", unit_weight=26e3, young=1e9, poisson=0.2)],
        supports=[bsm.Fixed(blocks=[0])],
    )
    report = quality_summary(model, LinearSystem(model, initial_contacts(model)))
    assert not any(report[key] for key in ("tiny", "thin", "concave", "short_edged", "without_contact"))
    assert dict(quality_rows(report))["tiny blocks (area below 0.001 of the median)"] == "none"
