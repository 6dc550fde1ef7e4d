"""The faces of blocks where they have come to, and the polygons in which those of different blocks touch there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.polygons import next_corner, owner_of_corner
from bsm_mesh.movements import turned
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
from bsm_mesh.three_d.blocks.polygons import bent_corners, sums, vector_areas
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.clipping import PARALLEL, clipped, facing_faces, near_blocks
from bsm_mesh.three_d.contacts.contact_set import depths, points_of, reaches
from bsm_mesh.three_d.contacts.history import PolygonPoints, keys_of

SUNK = 0.1  # of the thinner block: faces that overlap by more have come from the other side


@dataclass(frozen=True, eq=False, kw_only=True)
class Surfaces:
    """The faces of all blocks, in their order, corners in line left out.

    Attributes
    ----------
    blocks : Polyhedra
        The blocks.
    rule : str
        Contact points, as ``Model.contact_points``.
    """

    blocks: Polyhedra
    rule: str

    @cached_property
    def _sides(self) -> tuple[IntArray, IntArray, IntArray, FloatArray, IntArray]:
        """Face and block of every surface, first surface of every block, corners counter-clockwise, offsets."""
        blocks = self.blocks
        first, second = blocks.face_blocks.T
        face = np.concatenate([np.flatnonzero((first != second) & (side >= 0)) for side in (first, second)])
        back = np.arange(len(face)) >= ((first != second) & (first >= 0)).sum()
        block = np.where(back, second[face], first[face])
        order = np.lexsort((face, block))
        face, back, block = face[order], back[order], block[order]
        sizes = np.diff(blocks.face_offsets)[face]
        starts = np.cumsum(sizes) - sizes
        within = np.arange(sizes.sum()) - np.repeat(starts, sizes)
        within = np.where(np.repeat(back, sizes), np.repeat(sizes, sizes) - 1 - within, within)
        corners = blocks.vertices[blocks.face_vertices[np.repeat(blocks.face_offsets[face], sizes) + within]]
        offsets = np.append(starts, sizes.sum())
        bent = bent_corners(corners, offsets)
        kept = np.bincount(owner_of_corner(offsets)[bent], minlength=len(face))
        return (
            face.astype(np.int32),
            block.astype(np.int32),
            np.searchsorted(block, np.arange(blocks.count + 1)),
            corners[bent],
            np.concatenate([[0], np.cumsum(kept)]),
        )

    def polygons(
        self, position: FloatArray, moves: BoolArray, held: BoolArray, band: float, narrow: float
    ) -> PolygonPoints:
        """Return the points of polygons of faces that face each other at a position (n, 6).

        They are nearer than `band` and wider than `narrow` [m].
        One block of each pair `moves` (n,); two blocks that supports hold (n,) are no pair. Every point lies on the
        block with which it moves.
        """
        face, block, start, given, offsets = self._sides
        owner, centroid = owner_of_corner(offsets), self.blocks.moments.centroid
        of = block[owner]
        corners = centroid[of] + position[of, :3] + turned(given - centroid[of], position[of, 3:])
        full = np.diff(offsets) >= 3
        areas = vector_areas(corners, offsets)
        size = np.linalg.norm(areas, axis=1)
        normal = np.divide(areas, size[:, None], out=np.zeros_like(areas), where=(full & (size > 0))[:, None])
        low, high = (bound.reduceat(corners, offsets[:-1]) for bound in (np.minimum, np.maximum))
        boxes = np.minimum.reduceat(low, start[:-1]), np.maximum.reduceat(high, start[:-1])
        pairs = near_blocks(*boxes, moves, band)
        pairs = pairs[~(held[pairs[:, 0]] & held[pairs[:, 1]])]
        faces = facing_faces(pairs, start, normal, low, high, band)
        slide = self._slides(position, corners[offsets[faces[:, 0]]], block[faces])
        sizes, rows = clipped(faces, corners, offsets, normal, slide)
        faces, sizes = faces[sizes > 0], sizes[sizes > 0]
        rows, faces, sizes = _touching(rows, faces, sizes, (block, start, corners, offsets), band, narrow)
        kept = _facing_best(faces, block, normal)
        rows, faces, sizes = rows[np.repeat(kept, sizes)], faces[kept], sizes[kept]
        return self._points(position, rows, (face, block, corners, offsets, normal), faces, sizes)

    def _points(
        self,
        position: FloatArray,
        rows: FloatArray,
        surfaces: tuple[IntArray, IntArray, FloatArray, IntArray, FloatArray],
        faces: IntArray,
        sizes: IntArray,
    ) -> PolygonPoints:
        """Return the contact points of polygons: rows as `clipped` gives them, both surfaces, corners of each."""
        face, block, corners, offsets, normal = surfaces
        one, other = faces.T
        polygons = ContactPolygons(
            block_a=block[one],
            block_b=block[other],
            joint=_joints(self.blocks, face[one], face[other]),
            face=face[other],
            corners=rows[:, :3],
            offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        )
        points, slot = points_of(polygons, self.rule)
        polygon, mean = points.polygon, polygons.normal
        on_a, on_b = (_over(polygons.centroid, mean, corners[offsets[side]], normal[side]) for side in (one, other))
        found = rows
        if len(polygon) > len(rows):  # with centroids
            share = points.area[: len(rows)] * (rows[:, 13] - 0.5)
            with_b = sums(polygon[: len(rows)], share, len(sizes)) > 0
            flat = (np.cross(normal[one], normal[other]) ** 2).sum(axis=1) < PARALLEL**2
            own = np.where(with_b[:, None], -normal[one], normal[other])
            across = np.where(flat[:, None], own, mean)
            gap = np.einsum("ij,ij->i", on_a - on_b, across)
            on_a = np.where(with_b[:, None], on_b + gap[:, None] * across, on_a)
            on_b = on_a - gap[:, None] * across
            found = np.vstack([rows, np.column_stack([polygons.centroid, on_a, on_b, across, gap, with_b])])
        a, b = polygons.block_a[polygon], polygons.block_b[polygon]
        centroid = self.blocks.moments.centroid
        placed = centroid + position[:, :3]
        arms = [turned(found[:, c : c + 3] - placed[i], -position[i, 3:]) for c, i in ((3, a), (6, b))]
        apart = centroid[a] + arms[0] - centroid[b] - arms[1]
        made = PolygonPoints(
            key=keys_of(face[one][polygon], face[other][polygon], slot),
            block_a=a,
            block_b=b,
            geometry=np.hstack([*arms, turned(found[:, 9:12], -position[b, 3:]), apart]),
            found_gap=found[:, 12],
            reach=reaches(polygons)[polygon],
            area=points.area,
            depth=depths(polygons, placed)[polygon],
            joint=polygons.joint[polygon],
        )
        made = made.turned_over(found[:, 13] > 0, turned(-found[:, 9:12], -position[a, 3:]))
        return made.some(np.argsort(made.key, kind="stable"))

    def _slides(self, position: FloatArray, point: FloatArray, pair: IntArray) -> FloatArray:
        """Return the movements of the first of pairs of blocks (q, 2) against the second at points, (q, 3) [m]."""
        centroid = self.blocks.moments.centroid
        placed = centroid + position[:, :3]
        given = [centroid[i] + turned(point - placed[i], -position[i, 3:]) for i in pair.T]
        slide: FloatArray = turned(given[1] - given[0], position[pair[:, 1], 3:])
        return slide


def _touching(
    rows: FloatArray,
    faces: IntArray,
    sizes: IntArray,
    surfaces: tuple[IntArray, IntArray, FloatArray, IntArray],
    band: float,
    narrow: float,
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return rows, surfaces and sizes of polygons within `band`, wider than `narrow`, and not behind a block."""
    block, start, corners, offsets = surfaces
    if not len(faces):
        return rows, faces, sizes
    first = np.cumsum(sizes) - sizes
    least = np.minimum.reduceat(rows[:, 12], first)
    base, ends = rows[:, :3], np.append(first, len(rows))
    area = np.linalg.norm(vector_areas(base, ends), axis=1)
    around = np.add.reduceat(np.linalg.norm(base[next_corner(ends)] - base, axis=1), first)
    wide = 2 * area > narrow * around  # a narrow one is the elastic penetration of a face past another's edge
    near = (np.abs(least) <= band) & wide
    rows, faces, sizes, least = rows[np.repeat(near, sizes)], faces[near], sizes[near], least[near]
    if not len(faces):
        return rows, faces, sizes
    mean = np.add.reduceat(rows[:, 9:12], np.cumsum(sizes) - sizes)
    mean /= np.linalg.norm(mean, axis=1)[:, None]
    thin = np.full(len(faces), np.inf)
    for side in (0, 1):
        of = block[faces[:, side]]
        begin, end = offsets[start[of]], offsets[start[of + 1]]
        owner = np.repeat(np.arange(len(of)), end - begin)
        firsts = np.cumsum(end - begin) - (end - begin)
        heights = np.einsum(
            "ij,ij->i", corners[np.repeat(begin - firsts, end - begin) + np.arange(len(owner))], mean[owner]
        )
        thin = np.minimum(thin, np.maximum.reduceat(heights, firsts) - np.minimum.reduceat(heights, firsts))
    good = least >= -SUNK * thin
    return rows[np.repeat(good, sizes)], faces[good], sizes[good]


