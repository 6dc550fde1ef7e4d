"""Traces of joints from files: CSV, GeoJSON and DXF. Scan lines from CSV."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import Fault, FloatArray

Lines = dict[str, list[FloatArray]]


def read_traces(
    path: str | os.PathLike[str],
    *,
    names: Mapping[str, str] | None = None,
    scale: float = 1.0,
    extends: bool = False,
) -> list[Fault]:
    """Return the traces of a file, one `Fault` for each of its sets.

    * CSV: columns ``x1, y1, x2, y2`` and ``set``, a row a trace; or ``x, y, trace`` and ``set``, a row a point.
    * GeoJSON: LineString and MultiLineString features; the property ``set`` (or ``name``) names the set.
    * DXF: LINE, LWPOLYLINE and POLYLINE (arcs of theirs as straight lines); the layer names the set.

    Parameters
    ----------
    path : path
        The file.
    names : mapping of str to str, optional
        Name of the joint for names of sets in the file; sets not in it are left out.
    scale : float
        The file's unit of length [m].
    extends : bool
        Whether dead ends go on to the next joint.

    Raises
    ------
    GeometryError
        If the file cannot be read, or holds no traces.
    """
    file = Path(path)
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise GeometryError(f"{file}: traces are read from {', '.join(_READERS)}")
    try:
        found = reader(file)
    except OSError as fault:
        raise GeometryError(f"{file}: cannot be read: {fault.strerror or fault}") from fault
    except (ValueError, KeyError, TypeError, AttributeError) as fault:
        if isinstance(fault, GeometryError):
            raise
        raise GeometryError(f"{file}: is no {file.suffix[1:].upper()} file of traces: {fault}") from fault
    unknown = [name for name in names or {} if name not in found]
    if unknown:
        raise GeometryError(f"{file}: has no set '{unknown[0]}' (known: {', '.join(sorted(found))})")
    wanted = {name: name for name in found} if names is None else dict(names)
    if not any(found.get(name) for name in wanted):
        raise GeometryError(f"{file}: holds no traces")
    joints: Lines = {}
    for name, joint in wanted.items():
        joints.setdefault(joint, []).extend(line * scale for line in found[name])
    return [Fault(name=joint, lines=lines, extends=extends) for joint, lines in joints.items()]


def read_scan_line(path: str | os.PathLike[str]) -> list[dict[str, float | str]]:
    """Return the rows of a CSV file with the columns ``distance, dip, dip_direction, set``.

    Raises
    ------
    GeometryError
        With every row that is wrong.
    """
    file = Path(path)
    rows: list[dict[str, float | str]] = []
    faults = []
    for number, row in enumerate(_csv_rows(file, ("distance", "dip", "dip_direction", "set")), start=2):
        try:
            values = {key: float(row[key]) for key in ("distance", "dip", "dip_direction")}
        except ValueError:
            faults.append(f"{file}, line {number}: distance, dip and dip_direction must be numbers")
            continue
        if not 0 <= values["dip"] <= 90:
            faults.append(f"{file}, line {number}: dip = {values['dip']:g} must be from 0 to 90 degrees")
        rows.append({**values, "set": row["set"].strip()})
    if faults:
        raise GeometryError(faults)
    return rows


def _csv_rows(file: Path, needed: tuple[str, ...]) -> list[dict[str, str]]:
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as fault:
        raise GeometryError(f"{file}: cannot be read: {fault.strerror or fault}") from fault
    rows = list(csv.DictReader(text.splitlines(), skipinitialspace=True))
    missing = [name for name in needed if rows and name not in rows[0]]
    if missing or not rows:
        has = ", ".join(rows[0]) if rows else "no rows"
        raise GeometryError(f"{file}: needs the columns {', '.join(needed)}; it has {has}")
    return rows


def _read_csv(file: Path) -> Lines:
    found: Lines = {}
    rows = _csv_rows(file, ())
    if {"x1", "y1", "x2", "y2"} <= rows[0].keys():
        for row in rows:
            ends = np.array([[row["x1"], row["y1"]], [row["x2"], row["y2"]]], dtype=np.float64)
            found.setdefault((row.get("set") or "traces").strip(), []).append(ends)
        return found
    _csv_rows(file, ("x", "y", "trace"))
    traces: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in rows:
        key = ((row.get("set") or "traces").strip(), row["trace"])
        traces.setdefault(key, []).append((float(row["x"]), float(row["y"])))
    for (name, _), points in traces.items():
        found.setdefault(name, []).append(np.array(points))
    return found


def _read_geojson(file: Path) -> Lines:
    found: Lines = {}
    content = json.loads(file.read_text(encoding="utf-8-sig"))
    features = content["features"] if content.get("type") == "FeatureCollection" else [content]
    for feature in features:
        shape: dict[str, Any] = feature.get("geometry", feature) or {}
        properties = feature.get("properties") or {}
        name = str(properties.get("set") or properties.get("name") or "traces")
        coordinates: list[Any] = shape.get("coordinates") or []
        lines = {"LineString": [coordinates], "MultiLineString": coordinates}
        for line in lines.get(str(shape.get("type")), []):
            found.setdefault(name, []).append(np.array(line, dtype=np.float64)[:, :2])
    return found


def _read_dxf(file: Path) -> Lines:
    try:
        import ezdxf
    except ImportError as fault:
        raise GeometryError(f"{file}: to read DXF: pip install ezdxf") from fault
    file.read_bytes()  # ezdxf raises OSError also for a file that is no DXF
    try:
        drawing = ezdxf.readfile(file)
    except (OSError, ezdxf.DXFError) as fault:
        raise GeometryError(f"{file}: is no DXF file, or is damaged: {fault}") from fault
    found: Lines = {}
    for entity in drawing.modelspace().query("LINE LWPOLYLINE POLYLINE"):
        kind = entity.dxftype()
        if kind == "LINE":
            points = [(end.x, end.y) for end in (entity.dxf.start, entity.dxf.end)]
        elif kind == "LWPOLYLINE":
            points = list(entity.get_points("xy"))
        else:
            points = [(vertex.dxf.location.x, vertex.dxf.location.y) for vertex in entity.vertices]
        if kind != "LINE" and entity.is_closed:
            points.append(points[0])
        found.setdefault(entity.dxf.layer, []).append(np.array(points, dtype=np.float64))
    return found


_READERS: dict[str, Callable[[Path], Lines]] = {
    ".csv": _read_csv,
    ".geojson": _read_geojson,
    ".json": _read_geojson,
    ".dxf": _read_dxf,
}
