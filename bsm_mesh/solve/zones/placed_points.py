"""Where the points of the continuum's joints are, and what of the model acts there.

An interface is integrated at its nodes. With first-order triangles these are its two ends, which are the blocks' own
contact points (or the Gauss points, where the model has its contacts there); with second-order ones its middle besides.
Integration at the nodes keeps tractions free of oscillations.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.dilation import Dilating
from bsm_mesh.contact.shear_springs import Growing
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.face_chains import FaceChains
from bsm_mesh.solve.zones.interfaces import Interfaces
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.mesh import ContinuumMesh
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.rock_faces import (
    interface_closures,
    interface_curves,
    interface_dilations,
    interface_laws,
    interface_tensions,
)
from bsm_mesh.solve.zones.supports import nodal_unknowns

Rule = tuple[FloatArray, FloatArray]
"""Places and weights along a side of length 1."""

ENDS: Rule = (np.array([[0.0, 1.0]]), np.array([0.5, 0.5]))
GAUSS: Rule = (np.array([[0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5]]), np.array([0.5, 0.5]))
SIMPSON: Rule = (np.array([[0.0, 0.5, 1.0]]), np.array([1.0, 4.0, 1.0]) / 6)
TIED = 1e4  # of the softer rock's stiffness over the length of a point: represents rock that is whole


def joint_points(
    model: Model, mesh: ContinuumMesh, interfaces: Interfaces, basis: Any, order: int, chains: FaceChains | None
) -> JointPoints:
    """Return the points of all interfaces of a mesh that is opened along its joints.

    Parameters
    ----------
    model : Model
        Its joints and their laws.
    mesh : ContinuumMesh
        As `open_joints` returns it.
    interfaces : Interfaces
        Of that mesh.
    basis : skfem.CellBasis
        Of the vector-valued element.
    order : int
        Of the elements.
    chains : FaceChains or None
        Faces of that mesh that the points slide along; None: displacements are small.
    """
    import skfem

    rule = SIMPSON if order == 2 else GAUSS if model.contact_points == "gauss" else ENDS
    first, second = (
        skfem.FacetBasis(mesh.mesh, basis.elem, facets=interfaces.facet[:, side], quadrature=rule) for side in (0, 1)
    )
    normal = np.broadcast_to(np.asarray(first.normals), (2, *first.dx.shape)).reshape(2, -1)
    jump = [b - a for a, b in zip(_traces(first), _traces(second), strict=True)]
    count = first.dx.shape[1]
    joint = np.repeat(interfaces.joint, count)
    length = first.dx.ravel()
    of_joints = [given.contact_stiffness for given in model.joints]
    tied = joint >= len(of_joints)
    stiffness = np.array([*of_joints, (0.0, 0.0)])[np.where(tied, len(of_joints), joint)]
    tension, residual_tension = interface_tensions(model)
    block = np.stack([np.repeat(mesh.block[side.tind], count) for side in (first, second)], axis=1)
    softer = nominal_constants(model).stiffness.max(axis=(1, 2))[block].min(axis=1)
    stiffness[tied] = (TIED * softer / length)[tied, None]
    points = JointPoints(
        point=np.asarray(first.global_coordinates()).reshape(2, -1).T.copy(),
        normal=normal.T.copy(),
        length=length,
        joint=joint,
        block=block,
        normal_stiffness=stiffness[:, 0] * length,
        shear_stiffness=stiffness[:, 1] * length,
        tension=tension[joint] * length,
        residual_tension=residual_tension[joint] * length,
        closure_limit=interface_closures(model)[joint],
        dilating=Dilating.among(*interface_dilations(model)[:, joint]),
        growing=Growing.among(interface_curves(model)[joint], stiffness[:, 1], length, stiffness[:, 1] * length),
        joints=len(model.joints),
        laws=interface_laws(model),
        opening_rows=sp.csr_matrix(sp.diags(normal[0]) @ jump[0] + sp.diags(normal[1]) @ jump[1]),
        slip_rows=sp.csr_matrix(sp.diags(normal[0]) @ jump[1] - sp.diags(normal[1]) @ jump[0]),
        at_ends=rule is ENDS,
    )
    return points if chains is None else _moving(points, mesh, chains, interfaces, basis, rule)


def _moving(
    points: JointPoints, mesh: ContinuumMesh, chains: FaceChains, interfaces: Interfaces, basis: Any, rule: Rule
) -> MovingPoints:
    """Return the points with the nodes of the second side, and where these lie on the pieces of the first."""
    nodes = nodal_unknowns(basis)
    first, second = (mesh.mesh.facets[:, interfaces.facet[:, side]] for side in (0, 1))
    columns = [second[0], second[1]]
    if len(rule[1]) == 3:
        columns.insert(1, mesh.mesh.p.shape[1] + interfaces.facet[:, 1])
    node = np.stack(columns, axis=1).astype(np.int32)
    piece, own = interfaces.pieces.T
    forwards = mesh.piece_ends[piece, 0] == first[0]
    share = np.where(forwards[:, None], rule[0], 1 - rule[0])
    # What comes first along the second side comes last along the first one.
    outer = np.zeros(node.shape, dtype=np.int8)
    for end, free, way in zip(mesh.piece_ends[own].T, chains.free_ends(interfaces), (1, -1), strict=True):
        outer[(node == end[:, None]) & free[own, None]] = way
    return MovingPoints.of(
        points,
        node=node.ravel(),
        nodes=nodes,
        as_given=basis.doflocs[:, nodes[:, 0]].T,
        chains=chains,
        piece=np.repeat(piece, len(rule[1])).astype(np.int32),
        share=share.ravel(),
        outer=outer.ravel(),
    )


def _traces(basis: Any) -> tuple[Any, Any]:
    """Return the sparse matrices (q, N) that give the displacement in x and in y at the integration points."""
    sides, points = basis.dx.shape
    rows = np.tile(np.arange(sides * points), basis.Nbfun)
    columns = np.concatenate([np.repeat(basis.element_dofs[j], points) for j in range(basis.Nbfun)])
    x, y = (
        np.concatenate([np.broadcast_to(basis.basis[j][0][axis], (sides, points)).ravel() for j in range(basis.Nbfun)])
        for axis in (0, 1)
    )
    shape = (sides * points, basis.N)
    return sp.csr_matrix((x, (rows, columns)), shape=shape), sp.csr_matrix((y, (rows, columns)), shape=shape)