def _facing_best(faces: IntArray, block: IntArray, normal: FloatArray) -> BoolArray:
    """Return which pairs of surfaces (q, 2) face each other hardly worse than others of one face and the other block.

    A face that touches an edge of a block meets both faces there, and counts once. Pairs that share nothing are none:
    the bottom of a block that slides down to a floor faces it best, but lies over the slope.
    """
    tilt = np.arccos(np.clip(-np.einsum("ij,ij->i", *normal[faces.T]), -1.0, 1.0))
    best = np.ones(len(faces), dtype=bool)
    for side in (0, 1):
        key = (faces[:, side] << 32) | block[faces[:, 1 - side]]
        _, of = np.unique(key, return_inverse=True)
        least = np.full(len(faces), np.inf)
        np.minimum.at(least, of, tilt)
        best &= tilt <= least[of] + PARALLEL
    return best


def _over(point: FloatArray, mean: FloatArray, corner: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the points of faces, by a corner and a normal of each, that lie over points along `mean`, (k, 3)."""
    height = np.einsum("ij,ij->i", corner - point, normal) / np.einsum("ij,ij->i", mean, normal)
    found: FloatArray = point + height[:, None] * mean
    return found


def _joints(blocks: Polyhedra, one: IntArray, other: IntArray) -> IntArray:
    """Return the joints of pairs of faces: that of the second, else of the first, (k,); of none -1."""
    joint: IntArray = np.where(blocks.face_joint[other] >= 0, blocks.face_joint[other], blocks.face_joint[one])
    return joint
