"""Features of GeoJSON and of GIS files are read alike: names of sets, collections, omissions, units, planes."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
import shapely

from bsm_mesh.errors import MeshWarning
from bsm_mesh.geometries import GeometryError, read_traces

pyogrio = pytest.importorskip("pyogrio")
LINE, OTHER = [(0, 5), (20, 7)], [(0, 2), (20, 3)]
SURVEY_FOOT = 1200 / 3937
Features = Sequence[tuple[object, str | None]]  # the property set, and the geometry as WKT


def written(path: Path, features: Features, crs: str | None = None, name: str = "set") -> Path:
    """Write features as GeoJSON, or by GDAL as the ending says."""
    shapes = [None if wkt is None else shapely.from_wkt(wkt) for _, wkt in features]
    if path.suffix == ".geojson":
        listed = [
            {
                "type": "Feature",
                "properties": {name: of},
                "geometry": None if shape is None else json.loads(shapely.to_geojson(shape)),
            }
            for (of, _), shape in zip(features, shapes, strict=True)
        ]
        content: dict[str, Any] = {"type": "FeatureCollection", "features": listed}
        if crs:
            authority, code = crs.split(":")
            version = "1.3" if authority == "OGC" else ""
            content["crs"] = {"type": "name", "properties": {"name": f"urn:ogc:def:crs:{authority}:{version}:{code}"}}
        path.write_text(json.dumps(content))
        return path
    values = [of for of, _ in features]
    spatial = any(shape is not None and shape.has_z for shape in shapes)
    whole = all(isinstance(of, int) for of in values)
    pyogrio.raw.write(
        path,
        geometry=np.array([None if shape is None else shapely.to_wkb(shape) for shape in shapes], dtype=object),
        field_data=[np.array(values, dtype=np.int64 if whole else object)],
        fields=[name],
        geometry_type=("2.5D " * spatial + "LineString") if path.suffix == ".shp" else "Unknown",
        crs=crs or "EPSG:25832",
    )
    return path


def said_of(path: Path, **keys: Any) -> tuple[dict[str, list[list[list[float]]]], list[str]]:
    """Return the lines of every set, and what was said."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", MeshWarning)
        found = read_traces(path, **keys)
    lines = {one.name: [np.asarray(line).tolist() for line in one.lines] for one in found}
    return lines, [str(one.message).removeprefix(f"{path}: ") for one in said if one.category is MeshWarning]


def as_lists(line: Sequence[tuple[float, float]]) -> list[list[float]]:
    return [[float(x), float(y)] for x, y in line]


@pytest.mark.parametrize("ending", ["geojson", "gpkg"])
def test_lines_in_collections_are_read_and_all_else_is_counted(tmp_path: Path, ending: str) -> None:
    features = [
        (
            "J1",
            "GEOMETRYCOLLECTION (POINT (1 1), MULTILINESTRING ((0 5, 20 7), EMPTY), POLYGON ((2 2, 8 2, 8 8, 2 2)))",
        ),
        ("J1", "GEOMETRYCOLLECTION (GEOMETRYCOLLECTION (LINESTRING (0 2, 20 3)))"),
        ("J1", "MULTIPOLYGON (((0 0, 1 0, 1 1, 0 0)), ((2 2, 3 2, 3 3, 2 2)))"),
        ("J2", "LINESTRING (0 2, 20 3)"),
        ("J2", "LINESTRING EMPTY"),
        ("J2", "GEOMETRYCOLLECTION EMPTY"),
        ("J2", None),
    ]
    lines, said = said_of(written(tmp_path / f"t.{ending}", features))
    assert lines == {"J1": [as_lists(LINE), as_lists(OTHER)], "J2": [as_lists(OTHER)]}
    assert said == [
        "left out, being no lines: 1 Point, 3 Polygon, 1 empty GeometryCollection, 2 empty line, "
        "1 feature without geometry"
    ]


