"""FracMan's fractures cut by a section: where planes meet it, what cannot be read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bsm_mesh.errors import MeshWarning
from bsm_mesh.geometries import GeometryError, Region, RockMass, apparent_dip, cut_blocks, read_fractures, read_traces
from tests.scenes.networks import box

HEAD = "BEGIN FORMAT\n Format = Ascii\n Length_Unit = {unit}\n XAxis = East\n Scale = 100\nEND FORMAT\n\n"
HEAD += 'BEGIN PROPERTIES\n Prop1 = (Real*4) "Transmissivity"\nEND PROPERTIES\n\n'
HEAD += 'BEGIN SETS\n Set1 = "J1"\n Set2 = "Bedding"\nEND SETS\n\n'


def plane(dip: float, dip_direction: float, centre: tuple[float, float, float], half: float) -> np.ndarray:
    """Return the corners of a square fracture."""
    d, a = np.radians([dip, dip_direction])
    strike = np.array([-np.cos(a), np.sin(a), 0.0])
    down = np.array([np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), -np.sin(d)])
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return np.array([np.asarray(centre) + half * (u * strike + v * down) for u, v in corners])


def fab(folder: Path, fractures: list[tuple[int, np.ndarray]], unit: str = "Meter", more: str = "") -> Path:
    rows = ["BEGIN FRACTURE"]
    for number, (of_set, corners) in enumerate(fractures, start=1):
        rows += [f" {number} {len(corners)} {of_set} 1.2E-09"]
        rows += [f"   {k} {x:.12g} {y:.12g} {z:.12g}" for k, (x, y, z) in enumerate(corners, start=1)]
        rows += ["   0 -1.0 -1.0 -1.0"]
    path = folder / "a.fab"
    path.write_text(HEAD.format(unit=unit) + "\n".join([*rows, "END FRACTURE"]) + "\n" + more)
    return path


@pytest.mark.parametrize("azimuth", [0.0, 35.0, 90.0, 200.0])
def test_a_plane_leaves_its_apparent_dip_through_its_centre(tmp_path: Path, azimuth: float) -> None:
    """The trace of a large plane is the line at tan(apparent) = tan(dip) cos(dip direction - azimuth)."""
    centre, origin = (103.0, 57.0, -20.0), (103.0, 57.0, -25.0)
    (joint,) = read_fractures(fab(tmp_path, [(1, plane(55, 120, centre, 4.0))]), section_azimuth=azimuth, origin=origin)
    ((x0, y0), (x1, y1)) = joint.lines[0]
    assert joint.name == "J1"
    slope = np.tan(np.radians(apparent_dip(55, 120, azimuth)))
    assert (y1 - y0) == pytest.approx(slope * (x1 - x0))
    assert y0 - slope * x0 == pytest.approx(5.0)  # it goes through the centre, 5 m above the origin


def test_upright_concave_and_distant_fractures_of_two_sets(tmp_path: Path) -> None:
    upright = np.array([(3, -5, 0), (3, 5, 0), (3, 5, 8), (3, -5, 8)], dtype=float)
    u_shape = np.array([(0, -2, 1), (9, -2, 1), (9, 2, 1), (6, 2, 1), (6, -1, 1), (4, -1, 1), (4, 2, 1), (0, 2, 1)])
    away = plane(30, 90, (0, 100, 0), 2.0)
    path = fab(tmp_path, [(1, upright), (2, u_shape), (2, away)])
    joints = {joint.name: np.array(joint.lines) for joint in read_fractures(path, section_azimuth=90)}
    np.testing.assert_allclose(joints["J1"], [[(3, 0), (3, 8)]], atol=1e-12)
    np.testing.assert_allclose(joints["Bedding"], [[(0, 1), (4, 1)], [(6, 1), (9, 1)]], atol=1e-12)
    in_feet = fab(tmp_path, [(1, upright)], unit="Feet")
    assert read_fractures(in_feet, section_azimuth=90)[0].lines[0][1][1] == pytest.approx(8 * 0.3048)


def test_the_traces_cut_blocks(tmp_path: Path) -> None:
    path = fab(tmp_path, [(1, plane(90, 90, (5, 0, 5), 20)), (2, plane(0, 0, (5, 0, 4), 20))])
    joints = read_fractures(path, section_azimuth=90)
    assert cut_blocks(RockMass(regions=[Region(outline=box(0, 0, 10, 10), rock="r")], joints=joints)).count == 4


def test_what_is_left_out_is_counted_and_what_cannot_be_read_is_told(tmp_path: Path) -> None:
    tess = "BEGIN TESSFRACTURE\n 1 3 1 1\n 1 0 0 0\nEND TESSFRACTURE\n"
    path = fab(tmp_path, [(1, plane(40, 90, (0, 0, 0), 5))], more=tess)
    with pytest.warns(MeshWarning, match=r"left out: 2 in TESSFRACTURE \(lines\)"):
        read_fractures(path, section_azimuth=90)
    with pytest.raises(GeometryError, match=r"cuts none of its 1 fracture; move its origin"):
        read_fractures(fab(tmp_path, [(1, plane(40, 90, (0, 90, 0), 5))]), section_azimuth=90)
    good = path.read_text()
    for old, new, message in (
        ("4 1 1.2E-09", "40 1 1.2E-09", "a.fab.* (ends within a fracture|is no FracMan file in ASCII)"),
        ("4 1 1.2E-09", "2 1 1.2E-09", "line 18: .*: a fracture has 3 vertices at least, not 2"),
        (
            "4 1 1.2E-09",
            "4",
            "line 18: .*: a fracture begins with its number, how many vertices, and its set; this is '1",
        ),
        ("4 1 1.2E-09", "5 1 1.2E-09", "line 24: .*: after 5 vertices comes the normal, which begins with 0; this is"),
        ("   2 ", "   2 x ", "line 20: .*: a vertex, of 4 of this fracture, is a number, x, y and z; this is '2 x"),
        ("Set1", "SetA", "line 13: .*: a set has its name as in Set1 = J1; this is 'SetA'"),
        ("Ascii", "Binary", "line 2: .* Format = Binary; export it in ASCII"),
        ("East", "North", "export it with the x axis to the east"),
        ("Meter", "Furlong", "Length_Unit = Furlong; known: m, meter"),
        ("   1 ", "   1 nan ", "coordinates that are no numbers below"),
        ("BEGIN FRACTURE", "BEGIN NOTHING", "holds no fractures"),
    ):
        path.write_text(good.replace(old, new))
        with pytest.raises(GeometryError, match=message):
            read_fractures(path, section_azimuth=90)
    with pytest.raises(GeometryError, match=r"fractures in space: read_fractures\(path, section_azimuth=\.\.\.\)"):
        read_traces(path)
    with pytest.raises(GeometryError, match="section_azimuth = 'east' is not a finite number"):
        read_fractures(path, section_azimuth="east")  # type: ignore[arg-type]
    with pytest.raises(GeometryError, match="needs three numbers: east, north and elevation"):
        read_fractures(path, section_azimuth=0, origin=(1, 2))  # type: ignore[arg-type]
