"""Loads of the model as the continuum's right-hand side."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters.continuum.mesh import ContinuumMesh
from bsm_mesh.model.loads import BoundaryLoad, PointForces, PointLoad, edge_tractions, point_forces_of
from bsm_mesh.model.model import Model


def load_vector(model: Model, mesh: ContinuumMesh, basis: Any) -> FloatArray:
    """Return the forces of weight and loads on the unknowns of `basis`, (N,) [N/m].

    Tractions act on the sides of the triangles, linear along each edge. A point load becomes a force per volume,
    linear over its block, with the same force, moment and average stress (sum x_i F_j) as the load: the point itself
    would give an infinite displacement in a continuum.
    """
    forces: FloatArray = _body_forces(model, mesh, basis)
    for load in model.acting_loads:
        if not isinstance(load, PointLoad | PointForces):
            forces = forces + _traction_forces(load, model, mesh, basis)
    return forces


def _body_forces(model: Model, mesh: ContinuumMesh, basis: Any) -> FloatArray:
    import skfem

    moments = model.blocks.moments
    level = model.unit_weights[:, None] * model.gravity_vector
    slope = np.zeros((model.blocks.count, 2, 2))  # force per volume = level + slope @ (x - centroid)
    x = np.asarray(basis.global_coordinates())
    arm = x - moments.centroid[mesh.block].T[:, :, None]
    given = [load for load in model.acting_loads if isinstance(load, PointLoad | PointForces)]
    if given:
        forces = point_forces_of(given, model.blocks)
        block, force = forces.block, forces.force
        from_centroid = forces.point - moments.centroid[block]
        second = np.zeros((model.blocks.count, 2, 2))
        np.add.at(second, mesh.block, np.einsum("itq,jtq,tq->tij", arm, arm, basis.dx))
        weight = np.linalg.solve(second[block], from_centroid[:, :, None])[:, :, 0]
        np.add.at(level, block, force / moments.area[block][:, None])
        np.add.at(slope, block, force[:, :, None] * weight[:, None, :])
    body = level[mesh.block].T[:, :, None] + np.einsum("tij,jtq->itq", slope[mesh.block], arm)
    return _assemble(skfem, basis, body)


def _traction_forces(load: BoundaryLoad, model: Model, mesh: ContinuumMesh, basis: Any) -> Any:
    import skfem

    edges, ends, at_ends = edge_tractions(load, model.blocks)
    facets, place = mesh.facets_of(edges)
    sides = skfem.FacetBasis(basis.mesh, basis.elem, facets=facets)
    x = np.asarray(sides.global_coordinates())
    start, along = ends[place, 0], ends[place, 1] - ends[place, 0]
    share = np.einsum("piq,ip->pq", x.transpose(1, 0, 2) - start[:, :, None], along.T / (along**2).sum(axis=1))
    traction = at_ends[place, 0].T[:, :, None] * (1 - share) + at_ends[place, 1].T[:, :, None] * share
    return _assemble(skfem, sides, traction)


def _assemble(skfem: Any, basis: Any, force: FloatArray) -> FloatArray:
    """Return the right-hand side of a force per volume or area given at the integration points, (2, cells, points)."""
    from skfem.helpers import dot

    forces: FloatArray = skfem.LinearForm(lambda v, w: dot(w["force"], v)).assemble(basis, force=force)
    return forces