@pytest.mark.parametrize("ending", ["geojson", "gpkg", "shp"])
def test_a_set_may_be_a_number(tmp_path: Path, ending: str) -> None:
    """A set called 0 is one, and no feature without a set."""
    features = [(0, "LINESTRING (0 5, 20 7)"), (12, "LINESTRING (0 2, 20 3)")]
    lines, _ = said_of(written(tmp_path / f"t.{ending}", features))
    assert lines == {"0": [as_lists(LINE)], "12": [as_lists(OTHER)]}
    lines, _ = said_of(tmp_path / f"t.{ending}", names={"0": "J1"})
    assert lines == {"J1": [as_lists(LINE)]}


@pytest.mark.parametrize(("ending", "layer"), [("geojson", "traces"), ("gpkg", "t"), ("shp", "t")])
def test_names_in_capitals_and_features_without_one(tmp_path: Path, ending: str, layer: str) -> None:
    features = [("J1", "LINESTRING (0 5, 20 7)"), (None, "LINESTRING (0 2, 20 3)"), (" ", "LINESTRING (0 2, 20 3)")]
    lines, _ = said_of(written(tmp_path / f"t.{ending}", features, name="Set"))
    assert lines == {"J1": [as_lists(LINE)], layer: [as_lists(OTHER), as_lists(OTHER)]}


def test_whole_numbers_with_gaps_are_whole_numbers(tmp_path: Path) -> None:
    """GDAL makes real numbers of whole ones where one is missing."""
    path = written(tmp_path / "t.gpkg", [(0, "LINESTRING (0 5, 20 7)")])
    pyogrio.raw.write(
        path,
        geometry=np.array([shapely.to_wkb(shapely.LineString(line)) for line in (LINE, OTHER)], dtype=object),
        field_data=[np.array([3.0, np.nan])],
        fields=["set"],
        geometry_type="LineString",
        crs="EPSG:25832",
    )
    assert said_of(path)[0] == {"3": [as_lists(LINE)], "t": [as_lists(OTHER)]}


@pytest.mark.parametrize("ending", ["geojson", "gpkg", "shp"])
def test_coordinates_in_feet_are_read_in_feet(tmp_path: Path, ending: str) -> None:
    """New York Long Island is measured in US survey feet; `scale` takes the place of the file's unit."""
    path = written(tmp_path / f"t.{ending}", [("J1", "LINESTRING (0 5, 20 7)")], "EPSG:2263")
    lines, (said,) = said_of(path)
    np.testing.assert_allclose(lines["J1"], [np.array(LINE) * SURVEY_FOOT], rtol=1e-9)
    assert "in US survey foot: lengths are multiplied by 0.30480061; scale = 1 takes them as metres" in said
    assert said_of(path, scale=1.0) == ({"J1": [as_lists(LINE)]}, [])


@pytest.mark.parametrize(
    ("ending", "crs"),
    [
        *((ending, crs) for ending in ("geojson", "gpkg") for crs in ("EPSG:4326", "EPSG:4258", "EPSG:4978")),
        ("shp", "EPSG:4258"),
    ],
)
def test_degrees_of_any_crs_are_refused(tmp_path: Path, ending: str, crs: str) -> None:
    path = written(tmp_path / f"t.{ending}", [("J1", "LINESTRING (0 5, 20 7)")], crs)
    reason = "distances from the middle of the earth" if crs == "EPSG:4978" else "in degrees"
    for scale in (None, 0.3048):
        with pytest.raises(GeometryError, match=rf"are {reason} \(CRS .*project them to metres first"):
            read_traces(path, scale=scale)


def test_a_crs_of_geojson_that_is_not_known_is_said(tmp_path: Path) -> None:
    path = written(tmp_path / "t.geojson", [("J1", "LINESTRING (0 5, 20 7)")], "EPSG:999999")
    lines, said = said_of(path)
    assert lines == {"J1": [as_lists(LINE)]}
    assert said == ["the unit of its coordinates is not known, CRS EPSG:999999: they are taken as metres"]
    assert said_of(written(path, [("J1", "LINESTRING (0 5, 20 7)")], "EPSG:25832"))[1] == []
    with pytest.raises(GeometryError, match="are in degrees"):
        read_traces(written(path, [("J1", "LINESTRING (0 5, 20 7)")], "OGC:CRS84"))


