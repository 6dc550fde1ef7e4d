"""Lines of a DXF drawing: straight ones, and curves sampled so that each chord is within a tolerance."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.reading import refuse_special
from bsm_mesh.geometries.trace_lines import TraceLines, Unit

STRAIGHT = ("LINE", "LWPOLYLINE", "POLYLINE")
CURVES = ("ARC", "CIRCLE", "ELLIPSE", "SPLINE", "HELIX")  # and polylines with bulges
METRES = 6  # code of metres in $INSUNITS
FOOT, SURVEY_FOOT = 0.3048, 1200 / 3937  # m
UNITS = {  # by their codes in $INSUNITS
    1: Unit("inches", 0.0254),
    2: Unit("feet", FOOT),
    3: Unit("miles", 5280 * FOOT),
    4: Unit("mm", 1e-3),
    5: Unit("cm", 1e-2),
    7: Unit("km", 1e3),
    10: Unit("yards", 3 * FOOT),
    13: Unit("micrometres", 1e-6),
    14: Unit("dm", 0.1),
    15: Unit("decametres", 10.0),
    16: Unit("hectometres", 100.0),
    21: Unit("US survey feet", SURVEY_FOOT),
    22: Unit("US survey inches", SURVEY_FOOT / 12),
    23: Unit("US survey yards", 3 * SURVEY_FOOT),
    24: Unit("US survey miles", 5280 * SURVEY_FOOT),
}
ARC_PARTS = 8  # cubic curves a quarter of an arc at least: within 1e-9 of its radius
SAMPLED = 1e-3  # of the drawing's size: how far a chord may be off its curve where no tolerance is given


def lines_of_dxf(file: Path, scale: float | None, tolerance: float | None) -> TraceLines:
    """Return the lines of every layer, and how many entities of other types were left out.

    Blocks that are inserted are taken apart, as often as they are nested. A block's entities on layer 0 are on the
    layer of the insert, as in every CAD program.

    Parameters
    ----------
    file : Path
        The drawing.
    scale : float, optional
        The drawing's unit of length [m] in place of the one that it names (``$INSUNITS``); without both 1 m.
    tolerance : float, optional
        Greatest distance of a chord from its curve [m]; by default a thousandth of the drawing's size.

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
        return _lines(ezdxf.readfile(file), scale, tolerance)
    except Exception as fault:  # ezdxf lets through whatever a damaged file makes it raise
        raise GeometryError(f"{file}: is no DXF file, or is damaged: {fault or type(fault).__name__}") from fault


def _lines(drawing: Any, scale: float | None, tolerance: float | None) -> TraceLines:
    from ezdxf.path import make_path

    paths: list[tuple[str, Any]] = []
    found = TraceLines()
    unit = found.unit(scale, _unit(drawing, found.notes), "its header ($INSUNITS) says that it is drawn")
    for layer, entity in _taken_apart(drawing.modelspace(), None, found.left_out):
        kind = entity.dxftype()
        if kind not in STRAIGHT + CURVES or (
            kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)
        ):
            found.left_out[kind] += 1
            continue
        parts = [part for part in make_path(entity, segments=ARC_PARTS).sub_paths() if len(part)]
        paths += [(layer, part) for part in parts]
        if not parts:
            found.left_out["empty line"] += 1
    if tolerance is None:
        ends = np.array([tuple(p) for _, path in paths for p in path.control_vertices()]).reshape(-1, 3)
        allowed = SAMPLED * float(np.linalg.norm(np.ptp(ends, axis=0))) if len(ends) else 1.0
    else:
        allowed = tolerance / unit
    for layer, path in paths:
        points = np.array([tuple(p) for p in path.flattening(max(allowed, 1e-12))], dtype=np.float64)
        found.add(layer, points.reshape(-1, 3), unit)
    return found


def _unit(drawing: Any, notes: list[str]) -> Unit | None:
    """Return the unit of length that the header names, None for metres or none."""
    code = drawing.header.get("$INSUNITS", 0)
    if code in (0, METRES):
        return None
    if code not in UNITS:
        notes.append(f"its header names a unit that is not known ($INSUNITS = {code}): it is taken as metres")
        return None
    return UNITS[code]


def _taken_apart(entities: Iterable[Any], around: str | None, left_out: Counter[str]) -> Iterator[tuple[str, Any]]:
    """Give entities with their layers, those of inserted blocks in place of the inserts; `around` is an insert's.

    Blocks of other drawings (XREF) are not in the file, and are counted.
    """
    for entity in entities:
        layer = around if around is not None and entity.dxf.layer == "0" else entity.dxf.layer
        if entity.dxftype() == "INSERT":
            block = entity.block()
            if block is None or block.block.is_xref or block.block.is_xref_overlay:
                left_out["INSERT of another drawing (XREF)"] += 1
                continue
            for insert in entity.multi_insert() if entity.mcount > 1 else [entity]:
                yield from _taken_apart(insert.virtual_entities(), layer, left_out)
        else:
            yield layer, entity
