"""Traces and scan lines from tables (CSV)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.reading import as_path, faults_of_geometry
from bsm_mesh.geometries.trace_lines import UNNAMED, TraceLines
from bsm_mesh.named_units import ANGLES, LENGTHS
from bsm_mesh.table_rows import Rows, read_rows

ENDS = ("x1", "y1", "x2", "y2")
PORE_PY = ("start_x", "start_y", "end_x", "end_y")
POINTS = ("x", "y", "trace")
SCAN_COLUMNS = {"distance": LENGTHS, "dip": ANGLES, "dip_direction": ANGLES}
FARTHEST = 1e12  # [m]; as for nodes of meshes
UNNAMED_SET = "joints"  # planes of a table without the column `set`


def lines_of_csv(file: Path, scale: float | None) -> TraceLines:
    """Return the traces of a table: a row a trace, or a row a point.

    Parameters
    ----------
    file : Path
        The table.
    scale : float, optional
        The unit of length [m] in place of that in the header (``x1 [ft]``).

    Raises
    ------
    GeometryError
        With every row that is wrong.
    """
    found = TraceLines()
    faults: list[str] = []
    with faults_of_geometry():
        rows = read_rows(file, "x1, y1, x2, y2 of a trace, or x, y, trace of a point")
        ends = next((names for names in (ENDS, PORE_PY) if set(names) <= set(rows.names)), None)
        columns = rows.columns(*(ends or POINTS))
        sets = rows.columns("set")[0] if "set" in rows.names else None
        unit = _unit(rows, columns[: len(ends or POINTS[:2])]) if scale is None else scale
    traces: dict[tuple[str, str], list[list[float]]] = {}
    for row, cells in enumerate(rows.cells):
        name = (cells[sets] if sets is not None else "") or UNNAMED
        numbers = [rows.finite(row, column, faults) for column in (columns if ends else columns[:2])]
        if ends:
            found.add(name, np.array(numbers).reshape(2, 2), unit)
        else:
            traces.setdefault((name, cells[columns[2]]), []).append(numbers)
    if faults:
        raise GeometryError(faults)
    for (name, _), points in traces.items():
        found.add(name, np.array(points), unit)
    return found


def _unit(rows: Rows, columns: Sequence[int]) -> float:
    """Return the unit of length of some columns [m], which is that of all."""
    factors = {rows.factor(column, LENGTHS, "m") for column in columns}
    if len(factors) > 1:
        named = ", ".join(rows.header[column] for column in columns)
        raise GeometryError(f"{rows.path}: columns {named} name different units; give all the same")
    return factors.pop()


def read_scan_line(path: str | os.PathLike[str]) -> list[dict[str, float | str]]:
    """Return the rows of a CSV file with the columns ``distance, dip, dip_direction, set`` in m and degrees.

    Commas, semicolons (with decimal commas) or tabs part the columns; their names may have units: ``distance [ft]``.

    Raises
    ------
    GeometryError
        With every row that is wrong.
    """
    return _mapped(path, SCAN_COLUMNS, "distance, dip, dip_direction and set of a joint")


def read_orientations(path: str | os.PathLike[str]) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return dips and dip directions [degrees] of every set of a CSV file with the columns ``dip, dip_direction, set``.

    Without the column ``set`` all planes are of one set, `UNNAMED_SET`. The table of a scan line will do.

    Raises
    ------
    GeometryError
        With every row that is wrong.
    """
    columns = {name: ANGLES for name in ("dip", "dip_direction")}
    rows = _mapped(path, columns, "dip and dip_direction of a joint, and its set", set_is_given=False)
    names = dict.fromkeys(str(row["set"]) for row in rows)
    if not names:
        raise GeometryError(f"{path}: no row with a joint; give dip and dip_direction")
    return {
        name: (
            np.array([float(row["dip"]) for row in rows if row["set"] == name]),
            np.array([float(row["dip_direction"]) for row in rows if row["set"] == name]),
        )
        for name in names
    }


def _mapped(
    path: str | os.PathLike[str], wanted: Mapping[str, dict[str, float]], holds: str, *, set_is_given: bool = True
) -> list[dict[str, float | str]]:
    """Return the rows of a table of mapped joints, its columns in m and degrees, and the name of the set."""
    file = as_path("path", path)
    found: list[dict[str, float | str]] = []
    faults: list[str] = []
    with faults_of_geometry():
        rows = read_rows(file, holds)
        if "dip_direction" in wanted and "dip_direction" not in rows.names and "strike" in rows.names:
            raise ModelError(
                f"{file}: has a column 'strike' and none 'dip_direction'; give dip_direction, which is strike + 90 "
                "where strikes follow the right-hand rule"
            )
        columns = rows.columns(*wanted)
        of = rows.columns("set")[0] if set_is_given or "set" in rows.names else None
        factors = [rows.factor(column, wanted[rows.names[column]], "m or deg") for column in columns]
    for row, cells in enumerate(rows.cells):
        wrong = len(faults)
        numbers = [rows.finite(row, c, faults) * factor for c, factor in zip(columns, factors, strict=True)]
        if len(faults) > wrong:
            continue
        values = dict(zip(wanted, numbers, strict=True))
        place = rows.place(row)
        if not 0 <= values["dip"] <= 90:
            faults.append(f"{place}: dip = {values['dip']:g} must be from 0 to 90 degrees")
        if not -360 <= values["dip_direction"] <= 360:
            faults.append(f"{place}: dip_direction = {values['dip_direction']:g} is no angle up to 360 degrees")
        if not abs(values.get("distance", 0.0)) < FARTHEST:
            faults.append(f"{place}: distance = {values['distance']:g} must be below {FARTHEST:g} m")
        found.append({**values, "set": ("" if of is None else cells[of]) or UNNAMED_SET})
    if faults:
        raise GeometryError(faults)
    return found
