"""Kinematic screening of slopes: published lines, zones of the stereonet, the command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bsm_mesh.geometries import GeometryError, draw_kinematics, kinematic_screening, read_orientations
from bsm_mesh.geometries.kinematics import intersections, permits_by_line, permits_by_plane
from bsm_mesh.geometries.orientations import line_directions, upward_normals
from tests.scenes.small_case import Case

TABLE = "dip,dip_direction,set\n35,300,J3\n36,304,J3\n60,250,J4\n58,252,J4\n40,360,J5\n75,118,J6\n"


@pytest.mark.parametrize(
    ("planes", "trend", "plunge", "half"),
    [
        (((36, 266), (59, 146)), 219, 26, 0.5),  # Hudson and Harrison (1997), appendix B
        (((50, 130), (30, 250)), 200.5, 20.5, 1.0),  # Wyllie and Mah (2004), chapter 2: read off a net
        (((45, 105), (70, 235)), 157.7, 31.2, 0.05),  # Hoek and Bray (1981), appendix 2: the wedge
    ],
)
def test_published_lines_of_intersection(planes, trend, plunge, half):
    found = kinematic_screening({str(k): plane for k, plane in enumerate(planes)}, face=(65, 185), friction=20)
    assert_allclose(found.trend, trend, atol=half)
    assert_allclose(found.plunge, plunge, atol=half)


def test_the_wedge_of_hoek_and_bray():
    """It slides on both planes at 20 and 30 degrees of friction, and neither plane slides by itself."""
    for friction, slides in ((20, True), (30, True), (32, False)):
        found = kinematic_screening({"A": (45, 105), "B": (70, 235)}, face=(65, 185), friction=friction)
        assert found.wedge.tolist() == [slides]
        assert found.slides_on.tolist() == [-1]
        assert not found.planar.any()


def test_a_pit_slope_of_five_sets():
    """Richards' data set for a slope 60/300 and friction 25: set 3 slides."""
    sets = {"1": (45, 60), "2": (60, 180), "3": (35, 300), "4": (60, 250), "5": (40, 0)}
    found = kinematic_screening(sets, face=(60, 300), friction=25)
    assert found.planar.tolist() == [False, False, True, False, False]
    wedges = {
        (int(a) + 1, int(b) + 1) for a, b in zip(found.first[found.wedge], found.second[found.wedge], strict=True)
    }
    assert wedges == {(2, 3), (3, 4), (3, 5), (4, 5)}
    assert not found.flexural.any()


@pytest.mark.parametrize(
    ("dip", "direction", "expected"),
    [
        (40, 135, True),
        (34, 135, False),  # flatter than friction
        (46, 135, False),  # steeper than the face
        (40, 154, True),
        (40, 156, False),  # beyond the lateral limit
        (44.5, 154, False),  # the face falls at 43.4 degrees in this direction
    ],
)
def test_planar_sliding(dip, direction, expected):
    assert kinematic_screening({"J": (dip, direction)}, face=(45, 135), friction=35).planar.tolist() == [expected]


@pytest.mark.parametrize(
    ("dip", "direction", "expected"),
    [
        (80, 315, True),  # its normal plunges 10 degrees; 65 - 35 = 30 are allowed
        (61, 315, True),
        (59, 315, False),
        (80, 344, True),
        (80, 346, False),
        (80, 135, False),  # dips out of the slope
        (64.5, 344, True),  # 30 degrees fall at 26.8 degrees across: 90 - 63.2
        (62.5, 344, False),
    ],
)
def test_flexural_toppling(dip, direction, expected):
    found = kinematic_screening({"J": (dip, direction)}, face=(65, 135), friction=35)
    assert found.flexural.tolist() == [expected]


def test_no_flexural_toppling_of_a_face_flatter_than_friction():
    assert not kinematic_screening({"J": (90, 135)}, face=(30, 135), friction=35).flexural.any()


def test_direct_toppling_needs_lines_into_the_slope_and_a_base():
    columns = {"J1": (80, 330), "J2": (80, 240)}  # meet in a steep line that dips into the slope
    found = kinematic_screening(columns, face=(70, 105), friction=30)
    assert found.direct.tolist() == [True]
    assert found.modes["direct toppling"] == (0, 1)
    based = kinematic_screening(columns | {"J3": (10, 200)}, face=(70, 105), friction=30)
    assert based.base.tolist() == [False, False, True]
    assert based.modes["direct toppling"][0] == 1


def test_wedges_slide_where_mechanics_says():
    """A wedge pushed by its weight on two planes without friction slides on both if both are pressed."""
    rng = np.random.default_rng(5)
    planes = rng.uniform([5, 0], [85, 360], (600, 2))
    dip, direction = planes.T
    first, second = np.arange(0, 600, 2), np.arange(1, 600, 2)
    trend, plunge = intersections(dip, direction, first, second)
    line, normals = line_directions(trend, plunge), upward_normals(dip, direction)
    for k in range(300):
        pair = {"a": planes[first[k]], "b": planes[second[k]]}
        slides = kinematic_screening(pair, face=(89, float(trend[k])), friction=0).slides_on[0]
        basis = np.stack([normals[first[k]], normals[second[k]], line[k]], axis=1)
        pressed = np.linalg.solve(basis, [0, 0, 1.0])[:2] > 0  # normal forces that balance the weight across the line
        assert slides == (-1 if pressed.all() else int(np.argmax(pressed)))


