"""Polygons of blocks: rectangles, walls, triangles, Voronoi cells."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from bsm_mesh.model.polygons import polygon_moments

SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])


def square(x: float, y: float) -> np.ndarray:
    """Return the unit square with its lower left corner at (x, y)."""
    return SQUARE + np.array([x, y])


def rectangle(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)


def grid(xs: int | Sequence[float], ys: int | Sequence[float]) -> list[np.ndarray]:
    """Return the cells between the given lines (or unit cells), row by row from below."""
    xs = np.arange(xs + 1.0) if isinstance(xs, int) else np.asarray(xs, dtype=float)
    ys = np.arange(ys + 1.0) if isinstance(ys, int) else np.asarray(ys, dtype=float)
    return [rectangle(xs[i], ys[j], xs[i + 1], ys[j + 1]) for j in range(len(ys) - 1) for i in range(len(xs) - 1)]


def running_bond(courses: int, bricks: int, length: float = 1.0, height: float = 0.5) -> list[np.ndarray]:
    """Return a wall of flush ends: every second course has half a brick at both ends."""
    cells = []
    for j in range(courses):
        shift = [0.0, *(np.arange(bricks) + 0.5), float(bricks)] if j % 2 else np.arange(bricks + 1.0)
        lines = length * np.asarray(shift)
        cells += [rectangle(a, j * height, b, (j + 1) * height) for a, b in pairwise(lines)]
    return cells


def turned(points: np.ndarray, degrees: float, shift: Sequence[float] = (0.0, 0.0)) -> np.ndarray:
    """Return points turned counter-clockwise about the origin, then moved."""
    a = np.radians(degrees)
    turn = np.array([(np.cos(a), -np.sin(a)), (np.sin(a), np.cos(a))])
    return np.asarray(points, dtype=float) @ turn.T + shift


def gmsh_triangles(width: float, height: float, size: float) -> np.ndarray:
    """Return the triangles (n, 3, 2) of a rectangle meshed by Gmsh."""
    return _gmsh_cells(width, height, size, corners=3)


def gmsh_quads(width: float, height: float, size: float) -> np.ndarray:
    """Return the quadrilaterals (n, 4, 2) into which Gmsh joins the triangles of a rectangle."""
    return _gmsh_cells(width, height, size, corners=4)


def _gmsh_cells(width: float, height: float, size: float, corners: int) -> np.ndarray:
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.RecombineAll", int(corners == 4))
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.occ.addRectangle(0, 0, 0, width, height)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        place = np.zeros(int(tags.max()) + 1, dtype=int)
        place[tags.astype(int)] = np.arange(len(tags))
        cells = gmsh.model.mesh.getElementsByType(corners - 1)[1].astype(int).reshape(-1, corners)  # types 2 and 3
        return xyz.reshape(-1, 3)[:, :2][place[cells]]
    finally:
        gmsh.finalize()


def voronoi(
    width: float, height: float, count: int, rounds: int = 30, circle: tuple[tuple[float, float], float] | None = None
) -> list[np.ndarray]:
    """Return about equal Voronoi cells of a rectangle (Lloyd).

    Mirrored seeds make its sides edges of cells; seeds mirrored in a circle (centre, radius) give edges along it.
    """
    from scipy.spatial import Voronoi

    seeds = np.random.default_rng(1).uniform(size=(count, 2)) * (width, height)
    for number in range(rounds + 1):
        if circle and number > rounds // 2:
            seeds = _mirrored_in(np.array(circle[0]), circle[1], seeds, 1.2 * np.sqrt(width * height / count))
        x, y = seeds.T
        sides = [(-x, y), (2 * width - x, y), (x, -y), (x, 2 * height - y)]
        found = Voronoi(np.concatenate([seeds, *(np.column_stack(pair) for pair in sides)]))
        cells = [found.vertices[found.regions[found.point_region[k]]] for k in range(len(seeds))]
        cells = [c[np.argsort(np.arctan2(*(c - c.mean(axis=0)).T[::-1]))] for c in cells]
        offsets = np.cumsum([0, *map(len, cells)])
        seeds = polygon_moments(np.concatenate(cells), offsets).centroid
    return [np.clip(c, 0, (width, height)) for c in cells]


def _mirrored_in(centre: np.ndarray, radius: float, seeds: np.ndarray, band: float) -> np.ndarray:
    """Return the seeds outside the circle and the mirror images of those within `band` of it, as far inside."""
    distance = np.hypot(*(seeds - centre).T)
    outside, near = seeds[distance > radius], (distance > radius) & (distance < radius + band)
    inward = (2 * radius / distance[near] - 1)[:, None] * (seeds[near] - centre)
    deep = seeds[distance < radius - band]
    return np.concatenate([outside, centre + inward, deep])