@pytest.mark.parametrize("name", ["http://127.0.0.1:1/crs", "/etc/hostname", "http::1", "file:a", 'PROJCS["a"]'])
def test_the_name_of_a_crs_is_no_path_and_no_address(tmp_path: Path, name: str) -> None:
    feature = {"type": "LineString", "coordinates": LINE, "crs": {"type": "name", "properties": {"name": name}}}
    (tmp_path / "t.geojson").write_text(json.dumps(feature))
    lines, said = said_of(tmp_path / "t.geojson")
    assert lines == {"traces": [as_lists(LINE)]}
    assert said in (
        [],
        [f"the unit of its coordinates is not known, CRS {name}: they are taken as metres"],
    )


@pytest.mark.parametrize("ending", ["geojson", "gpkg", "shp", "dxf"])
def test_a_section_drawn_in_the_front_view_is_turned(tmp_path: Path, ending: str) -> None:
    """Lines in the xz plane are those of the section, as a mesh in it is."""
    path = tmp_path / f"t.{ending}"
    if ending == "dxf":
        drawing = ezdxf.new()
        drawing.modelspace().add_line((0, 3, 5), (20, 3, 7), dxfattribs={"layer": "J1"})
        drawing.saveas(path)
    else:
        written(path, [("J1", "LINESTRING Z (0 3 5, 20 3 7)")])
    lines, said = said_of(path)
    assert lines == {"J1": [as_lists(LINE)]}
    assert said == ["its lines lie in the xz plane: x is taken as right, z as up"]


def test_other_planes(tmp_path: Path) -> None:
    """In the yz plane y is right; heights on a map are left out, which is said; one height everywhere is nothing."""
    path = tmp_path / "t.geojson"
    for wkt, line, says in (
        ("LINESTRING Z (3 0 5, 3 20 7)", LINE, ["its lines lie in the yz plane: y is taken as right, z as up"]),
        ("LINESTRING Z (0 5 1, 20 7 4)", LINE, ["z is from 1 to 4 m along its lines and is left out"]),
        ("LINESTRING Z (0 5 4, 20 7 4)", LINE, []),
        (
            "LINESTRING Z (0 5 4, 20 5 4)",
            [(0, 5), (20, 5)],
            ["its lines lie at y = 5 m and z = 4 m: y is taken as up, z is left out"],
        ),
    ):
        assert said_of(written(path, [("J1", wkt)])) == ({"J1": [as_lists(line)]}, says)


def test_a_file_without_lines_says_what_it_has(tmp_path: Path) -> None:
    path = written(tmp_path / "t.geojson", [("J1", "POINT (1 1)"), ("J1", "POLYGON ((0 0, 1 0, 1 1, 0 0))")])
    with pytest.raises(GeometryError, match=r"holds no traces \(left out: 1 Point, 1 Polygon\)"):
        read_traces(path)
    (tmp_path / "t.json").write_text('{"type": "Topology", "objects": {}}')
    with pytest.raises(GeometryError, match=r"holds no traces \(left out: 1 Topology\)"):
        read_traces(tmp_path / "t.json")


