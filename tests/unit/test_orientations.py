"""Orientations from the field against vector algebra and published rules."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bsm_mesh.geometries import (
    GeometryError,
    Lognormal,
    apparent_dip,
    apparent_spacing,
    draw_stereonet,
    joint_set_in_section,
    joint_sets_of_scan_line,
)
from bsm_mesh.geometries.orientations import line_directions, mean_normal, upward_normals
from bsm_mesh.geometries.stereonet import friction_circles, project

ANGLES = np.random.default_rng(11).uniform([0, 0, 0], [90, 360, 360], (200, 3))


def normal_of(dip: float, direction: float) -> np.ndarray:
    delta, alpha = np.radians([dip, direction])
    return np.array([np.sin(delta) * np.sin(alpha), np.sin(delta) * np.cos(alpha), np.cos(delta)])


def test_the_trace_lies_in_the_plane_and_in_the_section() -> None:
    for dip, direction, azimuth in ANGLES:
        angle = np.radians(apparent_dip(dip, direction, azimuth))
        right = np.array([np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth)), 0.0])
        trace = np.cos(angle) * right + np.sin(angle) * np.array([0, 0, 1.0])
        assert trace @ normal_of(dip, direction) == pytest.approx(0, abs=1e-12)


def test_apparent_spacing_is_that_of_planes_cut_by_the_section() -> None:
    for dip, direction, azimuth in ANGLES:
        right = np.array([np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth)), 0.0])
        normal = normal_of(dip, direction)
        in_section = normal - (normal @ np.cross(right, [0, 0, 1.0])) * np.cross(right, [0, 0, 1.0])
        wide = float(apparent_spacing(2.0, dip, direction, azimuth))
        assert wide == pytest.approx(2.0 / np.linalg.norm(in_section))


def test_known_apparent_dips() -> None:
    # A plane that dips 40 degrees, seen 45 degrees off its dip direction: atan(tan 40 cos 45) = 30.68 degrees.
    assert float(apparent_dip(40, 90, 45)) == pytest.approx(-np.degrees(np.arctan(np.tan(np.radians(40)) / np.sqrt(2))))
    assert float(apparent_dip(90, 100, 45)) == pytest.approx(-90)
    assert float(apparent_dip(35, 0, 90)) == pytest.approx(0, abs=1e-12)
    with pytest.raises(GeometryError, match="nearly parallel to the section"):
        joint_set_in_section("J1", dip=90, dip_direction=0, spacing=1, section_azimuth=90)


def test_a_scan_line_gives_back_the_set_that_it_crossed() -> None:
    spacing, dip, direction = 0.8, 60.0, 120.0
    trend, plunge = 100.0, 10.0
    line = np.array([np.sin(np.radians(trend)), np.cos(np.radians(trend)), 0]) * np.cos(np.radians(plunge))
    line = line - np.array([0, 0, np.sin(np.radians(plunge))])
    step = spacing / abs(line @ normal_of(dip, direction))
    rows = [{"distance": 3 + k * step, "dip": dip, "dip_direction": direction, "set": "J1"} for k in range(12)]
    (found,) = joint_sets_of_scan_line(rows, trend=trend, plunge=plunge, section_azimuth=130)
    assert found.dip == pytest.approx(float(apparent_dip(dip, direction, 130)))
    mean = found.spacing.mean if isinstance(found.spacing, Lognormal) else found.spacing
    assert mean == pytest.approx(float(apparent_spacing(spacing, dip, direction, 130)))
    assert found.scatter == pytest.approx(0, abs=1e-6)
    with pytest.raises(GeometryError, match="set 'J2' has one joint"):
        joint_sets_of_scan_line([{**rows[0], "set": "J2"}], trend=0, plunge=0, section_azimuth=90)


def test_the_mean_normal_takes_steep_planes_of_both_dip_directions_as_one_set() -> None:
    normal = mean_normal([85, 85], [90, 270])
    np.testing.assert_allclose(np.abs(normal), [1, 0, 0], atol=1e-12)


def test_the_net_is_of_equal_area() -> None:
    # A cap of angle t around the centre covers 1 - cos t of the hemisphere and (r / 1)^2 of the net.
    angle = np.radians(37)
    (place,) = project(np.array([[np.sin(angle), 0, -np.cos(angle)]]))
    assert place @ place == pytest.approx(1 - np.cos(angle))


def test_the_stereonet_is_a_picture(tmp_path: Path) -> None:
    path = draw_stereonet(
        tmp_path / "net.png",
        {"bedding": ([28, 32, 30, 35], [110, 118, 105, 112]), "J1": ([78, 84, 80], [20, 200, 15])},
        section_azimuth=112,
    )
    assert path.read_bytes().startswith(b"\x89PNG")
    drawn = draw_stereonet(tmp_path / "slope.png", {"J1": (60, 120)}, friction=30, face=(65, 130))
    assert drawn.read_bytes() != path.read_bytes()
    with pytest.raises(GeometryError, match="friction = 95 must lie between 0 and 90 degrees"):
        draw_stereonet(tmp_path / "slope.png", {}, friction=95)
    with pytest.raises(GeometryError, match="is a PNG"):
        draw_stereonet(tmp_path / "net.svg", {})


@pytest.mark.parametrize("friction", [20.0, 45.0])
def test_friction_circles_part_planes_and_lines(friction: float) -> None:
    """A plane's pole lies as far from the centre as its dip; a line of the same plunge as far from the rim."""
    (flat, _, _), (steep, _, _) = friction_circles(friction)
    pole, line = (
        project(-upward_normals(friction, 70)),
        project(line_directions(np.array([70.0]), np.array([friction]))),
    )
    assert np.hypot(*pole[0]) == pytest.approx(flat)
    assert np.hypot(*line[0]) == pytest.approx(steep)