def test_all_turns_with_the_slope():
    rng = np.random.default_rng(8)
    dip, direction = rng.uniform(0, 90, 200), rng.uniform(0, 360, 200)
    for test, limits in ((permits_by_plane, (20.0, 30.0)), (permits_by_line, (20.0,))):
        for face in (35.0, 60.0, 89.0, 90.0):
            before = test(*((dip, direction) if len(limits) == 2 else (direction, dip)), (face, 10.0), 30.0, *limits)
            turned = direction + 123.0
            after = test(*((dip, turned) if len(limits) == 2 else (turned, dip)), (face, 133.0), 30.0, *limits)
            for one, two in zip(before, after, strict=True):
                np.testing.assert_array_equal(one, two)


def test_parallel_planes_have_no_line(tmp_path: Path):
    found = kinematic_screening({"A": (40, 120), "B": ([40, 60], [120, 200])}, face=(60, 120), friction=30)
    assert np.isnan(found.trend).tolist() == [True, False]
    assert not found.wedge[0]
    assert draw_kinematics(tmp_path / "net.png", found).read_bytes().startswith(b"\x89PNG")
    with pytest.raises(GeometryError, match="is a PNG"):
        draw_kinematics(tmp_path / "net.svg", found)


@pytest.mark.parametrize(
    ("sets", "changes", "message"),
    [
        ({}, {}, "no sets"),
        ({"J": (95, 10)}, {}, "dip = 95 must be from 0 to 90 degrees"),
        ({"J": (45, 400)}, {}, "dip direction = 400 must be from -360 to 360"),
        ({"J": ([45, 50], [10])}, {}, "set 'J': 2 dips and 1 dip directions"),
        ({"J": (45, 10)}, {"friction": np.nan}, "friction = nan must be from 0 to 90 degrees"),
        ({"J": (45, 10)}, {"face": (91, 0)}, "dip of the face = 91 must be from 0 to 90 degrees"),
    ],
)
def test_faults(sets, changes, message):
    with pytest.raises(GeometryError, match=message):
        kinematic_screening(sets, **{"face": (60, 120), "friction": 30, **changes})


def test_a_table_of_orientations(tmp_path: Path):
    path = tmp_path / "joints.csv"
    path.write_text("dip direction;dip [rad]\n120;0,5235987755982988\n")
    sets = read_orientations(path)
    assert_allclose(sets["joints"], [[30], [120]])
    path.write_text("dip,dip_direction\n")
    with pytest.raises(GeometryError):
        read_orientations(path)


@pytest.mark.heavy
def test_the_command(case: Case):
    case.write("joints.csv", TABLE)
    outcome = case.run("kinematics", "joints.csv", "--face", "60", "300", "--friction", "25", "--json")
    told = json.loads(outcome.out)
    assert told["sets"]["J3"] == {
        "planes": 2, "dip": pytest.approx(35.5, abs=0.1), "dip_direction": pytest.approx(302, abs=0.1), "planar": 1.0,
        "flexural": 0.0, "base": 1.0, "mean_plane_slides": True, "mean_plane_topples": False,
    }  # fmt: skip
    assert told["modes"]["planar sliding"] == {"possible": 2, "of": 6}
    assert told["modes"]["flexural toppling"] == {"possible": 1, "of": 6}
    assert all((case.folder / file).is_file() for file in told["files"])
    rows = (case.folder / "out/joints/kinematic_planes.csv").read_text().splitlines()
    assert rows[0] == "set,dip [deg],dip_direction [deg],planar,flexural,base"
    assert len(rows) == 7
    outcome = case.run("kinematics", "joints.csv", "--face", "60", "300", "--friction", "25", "--no-picture")
    assert "planar sliding: 2 of 6 planes permit it" in outcome.out


def test_planes_of_a_table_without_sets_have_no_mean_plane(case: Case):
    case.write("joints.csv", "dip,dip_direction\n35,300\n60,250\n40,360\n")
    face = ("kinematics", "joints.csv", "--face", "60", "300", "--friction", "25", "--no-picture")
    (row,) = json.loads(case.run(*face, "--json").out)["sets"].values()
    assert row["planes"] == 3
    assert {key: row[key] for key in ("dip", "dip_direction", "mean_plane_slides")} == {
        "dip": None, "dip_direction": None, "mean_plane_slides": None,
    }  # fmt: skip
    (line,) = [line for line in case.run(*face).out.splitlines() if line.lstrip("| ").startswith("joints")]
    assert line.replace("|", " ").split()[:3] == ["joints", "3", "-"]


def test_bad_input_of_the_command(case: Case):
    case.write("joints.csv", TABLE.replace("60,250", "95,250"))
    face = ("--face", "60", "300")
    case.refuses("kinematics", "joints.csv", *face, "--friction", "25", says=["line 4", "dip = 95 must be from 0"])
    case.refuses("kinematics", "none.csv", *face, "--friction", "25", says=["none.csv", "cannot be read"])
    case.write("joints.csv", "strike,dip\n1,2\n")
    case.refuses("kinematics", "joints.csv", *face, "--friction", "25", says=["dip_direction"])
    case.write("joints.csv", TABLE)
    case.refuses("kinematics", "joints.csv", *face, "--friction", "99", says=["friction = 99 must be from 0 to 90"])


def test_a_friction_of_a_tangent_and_a_table_of_strikes_are_told(case: Case) -> None:
    case.write("joints.csv", TABLE)
    told = case.run("kinematics", "joints.csv", "--face", "60", "300", "--friction", "0.47", "--no-picture")
    assert "note: friction = 0.47 degrees is less than that of any rock or clay" in told.out
    assert "25.2 if 0.47 is its tangent" in told.out
    case.write("strikes.csv", TABLE.replace("dip_direction", "strike"))
    refused = case.run("kinematics", "strikes.csv", "--face", "60", "300", "--friction", "25")
    assert refused.code == 2
    assert "has a column 'strike' and none 'dip_direction'" in refused.err
