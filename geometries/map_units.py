"""The unit of length of coordinate reference systems (CRS), which GDAL knows."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import numpy as np

from bsm_mesh.errors import shortened
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.trace_lines import TraceLines, Unit

PLANE = re.compile(r"(PROJCS|PROJCRS|LOCAL_CS|ENGCRS|ENGINEERINGCRS)\[")
GLOBE = re.compile(r"(GEOGCS|GEOGCRS|ANGLEUNIT)\[")
DEGREES = re.compile(r"OGC:CRS(84|83|27)|EPSG:4326")
KNOWN = re.compile(r"(EPSG|ESRI|OGC):\w{1,12}")
HEIGHTS = re.compile(r",(VERT_CS|VERTCRS|VERTICALCRS)\[.*", re.DOTALL)
UNITS = re.compile(r'(?:UNIT|LENGTHUNIT)\["([^"]*)",([-+0-9.eE]+)')
MEMORY = "/vsimem/bsm_mesh_crs.gpkg"
TEXTS = re.compile(r'"(?:[^"]|"")*"')


class NoPlaneError(Exception):
    """Coordinates of a CRS are no lengths in a plane: the text states their unit."""


def unit_of_crs(crs: str | None) -> Unit | None:
    """Return the unit of length of a CRS, or None if it is not known.

    Parameters
    ----------
    crs : str, optional
        As WKT, or as whatever GDAL knows: ``EPSG:2263``.

    Raises
    ------
    NoPlaneError
        If coordinates are degrees, or distances from the middle of the earth.
    ValueError
        If it is no CRS that GDAL knows.
    ImportError
        If pyogrio is needed and not installed.
    """
    if not crs:
        return None
    if DEGREES.fullmatch(crs):
        raise NoPlaneError("in degrees")
    wkt = crs if "[" in crs else _wkt(crs)
    plain = TEXTS.sub('""', wkt)
    if not PLANE.search(plain):
        raise NoPlaneError("in degrees" if GLOBE.search(plain) else "distances from the middle of the earth")
    found = UNITS.findall(HEIGHTS.sub("", wkt))
    name, metres = found[-1] if found else ("", "0")  # the last one: that of the geographic CRS within comes before
    return Unit(name, float(metres)) if float(metres) > 0 else None


def _wkt(crs: str) -> str:
    """Return the WKT of a CRS, which GDAL writes into every GeoPackage; this one is in memory."""
    if not KNOWN.fullmatch(crs):  # GDAL would read a name as that of a file, or an address
        raise ValueError
    import pyogrio

    nowhere = np.array([], dtype=object)
    try:
        pyogrio.raw.write(
            MEMORY, geometry=nowhere, field_data=[], fields=[], geometry_type="Point", crs=crs, driver="GPKG"
        )
        sql = "SELECT s.definition FROM gpkg_spatial_ref_sys s JOIN gpkg_contents c ON s.srs_id = c.srs_id"
        *_, (texts,) = pyogrio.raw.read(MEMORY, sql=sql)
    except pyogrio.errors.CRSError:
        raise ValueError from None
    finally:
        with contextlib.suppress(OSError):
            pyogrio.vsi_unlink(MEMORY)
    return str(texts[0])


def unit_on_map(file: Path, what: str, crs: str | None, scale: float | None, found: TraceLines) -> float:
    """Return the unit of length of coordinates [m]: `scale` if it is given, else that of their CRS, else 1 m.

    Parameters
    ----------
    file : Path
        The file, for messages.
    what : str
        The thing in the CRS, for messages.
    crs : str, optional
        The CRS, None for none.
    scale : float, optional
        Given by the user [m].
    found : TraceLines
        Gets a note where the unit is not metres, or not known.

    Raises
    ------
    GeometryError
        If coordinates are no lengths in a plane.
    """
    told, unit = shortened(str(crs), 40), None
    try:
        unit = unit_of_crs(crs)
    except NoPlaneError as fault:
        raise GeometryError(
            f"{file}: {what} are {fault} (CRS {told}); project them to metres first, by QGIS for one"
        ) from None
    except (ValueError, ImportError) as fault:
        if scale is None:
            cure = "" if isinstance(fault, ValueError) else " (pip install pyogrio)"
            found.notes.append(f"the unit of {what} is not known, CRS {told}{cure}: they are taken as metres")
    return found.unit(scale, unit, f"{what} are")
