"""Lines of a shapefile or GeoPackage, read by GDAL through pyogrio.

GDAL asks all its drivers whose file it is, whatever its ending: a virtual dataset (VRT) would read any path and the
network. It is given a file only where the first bytes are those of the format that the ending names, and by a name of
ours: in GDAL's ways to read a path ``http:/...`` is an address.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from bsm_mesh.files import given_alone
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.map_units import unit_on_map
from bsm_mesh.geometries.reading import refuse_special
from bsm_mesh.geometries.trace_lines import TraceLines

SHAPEFILE, GEOPACKAGE = ".shp", ".gpkg"
PARTS = {SHAPEFILE: (".shx", ".dbf", ".prj", ".cpg"), GEOPACKAGE: (".gpkg-wal",)}  # beside the file
OURS = "lines"  # what GDAL knows the file by: the layer of a shapefile is called so


def lines_of_gis(file: Path, scale: float | None) -> TraceLines:
    """Return the lines of every set, and the omissions.

    The field ``set`` or ``name`` (in any case) names the set of a line, else the name of its layer.

    Parameters
    ----------
    file : Path
        The shapefile or GeoPackage.
    scale : float, optional
        The unit of length [m] in place of that of each layer's CRS.

    Raises
    ------
    GeometryError
        If pyogrio is not installed, the content contradicts the ending, GDAL cannot read the file, or coordinates
        are degrees.
    """
    try:
        import pyogrio
    except ImportError as fault:
        raise GeometryError(f"{file}: to read shapefiles and GeoPackages: pip install pyogrio") from fault
    if not os.path.isfile(file):  # False for a name that is none
        raise GeometryError(f"{file}: there is no such file")
    _refuse_other_content(file)
    import shapely

    found = TraceLines()
    name = f"{OURS}{file.suffix.lower()}"
    with given_alone({name: file, **_parts_beside(file)}) as folder:
        given = folder / name
        try:
            for layer in pyogrio.list_layers(given)[:, 0]:
                _read_layer(file, given, str(layer), scale, found)
        except UnicodeDecodeError as fault:
            raise GeometryError(
                f"{file}: holds texts that are not in UTF-8; export the traces again in UTF-8"
            ) from fault
        except (RuntimeError, NameError, shapely.errors.ShapelyError) as fault:  # as pyogrio fails of damaged files
            told = str(fault).replace(str(given), str(file))
            raise GeometryError(f"{file}: GDAL cannot read it ({told}); export the traces again") from fault
    return found


def _refuse_other_content(file: Path) -> None:
    """Raise unless the first bytes are a shapefile's (code 9994) or a GeoPackage's (SQLite, its application number)."""
    try:
        with file.open("rb") as opened:
            head = opened.read(100)
    except OSError as fault:
        raise GeometryError(f"{file}: cannot be opened ({fault.strerror}); see to its permissions") from fault
    if file.suffix.lower() == SHAPEFILE:
        name, right = "shapefile", head[:4] == (9994).to_bytes(4, "big")
    else:
        name = "GeoPackage"
        right = head[:16] == b"SQLite format 3\0" and head[68:72] in (b"GPKG", b"GP10", b"GP11")
    if not right:
        raise GeometryError(
            f"{file}: its content is no {name}; it is damaged, or not what its ending says: export the traces again"
        )


def _parts_beside(file: Path) -> dict[str, Path]:
    """Return the other files of the same data by the names that GDAL is to know them by."""
    beside = {
        f"{OURS}{part.suffix.lower()}": part
        for part in sorted(file.parent.iterdir())
        if part.stem == file.stem and part.suffix.lower() in PARTS[file.suffix.lower()]
    }
    home = os.path.dirname(os.path.realpath(file))
    for part in beside.values():
        refuse_special(part)
        if os.path.dirname(os.path.realpath(part)) != home:
            raise GeometryError(f"{part}: is a link to another folder than that of {file.name}; put a copy there")
    return beside


def _read_layer(file: Path, given: Path, layer: str, scale: float | None, found: TraceLines) -> None:
    import pyogrio
    import shapely

    meta, _, geometry, fields = pyogrio.raw.read(given, layer=layer)
    if geometry is None:
        found.left_out["table without geometry"] += 1
        return
    layer = file.stem if given.suffix == SHAPEFILE else layer
    unit = unit_on_map(file, f"coordinates of layer '{layer}'", meta.get("crs"), scale, found)
    shapes = shapely.from_wkb(geometry)
    shapes = np.where(shapely.has_z(shapes), shapes, shapely.force_2d(shapes))  # measures are no places
    for number, shape in enumerate(shapes):
        properties = {str(name): values[number] for name, values in zip(meta["fields"], fields, strict=True)}
        found.add_feature(properties, None if shape is None else shapely.geometry.mapping(shape), layer, unit)
