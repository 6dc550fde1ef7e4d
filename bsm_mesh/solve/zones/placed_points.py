"""Where the points of the continuum's joints are, and what of the model acts there.

An interface is integrated at its nodes. With first-order triangles these are its two ends, which are the blocks' own
contact points (or the Gauss points, where the model has its contacts there); with second-order ones its middle besides.
Integration at the nodes keeps tractions free of oscillations.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.dilation import Dilating
from bsm_mesh.contact.shear_springs import Growing
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.elasticity import nominal_constants
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
from bsm_mesh.solve.zones.zone_faces import ZoneFaces

Rule = tuple[FloatArray, FloatArray]
"""Places and weights along a side of length 1."""

ENDS: Rule = (np.array([[0.0, 1.0]]), np.array([0.5, 0.5]))
GAUSS: Rule = (np.array([[0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5]]), np.array([0.5, 0.5]))
SIMPSON: Rule = (np.array([[0.0, 0.5, 1.0]]), np.array([1.0, 4.0, 1.0]) / 6)
TIED = 1e4  # of the softer rock's stiffness over the length of a point: represents rock that is whole


def joint_points(
    model: Model, mesh: ContinuumMesh, interfaces: Interfaces, basis: Any, order: int, faces: ZoneFaces | None
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
    faces : ZoneFaces or None
        Outlines of that mesh, along which points slide; None: displacements are small.
    """
    rule = SIMPSON if order == 2 else GAUSS if model.contact_points == "gauss" else ENDS
    count = len(rule[1])
    point, normal, length, jump = _sides(mesh, interfaces, basis, rule)
    joint = np.repeat(interfaces.joint, count)
    block = np.repeat(mesh.block[mesh.mesh.f2t[0, interfaces.facet]], count, axis=0)
    points = JointPoints(
        point=point.T.copy(),
        normal=normal.T.copy(),
        length=length,
        joint=joint,
        block=block,
        **springs_of(model, joint, length, block),
        joints=len(model.joints),
        laws=interface_laws(model),
        opening_rows=sp.csr_matrix(sp.diags(normal[0]) @ jump[0] + sp.diags(normal[1]) @ jump[1]),
        slip_rows=sp.csr_matrix(sp.diags(normal[0]) @ jump[1] - sp.diags(normal[1]) @ jump[0]),
        at_ends=rule is ENDS,
    )
    return points if faces is None else _moving(points, mesh, faces, interfaces, basis, rule)


def _sides(
    mesh: ContinuumMesh, interfaces: Interfaces, basis: Any, rule: Rule
) -> tuple[FloatArray, FloatArray, FloatArray, list[Any]]:
    """Return places and normals (2, q) of the points, their lengths (q,), and matrices of the jumps in x and y."""
    import skfem

    if not interfaces.joint.size:
        none = sp.csr_matrix((0, basis.N))
        return np.zeros((2, 0)), np.zeros((2, 0)), np.zeros(0), [none, none]
    first, second = (
        skfem.FacetBasis(mesh.mesh, basis.elem, facets=interfaces.facet[:, side], quadrature=rule) for side in (0, 1)
    )
    normal = np.broadcast_to(np.asarray(first.normals), (2, *first.dx.shape)).reshape(2, -1)
    jump = [b - a for a, b in zip(_traces(first), _traces(second), strict=True)]
    return np.asarray(first.global_coordinates()).reshape(2, -1), normal, first.dx.ravel(), jump


def springs_of(model: Model, joint: IntArray, length: FloatArray, block: IntArray) -> dict[str, Any]:
    """Return the fields of `JointPoints` that follow from the joint, the length and the blocks of points, (q,) each."""
    of_joints = [given.contact_stiffness for given in model.joints]
    tied = joint >= len(of_joints)
    stiffness = np.array([*of_joints, (0.0, 0.0)])[np.where(tied, len(of_joints), joint)]
    tension, residual_tension = interface_tensions(model)
    softer = nominal_constants(model).stiffness.max(axis=(1, 2))[block].min(axis=1)
    stiffness[tied] = (TIED * softer / length)[tied, None]
    return {
        "normal_stiffness": stiffness[:, 0] * length,
        "shear_stiffness": stiffness[:, 1] * length,
        "tension": tension[joint] * length,
        "residual_tension": residual_tension[joint] * length,
        "closure_limit": interface_closures(model)[joint],
        "dilating": Dilating.among(*interface_dilations(model)[:, joint]),
        "growing": Growing.among(interface_curves(model)[joint], stiffness[:, 1], length, stiffness[:, 1] * length),
    }


def _moving(
    points: JointPoints,
    mesh: ContinuumMesh,
    faces: ZoneFaces,
    interfaces: Interfaces,
    basis: Any,
    rule: Rule,
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
    begins, ends = (node == mesh.piece_ends[own, k][:, None] for k in (0, 1))
    edge = faces.halves * own[:, None]
    starts_there = np.where(ends, -1, edge + ~begins)  # the middle begins the second half
    ends_there = np.where(begins, -1, edge + ends * (faces.halves - 1))
    return MovingPoints.of(
        points,
        node=node.ravel(),
        nodes=nodes,
        as_given=basis.doflocs[:, nodes[:, 0]].T,
        faces=faces,
        piece=np.repeat(piece, len(rule[1])).astype(np.int32),
        share=share.ravel(),
        own=np.stack([starts_there.ravel(), ends_there.ravel()], axis=1).astype(np.int32),
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
