"""Lines of a shapefile or GeoPackage, read by GDAL through pyogrio."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray

IN_DEGREES = ("GEOGCS", "GEOGCRS", "EPSG:4326", "OGC:CRS84")
NAMES = ("set", "name")  # fields that name the set of a line, else it is the layer


def lines_of_gis(file: Path) -> tuple[dict[str, list[FloatArray]], Counter[str]]:
    """Return the lines of every set, and how many features of other types were left out.

    The field ``set`` or ``name`` (in any case) names the set of a line, else the name of its layer.

    Raises
    ------
    GeometryError
        If pyogrio is not installed, GDAL cannot read the file, or coordinates are degrees.
    """
    try:
        import pyogrio
    except ImportError as fault:
        raise GeometryError(f"{file}: to read shapefiles and GeoPackages: pip install pyogrio") from fault
    if not file.is_file():
        raise GeometryError(f"{file}: there is no such file")
    found: dict[str, list[FloatArray]] = {}
    left_out: Counter[str] = Counter()
    try:
        layers = pyogrio.list_layers(file)[:, 0]
        for layer in layers:
            _read_layer(file, str(layer), found, left_out)
    except (pyogrio.errors.DataSourceError, pyogrio.errors.DataLayerError, pyogrio.errors.FeatureError) as fault:
        raise GeometryError(f"{file}: GDAL cannot read it ({fault})") from fault
    return found, left_out


def _read_layer(file: Path, layer: str, found: dict[str, list[FloatArray]], left_out: Counter[str]) -> None:
    import pyogrio
    import shapely

    meta, _, geometry, fields = pyogrio.raw.read(file, layer=layer)
    if geometry is None:
        return
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
            given = "" if names is None else str(names[feature] if names[feature] is not None else "")
            points = np.asarray(shapely.get_coordinates(part), dtype=np.float64)
            found.setdefault(given.strip() or layer, []).append(points)
        else:
            left_out[str(part.geom_type)] += 1
