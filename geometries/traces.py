"""Traces of joints from files: CSV, GeoJSON, DXF, shapefile and GeoPackage."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from bsm_mesh.errors import MeshWarning, counted, one_line
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.geojson import lines_of_geojson
from bsm_mesh.geometries.joint_sets import Fault, FloatArray
from bsm_mesh.geometries.reading import as_path
from bsm_mesh.geometries.trace_lines import TraceLines
from bsm_mesh.geometries.trace_tables import FARTHEST, lines_of_csv


def read_traces(
    path: str | os.PathLike[str],
    *,
    names: Mapping[str, str] | None = None,
    scale: float | None = None,
    extends: bool = False,
    tolerance: float | None = None,
) -> list[Fault]:
    """Return the traces of a file, one `Fault` for each of its sets.

    * CSV: columns ``x1, y1, x2, y2`` and ``set``, a row a trace; or ``x, y, trace`` and ``set``, a row a point; or
      PorePy's ``FID, START_X, START_Y, END_X, END_Y``. In any case, parted by commas, semicolons (with decimal commas)
      or tabs, with units in brackets if need be.
    * GeoJSON: lines, also in collections; the property ``set`` (or ``name``) names the set.
    * DXF: lines, polylines with their bulges, arcs, circles, ellipses, splines, also those in inserted blocks; the
      layer names the set. Needs ezdxf.
    * Shapefile and GeoPackage: lines; the field ``set`` (or ``name``) names the set, else the layer. Needs pyogrio.

    Parameters
    ----------
    path : path
        The file.
    names : mapping of str to str, optional
        Name of the joint for names of sets in the file; sets not in it are left out, with a warning.
    scale : float, optional
        The file's unit of length [m]; by default the one that the file names (units in the header of a CSV,
        ``$INSUNITS`` of a DXF, the CRS), else 1 m.
    extends : bool
        Whether dead ends continue to the next joint.
    tolerance : float, optional
        Greatest distance of a chord from the curve that it represents [m]; by default a thousandth of the drawing.

    Warns
    -----
    MeshWarning
        For omissions, by kind and count; for another unit than metres, and another plane than xy.

    Raises
    ------
    GeometryError
        If the file cannot be read, or holds no traces.
    """
    found, others = chosen_traces(path, names=names, scale=scale, extends=extends, tolerance=tolerance)
    if others:
        told = ", ".join(f"'{name}' ({counted(len(lines), 'line')})" for name, lines in sorted(others.items()))
        warnings.warn(one_line(f"{path}: left out, being named nowhere: {told}"), MeshWarning, stacklevel=2)
    return found


def chosen_traces(
    path: str | os.PathLike[str],
    *,
    names: Mapping[str, str] | None,
    scale: float | None,
    extends: bool = False,
    tolerance: float | None = None,
) -> tuple[list[Fault], dict[str, list[FloatArray]]]:
    """Return the traces of a file, a `Fault` a joint, and the sets that `names` leaves out; see `read_traces`."""
    file = as_path("path", path)
    reader = _READERS.get(file.suffix.lower())
    if file.suffix.lower() == ".fab":
        raise GeometryError(f"{file}: holds fractures in space: read_fractures(path, section_azimuth=...) cuts them")
    if reader is None:
        raise GeometryError(f"{file}: traces are read from {', '.join(_READERS)}")
    if scale is not None and not 0 < scale < math.inf:
        raise GeometryError(f"{file}: scale = {scale} is no length above 0 m")
    if tolerance is not None and not 0 < tolerance < math.inf:
        raise GeometryError(f"{file}: tolerance = {tolerance} is no length above 0 m")
    found = reader(file, scale, tolerance)
    _refuse_wild(file, found.sets)
    found.flatten()
    left_out = ", ".join(f"{count} {kind}" for kind, count in sorted(found.left_out.items()))
    unknown = [name for name in names or {} if name not in found.sets]
    if unknown:
        raise GeometryError(f"{file}: has no set '{unknown[0]}'{_known(found.sets, left_out)}")
    wanted = {name: name for name in found.sets} if names is None else dict(names)
    if not any(found.sets.get(name) for name in wanted):
        raise GeometryError(f"{file}: holds no traces{_known(found.sets, left_out)}")
    for note in [*([f"left out, being no lines: {left_out}"] if left_out else []), *found.notes]:
        warnings.warn(one_line(f"{file}: {note}"), MeshWarning, stacklevel=3)
    joints: dict[str, list[FloatArray]] = {}
    for name, joint in wanted.items():
        joints.setdefault(joint, []).extend(found.sets[name])
    faults = [Fault(name=joint, lines=lines, extends=extends) for joint, lines in joints.items()]
    return faults, {name: lines for name, lines in found.sets.items() if name not in wanted and lines}


def _known(sets: Mapping[str, object], left_out: str) -> str:
    """Return the sets of a file, and its other contents."""
    said = [f"known: {', '.join(sorted(sets))}"] if sets else []
    return f" ({'; '.join([*said, *([f'left out: {left_out}'] if left_out else [])])})" if said or left_out else ""


def _refuse_wild(file: Path, found: Mapping[str, Sequence[FloatArray]]) -> None:
    """Refuse lines of fewer than two points, and coordinates that are no numbers or beyond any rock."""
    faults = []
    for name, lines in found.items():
        for number, line in enumerate(lines, start=1):
            if len(line) < 2:
                faults.append(f"{file}: line {number} of the set '{name}' has {len(line)} point(s); it needs two")
            elif not np.all(np.abs(line) < FARTHEST):  # also what is not a number
                faults.append(
                    f"{file}: line {number} of the set '{name}' has coordinates that are no numbers "
                    f"below {FARTHEST:g} m; correct it"
                )
    _raise_faults(faults)


def _raise_faults(faults: list[str]) -> None:
    if faults:
        raise GeometryError(faults)


def _by_gis(file: Path, scale: float | None, tolerance: float | None) -> TraceLines:
    from bsm_mesh.geometries.gis_files import lines_of_gis

    return lines_of_gis(file, scale)


def _by_dxf(file: Path, scale: float | None, tolerance: float | None) -> TraceLines:
    from bsm_mesh.geometries.drawings import lines_of_dxf

    return lines_of_dxf(file, scale, tolerance)


_READERS: dict[str, Callable[[Path, float | None, float | None], TraceLines]] = {
    ".csv": lambda file, scale, _: lines_of_csv(file, scale),
    ".geojson": lambda file, scale, _: lines_of_geojson(file, scale),
    ".json": lambda file, scale, _: lines_of_geojson(file, scale),
    ".dxf": _by_dxf,
    ".shp": _by_gis,
    ".gpkg": _by_gis,
}
