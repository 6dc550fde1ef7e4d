"""Traces from CSV, GeoJSON and DXF."""

from __future__ import annotations

import contextlib
import json
import re
import sys
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely

from bsm_mesh.errors import MeshWarning
from bsm_mesh.geometries import (
    Fault,
    GeometryError,
    Region,
    RockMass,
    cut_blocks,
    joint_sets_of_scan_line,
    read_scan_line,
    read_traces,
)
from tests.scenes.networks import box

LINES = {"J1": [[(-1, 3), (11, 4)]], "F": [[(5, -1), (5.5, 4), (5, 11)]]}


def write_csv(folder: Path) -> Path:
    rows = ["x,y,trace,set"]
    for name, lines in LINES.items():
        rows += [f"{x}, {y}, {name}{k}, {name}" for k, line in enumerate(lines) for x, y in line]
    path = folder / "traces.csv"
    path.write_text("\n".join(rows))
    return path


def write_geojson(folder: Path) -> Path:
    features = [
        {"type": "Feature", "properties": {"set": name}, "geometry": {"type": "MultiLineString", "coordinates": lines}}
        for name, lines in LINES.items()
    ]
    path = folder / "traces.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def write_dxf(folder: Path) -> Path:
    drawing = ezdxf.new()
    space = drawing.modelspace()
    space.add_line(*LINES["J1"][0], dxfattribs={"layer": "J1"})
    space.add_lwpolyline(LINES["F"][0], dxfattribs={"layer": "F"})
    drawing.saveas(folder / "traces.dxf")
    return folder / "traces.dxf"


@pytest.mark.parametrize("write", [write_csv, write_geojson, write_dxf])
def test_every_format_gives_the_same_blocks(tmp_path: Path, write: object) -> None:
    joints = read_traces(write(tmp_path))  # type: ignore[operator]
    assert {joint.name for joint in joints} == {"J1", "F"}
    region = [Region(outline=box(0, 0, 10, 10), rock="gneiss")]
    cut = cut_blocks(RockMass(regions=region, joints=joints))
    straight = [Fault(name=name, lines=lines) for name, lines in LINES.items()]
    wanted = cut_blocks(RockMass(regions=region, joints=straight))
    assert cut.count == wanted.count == 4
    assert {name: len(edges) for name, edges in cut.joints.items()} == {
        name: len(edges) for name, edges in wanted.joints.items()
    }


