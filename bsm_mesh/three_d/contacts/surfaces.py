"""The faces of blocks where they have come to, and the polygons in which those of different blocks touch there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.edges import pairs_of
from bsm_mesh.model.polygons import next_corner, owner_of_corner
from bsm_mesh.movements import turned
from bsm_mesh.three_d.blocks.cell_sides import CellSides, sides_of_cells
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
from bsm_mesh.three_d.blocks.placed_cells import PlacedCells
from bsm_mesh.three_d.blocks.polygons import bent_corners, spread, sums, vector_areas
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.beside_flats import beside_flats
from bsm_mesh.three_d.contacts.clipping import PARALLEL, clipped, facing_faces, near_blocks
from bsm_mesh.three_d.contacts.contact_set import depths, points_of, reaches
from bsm_mesh.three_d.contacts.history import SLOTS, PolygonPoints, keys_of
from bsm_mesh.three_d.contacts.inner_edges import at_inner_edges, over_points


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

        They are nearer than `band`, wider than `narrow` [m], and no deeper than their cells overlap. An edge over
        an edge, or a corner over a face, shares no area with it. So corners of faces that meet at an angle represent a
        part of the smaller block's size squared, at least.
        One block of each pair `moves` (n,); two blocks that supports hold (n,) are no pair. Every point lies on the
        block with which it moves.
        """
        face, block, _, _, offsets = self._sides
        corners, normal, faces = self._facing_each_other(position, moves, held, band)
        slide = self._slides(position, corners[offsets[faces[:, 0]]], block[faces])
        sizes, rows = clipped(faces, corners, offsets, normal, slide)
        faces, sizes, slide = faces[sizes > 0], sizes[sizes > 0], slide[sizes > 0]
        near = _are_near(rows, sizes, band, narrow)
        rows, faces, sizes, slide = rows[np.repeat(near, sizes)], faces[near], sizes[near], slide[near]
        flat, touch = are_flat(*normal[faces.T]), np.abs(_least_gaps(rows, sizes)) <= narrow
        there = corners[offsets[faces]], normal[faces]
        rows = at_inner_edges(rows, sizes, block[faces], (flat, touch), there, slide, narrow)
        least = _least_gaps(rows, sizes)
        overlap = self._overlaps(position, self._cell[faces], least < -narrow)
        kept = least >= -overlap - narrow  # deeper ones have come from the other side
        kept &= ~beside_flats(rows, sizes, block[faces], flat, touch, narrow)
        rows, faces, sizes = rows[np.repeat(kept, sizes)], faces[kept], sizes[kept]
        return self._points(position, rows, (face, block, corners, offsets, normal), faces, sizes)

    def _facing_each_other(
        self, position: FloatArray, moves: BoolArray, held: BoolArray, band: float
    ) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return corners and normals of the surfaces at a position, and pairs (q, 2) of them that face each other."""
        _, block, start, given, offsets = self._sides
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
        pairs = pairs[~held[pairs].all(axis=1)]
        return corners, normal, facing_faces(pairs, start, normal, low, high, band)

    def near_free_faces(self, position: FloatArray, held: BoolArray, reach: float, known: IntArray) -> IntArray:
        """Return the pairs of blocks (k, 2) with free faces within `reach` [m] of each other; none of the `known`.

        The known ones are numbers of pairs, as `pairs_of`.
        """
        face, block, *_ = self._sides
        *_, faces = self._facing_each_other(position, ~held, held, reach)
        pairs = np.unique(np.sort(block[faces[self.are_free(*face[faces].T)]], axis=1), axis=0)
        found: IntArray = pairs[~np.isin(pairs_of(*pairs.T), known)]
        return found

    @cached_property
    def _cell_sides(self) -> CellSides:
        return sides_of_cells(self.blocks)

    @cached_property
    def _cell(self) -> IntArray:
        """Cell of every surface."""
        face, block, *_ = self._sides
        cells = self.blocks.face_cells[face]
        of_first = self.blocks.face_blocks[face, 0] == block
        cell: IntArray = np.where(of_first, cells[:, 0], cells[:, 1])
        return cell

    def _overlaps(self, position: FloatArray, cells: IntArray, asked: BoolArray) -> FloatArray:
        """Return by how much pairs of cells (q, 2) overlap along their faces' normals [m]; inf where not `asked`."""
        depth = np.full(len(cells), np.inf)
        if asked.any():
            pairs, row = np.unique(cells[asked], axis=0, return_inverse=True)
            depth[asked] = PlacedCells.of(self.blocks, self._cell_sides, position).depths(pairs)[row.reshape(-1)]
        return depth

    def are_free(self, one: IntArray, other: IntArray) -> BoolArray:
        """Return whether both faces (k,) of pairs are of one block alone, as given, (k,)."""
        pair = self.blocks.face_blocks[np.stack([one, other])]  # (2, k, 2)
        both: BoolArray = (pair < 0).any(axis=2).all(axis=0)
        return both

    def share_corners(self, one: IntArray, other: IntArray) -> BoolArray:
        """Return whether faces (k,) share a corner as given, (k,): their blocks meet in a node of the mesh."""
        point, first, sizes = self.blocks.face_vertices, self.blocks.face_offsets, np.diff(self.blocks.face_offsets)
        pair, row = np.unique(np.column_stack([one, other]), axis=0, return_inverse=True)
        number = [np.repeat(np.arange(len(pair)), sizes[side]) for side in pair.T]
        corner = [point[spread(first[side], sizes[side])] for side in pair.T]
        keys = [n.astype(np.int64) << 32 | c for n, c in zip(number, corner, strict=True)]
        shared = np.zeros(len(pair), dtype=bool)
        shared[number[0][np.isin(keys[0], keys[1])]] = True
        of_each: BoolArray = shared[row.reshape(-1)]
        return of_each

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
            joint=self._joints(faces, normal),
            face=face[other],
            corners=rows[:, :3],
            offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        )
        points, slot = points_of(polygons, self.rule)
        polygon, mean = points.polygon, polygons.normal
        on_a, on_b = (
            over_points(polygons.centroid, mean, corners[offsets[side]], normal[side]) for side in (one, other)
        )
        found = rows
        flat, size = are_flat(normal[one], normal[other]), self.blocks.moments.size
        least = RULES.corner_share * np.minimum(size[polygons.block_a], size[polygons.block_b]) ** 2
        bare = (slot < SLOTS - 1) & ~flat[polygon]  # corners where faces meet at an angle
        area = np.where(bare, np.maximum(points.area, least[polygon]), points.area)
        if len(polygon) > len(rows):  # with centroids
            share = points.area[: len(rows)] * (rows[:, 13] - 0.5)
            with_b = sums(polygon[: len(rows)], share, len(sizes)) > 0
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
            area=area,
            depth=depths(polygons, placed)[polygon],
            joint=polygons.joint[polygon],
        )
        made = made.turned_over(found[:, 13] > 0, turned(-found[:, 9:12], -position[a, 3:]))
        return made.some(np.argsort(made.key, kind="stable"))

    def _joints(self, faces: IntArray, normal: FloatArray) -> IntArray:
        """Return the joints of pairs of surfaces (q, 2): that of the second, else of the first, (q,); of none -1.

        Where both have none and meet at an angle, it is that of the face of either block that faces the other most.
        """
        joints = self.blocks.face_joint[self._sides[0]]
        first, second = joints[faces].T
        joint: IntArray = np.where(second >= 0, second, first)
        bare = np.flatnonzero((joint < 0) & ~are_flat(*normal[faces.T]))
        if len(bare) and (joints >= 0).any():
            one, other = faces[bare].T
            first, second = joints[self._facing(one, other, normal)], joints[self._facing(other, one, normal)]
            joint[bare] = np.where(first >= 0, first, second)
        return joint

    def _facing(self, one: IntArray, other: IntArray, normal: FloatArray) -> IntArray:
        """Return the surfaces of the blocks of surfaces (q,) that are most opposed to other surfaces (q,)."""
        _, block, start, *_ = self._sides
        sizes = np.diff(start)[block[one]]
        mine = spread(start[block[one]], sizes)
        cosine = np.einsum("ij,ij->i", normal[mine], np.repeat(normal[other], sizes, axis=0))
        first = np.cumsum(sizes) - sizes
        least = np.repeat(np.minimum.reduceat(cosine, first), sizes)
        places = np.where(cosine <= least, np.arange(len(mine)), len(mine))
        found: IntArray = mine[np.minimum.reduceat(places, first)]
        return found

    def _slides(self, position: FloatArray, point: FloatArray, pair: IntArray) -> FloatArray:
        """Return the movements of the first of pairs of blocks (q, 2) against the second at points, (q, 3) [m]."""
        centroid = self.blocks.moments.centroid
        placed = centroid + position[:, :3]
        given = [centroid[i] + turned(point - placed[i], -position[i, 3:]) for i in pair.T]
        slide: FloatArray = turned(given[1] - given[0], position[pair[:, 1], 3:])
        return slide


def _least_gaps(rows: FloatArray, sizes: IntArray) -> FloatArray:
    """Return the least gaps of polygons (q,) of so many rows each [m]."""
    least: FloatArray = np.minimum.reduceat(rows[:, 12], np.cumsum(sizes) - sizes) if len(sizes) else np.zeros(0)
    return least


def _are_near(rows: FloatArray, sizes: IntArray, band: float, narrow: float) -> BoolArray:
    """Return which polygons (q,) of so many rows each are within `band` and wider than `narrow` [m]."""
    base, ends = rows[:, :3], np.append(0, np.cumsum(sizes))
    area = np.linalg.norm(vector_areas(base, ends), axis=1)
    around = sums(owner_of_corner(ends), np.linalg.norm(base[next_corner(ends)] - base, axis=1), len(sizes))
    # A narrow one is the elastic penetration of a face past another's edge.
    near: BoolArray = (np.abs(_least_gaps(rows, sizes)) <= band) & (2 * area > narrow * around)
    return near


def are_flat(one: FloatArray, other: FloatArray) -> BoolArray:
    """Return which pairs of faces, by their normals (q, 3), touch flat."""
    flat: BoolArray = (np.cross(one, other) ** 2).sum(axis=1) < PARALLEL**2
    return flat
