"""Blocks at any place, systems of them, and a slow, obvious search for the tests of the compiled one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.contact.rules import RULES, Rules
from bsm_mesh.contact.search import ActiveContacts, Candidates, Outlines, corner_positions, detect_contacts
from tests.scenes.shapes import rectangle, square, turned


@dataclass
class Scene:
    """Blocks that can be put anywhere: `Blocks` refuses outlines that overlap, positions may."""

    outlines: Outlines
    position: np.ndarray
    blocks: bsm.Blocks

    @classmethod
    def of(cls, polygons: Sequence[np.ndarray], fixed: Sequence[int] = ()) -> Scene:
        """Return the blocks where their polygons lie."""
        blocks = bsm.Blocks.from_polygons(polygons, rock="r")
        flags = np.isin(np.arange(blocks.count), fixed)
        return cls(
            Outlines.of(blocks, flags), np.column_stack([blocks.moments.centroid, np.zeros(blocks.count)]), blocks
        )

    def moved(self, block: int, shift: Sequence[float] = (0.0, 0.0), degrees: float = 0.0, about=None) -> Scene:
        """Return the scene with one block turned about a point (or its centroid), then shifted."""
        position = self.position.copy()
        about = position[block, :2] if about is None else np.asarray(about)
        position[block, :2] = turned(position[block, :2] - about, degrees) + about + shift
        position[block, 2] += np.radians(degrees)
        return Scene(self.outlines, position, self.blocks)

    @property
    def placed(self) -> np.ndarray:
        """Corners (n, 2)."""
        return corner_positions(self.outlines, self.position)

    def polygon(self, block: int) -> np.ndarray:
        offsets = self.outlines.offsets
        return self.placed[offsets[block] : offsets[block + 1]]

    def normals(self, edges: np.ndarray) -> np.ndarray:
        """Return the outward normals of edges, (k, 2)."""
        d = self.placed[self.blocks.following[edges]] - self.placed[edges]
        return np.column_stack([d[:, 1], -d[:, 0]]) / np.hypot(*d.T)[:, None]

    def detect(
        self, active: ActiveContacts | None = None, band: float | None = None, rules: Rules = RULES
    ) -> Candidates:
        """Return the candidates; the band is 0.075 of the median size unless given."""
        band = 0.075 * self.outlines.size if band is None else band
        return detect_contacts(self.outlines, self.position, active or ActiveContacts.none(), band, rules=rules)

    def within_tolerance(self, found: Candidates) -> np.ndarray:
        """Return the rows in range whose gap is small enough to count as contact."""
        return np.flatnonzero(found.in_range & (found.gap <= 1e-3 * self.outlines.size))

    def activated(self, found: Candidates, rows=None, pressure: float | np.ndarray = 1.0) -> ActiveContacts:
        """Return rows (those that touch) as active contacts with a pressure."""
        rows = self.within_tolerance(found) if rows is None else np.asarray(rows)
        return ActiveContacts(
            pair=found.pair[rows],
            key=found.key[rows],
            pressure=np.broadcast_to(pressure, len(rows)),
            point=self.placed[found.corner[rows]],
            normal=self.normals(found.edge[rows]),
        )


def near_scene(polygons: Sequence[np.ndarray], position: np.ndarray) -> Scene:
    """Return blocks of any shapes, centroids put at the positions (n, 3): made apart, so that they may overlap."""
    apart = [p - p.mean(axis=0) + (1000.0 * k, 0.0) for k, p in enumerate(polygons)]
    scene = Scene.of(apart)
    return Scene(scene.outlines, position, scene.blocks)


def brute_candidates(scene: Scene, band: float, rules: Rules = RULES) -> dict[tuple[int, int], dict[str, float]]:
    """Return (corner, edge) of all corners that face an edge of another block, by the definition, one by one.

    The rules that look at one candidate alone are applied (convex, near, both edges away), no others.
    """
    outlines, found = scene.outlines, {}
    n = len(outlines.block_size)
    for a in range(n):
        for b in range(n):
            if a == b or (outlines.fixed[a] and outlines.fixed[b]):
                continue
            h = min(outlines.block_size[a], outlines.block_size[b], outlines.size)
            p, q = scene.polygon(a), scene.polygon(b)
            for i, v in enumerate(p):
                if (v < q.min(axis=0) - band).any() or (v > q.max(axis=0) + band).any():
                    continue
                arms = [p[(i + 1) % len(p)] - v, p[i - 1] - v]
                for j in range(len(q)):
                    before, start, end, after = (q[(j + k) % len(q)] for k in (-1, 0, 1, 2))
                    notches = _cross(start - before, end - start) < 0, _cross(end - start, after - end) < 0
                    row = _facing(v, arms, start, end, notches, h, band, rules)
                    if row is not None:
                        key = int(outlines.offsets[a]) + i, int(outlines.offsets[b]) + j
                        found[key] = row | {"h": h, "a": a, "b": b}
    return found


def _cross(p, q):
    return p[0] * q[1] - p[1] * q[0]


def _facing(v, arms, start, end, notches, h, band, rules):
    units = [arm / np.hypot(*arm) for arm in arms]
    t = (end - start) / np.hypot(*(end - start))
    n = np.array([t[1], -t[0]])
    length, gap, tangential = np.hypot(*(end - start)), (v - start) @ n, (v - start) @ t
    if _cross(*units) < -rules.flat or not -rules.max_penetration * h <= gap <= band:
        return None
    if np.hypot(max(0.0, -tangential, tangential - length), max(0.0, gap)) > band:
        return None
    lean = -min(unit @ n for unit in units)
    most = rules.entrance + rules.turn * band / h
    if lean > rules.entrance and (lean > most or gap < lean * rules.ahead * h):
        return None
    shares = []
    for arm, unit, runs in zip(arms, units, (-1, 1), strict=True):
        if abs(unit @ n) <= rules.parallel and runs * (unit @ t) >= 0:
            ends = sorted([tangential, tangential + arm @ t])
            shared = max(0.0, min(length, ends[1]) - max(0.0, ends[0]))
            shares.append((shared / abs(unit @ t), min(length, ends[1] - ends[0])))
    at_end = min(abs(tangential), abs(tangential - length)) < rules.min_overlap * h
    total = sum(s for s, _ in shares)
    end_to_end = bool(shares) and at_end and total < min(rules.min_overlap * h, 0.5 * max(shares)[1])
    slack = [h * (rules.detach_tol if notch else rules.rounding) for notch in notches]
    return {
        "gap": gap,
        "tangential": tangential,
        "edge_length": length,
        "length": total / 2 if total > 0 and not end_to_end else rules.corner_share * h,
        "parallel": bool(shares),
        "end_to_end": end_to_end,
        "in_range": -slack[0] <= tangential <= length + slack[1],
    }


def column() -> Scene:
    """Return two unit squares one on the other; the upper one is block 1."""
    return Scene.of([square(0, 0), square(0, 1)])


def delaunay_triangles(rng: np.random.Generator, n: int) -> list[np.ndarray]:
    """Return the triangles between n random points, slivers left out."""
    from scipy.spatial import Delaunay

    p = rng.random((n, 2)) * 5
    return [q for q in p[Delaunay(p).simplices] if np.abs(np.linalg.det(np.column_stack([q, np.ones(3)]))) > 1e-3]


def random_wall(rng: np.random.Generator, courses: int) -> list[np.ndarray]:
    """Return courses of bricks of random length: joints of neighbouring courses at least 0.05 m apart."""
    wall, below = [], np.array([0.0, 10.0])
    for j in range(courses):
        joints = rng.uniform(0.1, 9.9, 14)
        kept = [0.0]
        for x in np.sort(joints):
            if x - kept[-1] > 0.1 and np.abs(below - x).min() > 0.05:
                kept.append(x)
        below = np.array([*kept, 10.0])
        wall += [rectangle(x0, 0.5 * j, x1, 0.5 * j + 0.5) for x0, x1 in pairwise(below)]
    return wall


def jagged_interface(rng: np.random.Generator, depth: float) -> list[np.ndarray]:
    """Return two concave blocks that meet along a zigzag, and one beside them."""
    zigzag = np.column_stack([np.arange(9.0), rng.uniform(-depth, depth, 9)])
    lower = np.vstack([[(0, -2), (8, -2)], zigzag[::-1]])
    upper = np.vstack([zigzag, [(8, 2), (0, 2)]])
    return [lower, upper, rectangle(8, -2, 9, zigzag[-1, 1]), rectangle(8, zigzag[-1, 1], 9, 2)]
