"""The single bars in space that supports stand for."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, listing
from bsm_mesh.model.polygons import owner_of_corner
from bsm_mesh.model.supports import Bars, Fixed, NormalRoller, no_edge
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


def bars_in_space(support: object, number: int, blocks: Polyhedra) -> list[Bars]:
    """Return the bars of a support: `Fixed` or `NormalRoller`, on blocks or a boundary.

    A block that is fixed has three bars at its centroid and three that hold its rotations; their direction is the axis.

    Raises
    ------
    ModelError
        For a boundary or block that does not exist, and for supports that polyhedra do not have.
    """
    if not isinstance(support, Fixed | NormalRoller):
        raise ModelError("polyhedra are held by Fixed(blocks=...), Fixed(boundary=...) or NormalRoller(boundary=...)")
    if support.point is not None:
        raise ModelError("polyhedra are held by blocks or by boundaries, not at points; give one of these")
    if support.boundary is not None:
        block, point, normal = _corners_of(blocks, support.boundary)
        if isinstance(support, NormalRoller):
            return [_bars(number, block, point, normal)]
        return [_bars(number, block, point, np.tile(axis, (len(block), 1))) for axis in np.eye(3)]
    ids = np.array(support.blocks, dtype=np.int64)
    outside = ids[(ids < 0) | (ids >= blocks.count)]
    if outside.size:
        raise ModelError(f"there is no block {listing(outside)}; blocks are numbered 0 to {blocks.count - 1}")
    block, point = ids.astype(np.int32), blocks.moments.centroid[ids]
    axes = [np.tile(axis, (len(ids), 1)) for axis in np.eye(3)]
    return [_bars(number, block, point, axis, turns=turns) for turns in (False, True) for axis in axes]


def _corners_of(blocks: Polyhedra, boundary: str) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return block (k,), corner (k, 3) and outward normal (k, 3) of every corner of a boundary's faces."""
    from bsm_mesh.three_d.blocks.polygons import vector_areas

    faces = blocks.boundary_faces(boundary)
    owner = owner_of_corner(blocks.face_offsets)
    chosen = np.flatnonzero(np.isin(owner, faces))
    corners = blocks.vertices[blocks.face_vertices]
    area = vector_areas(corners, blocks.face_offsets)[owner[chosen]]
    normal = area / np.linalg.norm(area, axis=1)[:, None]
    return blocks.face_blocks[owner[chosen], 0], corners[chosen], normal


def _bars(number: int, block: IntArray, point: FloatArray, direction: FloatArray, *, turns: bool = False) -> Bars:
    return Bars(
        block=block,
        point=point,
        direction=direction,
        holds_rotation=np.full(len(block), turns),
        value=np.zeros(len(block)),
        support=np.full(len(block), number, dtype=np.int32),
        edge=no_edge(block),
    )
