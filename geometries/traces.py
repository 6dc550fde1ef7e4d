"""Traces of joints from files: CSV, GeoJSON, DXF, shapefile and GeoPackage. Scan lines from CSV."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.errors import MeshWarning, one_line
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import Fault, FloatArray
from bsm_mesh.geometries.reading import as_path, read_text

Lines = dict[str, list[FloatArray]]
ENDS = ("x1", "y1", "x2", "y2")
PORE_PY = dict(zip(("START_X", "START_Y", "END_X", "END_Y"), ENDS, strict=True))
SCAN_COLUMNS = ("distance", "dip", "dip_direction", "set")
UNNAMED = "traces"  # the set of lines that name none
FARTHEST = 1e12  # [m]; as for nodes of meshes
LONGEST = 300  # digits; more are no double, and thousands are not turned into a number


def read_traces(
    path: str | os.PathLike[str],
    *,
    names: Mapping[str, str] | None = None,
    scale: float = 1.0,
    extends: bool = False,
    tolerance: float | None = None,
) -> list[Fault]:
    """Return the traces of a file, one `Fault` for each of its sets.

    * CSV: columns ``x1, y1, x2, y2`` and ``set``, a row a trace; or ``x, y, trace`` and ``set``, a row a point; or
      PorePy's ``FID, START_X, START_Y, END_X, END_Y``.
    * GeoJSON: LineString and MultiLineString features; the property ``set`` (or ``name``) names the set.
    * DXF: lines, polylines with their bulges, arcs, circles, ellipses, splines, also those in inserted blocks; the
      layer names the set. Needs ezdxf.
    * Shapefile and GeoPackage: lines; the field ``set`` (or ``name``) names the set, else the layer. Needs pyogrio.

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
    tolerance : float, optional
        Greatest distance of a chord from the curve that it stands for [m]; by default a thousandth of the drawing.

    Warns
    -----
    MeshWarning
        For what was left out, by its kind and count.

    Raises
    ------
    GeometryError
        If the file cannot be read, or holds no traces.
    """
    file = as_path("path", path)
    reader = _READERS.get(file.suffix.lower())
    if file.suffix.lower() == ".fab":
        raise GeometryError(f"{file}: holds fractures in space: read_fractures(path, section_azimuth=...) cuts them")
    if reader is None:
        raise GeometryError(f"{file}: traces are read from {', '.join(_READERS)}")
    if not 0 < scale < math.inf:
        raise GeometryError(f"{file}: scale = {scale} is no length above 0 m")
    if tolerance is not None and not 0 < tolerance < math.inf:
        raise GeometryError(f"{file}: tolerance = {tolerance} is no length above 0 m")
    found, left_out = reader(file, None if tolerance is None else tolerance / scale)
    if left_out:
        kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(left_out.items()))
        warnings.warn(one_line(f"{file}: left out, being no lines: {kinds}"), MeshWarning, stacklevel=2)
    _refuse_wild(file, found, scale)
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
    file = as_path("path", path)
    rows: list[dict[str, float | str]] = []
    faults: list[str] = []
    for line, row in _csv_rows(file, SCAN_COLUMNS):
        values = _numbers(file, line, row, SCAN_COLUMNS[:3], faults)
        if values is None:
            continue
        if not 0 <= values["dip"] <= 90:
            faults.append(f"{file}, line {line}: dip = {values['dip']:g} must be from 0 to 90 degrees")
        if not -360 <= values["dip_direction"] <= 360:
            faults.append(
                f"{file}, line {line}: dip_direction = {values['dip_direction']:g} is no angle up to 360 degrees"
            )
        if not abs(values["distance"]) < FARTHEST:
            faults.append(f"{file}, line {line}: distance = {values['distance']:g} must be below {FARTHEST:g} m")
        rows.append({**values, "set": row["set"].strip()})
    _raise_faults(faults)
    return rows


def _csv_rows(file: Path, needed: tuple[str, ...]) -> list[tuple[int, dict[str, str]]]:
    """Return the rows of a table with the line where each ends; every row has a cell for every column."""
    table = csv.DictReader(io.StringIO(read_text(file), newline=""), skipinitialspace=True, strict=True)
    rows, faults = [], []
    try:
        header = [PORE_PY.get(name.strip(" #").upper(), name.strip()) for name in table.fieldnames or ()]
        table.fieldnames = header
        for row in table:
            if None in row or None in row.values():
                faults.append(f"{file}, line {table.line_num}: has more or fewer cells than the header")
            else:
                rows.append((table.line_num, row))
    except csv.Error as fault:
        raise GeometryError(f"{file}, line {table.line_num}: is no table: {fault}") from fault
    _raise_faults(faults)
    if not rows:
        raise GeometryError(f"{file}: has no rows; it needs a header and rows below it")
    if not set(needed) <= set(header):
        raise GeometryError(f"{file}: needs the columns {', '.join(needed)}; it has {', '.join(header)}")
    return rows


def _numbers(
    file: Path, line: int, row: Mapping[str, str], names: Sequence[str], faults: list[str]
) -> dict[str, float] | None:
    """Return the numbers in some columns of a row; or None, with a fault for each cell that holds none."""
    values: dict[str, float] = {}
    for name in names:
        try:
            values[name] = float(row[name])
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            faults.append(f"{file}, line {line}: {name} = '{row[name].strip()}' is no finite number")
    return values if all(map(math.isfinite, values.values())) else None


def _read_csv(file: Path) -> Lines:
    rows = _csv_rows(file, ())
    by_ends = set(ENDS) <= rows[0][1].keys()
    if not by_ends:
        rows = _csv_rows(file, ("x", "y", "trace"))
    found: Lines = {}
    faults: list[str] = []
    traces: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for line, row in rows:
        name = (row.get("set") or "").strip() or UNNAMED
        values = _numbers(file, line, row, ENDS if by_ends else ("x", "y"), faults)
        if values is None:
            continue
        if by_ends:
            found.setdefault(name, []).append(np.array(list(values.values())).reshape(2, 2))
        else:
            traces.setdefault((name, row["trace"]), []).append((values["x"], values["y"]))
    _raise_faults(faults)
    for (name, _), points in traces.items():
        found.setdefault(name, []).append(np.array(points))
    return found


def _read_geojson(file: Path) -> Lines:
    text = read_text(file)
    try:
        content = json.loads(text, parse_int=_whole_number)
        return _lines_of_features(content["features"] if content.get("type") == "FeatureCollection" else [content])
    except RecursionError as fault:
        raise GeometryError(
            f"{file}: is no {file.suffix[1:].upper()} file of traces: brackets nested too deep"
        ) from fault
    except KeyError as fault:
        raise GeometryError(f"{file}: is no {file.suffix[1:].upper()} file of traces: it has no {fault}") from fault
    except (ValueError, TypeError, AttributeError, IndexError, OverflowError) as fault:
        raise GeometryError(f"{file}: is no {file.suffix[1:].upper()} file of traces: {fault}") from fault


def _lines_of_features(features: Iterable[dict[str, Any]]) -> Lines:
    found: Lines = {}
    for feature in features:
        shape: dict[str, Any] = feature.get("geometry", feature) or {}
        properties = feature.get("properties") or {}
        name = str(properties.get("set") or properties.get("name") or UNNAMED)
        coordinates: list[Any] = shape.get("coordinates") or []
        lines = {"LineString": [coordinates], "MultiLineString": coordinates}
        for line in lines.get(str(shape.get("type")), []):
            found.setdefault(name, []).append(_points(line, name))
    return found


def _points(line: Any, name: str) -> FloatArray:
    """Return the points of a line (n, 2); a third coordinate is left out."""
    points = [point[:2] if isinstance(point, list) else () for point in line] if isinstance(line, list) else [()]
    if not all(len(point) == 2 and all(isinstance(value, int | float) for value in point) for point in points):
        raise ValueError(f"a position of the set '{name}' is not of the form [x, y]")
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def _whole_number(text: str) -> float:
    return int(text) if len(text) < LONGEST else math.inf


def _refuse_wild(file: Path, found: Lines, scale: float) -> None:
    """Refuse lines of fewer than two points, and coordinates that are no numbers or farther away than any rock."""
    faults = []
    for name, lines in found.items():
        for number, line in enumerate(lines, start=1):
            if len(line) < 2:
                faults.append(f"{file}: line {number} of the set '{name}' has {len(line)} point(s); it needs two")
            elif not np.all(np.abs(line) * scale < FARTHEST):  # also what is not a number
                faults.append(
                    f"{file}: line {number} of the set '{name}' has coordinates that are no numbers "
                    f"below {FARTHEST:g} m; mend it"
                )
    _raise_faults(faults)


def _raise_faults(faults: list[str]) -> None:
    if faults:
        raise GeometryError(faults)


def _by_gis(file: Path, tolerance: float | None) -> tuple[Lines, Counter[str]]:
    from bsm_mesh.geometries.gis_files import lines_of_gis

    return lines_of_gis(file)


def _by_dxf(file: Path, tolerance: float | None) -> tuple[Lines, Counter[str]]:
    from bsm_mesh.geometries.drawings import lines_of_dxf

    return lines_of_dxf(file, tolerance)


_READERS: dict[str, Callable[[Path, float | None], tuple[Lines, Counter[str]]]] = {
    ".csv": lambda file, _: (_read_csv(file), Counter()),
    ".geojson": lambda file, _: (_read_geojson(file), Counter()),
    ".json": lambda file, _: (_read_geojson(file), Counter()),
    ".dxf": _by_dxf,
    ".shp": _by_gis,
    ".gpkg": _by_gis,
}
