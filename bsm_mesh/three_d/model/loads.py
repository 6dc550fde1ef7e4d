"""Loads on polyhedra as forces at points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bsm_mesh.errors import ModelError, listing, place
from bsm_mesh.model.loads import PointForces, PointLoad, Pressure
from bsm_mesh.three_d.blocks.cell_sides import polyhedra_at
from bsm_mesh.three_d.blocks.polygons import polygon_moments
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


def forces_in_space(loads: Sequence[object], blocks: Polyhedra) -> PointForces:
    """Return the forces of all loads: a constant pressure becomes one force a face, at its centroid.

    Raises
    ------
    ModelError
        For a boundary that does not exist, a pressure that is not constant, and loads that are for the plane.
    """
    parts = [PointForces(block=np.zeros(0, np.int32), point=np.zeros((0, 3)), force=np.zeros((0, 3)))]
    for load in loads:
        if isinstance(load, Pressure):
            parts.append(_pressed(load, blocks))
        elif isinstance(load, PointForces) and load.point.shape[1:] == load.force.shape[1:] == (3,):
            outside = load.block[(load.block < 0) | (load.block >= blocks.count)]
            if outside.size:
                raise ModelError(f"there is no block {listing(outside)}; blocks are numbered 0 to {blocks.count - 1}")
            parts.append(load)
        elif isinstance(load, PointLoad):
            parts.append(_at_point(load, blocks))
        else:
            raise ModelError("polyhedra take Pressure(boundary=..., pressure=...), or PointLoad with three components")
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


def _pressed(load: Pressure, blocks: Polyhedra) -> PointForces:
    pressure, *gradient = np.atleast_1d(load.pressure)
    if np.any(gradient):
        raise ModelError(f"boundary '{load.boundary}': on polyhedra a pressure is constant; give one number")
    faces = blocks.boundary_faces(load.boundary)
    moments = polygon_moments(blocks.vertices[blocks.face_vertices], blocks.face_offsets)
    inward = -moments.normal[faces] * moments.area[faces, None]
    return PointForces(block=blocks.face_blocks[faces, 0], point=moments.centroid[faces], force=pressure * inward)
