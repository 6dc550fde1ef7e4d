"""Loads of the model as the continuum's right-hand side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.in_stage import without_stages
from bsm_mesh.model.loads import ActingLoad, BoundaryLoad, PointForces, PointLoad, edge_tractions, point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.mesh import ContinuumMesh


def load_vector(
    model: Model, mesh: ContinuumMesh, basis: Any, loads: Sequence[ActingLoad], present: BoolArray
) -> FloatArray:
    """Return the forces of weight and loads on the unknowns of `basis`, (N,) [N/m].

    Tractions act on the sides of the cells, linear along each edge. A point load becomes a force per volume,
    linear over its block, with the same force, moment and average stress (sum x_i F_j) as the load: the point itself
    would give an infinite displacement in a continuum.

    Parameters
    ----------
    model : Model
        Its blocks and their weights.
    mesh : ContinuumMesh
        The cells.
    basis : skfem.CellBasis
        Of the vector-valued element.
    loads : sequence of load
        What acts besides the weights.
    present : (n,) bool
        Which blocks are there.
    """
    forces: FloatArray = _body_forces(model, mesh, basis, loads, present)
    for load in loads:
        if not isinstance(load, PointLoad | PointForces):
            forces = forces + _traction_forces(load, model, mesh, basis, present)
    return forces


def weightless(model: Model) -> Model:
    """Return a model whose rocks weigh nothing, without its stages and bolts."""
    return without_stages(model, rocks=[replace(rock, unit_weight=0.0) for rock in model.rocks])


def pressure_on_new_faces(
    mesh: ContinuumMesh, basis: Any, facets: IntArray, stays: BoolArray, leaves: BoolArray, pressure: float
) -> FloatArray:
    """Return the forces (N,) [N/m] of a pressure into the blocks that stay, on their faces with those that leave.

    Parameters
    ----------
    mesh, basis
        As for `load_vector`.
    facets : (k, 2) int
        Pairs of facets that lie on each other, of joints.
    stays, leaves : (n,) bool
        Blocks.
    pressure : float [Pa]
        Positive into the blocks.
    """
    import skfem
    from skfem.helpers import dot

    @skfem.LinearForm
    def inward(v: Any, w: Any) -> Any:
        return -pressure * dot(w.n, v)

    forces: FloatArray = np.zeros(basis.N)
    f2t = basis.mesh.f2t
    whole = np.flatnonzero(f2t[1] >= 0)
    for side in (0, 1):  # rock without a joint: one facet, seen from the cell on that side
        own, other = (mesh.block[f2t[s, whole]] for s in (side, 1 - side))
        bare = whole[stays[own] & leaves[other]]
        if bare.size:
            seen = skfem.FacetBasis(basis.mesh, basis.elem, facets=bare, side=side)
            forces += (-1) ** side * inward.assemble(seen)  # normals are those out of side 0
        own, other = (mesh.block[f2t[0, facets[:, s]]] for s in (side, 1 - side))
        bare = facets[stays[own] & leaves[other], side]
        if bare.size:
            forces += inward.assemble(skfem.FacetBasis(basis.mesh, basis.elem, facets=bare))
    return forces


def _body_forces(
    model: Model, mesh: ContinuumMesh, basis: Any, loads: Sequence[ActingLoad], present: BoolArray
) -> FloatArray:
    moments = model.blocks.moments
    level = model.unit_weights[:, None] * model.gravity_vector
    slope = np.zeros((model.blocks.count, 2, 2))  # force per volume = level + slope @ (x - centroid)
    x = np.asarray(basis.global_coordinates())
    arm = x - moments.centroid[mesh.block].T[:, :, None]
    given = [load for load in loads if isinstance(load, PointLoad | PointForces)]
    if given:
        forces = point_forces_of(given, model.blocks)
        block, force = forces.block, forces.force
        from_centroid = forces.point - moments.centroid[block]
        second = np.zeros((model.blocks.count, 2, 2))
        np.add.at(second, mesh.block, np.einsum("itq,jtq,tq->tij", arm, arm, basis.dx))
        weight = np.linalg.solve(second[block], from_centroid[:, :, None])[:, :, 0]
        np.add.at(level, block, force / moments.area[block][:, None])
        np.add.at(slope, block, force[:, :, None] * weight[:, None, :])
    level[~present], slope[~present] = 0.0, 0.0
    body = level[mesh.block].T[:, :, None] + np.einsum("tij,jtq->itq", slope[mesh.block], arm)
    return assemble_load(basis, body)


def _traction_forces(
    load: BoundaryLoad, model: Model, mesh: ContinuumMesh, basis: Any, present: BoolArray
) -> FloatArray:
    import skfem

    edges, ends, at_ends = edge_tractions(load, model.blocks)
    here = present[model.blocks.owner[edges]]
    edges, ends, at_ends = edges[here], ends[here], at_ends[here]
    if not edges.size:
        return np.zeros(basis.N)
    facets, place = mesh.facets_of(edges)
    sides = skfem.FacetBasis(basis.mesh, basis.elem, facets=facets)
    x = np.asarray(sides.global_coordinates())
    start, along = ends[place, 0], ends[place, 1] - ends[place, 0]
    share = np.einsum("piq,ip->pq", x.transpose(1, 0, 2) - start[:, :, None], along.T / (along**2).sum(axis=1))
    traction = at_ends[place, 0].T[:, :, None] * (1 - share) + at_ends[place, 1].T[:, :, None] * share
    return assemble_load(sides, traction)


def assemble_load(basis: Any, force: FloatArray) -> FloatArray:
    """Return the right-hand side of a force per volume or area given at the integration points, (2, cells, points)."""
    import skfem
    from skfem.helpers import dot

    forces: FloatArray = skfem.LinearForm(lambda v, w: dot(w["force"], v)).assemble(basis, force=force)
    return forces