def test_a_row_a_trace_names_units_and_layers(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("x1,y1,x2,y2,set\n0,0,1000,0,bedding\n0,500,1000,500,bedding\n0,0,0,1,other\n")
    with pytest.warns(MeshWarning, match=r"left out, being named nowhere: 'other' \(1 line\)"):
        (found,) = read_traces(path, names={"bedding": "J1"}, scale=1e-3)
    assert found.name == "J1"
    np.testing.assert_allclose(found.lines, [[(0, 0), (1, 0)], [(0, 0.5), (1, 0.5)]])


def test_closed_polylines_close(tmp_path: Path) -> None:
    drawing = ezdxf.new()
    drawing.modelspace().add_lwpolyline([(0, 0), (1, 0), (1, 1)], close=True)
    drawing.saveas(tmp_path / "a.dxf")
    (found,) = read_traces(tmp_path / "a.dxf")
    assert len(found.lines[0]) == 4


def drawn(folder: Path) -> tuple[Path, dict[str, float]]:
    """Return a drawing of curves, one a layer, and the length of each as it is."""
    drawing = ezdxf.new()
    space = drawing.modelspace()
    space.add_arc((0, 0), 5, 0, 90, dxfattribs={"layer": "arc"})
    space.add_lwpolyline([(0, 0, 0, 0, 1), (10, 0, 0, 0, 0)], format="xyseb", dxfattribs={"layer": "bulge"})
    space.add_spline([(0, 0), (5, 4), (10, -4), (15, 0)], dxfattribs={"layer": "spline"})
    space.add_circle((3, 3), 2, dxfattribs={"layer": "circle"})
    space.add_ellipse((0, 0), (4, 0), 0.5, 0, np.pi, dxfattribs={"layer": "ellipse"})
    inner = drawing.blocks.new("inner")
    inner.add_line((0, 0), (1, 0))
    outer = drawing.blocks.new("outer")
    outer.add_blockref("inner", (0, 1), dxfattribs={"xscale": 2})
    outer.add_line((0, 0), (0, 3), dxfattribs={"layer": "own"})
    space.add_blockref("outer", (100, 50), dxfattribs={"layer": "insert", "rotation": 90})
    space.add_text("J1")
    space.add_point((1, 1))
    space.add_point((2, 1))
    drawing.saveas(folder / "curves.dxf")
    a, b = 4.0, 2.0
    h = (a - b) ** 2 / (a + b) ** 2
    half = np.pi * (a + b) * (1 + 3 * h / (10 + np.sqrt(4 - 3 * h))) / 2  # Ramanujan's second, to 1e-9 here
    lengths = {"arc": 2.5 * np.pi, "bulge": 5 * np.pi, "circle": 4 * np.pi, "ellipse": half, "own": 3.0}
    return folder / "curves.dxf", lengths


@pytest.mark.parametrize("tolerance", [0.1, 1e-3])
def test_curves_are_sampled_to_a_tolerance(tmp_path: Path, tolerance: float) -> None:
    """No chord is further from its curve than the tolerance; inserts are taken apart, other things are counted."""
    path, lengths = drawn(tmp_path)
    with pytest.warns(MeshWarning, match=r"curves.dxf: left out, being no lines: 2 POINT, 1 TEXT"):
        found = {one.name: [np.asarray(line) for line in one.lines] for one in read_traces(path, tolerance=tolerance)}
    assert set(found) == {*lengths, "spline", "insert"}
    for name, length in lengths.items():
        sampled = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in found[name])
        assert length * (1 - 2 * tolerance) - 1e-9 <= sampled <= length * (1 + 1e-9), name
    (arc,) = found["arc"]
    np.testing.assert_allclose(np.hypot(*arc.T), 5, rtol=1e-9)
    middle = (arc[1:] + arc[:-1]) / 2
    assert (5 - np.hypot(*middle.T)).max() <= tolerance
    (spline,) = found["spline"]
    np.testing.assert_allclose(spline[[0, -1]], [(0, 0), (15, 0)], atol=1e-9)
    (insert,) = found["insert"]  # of a block in a block, twice as wide, turned by 90 degrees
    np.testing.assert_allclose(insert, [(99, 50), (99, 52)], atol=1e-9)


def test_a_finer_tolerance_takes_more_points(tmp_path: Path) -> None:
    path, _ = drawn(tmp_path)
    with pytest.warns(MeshWarning):
        coarse, fine, usual = (
            sum(len(line) for one in read_traces(path, tolerance=t) for line in one.lines) for t in (1.0, 1e-4, None)
        )
    assert coarse < usual < fine
    with pytest.raises(GeometryError, match="tolerance = 0 is no length"):
        read_traces(path, tolerance=0)


@pytest.mark.parametrize("ending", ["shp", "gpkg"])
def test_lines_of_a_gis(tmp_path: Path, ending: str) -> None:
    """A shapefile and a GeoPackage of traces, as QGIS writes them, give the blocks of the same lines."""
    path = write_gis(tmp_path / f"traces.{ending}")
    joints = read_traces(path)
    assert {joint.name for joint in joints} == {"J1", "F"}
    region = [Region(outline=box(0, 0, 10, 10), rock="gneiss")]
    assert cut_blocks(RockMass(regions=region, joints=joints)).count == 4


def write_gis(path: Path, crs: str = "EPSG:25832") -> Path:
    pyogrio = pytest.importorskip("pyogrio")
    shapes = [shapely.LineString(line) for lines in LINES.values() for line in lines]
    fields = [np.array([name for name, lines in LINES.items() for _ in lines], dtype=object)]
    pyogrio.raw.write(
        path,
        geometry=np.array([shapely.to_wkb(shape) for shape in shapes], dtype=object),
        field_data=fields,
        fields=["set"],
        geometry_type="LineString",
        crs=crs,
    )
    return path


