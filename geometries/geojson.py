"""Lines of GeoJSON: features, collections of them, or bare geometries."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.map_units import unit_on_map
from bsm_mesh.geometries.reading import read_text
from bsm_mesh.geometries.trace_lines import UNNAMED, TraceLines

LONGEST = 300  # digits; more are no double, and thousands are not turned into a number
CRS_NAME = re.compile(r"(?:.*[:/])?(EPSG|OGC)[:/](?:[\d.]*[:/])?(\w+)")  # urn:ogc:def:crs:EPSG::25832, EPSG:25832


def lines_of_geojson(file: Path, scale: float | None) -> TraceLines:
    """Return the lines of a GeoJSON file.

    Coordinates are in the unit of its CRS (the member ``crs`` of before RFC 7946, or ``coordRefSys``), in metres
    without one: sections are drawn in plane coordinates.

    Parameters
    ----------
    file : Path
        The file.
    scale : float, optional
        The unit of length [m] in place of that of the CRS.

    Raises
    ------
    GeometryError
        If it is no GeoJSON, or its coordinates are degrees.
    """
    kind, text = file.suffix[1:].upper(), read_text(file)
    try:
        content = json.loads(text, parse_int=_whole_number)
        return _lines(file, content, scale)
    except RecursionError as fault:
        raise GeometryError(f"{file}: is no {kind} file of traces: brackets nested too deep") from fault
    except KeyError as fault:
        raise GeometryError(f"{file}: is no {kind} file of traces: it has no {fault}") from fault
    except GeometryError:
        raise
    except (ValueError, TypeError, AttributeError, IndexError, OverflowError) as fault:
        raise GeometryError(f"{file}: is no {kind} file of traces: {fault}") from fault


def _lines(file: Path, content: Any, scale: float | None) -> TraceLines:
    found = TraceLines()
    features = content["features"] if content.get("type") == "FeatureCollection" else [content]
    crs = {told: None for part in (content, *features) if (told := _crs(part)) is not None}  # of all, or of features
    if len(crs) > 1:
        raise GeometryError(f"{file}: has features in several CRS ({', '.join(crs)}); project them to one first")
    unit = unit_on_map(file, "its coordinates", next(iter(crs), None), scale, found)
    for feature in features:
        geometry = feature.get("geometry") if feature.get("type") == "Feature" else feature
        found.add_feature(feature.get("properties") or {}, geometry, UNNAMED, unit)
    return found


def _crs(content: Mapping[str, Any]) -> str | None:
    """Return the CRS that a file names, None if it names none."""
    named = content.get("crs")
    name = named["properties"].get("name") or "link" if named else content.get("coordRefSys")
    if name is None:
        return None
    found = CRS_NAME.fullmatch(str(name))
    return f"{found[1]}:{found[2]}" if found else str(name)


def _whole_number(text: str) -> float:
    return int(text) if len(text) < LONGEST else math.inf
