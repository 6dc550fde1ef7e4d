"""Lines of a DXF drawing: straight ones, and curves sampled so that no chord is farther off than a tolerance."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.reading import refuse_special

STRAIGHT = ("LINE", "LWPOLYLINE", "POLYLINE")
CURVES = ("ARC", "CIRCLE", "ELLIPSE", "SPLINE", "HELIX")  # and polylines with bulges
ARC_PARTS = 8  # cubic curves a quarter of an arc at least: within 1e-9 of its radius
SAMPLED = 1e-3  # of the drawing's size: how far a chord may be off its curve where no tolerance is given


def lines_of_dxf(file: Path, tolerance: float | None) -> tuple[dict[str, list[FloatArray]], Counter[str]]:
    """Return the lines of every layer, and how many entities of other types were left out.

    Blocks that are inserted are taken apart, as often as they are nested. A block's entities on layer 0 are on the
    layer of the insert, as in every CAD program.

    Parameters
    ----------
    file : Path
        The drawing.
    tolerance : float, optional
        Greatest distance of a chord from its curve, in the drawing's unit; by default a thousandth of its size.

    Raises
    ------
    GeometryError
        If ezdxf is not installed, or cannot read the file.
    """
    try:
        import ezdxf
    except ImportError as fault:
        raise GeometryError(f"{file}: to read DXF: pip install ezdxf") from fault
    log = logging.getLogger("ezdxf")
    if not log.handlers:  # else Python writes on stderr what ezdxf quotes of the file
        log.addHandler(logging.NullHandler())
    refuse_special(file)
    try:
        file.read_bytes()  # ezdxf raises OSError also for a file that is no DXF
    except (OSError, ValueError) as fault:
        raise GeometryError(f"{file}: cannot be read: {getattr(fault, 'strerror', None) or fault}") from fault
    try:
        return _lines(ezdxf.readfile(file), tolerance)
    except Exception as fault:  # ezdxf lets through whatever a damaged file makes it raise
        raise GeometryError(f"{file}: is no DXF file, or is damaged: {fault or type(fault).__name__}") from fault


def _lines(drawing: Any, tolerance: float | None) -> tuple[dict[str, list[FloatArray]], Counter[str]]:
    from ezdxf.path import make_path

    paths: list[tuple[str, Any]] = []
    left_out: Counter[str] = Counter()
    for layer, entity in _taken_apart(drawing.modelspace(), None):
        kind = entity.dxftype()
        if kind not in STRAIGHT + CURVES or (
            kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)
        ):
            left_out[kind] += 1
            continue
        path = make_path(entity, segments=ARC_PARTS)
        for part in path.sub_paths():
            if len(part):
                paths.append((layer, part))
    if tolerance is None:
        ends = np.array([(p.x, p.y) for _, path in paths for p in path.control_vertices()]).reshape(-1, 2)
        tolerance = SAMPLED * float(np.hypot(*np.ptp(ends, axis=0))) if len(ends) else 1.0
    found: dict[str, list[FloatArray]] = {}
    for layer, path in paths:
        points = np.array([(p.x, p.y) for p in path.flattening(max(tolerance, 1e-12))], dtype=np.float64)
        found.setdefault(layer, []).append(points)
    return found, left_out


def _taken_apart(entities: Iterable[Any], around: str | None) -> Iterator[tuple[str, Any]]:
    """Give entities with their layers, those of inserted blocks in place of the inserts; `around` is an insert's."""
    for entity in entities:
        layer = around if around is not None and entity.dxf.layer == "0" else entity.dxf.layer
        if entity.dxftype() == "INSERT":
            for insert in entity.multi_insert() if entity.mcount > 1 else [entity]:
                yield from _taken_apart(insert.virtual_entities(), layer)
        else:
            yield layer, entity
