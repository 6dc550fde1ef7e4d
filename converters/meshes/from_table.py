"""Tables of nodes (CSV): a row a node with x, y and fields, as RS2 and others give their results away.

RS2's Python interface returns x, y and one value at all nodes for a stage and a kind of result; put side by side these
are such a table. It has no elements: fields are interpolated over the Delaunay triangles of the nodes.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.meshes.foreign_result import ForeignResult
from bsm_mesh.errors import ModelError
from bsm_mesh.model.edges import LongArray
from bsm_mesh.named_units import unit_in
from bsm_mesh.table_rows import read_rows

SUFFIX = ".csv"
NAMES = ("{}", "{}coord", "{}coordinate", "coord{}")  # of the columns of x and y, without signs
TRIANGLE = 5  # VTK's number
SAME = 1e-9  # of the greatest extent: nodes nearer than this are one, with the mean of their values
FLAT = 1e-12  # of the square of the extent: a triangle of the hull that is no more than an edge


def read_table(path: Path) -> ForeignResult:
    """Return the fields of a table of nodes, and the triangles between these.

    Commas, semicolons and tabs part columns; with the latter two a comma may be a decimal point. The first row has the
    names, ``Sigma XX (MPa)`` with a unit. A column without any number is left out.

    Raises
    ------
    ModelError
        If there is no column of x or y, their units differ, two columns have one name, or a row is not complete.
        Missing numbers, and nodes on one line, are errors too.
    """
    rows = read_rows(path, "x and y among them, a row a node")
    header, places = rows.header, range(len(rows.lines))
    columns = {name: np.array([rows.number(row, k) for row in places]) for k, name in enumerate(header)}
    numbers = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    for name, values in numbers.items():
        if not np.isfinite(values).all():
            worst = int(np.isfinite(values).argmin())
            cell = rows.cells[worst][header.index(name)]
            cure = rows.cure(cell, "leave out that row, or the column")
            raise ModelError(
                f"{path}: column '{name}' is not all numbers: line {rows.lines[worst]} has '{cell}'; {cure}"
            )
    x, y = (_coordinate(path, axis, header, numbers) for axis in "xy")
    if unit_in(x).lower() != unit_in(y).lower():
        raise ModelError(f"{path}: columns '{x}' and '{y}' name different units; give both the same")
    place = np.stack([numbers.pop(x), numbers.pop(y)], axis=1)
    points, fields = _merged(place, numbers)
    triangles = _triangles(path, points)
    return ForeignResult(
        source=str(path),
        points=np.column_stack([points, np.zeros(len(points))]),
        cell_type=np.full(len(triangles), TRIANGLE),
        offsets=3 * np.arange(len(triangles) + 1),
        connectivity=triangles.ravel(),
        at_points=fields,
        at_cells={},
        length_unit=unit_in(x),
        has_elements=False,
    )


def _coordinate(path: Path, axis: str, header: list[str], numbers: dict[str, FloatArray]) -> str:
    known = [name.format(axis) for name in NAMES]
    for name in header:
        if re.sub(r"[(\[].*|[^a-z0-9]", "", name.lower()) in known:
            if name in numbers:
                return name
            raise ModelError(f"{path}: column '{name}' is not all numbers")
    raise ModelError(f"{path}: no column is called {axis} (or {axis}_coord); it has {', '.join(header[:12])}")


def _merged(place: FloatArray, fields: dict[str, FloatArray]) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return different nodes, and the means of the fields at each, (n, 1)."""
    size = float(np.ptp(place, axis=0).max(initial=0.0))
    rounded = np.round((place - place.min(axis=0)) / (SAME * size if size else 1.0))
    _, first, number, count = np.unique(rounded, axis=0, return_index=True, return_inverse=True, return_counts=True)
    means = {name: (np.bincount(number.ravel(), of) / count)[:, None] for name, of in fields.items()}
    return place[first], means


def _triangles(path: Path, points: FloatArray) -> LongArray:
    from scipy.spatial import Delaunay, QhullError

    try:
        triangles = Delaunay(points).simplices
    except (QhullError, ValueError):
        raise ModelError(f"{path}: its {len(points)} nodes span no area") from None
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    kept: LongArray = triangles[area > FLAT * float(np.ptp(points, axis=0).max()) ** 2].astype(np.int64)
    return kept
