"""The sides of polyhedral blocks: which are bare, where they are, and the edges at which a body bends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.three_d.blocks.polygons import spread, vector_areas

if TYPE_CHECKING:
    from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

BENT = 0.77  # cosine of 40 degrees: bare sides that meet at less have an edge of the body between them
LEVEL = 0.1  # cosine: sides of an opening that face down more than this are its roof


@dataclass(frozen=True, eq=False)
class Sides:
    """Sides of blocks, as given: every face between two blocks has one of each, those within a block none.

    Attributes
    ----------
    blocks : Polyhedra
        The blocks.
    """

    blocks: Polyhedra

    @cached_property
    def _rows(self) -> tuple[IntArray, IntArray]:
        """Face, and which of its two blocks, of every side."""
        pairs = self.blocks.face_blocks
        face, of = np.nonzero((pairs >= 0) & (pairs != pairs[:, ::-1]))
        return face, of

    @cached_property
    def face(self) -> IntArray:
        """Number of the face, (n,)."""
        return self._rows[0]

    @cached_property
    def block(self) -> IntArray:
        """Block whose side it is, (n,)."""
        face, of = self._rows
        block: IntArray = self.blocks.face_blocks[face, of]
        return block

    @cached_property
    def other(self) -> IntArray:
        """Block on the other side of the face, (n,); -1: none."""
        face, of = self._rows
        other: IntArray = self.blocks.face_blocks[face, 1 - of]
        return other

    @cached_property
    def outward(self) -> FloatArray:
        """Area times the normal out of the block, (n, 3) [m2]."""
        corners = self.blocks.vertices[self.blocks.face_vertices]
        face, of = self._rows
        out: FloatArray = vector_areas(corners, self.blocks.face_offsets)[face] * np.where(of == 0, 1.0, -1.0)[:, None]
        return out

    def bare(self, present: BoolArray) -> BoolArray:
        """Return the sides of present blocks (m,) with no present block beyond, (n,)."""
        bare: BoolArray = present[self.block] & ~np.append(present, False)[self.other]
        return bare

    def polygons(self, sides: IntArray, movement: FloatArray | None = None) -> tuple[FloatArray, IntArray]:
        """Return the corners of sides, counter-clockwise from outside, and their offsets.

        Parameters
        ----------
        sides : (k,) int
            Numbers of sides.
        movement : (m, 6) float64, optional [m, rad]
            By which every block is moved.
        """
        blocks: Any = self.blocks
        face = self.face[sides]
        sizes = np.diff(blocks.face_offsets)[face]
        offsets = np.concatenate([[0], np.cumsum(sizes)])
        within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
        back = np.repeat(self._rows[1][sides] == 1, sizes)  # faces turn about the normal of their first block
        within = np.where(back, np.repeat(sizes, sizes) - 1 - within, within)
        corners = blocks.vertices[blocks.face_vertices[np.repeat(blocks.face_offsets[:-1][face], sizes) + within]]
        if movement is not None:
            corners = corners + displacement_of(blocks, movement, np.repeat(self.block[sides], sizes), corners)
        return corners, offsets

    def bent_edges(self, sides: IntArray) -> IntArray:
        """Return the edges, (k, 2) numbers of vertices, at which a surface of sides bends or ends."""
        blocks, face = self.blocks, self.face[sides]
        sizes = np.diff(blocks.face_offsets)[face]
        offsets = np.concatenate([[0], np.cumsum(sizes)])
        place = spread(blocks.face_offsets[:-1][face], sizes)
        start = blocks.face_vertices[place]
        following = np.arange(1, len(place) + 1)
        following[offsets[1:] - 1] = offsets[:-1]
        edge = np.sort(np.stack([start, start[following]], axis=1), axis=1)
        owner = np.repeat(np.arange(len(sides)), sizes)
        order = np.lexsort(edge.T)
        edge, owner = edge[order], owner[order]
        unit = self.outward[sides] / np.linalg.norm(self.outward[sides], axis=1)[:, None]
        same = (edge[1:] == edge[:-1]).all(axis=1)
        even = same & (np.einsum("ij,ij->i", unit[owner[1:]], unit[owner[:-1]]) > BENT)
        smooth = np.append(even, False) | np.append(False, even)
        return np.unique(edge[~smooth], axis=0)