@pytest.mark.parametrize(
    ("code", "metres"), [(1, 0.0254), (2, 0.3048), (4, 1e-3), (5, 1e-2), (7, 1e3), (21, SURVEY_FOOT)]
)
def test_a_drawing_is_in_the_unit_that_its_header_names(tmp_path: Path, code: int, metres: float) -> None:
    """A joint from (0, 5) to (20, 7) m and a quarter of a circle, whose chords are within a tolerance in metres."""
    drawing = ezdxf.new(units=code)
    drawing.modelspace().add_line(*[np.array(point) / metres for point in LINE], dxfattribs={"layer": "J1"})
    drawing.modelspace().add_arc((0, 0), 5 / metres, 0, 90, dxfattribs={"layer": "arc"})
    drawing.saveas(tmp_path / "t.dxf")
    lines, (said,) = said_of(tmp_path / "t.dxf", tolerance=1e-3)
    np.testing.assert_allclose(lines["J1"], [LINE], rtol=1e-9)
    middle = (np.array(lines["arc"][0])[1:] + np.array(lines["arc"][0])[:-1]) / 2
    assert 1e-4 < 5 - np.hypot(*middle.T).min() < 1e-3
    assert re.fullmatch(
        rf"its header \(.INSUNITS\) says that it is drawn in .*: lengths are .* by {metres:.9g}; .*", said
    )
    assert said_of(tmp_path / "t.dxf", scale=metres, tolerance=1e-3) == (lines, [])


@pytest.mark.parametrize(("code", "notes"), [(0, 0), (6, 0), (18, 1)])
def test_a_drawing_in_metres_or_in_no_unit(tmp_path: Path, code: int, notes: int) -> None:
    drawing = ezdxf.new(units=code)
    drawing.modelspace().add_line(*LINE, dxfattribs={"layer": "J1"})
    drawing.saveas(tmp_path / "t.dxf")
    lines, said = said_of(tmp_path / "t.dxf")
    assert (lines, len(said)) == ({"J1": [as_lists(LINE)]}, notes)
    assert all("a unit that is not known ($INSUNITS = 18)" in text for text in said)


def test_a_curve_drawn_in_the_front_view_keeps_its_form(tmp_path: Path) -> None:
    """An arc in a coordinate system of its own, whose z points to the viewer, beside a line."""
    drawing = ezdxf.new()
    space = drawing.modelspace()
    space.add_arc((0, 0, 2), 5, 0, 90, dxfattribs={"layer": "arc", "extrusion": (0, -1, 0)})
    space.add_line((0, -2, 0), (8, -2, 3), dxfattribs={"layer": "J1"})
    drawing.saveas(tmp_path / "t.dxf")
    lines, said = said_of(tmp_path / "t.dxf", tolerance=1e-4)
    assert said == ["its lines lie in the xz plane: x is taken as right, z as up"]
    assert lines["J1"] == [[[0, 0], [8, 3]]]
    np.testing.assert_allclose(np.hypot(*np.array(lines["arc"][0]).T), 5, rtol=1e-8)


def test_blocks_of_other_drawings_and_lines_without_points_are_counted(tmp_path: Path) -> None:
    drawing = ezdxf.new()
    space = drawing.modelspace()
    drawing.add_xref_def("other.dxf", "other")
    space.add_blockref("other", (0, 0))
    space.add_blockref("nowhere", (0, 0))
    space.add_lwpolyline([(3, 3)])
    space.add_line(*LINE, dxfattribs={"layer": "J1"})
    drawing.saveas(tmp_path / "t.dxf")
    lines, said = said_of(tmp_path / "t.dxf")
    assert lines == {"J1": [as_lists(LINE)]}
    assert said == ["left out, being no lines: 2 INSERT of another drawing (XREF), 1 empty line"]


def test_a_crs_of_features_counts(tmp_path: Path) -> None:
    path = written(tmp_path / "t.geojson", [("J1", "LINESTRING (0 5, 20 7)"), ("J1", "LINESTRING (0 2, 20 3)")])
    content = json.loads(path.read_text())
    for feature, code in zip(content["features"], (2263, 25832), strict=True):
        feature["crs"] = {"type": "name", "properties": {"name": f"EPSG:{code}"}}
    path.write_text(json.dumps(content))
    with pytest.raises(GeometryError, match=r"features in several CRS \(EPSG:2263, EPSG:25832\)"):
        read_traces(path)
    del content["features"][1]["crs"]
    path.write_text(json.dumps(content))
    np.testing.assert_allclose(said_of(path)[0]["J1"][0], np.array(LINE) * SURVEY_FOOT, rtol=1e-9)
