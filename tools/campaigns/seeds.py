"""Files as users of other programs have them, made small: each was once read wrongly, refused untruly or obeyed.

Groups of one name, forms of Gmsh and Abaqus that few readers know, tables of other countries, features that are no
lines, drawings of another plane and unit, files that are scripts or lead elsewhere.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.scenes.square_mesh import NODES, QUADS, Group, msh_of

SCRIPT = b"""SystemCall "touch PWNED";
Point(1)={0,0,0};Point(2)={1,0,0};Point(3)={1,1,0};
Line(1)={1,2};Line(2)={2,3};Line(3)={3,1};
Curve Loop(1)={1,2,3};Plane Surface(1)={1};Physical Surface("rock:gneiss")={1};
Mesh 2;
"""
HALVES: list[Group] = [  # several groups of one name
    (1, "joint:J1", [(3, 4)]),
    (1, "joint:J1", [(4, 5)]),
    (1, "boundary:bottom", [(0, 1)]),
    (1, "boundary:bottom", [(1, 2)]),
    (2, "rock:gneiss", QUADS[:2]),
    (2, "rock:gneiss", QUADS[2:]),
]
BARE: list[Group] = [(d, None if k in (1, 2) else name, cells) for k, (d, name, cells) in enumerate(HALVES)]
_ABAQUS = "*Node\n1,0,0\n2,1,0\n3,2,0\n4,0,1\n5,1,1\n6,2,1\n*Element, type=CPS4, elset=ROCK\n1,1,2,5,4\n"
_ENDS = "2,2,3,6,5\n*Nset, nset=BASE\n1,2,3\n"
ABAQUS = {
    "system": "*System\n10.,0.,0.,10.,1.,0.\n" + _ABAQUS + _ENDS,
    "elgen": _ABAQUS + "*Elgen, elset=ROCK\n1,2,1,1\n*Nset, nset=BASE\n1,2,3\n",
    "ngen": "*Node\n1,0.,0.\n3,2.,0.\n4,0.,1.\n6,2.,1.\n*Ngen\n1,3,1\n4,6,1\n" + _ABAQUS[_ABAQUS.index("*E") :] + _ENDS,
    "ncopy": _ABAQUS + "*Ncopy, change number=10, old set=ALL, shift\n1.,0.,0.\n"
    "*Elcopy, old set=ROCK, element shift=1, shift nodes=10\n*Nset, nset=BASE\n1,2\n",
    "nset": _ABAQUS.replace("*Node\n", "*Node, nset=BASE\n") + "2,2,3,6,5\n",
}


def write_meshes(folder: Path) -> None:
    """Write meshes of these kinds."""
    for version in ("4.1", "2.2"):
        (folder / f"halves.{version}.msh").write_text(msh_of(NODES, HALVES, version))
        (folder / f"bare.{version}.msh").write_text(msh_of(NODES, BARE, version))
    far = [(512345.0 + float(str(x)), 4501234.0 + float(str(y))) for x, y in NODES]
    (folder / "map.msh").write_text(msh_of(far, HALVES, "4.1"))
    (folder / "script.Unv").write_bytes(SCRIPT)
    for name, text in ABAQUS.items():
        (folder / f"{name}.inp").write_text(text)


FORMS: dict[str, dict[str, float]] = {  # options of Gmsh
    "parametric.msh": {"MshFileVersion": 2.2, "SaveParametric": 1},
    "all.msh": {"MshFileVersion": 2.2, "SaveAll": 1},
    "of_2018.msh": {"MshFileVersion": 4.0},
    "of_2003.msh": {"MshFileVersion": 1.0},
    "gmsh.bdf": {},
    "gmsh.unv": {"SaveGroupsOfElements": 1},
}


def write_forms(gmsh: Any, folder: Path) -> None:
    """Write the mesh of a session of Gmsh in forms that few readers know."""
    for name, options in FORMS.items():
        for option in ("SaveParametric", "SaveAll", "Binary"):
            gmsh.option.setNumber(f"Mesh.{option}", options.get(option, 0))
        for option, value in options.items():
            gmsh.option.setNumber(f"Mesh.{option}", value)
        gmsh.write(str(folder / name))


TABLES_OF_LINES = {  # one row each
    "a comment line": b"# mapped 2024\nx1,y1,x2,y2,set\n-0.5,1.25,10,2.5,J1\n",
    "decimal commas in quotes": b'x1,y1,x2,y2,set\n"-0,5","1,25","10,0","2,5",J1\n',
    "decimal commas, semicolons": b"x1;y1;x2;y2;set\n-0,5;1,25;10,0;2,5;J1\n",
    "semicolons": b"x1;y1;x2;y2;set\n-0.5;1.25;10.0;2.5;J1\n",
    "tabs": b"x1\ty1\tx2\ty2\tset\n-0.5\t1.25\t10.0\t2.5\tJ1\n",
    "units in the header": b"x1 [m],y1 [m],x2 [m],y2 [m],set\n-0.5,1.25,10,2.5,J1\n",
    "capitals in the header": b"X1,Y1,X2,Y2,SET\n-0.5,1.25,10,2.5,J1\n",
}
TABLES_OF_BOLTS = (
    b"start_x;start_y;end_x;end_y;diameter\n0,5;1,9;0,5;0,2;25 mm\n",
    b"START_X\tSTART_Y\tEND_X\tEND_Y\tDIAMETER [mm]\n0.5\t1.9\t0.5\t0.2\t25\n",
    b"# bolts of 2024\nstart_x [m],start_y [m],end_x [m],end_y [m],diameter\n0.5,1.9,0.5,0.2,0.025\n",
)
_LINE = '{"type": "LineString", "coordinates": [[-1, 1], [3, 1.2]]}'
_RING = '{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]}'


def _feature(geometry: str, group: str = '"J1"') -> str:
    return f'{{"type": "Feature", "properties": {{"set": {group}}}, "geometry": {geometry}}}'


def _collection(*features: str, crs: str = "") -> bytes:
    return f'{{"type": "FeatureCollection", {crs}"features": [{", ".join(features)}]}}'.encode()


_FEET = '"crs": {"type": "name", "properties": {"name": "EPSG:2263"}}, '
FEATURES = (
    _collection(_feature(f'{{"type": "GeometryCollection", "geometries": [{_LINE}]}}'), _feature(_LINE, '"J2"')),
    _collection(_feature(_RING), _feature(_LINE), _feature("null")),
    _collection(_feature(_LINE, "0"), _feature(_LINE, "false")),
    _collection(_feature(_LINE.replace("3,", "30,")), crs=_FEET),
)
DRAWING = b"\n".join(  # in the front view (XZ), in mm
    b"0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES 0 LINE 8 J1 10 -100.0 20 0.0 30 1000.0 "
    b"11 3000.0 21 0.0 31 1200.0 0 ENDSEC 0 EOF".split()
)
SECRET = {"secret.csv": b'WKT,set\n"LINESTRING (777 777,778 777)",J1\n'}
VIRTUAL = (  # a file of GDAL that leads to another
    b'<OGRVRTDataSource><OGRVRTLayer name="secret"><SrcDataSource>secret.csv</SrcDataSource><GeometryType>wkbLineString'
    b'</GeometryType><GeometryField encoding="WKT" field="WKT"/></OGRVRTLayer></OGRVRTDataSource>'
)


def write_features(folder: Path) -> None:
    """Write a GeoPackage, where that can be done."""
    try:
        import pyogrio
        import shapely
    except ImportError:
        return
    import numpy as np

    lines = [shapely.LineString([(-1, 1), (3, 1.2)]), shapely.LineString([(0, 0), (1, 1), (2, 1)])]
    pyogrio.raw.write(
        folder / "t.gpkg",
        geometry=np.array([shapely.to_wkb(line) for line in lines], dtype=object),
        field_data=[np.array(["J1", "J2"], dtype=object)],
        fields=["set"],
        geometry_type="LineString",
        crs="EPSG:2263",  # in feet
    )


def _with(tree: dict[str, Any], **tables: Any) -> dict[str, Any]:
    return {**tree, **{name: {**tree.get(name, {}), **keys} for name, keys in tables.items()}}


def _renamed(plain: dict[str, Any], kind: str, name: str, other: str) -> dict[str, Any]:
    tables = {other if key == name else key: value for key, value in plain[kind].items()}
    return {**plain, kind: tables, "groups": {f"{kind}:{name}": f"{kind}:{other}"}}


def models(plain: dict[str, Any]) -> list[tuple[dict[str, Any], dict[str, bytes]]]:
    """Return model files, each with the files it needs beside the small mesh, made of a plain one.

    Lines in files of others, a mesh that is a script, names that are commands of other programs, of pages and tables.
    """
    joint = {**plain["joint"]["J1"], "along": [[-1, 1.5], [3, 1.6]]}
    formula, page = '=HYPERLINK("http://127.0.0.1/","x")', "</script><script>document.title='PWNED'</script>"
    found: list[tuple[dict[str, Any], dict[str, bytes]]] = [
        (_with(plain, mesh={"file": "rock.Unv"}), {"rock.Unv": SCRIPT}),
        (_with(plain, mesh={"file": "rock.Unv", "blocks": "regions"}, joint={"L": joint}), {"rock.Unv": SCRIPT}),
        (_with(plain, mesh={"blocks": "regions"}, joint={"L": joint}, boundary={"base": {"below": 0.01}}), {}),
        (_renamed(plain, "joint", "J1", page), {}),
        (_renamed(plain, "rock", "gneiss", formula), {}),
        (_renamed(plain, "joint", "J1", "J\ncall x\n;"), {}),
        ({**plain, "title": page, "stage": [{"name": "=1+1"}, {"name": "../../x"}]}, {}),
        (_with(plain, mesh={"unit": "mm"}), {}),
    ]
    for name, data in (
        *((f"t{k}.geojson", data) for k, data in enumerate(FEATURES)),
        *((f"t{k}.csv", data) for k, data in enumerate(TABLES_OF_LINES.values())),
        ("t.dxf", DRAWING),
        ("t.gpkg", VIRTUAL),
    ):
        along = {**joint, "along": {"file": name, "set": "J1"}}
        beside = {name: data, **(SECRET if data is VIRTUAL else {})}
        found.append((_with(plain, mesh={"blocks": "regions"}, joint={"L": along}), beside))
    return found
