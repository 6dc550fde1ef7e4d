"""From joint sets to blocks, from mesh files to blocks, and from results to files."""

from __future__ import annotations

import tempfile
from argparse import Namespace
from pathlib import Path
from typing import Any

import gmsh

import bsm_mesh as bsm
from benchmarks.linear import make_model, mesh_in_memory
from benchmarks.measure import peak_memory, timed
from bsm_mesh.converters import convert_mesh, read_mesh
from bsm_mesh.converters.meshes.files import read_cells
from bsm_mesh.geometries import Exponential, JointSet, Region, RockMass, Voronoi, cut_blocks, rectangle, write_blocks
from bsm_mesh.geometries.joint_sets import Joints

SIDE = 100.0  # m
COLUMNS, ROWS = 4, 3  # parts of the rectangle of `write_mesh`
NETWORKS = ("two-sets", "scattered", "ended", "voronoi")
Row = dict[str, Any]


def network(kind: str, count: int) -> list[Joints]:
    """Return joints for about `count` blocks in a square."""
    spacing = SIDE / count**0.5
    steep = {"dip": 107.0, "spacing": spacing}
    return {
        "two-sets": [JointSet(name="J1", dip=31.3, spacing=spacing), JointSet(name="J2", **steep)],
        "scattered": [
            JointSet(name="J1", dip=31.3, spacing=Exponential(spacing), scatter=2.0),
            JointSet(name="J2", **steep, scatter=2.0),
        ],
        "ended": [
            JointSet(name="J1", dip=31.3, spacing=spacing),
            JointSet(name="J2", **steep, persistence=0.7, bridge=2 * spacing, ends="t_ended"),
        ],
        "voronoi": [Voronoi(name="V", size=spacing, rounds=2)],
    }[kind]


def run_cutting(kind: str, n: int, given: Namespace) -> Row:
    """Cut a square along joints, write the mesh and read it back; the areas are compared with the square's."""
    mass = RockMass(
        regions=[Region(outline=rectangle(0, 0, SIDE, SIDE), rock="gneiss")], joints=network(kind, n), seed=1
    )
    row: Row = {}
    with tempfile.TemporaryDirectory() as folder:
        with timed(row, "cut"):
            cut = cut_blocks(mass)
        with timed(row, "write"):
            path = write_blocks(cut, Path(folder) / "rock.msh")
        with timed(row, "read"):
            blocks, _ = read_mesh(path, blocks="regions")
    return _finished(row, blocks.count, f"area wrong by {abs(blocks.moments.area.sum() / SIDE**2 - 1):.1e}")


def run_reading(ending: str, n: int, given: Namespace) -> Row:
    """Read a Gmsh mesh of triangles with a dozen groups and make blocks of it."""
    row: Row = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"mesh{ending}"
        write_mesh(path, n, binary=ending == ".msh")
        with timed(row, "read"):
            mesh: Any = read_cells(path)
        cells = [("triangle", mesh.corners.reshape(-1, 3)), ("line", mesh.pieces)]
        sets = {group.name: [group.elements, group.pieces] for group in mesh.groups}
        with timed(row, "convert"):
            blocks, report = convert_mesh(mesh.points, cells, sets)
    return _finished(row, blocks.count, f"{len(report.groups)} groups, {len(report.notes)} notes")


def run_writing(n: int, given: Namespace) -> Row:
    """Write the results of the linear scheme, and load them again."""
    results = bsm.run(make_model(*mesh_in_memory(n)), bsm.Options(scheme="linear", linear_solver=given.solver))
    row: Row = {}
    with tempfile.TemporaryDirectory() as folder:
        with timed(row, "write"):
            results.save(folder)
        size = sum(file.stat().st_size for file in Path(folder).iterdir()) / 1024**2
        with timed(row, "read"):
            loaded = bsm.Results.load(folder)
    return _finished(row, loaded.blocks.count, f"{size:.1f} MB")


def _finished(row: Row, blocks: int, note: str) -> Row:
    spent = sum(row["parts"].values())
    numbers = {"blocks": blocks, "seconds": spent, "processor": spent, "memory": peak_memory()}
    return row | numbers | {"verdict": "done", "note": note}


def write_mesh(path: Path, triangles: int, *, binary: bool) -> None:
    """Write a rectangle of 4 x 3 units in MSH 4.1: two rocks, two excavations, five joints, four boundaries."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    geo = gmsh.model.geo
    at = {(i, j): geo.addPoint(i, j, 0) for i in range(COLUMNS + 1) for j in range(ROWS + 1)}
    level = {(i, j): geo.addLine(at[i, j], at[i + 1, j]) for i in range(COLUMNS) for j in range(ROWS + 1)}
    upright = {(i, j): geo.addLine(at[i, j], at[i, j + 1]) for i in range(COLUMNS + 1) for j in range(ROWS)}
    part = {}
    for i, j in ((i, j) for i in range(COLUMNS) for j in range(ROWS)):
        loop = geo.addCurveLoop([level[i, j], upright[i + 1, j], -level[i, j + 1], -upright[i, j]])
        part[i, j] = geo.addPlaneSurface([loop])
    geo.synchronize()
    for j, name in enumerate(("boundary:bottom", "joint:H1", "joint:H2", "boundary:top")):
        gmsh.model.addPhysicalGroup(1, [level[i, j] for i in range(COLUMNS)], name=name)
    for i, name in enumerate(("boundary:left", "joint:V1", "joint:V2", "joint:V3", "boundary:right")):
        gmsh.model.addPhysicalGroup(1, [upright[i, j] for j in range(ROWS)], name=name)
    gmsh.model.addPhysicalGroup(2, [part[k] for k in part if k[1] < 2], name="rock:granite")
    gmsh.model.addPhysicalGroup(2, [part[k] for k in part if k[1] == 2], name="rock:gneiss")
    for i in (1, 2):
        gmsh.model.addPhysicalGroup(2, [part[i, 1]], name=f"excavation:{i}")
    size = (2.6 * COLUMNS * ROWS / triangles) ** 0.5
    for option, value in (("MeshSizeMin", size), ("MeshSizeMax", size), ("Algorithm", 5), ("Binary", int(binary))):
        gmsh.option.setNumber(f"Mesh.{option}", value)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))
    gmsh.finalize()
