"""Seconds to read a Gmsh mesh and to make blocks of it, step by step.

Run as ``python benchmarks/read_mesh.py 1e6`` (number of triangles; a twelve-part rectangle with a dozen groups).
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import gmsh
import meshio

from converters import convert_mesh
from converters.meshes.files import read_cells

Result = TypeVar("Result")
COLUMNS, ROWS = 4, 3


def write_mesh(path: Path, triangles: float) -> None:
    """Write a rectangle of 4 x 3 units in MSH 4.1: two rocks, two excavations, five joints, four boundaries."""
    geo = gmsh.model.geo
    at = {(i, j): geo.addPoint(i, j, 0) for i in range(COLUMNS + 1) for j in range(ROWS + 1)}
    level = {(i, j): geo.addLine(at[i, j], at[i + 1, j]) for i in range(COLUMNS) for j in range(ROWS + 1)}
    upright = {(i, j): geo.addLine(at[i, j], at[i, j + 1]) for i in range(COLUMNS + 1) for j in range(ROWS)}
    part = {}
    for i, j in ((i, j) for i in range(COLUMNS) for j in range(ROWS)):
        loop = geo.addCurveLoop([level[i, j], upright[i + 1, j], -level[i, j + 1], -upright[i, j]])
        part[i, j] = geo.addPlaneSurface([loop])
    geo.synchronize()
    names = {j: ("boundary:bottom", "joint:H1", "joint:H2", "boundary:top")[j] for j in range(ROWS + 1)}
    for j, name in names.items():
        gmsh.model.addPhysicalGroup(1, [level[i, j] for i in range(COLUMNS)], name=name)
    for i, name in enumerate(("boundary:left", "joint:V1", "joint:V2", "joint:V3", "boundary:right")):
        gmsh.model.addPhysicalGroup(1, [upright[i, j] for j in range(ROWS)], name=name)
    gmsh.model.addPhysicalGroup(2, [part[k] for k in part if k[1] < 2], name="rock:granite")
    gmsh.model.addPhysicalGroup(2, [part[k] for k in part if k[1] == 2], name="rock:gneiss")
    for i in (1, 2):
        gmsh.model.addPhysicalGroup(2, [part[i, 1]], name=f"excavation:{i}")
    size = (2.6 * COLUMNS * ROWS / triangles) ** 0.5
    for option, value in (("MeshSizeMin", size), ("MeshSizeMax", size), ("Algorithm", 5), ("Binary", 1)):
        gmsh.option.setNumber(f"Mesh.{option}", value)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))
    gmsh.option.setNumber("Mesh.Binary", 0)
    gmsh.write(str(path.with_suffix(".text.msh")))


def timed(what: str, act: Callable[[], Result]) -> Result:
    start = time.perf_counter()
    result = act()
    print(f"{what:45s} {time.perf_counter() - start:7.2f} s")
    return result


def main(triangles: float) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.msh"
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        timed("gmsh: mesh and write", lambda: write_mesh(path, triangles))
        gmsh.finalize()
        timed("meshio alone, binary", lambda: meshio.read(path, file_format="gmsh"))
        timed("meshio alone, text", lambda: meshio.read(path.with_suffix(".text.msh"), file_format="gmsh"))
        timed("read, text", lambda: read_cells(path.with_suffix(".text.msh")))
        mesh: Any = timed("read, binary", lambda: read_cells(path))
        cells = [("triangle", mesh.corners.reshape(-1, 3)), ("line", mesh.pieces)]
        sets = {group.name: [group.elements, group.pieces] for group in mesh.groups}
        blocks, report = timed("convert (in memory)", lambda: convert_mesh(mesh.points, cells, sets))
        print(f"{blocks.count} blocks, {len(report.groups)} groups, {len(report.notes)} notes")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 1e5)
