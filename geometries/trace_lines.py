"""Lines of a file by their sets, and what of it is left out: of GeoJSON, GIS files, drawings and tables alike."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bsm_mesh.errors import shortened
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.section_plane import section_axes

UNNAMED = "traces"  # the set of lines that name none
NAMES = ("set", "name")  # properties that name the set of a feature, in any case; the first that says something
LINES = ("LineString", "LinearRing")
COLLECTIONS = {  # how the parts of a type are called, and of which type they are
    "MultiLineString": ("coordinates", "LineString"),
    "MultiPolygon": ("coordinates", "Polygon"),
    "MultiPoint": ("coordinates", "Point"),
    "GeometryCollection": ("geometries", None),
}
AXES = "xyz"


class Unit(NamedTuple):
    """A unit of length: its name, and how many metres it is."""

    name: str
    metres: float


@dataclass(slots=True)
class TraceLines:
    """Contents of a file of lines.

    Attributes
    ----------
    sets : dict of str to list of (n, 3) float64 [m]
        Lines by the names of their sets.
    left_out : Counter of str
        Entities that are no lines, by kind.
    notes : list of str
        Further notes, a sentence each.
    """

    sets: dict[str, list[FloatArray]] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)

    def unit(self, scale: float | None, named: Unit | None, source: str) -> float:
        """Return the unit of length [m]: `scale` if it is given, else the one that the file names, else 1 m."""
        if scale is not None:
            return scale
        if named is None or named.metres == 1:
            return 1.0
        self.notes.append(
            f"{source} in {named.name}: lengths are multiplied by {named.metres:.9g}; scale = 1 takes them as metres"
        )
        return named.metres

    def add(self, name: str, points: FloatArray, unit: float) -> None:
        """Add a line of points (n, 2 or 3) in a unit [m]; one without points is left out."""
        if not len(points):
            self.left_out["empty line"] += 1
            return
        line = np.zeros((len(points), 3))
        line[:, : points.shape[1]] = points
        line[~np.isfinite(line[:, 2]), 2] = 0.0  # a height that is not known
        with np.errstate(over="ignore"):  # too far away is reported of the whole file
            self.sets.setdefault(name, []).append(line * unit)

    def add_feature(
        self, properties: Mapping[str, Any], geometry: Mapping[str, Any] | None, layer: str, unit: float
    ) -> None:
        """Add the lines of a feature, in any depth of collections; count what else there is.

        Parameters
        ----------
        properties : mapping of str
            ``set`` or ``name`` names its set; else it is `layer`.
        geometry : mapping of str, optional
            As in GeoJSON.
        layer : str
            The set of features without a name.
        unit : float
            Of the coordinates [m].

        Raises
        ------
        ValueError
            If coordinates are no positions.
        """
        lowered = {str(key).lower(): value for key, value in properties.items()}
        name = next((text for key in NAMES if (text := _text(lowered.get(key)))), layer)
        for kind, coordinates in _parts(geometry):
            if kind in LINES:
                self.add(name, _points(coordinates, name), unit)
            else:
                self.left_out[kind] += 1

    def flatten(self) -> None:
        """Leave two coordinates to every line: those of the section in which all lie, else x and y."""
        if not self.sets:
            return
        every = np.concatenate([line for lines in self.sets.values() for line in lines])
        least, extent = every.min(axis=0), np.ptp(every, axis=0)
        axes = section_axes(extent.tolist())
        if axes is None:
            self.notes.append(f"z is from {least[2]:.6g} to {every[:, 2].max():.6g} m along its lines and is left out")
        elif axes != (0, 1):
            right = AXES[axes[0]]
            self.notes.append(f"its lines lie in the {right}z plane: {right} is taken as right, z as up")
        elif least[2] and section_axes(extent[[0, 2, 1]].tolist()) == (0, 1):
            self.notes.append(
                f"its lines lie at y = {least[1]:.6g} m and z = {least[2]:.6g} m: y is taken as up, z is left out"
            )
        flat = list(axes or (0, 1))
        self.sets = {name: [line[:, flat] for line in lines] for name, lines in self.sets.items()}


def _text(value: Any) -> str:
    """Return a name as a text: of whole numbers their digits, empty for a missing one."""
    value = value.item() if isinstance(value, np.generic) else value
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return str(value).strip()


def _parts(geometry: Mapping[str, Any] | None) -> Iterator[tuple[str, Any]]:
    """Give type and coordinates of the parts of a geometry; a collection without any is a part of its own."""
    if geometry is None:
        yield "feature without geometry", None
        return
    kind = str(geometry.get("type"))
    key, single = COLLECTIONS.get(kind, ("", None))
    if not key:
        yield (kind if kind in LINES else shortened(kind, 30)), geometry.get("coordinates")
        return
    parts = geometry.get(key)
    if not isinstance(parts, list | tuple):
        raise ValueError(f"a {kind} has no list of {key}")
    if not parts:
        yield f"empty {kind}", None
    for part in parts:
        yield from _parts(part if single is None else {"type": single, "coordinates": part})


def _points(line: Any, name: str) -> FloatArray:
    """Return the points of a line, (n, 2 or 3); a fourth coordinate is a measure and no place."""
    points = (
        [list(p[:3]) if isinstance(p, list | tuple) else [] for p in line] if isinstance(line, list | tuple) else [[]]
    )
    if not all(len(p) >= 2 and all(isinstance(value, int | float) for value in p) for p in points):
        raise ValueError(f"a position of the set '{name}' is not of the form [x, y]")
    width = min(map(len, points), default=3)
    return np.array([p[:width] for p in points], dtype=np.float64).reshape(-1, width)
