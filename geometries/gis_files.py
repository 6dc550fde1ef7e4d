"""Lines of a shapefile or GeoPackage, read by GDAL through pyogrio.

GDAL asks all its drivers whose file it is, whatever its ending: a virtual dataset (VRT) would read any path and the
network. It is given a file only where the first bytes are those of the format that the ending names, and by a name of
ours: in GDAL's ways to read a path ``http:/...`` is an address.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np

from bsm_mesh.files import given_alone
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.reading import refuse_special

IN_DEGREES = ("GEOGCS", "GEOGCRS", "EPSG:4326", "OGC:CRS84")
NAMES = ("set", "name")  # fields that name the set of a line, else it is the layer
SHAPEFILE, GEOPACKAGE = ".shp", ".gpkg"
PARTS = {SHAPEFILE: (".shx", ".dbf", ".prj", ".cpg"), GEOPACKAGE: (".gpkg-wal",)}  # beside the file
OURS = "lines"  # what GDAL knows the file by: the layer of a shapefile is called so


def lines_of_gis(file: Path) -> tuple[dict[str, list[FloatArray]], Counter[str]]:
    """Return the lines of every set, and how many features of other types were left out.

    The field ``set`` or ``name`` (in any case) names the set of a line, else the name of its layer.

    Raises
    ------
    GeometryError
        If pyogrio is not installed, the content is not what the ending says, GDAL cannot read the file, or coordinates
        are degrees.
    """
    try:
        import pyogrio
    except ImportError as fault:
        raise GeometryError(f"{file}: to read shapefiles and GeoPackages: pip install pyogrio") from fault
    if not file.is_file():
        raise GeometryError(f"{file}: there is no such file")
    _refuse_other_content(file)
    import shapely

    found: dict[str, list[FloatArray]] = {}
    left_out: Counter[str] = Counter()
    name = f"{OURS}{file.suffix.lower()}"
    with given_alone({name: file, **_parts_beside(file)}) as folder:
        given = folder / name
        try:
            for layer in pyogrio.list_layers(given)[:, 0]:
                _read_layer(file, given, str(layer), found, left_out)
        except UnicodeDecodeError as fault:
            raise GeometryError(
                f"{file}: holds texts that are not in UTF-8; export the traces again in UTF-8"
            ) from fault
        except (RuntimeError, NameError, shapely.errors.ShapelyError) as fault:  # as pyogrio fails of damaged files
            told = str(fault).replace(str(given), str(file))
            raise GeometryError(f"{file}: GDAL cannot read it ({told}); export the traces again") from fault
    return found, left_out


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


def _read_layer(
    file: Path, given: Path, layer: str, found: dict[str, list[FloatArray]], left_out: Counter[str]
) -> None:
    import pyogrio
    import shapely

    meta, _, geometry, fields = pyogrio.raw.read(given, layer=layer)
    if geometry is None:
        return
    layer = file.stem if given.suffix == SHAPEFILE else layer
    if str(meta.get("crs") or "").startswith(IN_DEGREES):
        raise GeometryError(
            f"{file}: layer '{layer}' is in degrees ({meta['crs']:.20}); project it to metres first, by QGIS for one"
        )
    columns = {str(name).lower(): values for name, values in zip(meta["fields"], fields, strict=True)}
    names = next((columns[name] for name in NAMES if name in columns), None)
    shapes = shapely.force_2d(shapely.from_wkb(geometry))
    parts, owner = shapely.get_parts(shapes, return_index=True)
    kinds = shapely.get_type_id(parts)
    for part, feature, kind in zip(parts, owner, kinds, strict=True):
        if kind in (shapely.GeometryType.LINESTRING, shapely.GeometryType.LINEARRING):
            said = "" if names is None else str(names[feature] if names[feature] is not None else "")
            points = np.asarray(shapely.get_coordinates(part), dtype=np.float64)
            found.setdefault(said.strip() or layer, []).append(points)
        else:
            left_out[str(part.geom_type)] += 1
