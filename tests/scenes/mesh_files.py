"""Irregular meshes of one section in files of several formats: triangles, quadrilaterals, polygons."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

SLOPE = np.array([(0, 0), (24, 0), (24, 14), (13, 14), (8, 6), (0, 6)], dtype=float)  # outline of the section [m]
SHAPES = ("triangles", "quads", "polygons", "jittered")
FORMATS = {  # in which they are written; quadrilaterals have a few triangles among them
    **dict.fromkeys(("triangles", "jittered"), ("msh", "msh22", "vtu", "inp")),
    "quads": ("vtu", "msh22", "inp"),
    "polygons": ("vtu",),
}


Cells = list[tuple[str, np.ndarray]]


def two_squares(model: Any) -> tuple[dict[tuple[int, int], int], list[int]]:
    """Add two unit squares of eight triangles each to Gmsh's model; return their level and their upright lines."""
    geo, mesh = model.geo, model.mesh
    at = {(x, y): geo.addPoint(x, y, 0) for x in range(3) for y in range(2)}
    level = {(x, y): geo.addLine(at[x, y], at[x + 1, y]) for x in range(2) for y in range(2)}
    upright = [geo.addLine(at[x, 0], at[x, 1]) for x in range(3)]
    for x in range(2):
        geo.addPlaneSurface([geo.addCurveLoop([level[x, 0], upright[x + 1], -level[x, 1], -upright[x]])], x + 1)
    geo.synchronize()
    for curve in [*level.values(), *upright]:
        mesh.setTransfiniteCurve(curve, 3)
    for surface in (1, 2):
        mesh.setTransfiniteSurface(surface)
    return level, upright


def write_mesh(shape: str, format_: str, size: float, seed: int, folder: Path) -> Path:
    """Return the path of a mesh of the section; elements have about this size [m]."""
    if shape == "polygons":
        points, cells = _voronoi(size, seed)
    elif shape == "jittered":
        points, cells = _jittered(size, seed)
    else:
        points, cells = _by_gmsh(size, seed, quads=shape == "quads")
    path = folder / f"mesh.{'msh' if format_ == 'msh22' else format_}"
    _write(path, format_, points, cells)
    return path


def _by_gmsh(size: float, seed: int, *, quads: bool) -> tuple[np.ndarray, Cells]:
    from bsm_mesh.geometries import gmsh_session

    rng = np.random.default_rng(seed)
    with gmsh_session() as gmsh:
        geo = gmsh.model.geo
        tags = [geo.addPoint(x, y, 0, size * rng.uniform(0.5, 1.5)) for x, y in SLOPE]
        lines = [geo.addLine(a, b) for a, b in zip(tags, [*tags[1:], tags[0]], strict=True)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        gmsh.option.setNumber("Mesh.Algorithm", [5, 6, 8][seed % 3])
        if quads:
            gmsh.model.mesh.setRecombine(2, surface)
        gmsh.model.mesh.generate(2)
        numbers, coordinates, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(numbers)
        points = coordinates.reshape(-1, 3)[order, :2]
        kinds, _, nodes = gmsh.model.mesh.getElements(2)
        names = {2: ("triangle", 3), 3: ("quad", 4)}
        cells = [
            (names[kind][0], np.searchsorted(numbers[order], flat).reshape(-1, names[kind][1]))
            for kind, flat in zip(kinds, nodes, strict=True)
        ]
    return points, cells


def _voronoi(size: float, seed: int) -> tuple[np.ndarray, Cells]:
    """Return Voronoi cells clipped to the section."""
    import shapely

    rng = np.random.default_rng(seed)
    outline = shapely.Polygon(SLOPE)
    low, high = SLOPE.min(axis=0), SLOPE.max(axis=0)
    seeds = rng.uniform(low, high, (int(np.prod(high - low) / size**2), 2))
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.multipoints(seeds), extend_to=outline))
    clipped = shapely.get_parts(shapely.intersection(cells, outline))
    rings = [shapely.get_coordinates(shapely.orient_polygons(cell).exterior)[:-1] for cell in clipped]
    points, inverse = np.unique(np.round(np.concatenate(rings), 9), axis=0, return_inverse=True)
    numbers = np.split(inverse.reshape(-1), np.cumsum([len(ring) for ring in rings])[:-1])
    return points, [("polygon", ring[None]) for ring in numbers]


def _jittered(size: float, seed: int) -> tuple[np.ndarray, Cells]:
    """Return a regular grid over a rectangle, its inner nodes moved by a hundredth of an element and more."""
    rng = np.random.default_rng(seed)
    x, y = (np.linspace(0, end, max(3, round(end / size) + 1)) for end in (24.0, 14.0))
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    points[1:-1, 1:-1] += size * rng.choice([0.005, 0.05, 0.2]) * rng.uniform(-1, 1, points[1:-1, 1:-1].shape)
    node = np.arange(points[..., 0].size).reshape(len(x), len(y))
    quads = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1).reshape(-1, 4)
    return points.reshape(-1, 2), [("quad", quads)]


def _write(path: Path, format_: str, points: np.ndarray, cells: Cells) -> None:
    import meshio

    flat = np.column_stack([points, np.zeros(len(points))])
    mesh = meshio.Mesh(flat, cells)
    if format_ == "msh22":
        mesh.write(path, file_format="gmsh22")
    elif format_ == "msh":
        mesh.write(path, file_format="gmsh")
    else:
        mesh.write(path)
