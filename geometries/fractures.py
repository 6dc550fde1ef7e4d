"""Fractures in space, FracMan's .fab files, cut by an upright section to traces."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bsm_mesh.errors import MeshWarning, counted, one_line
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import Fault, FloatArray
from bsm_mesh.geometries.parameters import Checks
from bsm_mesh.geometries.reading import as_path, read_text

METRES = {"m": 1.0, "meter": 1.0, "meters": 1.0, "metre": 1.0, "ft": 0.3048, "feet": 0.3048, "foot": 0.3048}
FARTHEST = 1e12  # m; as for traces


@dataclass(slots=True)
class _File:
    """Contents of a .fab file: its unit, the names of its sets, its fractures one after the other."""

    unit: float = 1.0
    names: dict[int, str] = field(default_factory=dict)
    points: list[tuple[float, float, float]] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)  # vertices of every fracture
    sets: list[int] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)


def read_fractures(
    path: str | os.PathLike[str],
    *,
    section_azimuth: float,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    extends: bool = False,
) -> list[Fault]:
    """Return the traces of FracMan's fractures in an upright section, one `Fault` for each of their sets.

    Parameters
    ----------
    path : path
        The file, ``.fab`` in ASCII; its x axis points east, z up. In metres where it does not say.
    section_azimuth : float
        Direction in which the section's x axis points, clockwise from north [degrees].
    origin : (float, float, float)
        East, north and elevation of the section's origin [m].
    extends : bool
        Whether dead ends continue to the next joint.

    Returns
    -------
    list of Fault
        Traces in the section: x along it from the origin, y the height above it [m]. Sets that it does not cut are
        not among them.

    Warns
    -----
    MeshWarning
        For tessellated fractures and rock blocks, which are left out.

    Raises
    ------
    GeometryError
        If the file cannot be read, or the section cuts no fracture.
    """
    file = as_path("path", path)
    checks = Checks("section")
    checks.number("degrees", section_azimuth=section_azimuth)
    if len(origin) == 3:
        checks.number("m", **dict(zip(("east", "north", "elevation"), origin, strict=True)))
    else:
        checks.add(f"origin = {origin} needs three numbers: east, north and elevation [m]")
    checks.raise_faults()
    found = _parsed(file)
    if found.left_out:
        told = ", ".join(f"{count} in {kind}" for kind, count in found.left_out.items())
        warnings.warn(one_line(f"{file}: left out: {told}"), MeshWarning, stacklevel=2)
    points = np.array(found.points).reshape(-1, 3) * found.unit
    if not np.all(np.abs(points) < FARTHEST):
        raise GeometryError(f"{file}: has coordinates that are no numbers below {FARTHEST:g} m; correct it")
    traces, owner = _cut(points, np.array(found.sizes, dtype=np.int64), section_azimuth, origin)
    if not len(traces):
        raise GeometryError(
            f"{file}: the section cuts none of its {counted(len(found.sizes), 'fracture')}; move its origin"
        )
    of_set = np.array(found.sets)[owner]
    return [
        Fault(name=found.names.get(number, f"set {number}"), lines=list(traces[of_set == number]), extends=extends)
        for number in dict.fromkeys(of_set.tolist())
    ]


def _cut(
    points: FloatArray, sizes: np.ndarray, azimuth: float, origin: tuple[float, float, float]
) -> tuple[FloatArray, np.ndarray]:
    """Return the traces of polygons in an upright plane, (n, 2, 2) [m], and the polygon of each.

    Sides that go from one side of the plane to the other cross it; along the plane their crossings follow each other
    into and out of the polygon, so every two are a trace, of concave ones too.
    """
    a = math.radians(azimuth)
    along, across = np.array([math.sin(a), math.cos(a), 0.0]), np.array([math.cos(a), -math.sin(a), 0.0])
    relative = points - np.asarray(origin, dtype=np.float64)
    off, first = relative @ across, np.cumsum(sizes) - sizes
    following = np.arange(1, len(points) + 1)
    following[first + sizes - 1] = first
    side = np.flatnonzero((off >= 0) != (off[following] >= 0))
    share = (off[side] / (off[side] - off[following[side]]))[:, None]
    place = relative[side] + share * (relative[following[side]] - relative[side])
    owner = np.repeat(np.arange(len(sizes)), sizes)[side]
    flat = np.stack([place @ along, place[:, 2]], axis=1)
    # Crossings of a polygon lie on one line: upright if its x is everywhere the same.
    order = np.lexsort([flat[:, 1].round(12), flat[:, 0].round(12), owner])
    traces: FloatArray = flat[order].reshape(-1, 2, 2)
    return traces, owner[order][::2]


def _parsed(file: Path) -> _File:
    """Return the content of the file; a line that cannot be read is reported."""
    found, lines = _File(), iter(enumerate(read_text(file).splitlines(), start=1))
    section, line = "", 0
    try:
        for line, text in lines:
            words = text.split()
            if not words:
                continue
            if words[0].upper() in ("BEGIN", "END") and len(words) > 1:
                section = words[1].upper() if words[0].upper() == "BEGIN" else ""
            elif section == "FRACTURE":
                size, of_set = _numbers(text, 1, 3, "a fracture begins with its number, how many vertices, and its set")
                if not size >= 3:
                    raise ValueError(f"a fracture has 3 vertices at least, not {size:g}")
                found.sizes.append(int(size))
                found.sets.append(int(of_set))
                for _ in range(int(size)):
                    line, row = next(lines)
                    x, y, z = _numbers(row, 1, 4, f"a vertex, of {size:g} of this fracture, is a number, x, y and z")
                    found.points.append((x, y, z))
                line, row = next(lines)  # the normal, which the vertices give too
                if row.split()[:1] != ["0"]:
                    raise ValueError(
                        f"after {size:g} vertices comes the normal, which begins with 0; this is '{row.strip()}'"
                    )
            elif section in ("FORMAT", "SETS"):
                _keep(found, section, *(part.strip().strip('"') for part in text.partition("=")[::2]))
            elif section in ("TESSFRACTURE", "ROCKBLOCK"):
                found.left_out[f"{section} (lines)"] = found.left_out.get(f"{section} (lines)", 0) + 1
    except StopIteration:
        raise GeometryError(f"{file}: ends within a fracture; it is cut off") from None
    except (ValueError, OverflowError) as fault:
        raise GeometryError(one_line(f"{file}, line {line}: is no FracMan file in ASCII: {fault}")) from fault
    if not found.sizes:
        raise GeometryError(f"{file}: holds no fractures; it needs a section BEGIN FRACTURE with polygons in ASCII")
    return found


def _numbers(row: str, first: int, last: int, rule: str) -> list[float]:
    """Return some of the numbers of a row."""
    try:
        numbers = [float(word) for word in row.split()[first:last]]
    except ValueError:
        numbers = []
    if len(numbers) != last - first:
        raise ValueError(f"{rule}; this is '{row.strip()}'")
    return numbers


def _keep(found: _File, section: str, key: str, value: str) -> None:
    """Keep a line of the format or of the names of sets."""
    if section == "SETS":
        if not key[3:].isdecimal():
            raise ValueError(f"a set has its name as in Set1 = J1; this is '{key}'")
        found.names[int(key[3:])] = value or key
    elif key.lower() == "length_unit":
        if value.lower() not in METRES:
            raise ValueError(f"Length_Unit = {value}; known: {', '.join(METRES)}")
        found.unit = METRES[value.lower()]
    elif key.lower() == "xaxis" and value.lower() != "east":
        raise ValueError(f"XAxis = {value}; export it with the x axis to the east")
    elif key.lower() == "format" and value.lower() != "ascii":
        raise ValueError(f"Format = {value}; export it in ASCII")
