"""Traces, scan lines and bolt tables: rows short of a cell, other encodings, numbers that are none."""

from __future__ import annotations

from pathlib import Path
from random import Random

from tests.scenes.small_models import MESH, model

from ..inputs import AcceptedError, Input, demand_finite
from ..mutations import mutate
from ..seeds import DRAWING, FEATURES, SECRET, TABLES_OF_BOLTS, TABLES_OF_LINES, VIRTUAL, write_features
from .models import written

PIECES = b"x1,y1,x2,y2,set\n0,0,10,5,J1\n0,5,10,9.5,J1\n3,0,2.5,10,fault\n1.5,-2,1.5e1,8,J2\n"
POINTS = b"x,y,trace,set\n0,0,1,J1\n5,2,1,J1\n10,5,1,J1\n0,5,2,J2\n10,9.5,2,J2\n"
SCAN = b"distance,dip,dip_direction,set\n0.4,60,135,J1\n1.1,62,130,J1\n1.9,12,310,bedding\n2.2,58.5,140,J1\n"
GEOJSON = (
    b'{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"set": "J1"}, "geometry": '
    b'{"type": "LineString", "coordinates": [[0, 0], [5, 2.5], [10, 5]]}}, {"type": "Feature", "properties": '
    b'{"name": "J2"}, '
    b'"geometry": {"type": "MultiLineString", '
    b'"coordinates": [[[0, 5], [10, 9.5]], [[1, 1], [2, 3]]]}}]}'
)
DXF = b"\n".join(
    b"0 SECTION 2 ENTITIES 0 LINE 8 J1 10 0.0 20 0.0 30 0.0 11 10.0 21 5.0 31 0.0 0 LINE 8 J2 10 0.0 20 5.0 30 0.0 "
    b"11 10.0 21 9.5 31 0.0 0 LWPOLYLINE 8 J1 90 3 70 1 10 0.0 20 1.0 10 4.0 20 3.0 10 8.0 20 9.0 "
    b"0 ENDSEC 0 EOF".split()
)
TRACES = (
    ("t.csv", PIECES, 0.35),
    ("t.csv", POINTS, 0.2),
    ("t.geojson", GEOJSON, 0.25),
    ("t.json", GEOJSON, 0.02),
    ("t.dxf", DXF, 0.03),
    *(("t.csv", data, 0.02) for data in TABLES_OF_LINES.values()),
    *(("t.geojson", data, 0.03) for data in FEATURES),
    ("t.dxf", DRAWING, 0.03),
    ("t.gpkg", VIRTUAL, 0.005),
    ("t.gpkg", b"", 0.005),  # the one that is written
)
BOLT_TABLES = (
    b"start_x,start_y,end_x,end_y,diameter,name\n0.5,1.9,0.5,0.3,25 mm,A\n1.5,1.9,1.5,0.3,0.025,B\n",
    b"start_x,start_y,end_x,end_y,diameter,kind,pretension,yield_strength,stage\n0.5,1.9,0.5,0.3,25 mm,end_anchored,"
    b"5 kN,500 MPa,\n1.2,1.8,1.7,0.1,20 mm,end_anchored,0,5e8,\n",
    b"start_x,start_y,end_x,end_y,diameter,bond_strength,bond_stiffness,bearing_stiffness,plate,spacing\n"
    b"1 m,180 cm,0.4,0.3,25 mm,150 kN/m,1 GPa,2 GPa,100 kN,1.5 m\n",
    *TABLES_OF_BOLTS,
)


def prepare_traces(folder: Path) -> None:
    """Write the traces that are no text."""
    (folder / "traces").mkdir(parents=True, exist_ok=True)
    write_features(folder / "traces")


def draw_traces(random: Random, folder: Path) -> Input:
    """Return a file of traces, or a scan line, with a few changes."""
    if random.random() < 0.2:
        return Input("read_scan_line('scan.csv')", _scan_line, {"scan.csv": mutate(random, SCAN, binary=False)})
    name, data, _ = random.choices(TRACES, [share for *_, share in TRACES])[0]
    stored = folder / "traces" / name
    if not data and stored.exists():
        data = stored.read_bytes()
    scale = random.choice((1.0, 1.0, 1.0, 0.001, 1e200))
    names = random.choice((None, None, {"J1": "J1"}, {"J1": "a", "J2": "a"}, {"nothing": "J1"}))
    return Input(
        f"read_traces({name!r}, names={names}, scale={scale})",
        lambda: _traces(name, names, scale),
        {name: mutate(random, data, binary=None if name == "t.gpkg" else False), **SECRET},
    )


def _traces(name: str, names: dict[str, str] | None, scale: float) -> None:
    import numpy as np

    from bsm_mesh import geometries

    for fault in geometries.read_traces(name, names=names, scale=scale):
        if not fault.lines:
            raise AcceptedError("traces: a set without lines")
        for line in fault.lines:
            demand_finite(line, "traces")
            if any(777 in point for point in np.asarray(line).tolist()) and name == "t.gpkg":
                raise AcceptedError("traces: another file was read")


def _scan_line() -> None:
    from bsm_mesh import geometries

    for row in geometries.read_scan_line("scan.csv"):
        demand_finite([row["distance"], row["dip"], row["dip_direction"]], "scan line")


def draw_bolts(random: Random, folder: Path) -> Input:
    """Return a model with a bolt table that has a few changes."""
    tree = model(0)
    tree["bolt"] = [{"table": "bolts.csv"}]
    table = mutate(random, random.choice(BOLT_TABLES), binary=False)
    return Input("bsm.load('model.toml')", _bolts, {"model.toml": written(tree), "mesh.msh": MESH, "bolts.csv": table})


def _bolts() -> None:
    import bsm_mesh as bsm

    for bolt in bsm.load("model.toml").bolts:
        demand_finite([*bolt.start, *bolt.end, bolt.diameter, bolt.pretension], "bolt table")