def test_what_gdal_cannot_use_is_said(tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match=r"are in degrees .*; project them to metres"):
        read_traces(write_gis(tmp_path / "degrees.gpkg", "EPSG:4326"))
    path = write_gis(tmp_path / "cut.gpkg")
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(GeometryError, match=r"cut\.gpkg: GDAL cannot read it \((?!.*lines\.gpkg)"):
        read_traces(path)


def test_without_pyogrio_the_cure_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyogrio", None)
    (tmp_path / "a.shp").touch()
    with pytest.raises(GeometryError, match=r"a.shp: to read shapefiles and GeoPackages: pip install pyogrio"):
        read_traces(tmp_path / "a.shp")


def test_the_columns_of_porepy(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("# FID, START_X, START_Y, END_X, END_Y\n0, 0, 1, 2, 3\n")
    (found,) = read_traces(tmp_path / "a.csv")
    np.testing.assert_allclose(found.lines, [[(0, 1), (2, 3)]])


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.dwg", "", "traces are read from .csv, .geojson, .json, .dxf, .shp, .gpkg"),
        ("a.csv", "x,y\n1,2\n", "needs the columns x, y, trace; it has x, y"),
        ("a.csv", "x1,y1,x2,y2\n1,2,a,3\n", "line 2: x2 = 'a' is no finite number"),
        ("a.json", "{", "no JSON file of traces"),
        ("a.geojson", '{"type": "FeatureCollection", "features": []}', "holds no traces"),
        ("a.dxf", "no drawing", "no DXF file"),
    ],
)
def test_what_is_no_file_of_traces_is_said(tmp_path: Path, name: str, content: str, says: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(GeometryError, match=says.replace(".", r"\.")):
        read_traces(tmp_path / name)


def test_unknown_sets_and_missing_files_are_said(tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match="has no set 'K'"):
        read_traces(write_csv(tmp_path), names={"K": "J1"})
    with pytest.raises(GeometryError, match="cannot be read"):
        read_traces(tmp_path / "missing.csv")


def test_a_scan_line_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "scan.csv"
    path.write_text(
        "distance,dip,dip_direction,set\n0,60,90,J1\n1.1,62,92,J1\n2.0,58,88,J1\n0.4,20,270,B\n3.4,22,268,B\n"
    )
    sets = joint_sets_of_scan_line(read_scan_line(path), trend=90, plunge=0, section_azimuth=90)
    assert [found.name for found in sets] == ["J1", "B"]
    assert [found.dip for found in sets] == pytest.approx([-60, 21], abs=0.1)
    path.write_text("distance,dip,dip_direction,set\n0,95,90,J1\nx,62,92,J1\n")
    with pytest.raises(GeometryError) as caught:
        read_scan_line(path)
    assert len(caught.value.faults) == 2


HEAD = "x1,y1,x2,y2,set\n0,0,1,1,J1\n"
GEOJSON = '{"type": "LineString", "coordinates": COORDINATES}'


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.csv", HEAD.encode() + "0,0,1,1,Größe\n".encode("latin-1"), "line 3: is no text in UTF-8"),
        ("a.geojson", '{"name": "Größe"}'.encode("latin-1"), "line 1: is no text in UTF-8"),
        ("a.csv", HEAD + "0,0,1\n", "line 3: has more or fewer cells than the header"),
        ("a.csv", HEAD + "0,0,1,1,J1,7\n", "line 3: has more or fewer cells than the header"),
        ("a.csv", HEAD + "0,0,1,nan,J1\n", "line 3: y2 = 'nan' is no finite number"),
        ("a.csv", HEAD + "0,0,1,-inf,J1\n", "line 3: y2 = '-inf' is no finite number"),
        ("a.csv", HEAD + "0,0,1,1e200,J1\n", "coordinates that are no numbers below 1e+12 m"),
        ("a.csv", HEAD + '0,0,1,1,"J1\n', "is no table"),
        ("a.csv", "x,y,trace\n0,0,1\n", "line 1 of the set 'traces' has 1 point(s); it needs two"),
        ("a.json", GEOJSON.replace("COORDINATES", "[[0, 0], [1, NaN]]"), "coordinates that are no numbers below"),
        *(
            (
                "a.json",
                GEOJSON.replace("COORDINATES", line),
                "is no JSON file of traces: a position of the set 'traces' is not of the form [x, y]",
            )
            for line in ("[[0, 0], [1]]", "[0, 1]", '[["a", 0], [1, 1]]', "[[0, 0], [null, 1]]", "7", '{"a": 1}')
        ),
        ("a.json", GEOJSON.replace("COORDINATES", f"[[0, 0], [{'9' * 5000}, 1]]"), "coordinates that are no numbers"),
        ("a.csv", "", "a.csv: has no rows; it needs a header and rows below it"),
        ("a.csv", "x1,y1,x2,y2\n", "a.csv: has no rows; it needs a header and rows below it"),
        ("a.json", "[" * 100_000, "brackets nested too deep"),
        ("a.json", "[1, 2]", "no JSON file of traces"),
        ("a.json", '{"type": "FeatureCollection"}', "it has no 'features'"),
    ],
)
def test_damaged_traces(tmp_path: Path, name: str, content: str | bytes, says: str) -> None:
    (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(GeometryError, match=re.escape(says)):
        read_traces(tmp_path / name)


@pytest.mark.parametrize("scale", [0, -1, float("nan"), float("inf")])
def test_a_scale_is_a_length(tmp_path: Path, scale: float) -> None:
    with pytest.raises(GeometryError, match="is no length above 0 m"):
        read_traces(write_csv(tmp_path), scale=scale)


def test_all_wrong_rows_are_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(HEAD + "0,0,1,a,J1\n0,nan,1,b,J1\n")
    with pytest.raises(GeometryError) as caught:
        read_traces(tmp_path / "a.csv")
    assert len(caught.value.faults) == 3


def test_a_drawing_cut_off_anywhere_is_an_error_or_is_read(tmp_path: Path) -> None:
    drawing = ezdxf.new()
    drawing.modelspace().add_lwpolyline([(0, 0), (1, 0), (1, 1)])
    drawing.saveas(tmp_path / "a.dxf")
    whole = (tmp_path / "a.dxf").read_bytes()
    for length in range(0, len(whole), len(whole) // 15):
        (tmp_path / "b.dxf").write_bytes(whole[:length])
        with contextlib.suppress(GeometryError):
            read_traces(tmp_path / "b.dxf")


@pytest.mark.parametrize(
    ("row", "says"),
    [
        (b"1,60,90", "line 3: has more or fewer cells than the header"),
        (b"1,nan,90,J", "line 3: dip = 'nan' is no finite number"),
        (b"1,60,inf,J", "line 3: dip_direction = 'inf' is no finite number"),
        (b"1,60,1e9,J", "line 3: dip_direction = 1e+09 is no angle"),
        (b"1e200,60,90,J", "line 3: distance = 1e+200 must be below"),
        (b"1,60,90,Gr\xf6\xdfe", "line 3: is no text in UTF-8"),
    ],
)
def test_damaged_scan_lines(tmp_path: Path, row: bytes, says: str) -> None:
    (tmp_path / "a.csv").write_bytes(b"distance,dip,dip_direction,set\n0,60,90,J\n" + row + b"\n")
    with pytest.raises(GeometryError, match=re.escape(says)):
        read_scan_line(tmp_path / "a.csv")


@pytest.mark.parametrize("ending", ["csv", "dxf", "geojson", "gpkg"])
def test_a_name_too_long_for_the_disk_is_refused(ending: str) -> None:
    with pytest.raises(GeometryError):
        read_traces(f"{3000 * 'x'}.{ending}")
