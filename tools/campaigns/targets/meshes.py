"""Meshes in every format: sections, numbers and bytes changed."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Any

from tests.scenes.small_models import CURVES, MESH, SURFACES
from tests.scenes.square_mesh import NODES, QUADS

from ..inputs import Input, demand_finite
from ..mutations import mutate
from ..seeds import write_forms, write_meshes

GROUPS: tuple[dict[str, str] | None, ...] = (
    None,
    None,
    {"*": "rock:gneiss"},
    {"*": "rock:r"},
    {"rock=1": "rock:a"},
    {"*": "rock:r", "BASE": "boundary:b"},
)
BY_MESHIO = (
    "avs",
    "bdf",
    "dat",
    "dato",
    "fem",
    "inp",
    "mdpa",
    "mesh",
    "meshb",
    "nas",
    "obj",
    "ply",
    "post",
    "stl",
    "tec",
    "vol",
    "vtk",
    "vtu",
    "wkt",
    "xml",
)
FOREIGN = 0.15  # of the inputs are in formats that only meshio reads


def prepare(folder: Path) -> None:
    """Write the small mesh in every format that can be written here."""
    there = folder / "meshes"
    there.mkdir(parents=True, exist_ok=True)
    (there / "small.22.msh").write_bytes(MESH)
    _by_gmsh(there)
    _by_vtk(there)
    _by_meshio(there)
    write_meshes(there)


def _by_gmsh(there: Path) -> None:
    from bsm_mesh.geometries import gmsh_session

    with gmsh_session("small") as gmsh:
        corner = [gmsh.model.geo.addPoint(float(x), float(y), 0.0, 9.0) for x, y in NODES]
        sides: dict[tuple[int, int], int] = {}

        def side(a: int, b: int) -> int:
            if (b, a) in sides:
                return -sides[b, a]
            return sides.setdefault((a, b), gmsh.model.geo.addLine(corner[a], corner[b]))

        faces = []
        for quad in QUADS:
            loop = gmsh.model.geo.addCurveLoop([side(a, b) for a, b in zip(quad, quad[1:] + quad[:1], strict=True)])
            faces.append(gmsh.model.geo.addPlaneSurface([loop]))
        gmsh.model.geo.synchronize()
        for name, pairs in CURVES.items():
            tags = [abs(sides.get((a, b)) or sides.get((b, a)) or 0) for a, b in pairs]
            gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, [tag for tag in tags if tag]), name)
        for name, numbers in SURFACES.items():
            gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [faces[k] for k in numbers]), name)
        gmsh.model.mesh.generate(2)
        for version in (2.2, 4.1):
            for binary in (0, 1):
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
                gmsh.option.setNumber("Mesh.Binary", binary)
                gmsh.write(str(there / f"gmsh.{version}.{binary}.msh"))
        write_forms(gmsh, there)


def _by_vtk(there: Path) -> None:
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    for name, writer, data in (
        ("grid.vtu", vtkXMLUnstructuredGridWriter, _grid()),
        ("grid.vtp", vtkXMLPolyDataWriter, _polygons()),
    ):
        for mode in ("Ascii", "Binary", "Appended"):
            made = writer()
            getattr(made, f"SetDataModeTo{mode}")()
            made.SetCompressorTypeToZLib() if mode == "Appended" else made.SetCompressorTypeToNone()
            made.SetFileName(str(there / f"{mode.lower()}.{name}"))
            made.SetInputData(data)
            made.Write()
    for name, legacy, data in (
        ("grid.vtk", vtkUnstructuredGridWriter, _grid()),
        ("poly.vtk", vtkPolyDataWriter, _polygons()),
    ):
        for mode in ("ASCII", "Binary"):
            made = legacy()
            getattr(made, f"SetFileTypeTo{mode}")()
            made.SetFileName(str(there / f"{mode.lower()}.{name}"))
            made.SetInputData(data)
            made.Write()


def _cells(data: Any) -> Any:
    from vtkmodules.vtkCommonCore import vtkIntArray, vtkPoints, vtkStringArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    points = vtkPoints()
    for x, y in NODES:
        points.InsertNextPoint(x, y, 0.0)
    cells = vtkCellArray()
    for quad in QUADS:
        cells.InsertNextCell(4, quad)
    rock = vtkIntArray()
    rock.SetName("rock")
    for value in (0, 0, 1, 1):
        rock.InsertNextValue(value)
    names = vtkStringArray()
    names.SetName("rock_names")
    for name in ("gneiss", "schist"):
        names.InsertNextValue(name)
    data.SetPoints(points)
    data.GetCellData().AddArray(rock)
    data.GetFieldData().AddArray(names)
    return cells


def _grid() -> Any:
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

    data = vtkUnstructuredGrid()
    data.SetCells(7, _cells(data))
    return data


def _polygons() -> Any:
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    data = vtkPolyData()
    data.SetPolys(_cells(data))
    return data


def _by_meshio(there: Path) -> None:
    import meshio
    import numpy as np

    points = np.array([(x, y, 0.0) for x, y in NODES])
    triangles = [half for a, b, c, d in QUADS for half in ((a, b, c), (a, c, d))]
    for ending in BY_MESHIO:
        for kind, cells in (("quad", QUADS), ("triangle", triangles)):
            path = there / f"meshio.{kind}.{ending}"
            try:
                meshio.write(path, meshio.Mesh(points, [(kind, np.array(cells))]))
            except (Exception, SystemExit):  # a format without this kind of cell
                path.unlink(missing_ok=True)


_KNOWN: dict[Path, tuple[list[tuple[str, bytes]], list[tuple[str, bytes]]]] = {}


def good(folder: Path) -> tuple[list[tuple[str, bytes]], list[tuple[str, bytes]]]:
    """Return (name, content) of the good meshes: those that the project reads, and those that meshio reads."""
    if folder not in _KNOWN:
        there = sorted((path.name, path.read_bytes()) for path in (folder / "meshes").iterdir())
        ours = [mesh for mesh in there if mesh[0].rpartition(".")[2] in ("msh", "vtu", "vtp", "vtk")]
        _KNOWN[folder] = ours, [mesh for mesh in there if mesh not in ours]
    return _KNOWN[folder]


def draw(random: Random, folder: Path) -> Input:
    """Return a mesh with a few changes, now and then under the ending of another format."""
    ours, foreign = good(folder)
    name, data = random.choice(foreign if random.random() < FOREIGN else ours)
    ending = name.rpartition(".")[2]
    if random.random() < 0.01:
        ending = random.choice(foreign + ours)[0].rpartition(".")[2]
    groups = random.choice(GROUPS)
    blocks = random.choice(("elements", "elements", "regions"))
    return Input(
        f"read_mesh('mesh.{ending}', groups={groups}, blocks={blocks!r}), made of {name}",
        lambda: _read(f"mesh.{ending}", groups, blocks),
        {f"mesh.{ending}": mutate(random, data)},
    )


def _read(name: str, groups: dict[str, str] | None, blocks: Any) -> None:
    from bsm_mesh.converters import read_mesh

    made, _ = read_mesh(name, groups=groups or {}, blocks=blocks)
    demand_finite(made.vertices, "a corner of a mesh's block")
