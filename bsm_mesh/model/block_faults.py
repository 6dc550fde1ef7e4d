"""Which outlines cannot be blocks, said one sentence a block."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import place
from bsm_mesh.model.polygons import edge_vectors, owner_of_corner, polygon_moments, self_crossing

FARTHEST = 1e12  # [m]; what is beyond, and what is no number, comes from a damaged file
SHORTEST_EDGE = 1e-9  # m, as the merge tolerance: a shorter edge is two corners of one point


def outline_faults(vertices: FloatArray, offsets: IntArray) -> list[str]:
    """Return one sentence for every outline that is not a simple counter-clockwise polygon.

    Parameters
    ----------
    vertices : (n_vertices, 2) float64 [m]
        Corners, block after block.
    offsets : (n_blocks + 1,) int32
        Block b owns ``vertices[offsets[b]:offsets[b + 1]]``.
    """
    owner = owner_of_corner(offsets)
    faults = []
    bad = np.flatnonzero(~(np.abs(vertices) < FARTHEST).all(axis=1))
    if bad.size:  # nothing else can be computed from these
        return [
            f"block {owner[v]}: corner {v - offsets[owner[v]]} is at ({vertices[v, 0]}, {vertices[v, 1]}); "
            f"coordinates must be numbers below {FARTHEST:g} m"
            for v in bad
        ]
    length = np.hypot(*edge_vectors(vertices, offsets).T)
    for e in np.flatnonzero(length < SHORTEST_EDGE):
        faults.append(
            f"block {owner[e]}: edge {e - offsets[owner[e]]} at {place(vertices[e])} has length {length[e]:.3g} m; "
            f"merge duplicate corners (tolerance {SHORTEST_EDGE:g} m)"
        )
    area = polygon_moments(vertices, offsets).area
    perimeter = np.add.reduceat(length, offsets[:-1])
    flat = np.abs(area) <= 1e-12 * perimeter**2
    for b in np.flatnonzero(flat):
        faults.append(f"block {b} at {place(vertices[offsets[b]])}: encloses no area: corners on a line, or crossing")
    for b in np.flatnonzero(~flat & (area < 0)):
        faults.append(f"block {b} at {place(vertices[offsets[b]])}: corners run clockwise; reverse their order")
    for b in self_crossing(vertices, offsets):
        if not flat[b]:
            faults.append(
                f"block {b} at {place(vertices[offsets[b]])}: its outline crosses or touches itself; "
                "give the corners in order round the block, or split it"
            )
    return faults
