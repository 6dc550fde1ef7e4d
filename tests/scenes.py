"""Block systems and slow, obvious reference solutions that several tests share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.model.polygons import polygon_moments

LINEAR = bsm.Options(scheme="linear")
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
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.occ.addRectangle(0, 0, 0, width, height)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        place = np.zeros(int(tags.max()) + 1, dtype=int)
        place[tags.astype(int)] = np.arange(len(tags))
        corners = gmsh.model.mesh.getElementsByType(2)[1].astype(int).reshape(-1, 3)
        return xyz.reshape(-1, 3)[:, :2][place[corners]]
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


def framed(blocks: bsm.Blocks, width: float, height: float) -> bsm.Blocks:
    """Return the blocks of a rectangle with its four sides as boundaries."""
    off = 1e-6 * max(width, height)
    return (
        blocks.with_boundary("left", lambda x, y: x < off)
        .with_boundary("right", lambda x, y: x > width - off)
        .with_boundary("bottom", lambda x, y: y < off)
        .with_boundary("top", lambda x, y: y > height - off)
    )


def stress_on_sides(stress: np.ndarray) -> list[bsm.Traction]:
    """Return the tractions of a uniform stress on the four sides of a `framed` rectangle."""
    normals = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}
    return [bsm.Traction(boundary=side, traction=tuple(stress @ n)) for side, n in normals.items()]


@dataclass
class Reference:
    """A model solved with dense matrices and Lagrange multipliers."""

    K: np.ndarray
    displacement: np.ndarray
    reactions: np.ndarray
    face_forces: dict[tuple[int, int], np.ndarray]


def corner_row(centroid: np.ndarray, point: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return the row that turns (u, v, theta) into the displacement of a point in a direction (Wang Eq. 3.6)."""
    x, y = point - centroid
    return np.array([direction[0], direction[1], x * direction[1] - y * direction[0]])


def brute_faces(polygons: Sequence[np.ndarray]) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Return (i, j, start, end) of all common parts of edges, by comparing every edge with every other."""
    found = []
    for i, p in enumerate(polygons):
        for j in range(i + 1, len(polygons)):
            q = polygons[j]
            for a0, a1 in zip(p, np.roll(p, -1, axis=0), strict=True):
                for b0, b1 in zip(q, np.roll(q, -1, axis=0), strict=True):
                    length = np.hypot(*(a1 - a0))
                    t = (a1 - a0) / length
                    n = np.array([t[1], -t[0]])
                    if max(abs((b0 - a0) @ n), abs((b1 - a0) @ n)) > 1e-6 or (b1 - b0) @ t > 0:
                        continue
                    low, high = max(0.0, (b1 - a0) @ t), min(length, (b0 - a0) @ t)
                    if high - low > 1e-6:
                        found.append((i, j, a0 + low * t, a0 + high * t))
    return found


def dense_solution(
    polygons: Sequence[np.ndarray],
    stiffness: tuple[float, float],
    loads: np.ndarray,
    bars: Sequence[tuple[int, np.ndarray, float, float]],
) -> Reference:
    """Solve rigid blocks on joints; bars are (block, point, degrees, displacement)."""
    blocks = bsm.Blocks.from_polygons(polygons, rock="any")
    centroid, n = blocks.moments.centroid, 3 * len(polygons)
    K = np.zeros((n, n))
    springs = []
    for i, j, start, end in brute_faces(polygons):
        length = np.hypot(*(end - start))
        t = (end - start) / length
        for point in (start, end):
            for k, d in zip(stiffness, (np.array([t[1], -t[0]]), t), strict=True):
                row = np.zeros(n)
                row[3 * i : 3 * i + 3] = -corner_row(centroid[i], point, d)
                row[3 * j : 3 * j + 3] = corner_row(centroid[j], point, d)
                K += k * length / 2 * np.outer(row, row)
                springs.append((i, j, k * length / 2, row, d))
    C, w = np.zeros((len(bars), n)), np.zeros(len(bars))
    for r, (block, point, degrees, displacement) in enumerate(bars):
        direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        C[r, 3 * block : 3 * block + 3] = corner_row(centroid[block], np.asarray(point), direction)
        w[r] = displacement
    scale = K.diagonal().mean()  # keeps the two halves of the saddle point of one size
    system = np.block([[K / scale, C.T], [C, np.zeros((len(bars), len(bars)))]])
    right = np.concatenate([loads.reshape(-1) / scale, w])
    solution = np.linalg.lstsq(system, right, rcond=1e-13)[0]
    solution += np.linalg.lstsq(system, right - system @ solution, rcond=1e-13)[0]
    U = solution[:n]
    forces: dict[tuple[int, int], np.ndarray] = {}
    for i, j, k, row, d in springs:
        forces[i, j] = forces.get((i, j), np.zeros(2)) + k * (row @ U) * d  # on block i
    reactions = -(C.T @ solution[n:]).reshape(-1, 3) * scale
    return Reference(K=K, displacement=U.reshape(-1, 3), reactions=reactions, face_forces=forces)


def face_forces(contacts: bsm.results.ContactForces) -> dict[tuple[int, int], np.ndarray]:
    """Return the sum of the contact forces on the lower-numbered block of every pair of blocks."""
    forces: dict[tuple[int, int], np.ndarray] = {}
    for a, b, force in zip(contacts.block_a, contacts.block_b, contacts.force, strict=True):
        pair, sign = ((int(b), int(a)), 1.0) if b < a else ((int(a), int(b)), -1.0)
        forces[pair] = forces.get(pair, np.zeros(2)) + sign * force
    return forces
