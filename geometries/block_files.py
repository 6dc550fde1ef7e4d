"""Blocks written as a Gmsh mesh with physical groups: few elements a block, or meshed to a size.

MSH has no polygons. `write_blocks` therefore divides each block into triangles around its centroid, with nodes on its
outline only where another block has a corner; read with ``[mesh] blocks = "regions"`` the elements between joints are
put together again, and each block is the polygon that it was.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.geometries import physical_groups
from bsm_mesh.geometries.cutting.block_cut import BlockCut
from bsm_mesh.geometries.cutting.fans import divide_faces
from bsm_mesh.geometries.cutting.pieces import IntArray
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray
from bsm_mesh.geometries.parameters import Checks
from bsm_mesh.geometries.session import gmsh_session, name_groups, write_mesh

LINE, TRIANGLE = 1, 2  # Gmsh's numbers of element types
MOST_MESHED = 20_000


def write_blocks(cut: BlockCut, path: str | os.PathLike[str]) -> Path:
    """Write the blocks with as few elements as may be, to be read with ``blocks = "regions"``; return the path.

    Parameters
    ----------
    cut : BlockCut
        The blocks.
    path : path
        The file, ``.msh``.

    Raises
    ------
    GeometryError
        Where the file cannot be written.
    """
    checks = Checks("write_blocks")
    checks.a_thing(BlockCut, cut=cut)
    checks.raise_faults()
    points, triangles, block = divide_faces(cut)
    groups, of_group = surface_groups(cut)
    with gmsh_session("blocks") as gmsh:
        surfaces = add_surfaces(gmsh, points, groups, {TRIANGLE: (triangles, of_group[block])})
        curves = {name: [add_lines(gmsh, edges)] for name, edges in _curve_groups(cut).items()}
        gmsh.model.mesh.reclassifyNodes()
        name_groups(surfaces | curves)
        return write_mesh(path)


def mesh_blocks(
    cut: BlockCut,
    path: str | os.PathLike[str],
    *,
    size: float,
    quads: bool = False,
    sizes: Sequence[tuple[tuple[float, float], float, float]] = (),
) -> Path:
    """Mesh every block into elements of about a size and write them; return the path.

    Joints that end in the rock are lines of the mesh too.

    Parameters
    ----------
    cut : BlockCut
        The blocks; some ten thousand at most.
    path : path
        The file, ``.msh``.
    size : float
        Size of the elements [m].
    quads : bool
        Quadrilaterals where they fit.
    sizes : sequence of ((x, y), radius, size)
        Within `radius` of each of these points elements of that size [m], growing to `size` over twice the radius.

    Raises
    ------
    GeometryError
        For more blocks than can be meshed, and where the file cannot be written.
    """
    checks = Checks("mesh_blocks")
    checks.a_thing(BlockCut, cut=cut)
    checks.positive(size=size)
    checks.true_or_false(quads=quads)
    checks.raise_faults()
    if cut.count > MOST_MESHED:
        raise GeometryError(f"{cut.count} blocks are too many to mesh; write_blocks takes any number")
    groups, of_group = surface_groups(cut)
    with gmsh_session("blocks") as gmsh:
        curve_of = _add_geometry(gmsh, cut)
        if sizes:
            _grade(gmsh, size, sizes)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.option.setNumber("Mesh.RecombineAll", int(quads))
        gmsh.model.mesh.generate(2)
        surfaces: dict[str, list[int]] = {}
        for number, names in enumerate(groups):
            for name in names:
                surfaces.setdefault(name, []).extend((np.flatnonzero(of_group == number) + 1).tolist())
        curves = {
            name: [curve_of[a, b] for a, b in np.sort(edges, axis=1).tolist()]
            for name, edges in _curve_groups(cut).items()
        }
        name_groups(surfaces | curves)
        return write_mesh(path)


def surface_groups(cut: BlockCut) -> tuple[list[list[str]], IntArray]:
    """Return the groups of each kind of block, by rock and excavations, and the kind of every block."""
    member = np.zeros((cut.count, len(cut.excavations)), dtype=np.int64)
    for k, blocks in enumerate(cut.excavations.values()):
        member[blocks, k] = 1
    kinds, of_block = np.unique(np.column_stack([cut.rock, member]), axis=0, return_inverse=True)
    names = [
        [physical_groups.rock(cut.rock_names[rock])]
        + [physical_groups.excavation(name) for name, there in zip(cut.excavations, inside, strict=True) if there]
        for rock, *inside in kinds.tolist()
    ]
    return names, of_block.reshape(-1)


def _curve_groups(cut: BlockCut) -> dict[str, IntArray]:
    groups = {physical_groups.joint(name): edges for name, edges in cut.joints.items()}
    for name, edges in cut.dead.items():
        key = physical_groups.joint(name)
        groups[key] = np.concatenate([groups[key], edges]) if key in groups else edges
    return groups | {physical_groups.boundary(name): edges for name, edges in cut.boundaries.items()}


def add_surfaces(
    gmsh: Any, points: FloatArray, groups: list[list[str]], elements: Mapping[int, tuple[IntArray, IntArray]]
) -> dict[str, list[int]]:
    """Add points and a surface a kind of block; return the tags of each group's surfaces.

    Of each of Gmsh's element types: points of the elements (k, corners), from 0, and their kinds of block (k,).
    """
    surfaces: dict[str, list[int]] = {}
    for number, names in enumerate(groups):
        surface = gmsh.model.addDiscreteEntity(2)
        if number == 0:
            flat = np.column_stack([points, np.zeros(len(points))]).ravel()
            gmsh.model.mesh.addNodes(2, surface, np.arange(1, len(points) + 1), flat)
        for shape, (nodes, kind) in elements.items():
            chosen = nodes[kind == number]
            if len(chosen):
                gmsh.model.mesh.addElementsByType(surface, shape, [], (chosen + 1).ravel())
        for name in names:
            surfaces.setdefault(name, []).append(surface)
    return surfaces


def add_lines(gmsh: Any, edges: IntArray) -> int:
    """Add a curve of lines between points (k, 2), counted from 0, and return its tag."""
    curve: int = gmsh.model.addDiscreteEntity(1)
    gmsh.model.mesh.addElementsByType(curve, LINE, [], (edges + 1).ravel())
    return curve


def _add_geometry(gmsh: Any, cut: BlockCut) -> dict[tuple[int, int], int]:
    """Add a plane surface a block, tagged by its number from 1, and return the curve between each two points."""
    geo = gmsh.model.geo
    curve_of: dict[tuple[int, int], int] = {}
    added: set[int] = set()

    def curve(a: int, b: int) -> int:
        for point in {a, b} - added:
            geo.addPoint(*cut.points[point], 0.0, tag=point + 1)
            added.add(point)
        key = (a, b) if a < b else (b, a)
        if key not in curve_of:
            curve_of[key] = geo.addLine(key[0] + 1, key[1] + 1)
        return curve_of[key] if a < b else -curve_of[key]

    for block in range(cut.count):
        loops = []
        for ring in range(cut.faces[block], cut.faces[block + 1]):
            nodes = cut.corners[cut.rings[ring] : cut.rings[ring + 1]].tolist()
            loops.append(geo.addCurveLoop([curve(a, b) for a, b in zip(nodes, [*nodes[1:], nodes[0]], strict=True)]))
        geo.addPlaneSurface(loops, tag=block + 1)
    pieces = np.concatenate([np.empty((0, 2), np.int64), *cut.dead.values()])
    tags = [abs(curve(a, b)) for a, b in pieces.tolist()]
    geo.synchronize()
    if len(pieces):
        for block, inside in _blocks_around(cut, pieces).items():
            gmsh.model.mesh.embed(1, [tags[k] for k in inside], 2, block + 1)
    return curve_of


def _blocks_around(cut: BlockCut, pieces: IntArray) -> Mapping[int, list[int]]:
    """Return the numbers of the pieces in each block that has any."""
    import shapely

    from bsm_mesh.geometries.cutting.faces import Faces

    polygons = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces).polygons(cut.points)
    piece, block = shapely.STRtree(polygons).query(shapely.points(cut.points[pieces].mean(axis=1)), "within")
    found: dict[int, list[int]] = {}
    for each, around in zip(piece.tolist(), block.tolist(), strict=True):
        found.setdefault(around, []).append(each)
    return found


def _grade(gmsh: Any, size: float, sizes: Sequence[tuple[tuple[float, float], float, float]]) -> None:
    fields = []
    for (x, y), radius, fine in sizes:
        field = gmsh.model.mesh.field.add("Ball")
        values = {"XCenter": x, "YCenter": y, "Radius": radius, "Thickness": 2 * radius, "VIn": fine, "VOut": size}
        for key, value in values.items():
            gmsh.model.mesh.field.setNumber(field, key, value)
        fields.append(field)
    least = gmsh.model.mesh.field.add("Min")
    gmsh.model.mesh.field.setNumbers(least, "FieldsList", fields)
    gmsh.model.mesh.field.setAsBackgroundMesh(least)
