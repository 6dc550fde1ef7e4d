"""Loads on polyhedra as forces at points: given ones, pressures and tractions on faces, and those of the ground."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, listing, place
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import PointForces, PointLoad, Pressure, Traction, refuse_misfit, values_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.polygons import next_corner
from bsm_mesh.three_d.blocks.cell_sides import polyhedra_at
from bsm_mesh.three_d.blocks.polygons import polygon_moments, spread
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.stress_field import SpaceStress

OnFace = Callable[[FloatArray, FloatArray], FloatArray]
"""Returns the tractions (k, 3) [Pa] at points (k, 3) of faces with outward normals (k, 3)."""


def forces_in_space(loads: Sequence[object], blocks: Polyhedra) -> PointForces:
    """Return the forces of all loads: a constant pressure or traction becomes one force a face, at its centroid.

    One that is linear becomes three forces for each triangle of a face, exact in force and moment.

    Raises
    ------
    ModelError
        For a boundary that does not exist, and loads that are for the plane.
    """
    parts = [PointForces(block=np.zeros(0, np.int32), point=np.zeros((0, 3)), force=np.zeros((0, 3)))]
    for load in loads:
        if isinstance(load, Pressure | Traction):
            parts.append(_on_boundary(load, blocks))
        elif isinstance(load, PointForces) and load.point.shape[1:] == load.force.shape[1:] == (3,):
            outside = load.block[(load.block < 0) | (load.block >= blocks.count)]
            if outside.size:
                raise ModelError(f"there is no block {listing(outside)}; blocks are numbered 0 to {blocks.count - 1}")
            parts.append(load)
        elif isinstance(load, PointLoad):
            parts.append(_at_point(load, blocks))
        else:
            raise ModelError(
                "not for polyhedra; they take Pressure, Traction and InSituTraction on a boundary, and PointLoad"
            )
    block, point, force = (np.concatenate([getattr(p, name) for p in parts]) for name in ("block", "point", "force"))
    return PointForces(block=block.astype(np.int32), point=point, force=force)


def _at_point(load: PointLoad, blocks: Polyhedra) -> PointForces:
    point, force = np.array([load.point]), np.array([load.force])
    if len(load.point) != 3:
        raise ModelError(f"point load on block {load.block}: in space point and force are three numbers each")
    if not 0 <= load.block < blocks.count:
        raise ModelError(f"there is no block {load.block}; blocks are numbered 0 to {blocks.count - 1}")
    if load.block not in polyhedra_at(blocks, point[0]):
        centre = blocks.moments.centroid[load.block]
        raise ModelError(f"the point {place(point[0])} is not in block {load.block}, whose centroid is {place(centre)}")
    return PointForces(block=np.array([load.block], dtype=np.int32), point=point, force=force)


def in_situ_forces(model: Model, boundary: str) -> PointForces:
    """Return the forces on a boundary that balance the in-situ stress of the ground: exact where it is linear."""
    assert in_space(model.blocks)
    field = SpaceStress(model)
    return _on_triangles(model.blocks, boundary, lambda point, normal: np.einsum("kij,kj->ki", field.at(point), normal))


def _on_boundary(load: Pressure | Traction, blocks: Polyhedra) -> PointForces:
    refuse_misfit(load, axes=3)
    fields = (load.pressure,) if isinstance(load, Pressure) else load.traction

    def traction(point: FloatArray, normal: FloatArray) -> FloatArray:
        values = np.stack([values_of(field, point) for field in fields], axis=-1)
        return -values * normal if isinstance(load, Pressure) else values

    if any(any(field[1:]) for field in fields):
        return _on_triangles(blocks, load.boundary, traction)
    face, block, side = _sides(blocks, load.boundary)
    moments = polygon_moments(blocks.vertices[blocks.face_vertices], blocks.face_offsets)
    point, normal, area = moments.centroid[face], side * moments.normal[face], moments.area[face, None]
    return PointForces(block=block, point=point, force=area * traction(point, normal))


def _sides(blocks: Polyhedra, boundary: str) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the faces of a boundary, the blocks behind them, and the sign of their normals out of these (k, 1).

    A face between two blocks, such as one that an excavation lays bare, is there for both.
    """
    face = blocks.boundary_faces(boundary)
    first, second = blocks.face_blocks[face].T
    inner = (second >= 0) & (second != first)
    sign = np.concatenate([np.ones(len(face)), -np.ones(int(inner.sum()))])
    return np.concatenate([face, face[inner]]), np.concatenate([first, second[inner]]), sign[:, None]


def _on_triangles(blocks: Polyhedra, boundary: str, traction: OnFace) -> PointForces:
    """Return forces at the middles of the sides of the triangles about the centroids of a boundary's faces."""
    face, block, sign = _sides(blocks, boundary)
    corner, offsets = blocks.vertices[blocks.face_vertices], blocks.face_offsets
    moments, following = polygon_moments(corner, offsets), next_corner(offsets)
    sizes = np.diff(offsets)[face]
    at, side = spread(offsets[face], sizes), np.repeat(np.arange(len(face)), sizes)
    centre, here, there = moments.centroid[face[side]], corner[at], corner[following[at]]
    point = np.concatenate([centre + here, here + there, there + centre]) / 2
    side, part = np.tile(side, 3), np.tile(moments.triangle_area[at], 3) / 3
    force = part[:, None] * traction(point, sign[side] * moments.normal[face[side]])
    return PointForces(block=block[side], point=point, force=force)
