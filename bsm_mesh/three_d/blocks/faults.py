"""Faults of given polyhedra."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import numbered
from bsm_mesh.three_d.blocks.polygons import sums, vector_areas

CLOSED = 1e-9  # over the sum of a cell's face areas: what is left of their vectors


def index_faults(name: str, values: IntArray, lowest: int, count: int) -> list[str]:
    """Return a fault if numbers do not lie from `lowest` to below `count`."""
    if values.size and (values.min() < lowest or values.max() >= count):
        return [f"Polyhedra.{name}: index outside {lowest} .. {count - 1}"]
    return []


def cell_faults(
    vertices: FloatArray, face_vertices: IntArray, face_offsets: IntArray, face_cells: IntArray, count: int
) -> list[str]:
    """Return a fault for the cells that are not closed."""
    vector = vector_areas(vertices[face_vertices], face_offsets)
    area, left = np.zeros(count), np.zeros((count, 3))
    for side, sign in ((0, 1.0), (1, -1.0)):
        chosen = face_cells[:, side] >= 0
        cell = face_cells[chosen, side]
        left += sign * sums(cell, vector[chosen], count)
        area += sums(cell, np.linalg.norm(vector[chosen], axis=1), count)
    open_cells = np.flatnonzero(np.linalg.norm(left, axis=1) > CLOSED * area + 1e-300)
    if not open_cells.size:
        return []
    return [
        f"Polyhedra: {numbered('cell', open_cells)}: the faces do not close; corners must run counter-clockwise "
        "seen from outside the face's first cell, and no face may be missing"
    ]


def volume_faults(volume: FloatArray) -> list[str]:
    """Return a fault for the blocks that have no positive volume."""
    bad = np.flatnonzero(~(volume > 0))
    if not bad.size:
        return []
    return [f"Polyhedra: {numbered('block', bad)}: the volume is not positive; turn the faces outward"]
