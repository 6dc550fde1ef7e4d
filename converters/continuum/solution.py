"""Plane-strain elastic solution of a model's domain by scikit-fem, averaged over the blocks."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.converters.continuum.elasticity import (
    matched_stiffness,
    nominal_stiffness,
    rigid_rock_faults,
    rocks_in_use,
)
from bsm_mesh.converters.continuum.interfaces import Interfaces, interface_stiffness, open_joints
from bsm_mesh.converters.continuum.loads import load_vector
from bsm_mesh.converters.continuum.mesh import build_continuum_mesh
from bsm_mesh.converters.continuum.supports import held_displacements, nodal_unknowns
from bsm_mesh.converters.continuum.system import solve_held
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import find_faces
from bsm_mesh.model.loads import PointLoad
from bsm_mesh.model.model import Model

ElasticityName = Literal["nominal", "matched"]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContinuumSolution:
    """A continuum solution, averaged over the blocks, and its mesh.

    Attributes
    ----------
    elasticity : {"nominal", "matched"}
        Elastic constants: the rock's E and Poisson's ratio, or those of the continuum to which the
        Block-Spring Model tends (`converters.continuum.elasticity.matched_elasticity`).
    stress : (n, 2, 2) float64 [Pa]
        Average stress of every block, tension positive.
    displacement : (n, 3) float64 [m, m, rad]
        Average of u, v and of the rotation (dv/dx - du/dy) / 2 over every block.
    points : (p, 2) float64 [m]
        Nodes: vertices of the triangles, then middles of their sides (second order).
    point_displacement : (p, 2) float64 [m]
        Displacement of the nodes.
    triangles : (t, 3) or (t, 6) int32
        Nodes of the triangles, counter-clockwise: corners, then the middles of sides 0-1, 1-2, 2-0 (as in VTK).
    triangle_block : (t,) int32
        Block of every triangle.
    triangle_stress : (t, 2, 2) float64 [Pa]
        Average stress of every triangle.
    total_load, total_reaction : (2,) float64 [N/m]
        Sum of weights and loads, and of the forces of the supports.
    unknowns : int
        Number of displacement components that were solved for.
    seconds : float
        Wall time.
    notes : tuple of str
        What the continuum leaves out or treats in its own way, a sentence each.
    """

    elasticity: ElasticityName
    stress: FloatArray
    displacement: FloatArray
    points: FloatArray
    point_displacement: FloatArray
    triangles: IntArray
    triangle_block: IntArray
    triangle_stress: FloatArray
    total_load: FloatArray
    total_reaction: FloatArray
    unknowns: int
    seconds: float
    notes: tuple[str, ...]


def solve_continuum(
    model: Model, *, elasticity: ElasticityName = "nominal", order: int = 2, joints: bool = False
) -> ContinuumSolution:
    """Return the continuum solution of a model: the same domain, supports and loads.

    Parameters
    ----------
    model : Model
        What is given; every rock in use must be elastic.
    elasticity : {"nominal", "matched"}
        Elastic constants, see `ContinuumSolution`.
    order : {1, 2}
        Polynomial order of the displacements.
    joints : bool
        Whether joints are elastic interface elements of zero thickness (`interfaces`); else they are ignored.

    Raises
    ------
    ModelError
        For rigid rocks, supports that contradict each other at a shared node, or a part free to move.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> square = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="granite")
    >>> square = square.with_boundary("bottom", lambda x, y: y < 1e-9)
    >>> rock = bsm.Rock("granite", unit_weight=26e3, young=50e9, poisson=0.0)
    >>> model = bsm.Model(blocks=square, rocks=[rock], supports=[bsm.Fixed(boundary="bottom")])
    >>> print(f"{solve_continuum(model).stress[0, 1, 1]:.0f} Pa")
    -13000 Pa
    """
    return Continuum(model, order, joints).solve(elasticity)


class Continuum:
    """A model's mesh, loads and supports in scikit-fem, ready to be solved with different elastic constants.

    Parameters
    ----------
    model : Model
        What is given.
    order : {1, 2}
        Polynomial order of the displacements.
    joints : bool
        Whether joints are elastic interface elements of zero thickness (`interfaces`); else they are ignored.
    """

    def __init__(self, model: Model, order: int = 2, joints: bool = False) -> None:
        import skfem

        if order not in (1, 2):
            raise ModelError(f"order = {order!r} must be 1 or 2")
        if model.stages or model.water is not None:
            raise ModelError(
                "the continuum has neither stages nor water; compare a model without [[stage]] and [water]"
            )
        raise_faults(rigid_rock_faults(model.rocks, rocks_in_use(model)))
        began = time.perf_counter()
        self.model = model
        self.mesh = build_continuum_mesh(model.blocks)
        self.interfaces: Interfaces | None = None
        if joints:
            self.mesh, self.interfaces = open_joints(model, self.mesh)
        self.order = order
        element = skfem.ElementTriP2() if order == 2 else skfem.ElementTriP1()
        self.basis = skfem.CellBasis(self.mesh.mesh, skfem.ElementVector(element))
        self.averages = _block_averages(self.basis, self.mesh.block, model.blocks.moments.area)
        self.supports = held_displacements(model, self.mesh, self.basis, self.averages)
        self.load = load_vector(model, self.mesh, self.basis)
        self.seconds = time.perf_counter() - began

    def solve(self, elasticity: ElasticityName) -> ContinuumSolution:
        """Return the solution with the named elastic constants."""
        if elasticity not in ("nominal", "matched"):
            raise ModelError(f"elasticity = {elasticity!r} must be 'nominal' or 'matched'")
        began = time.perf_counter()
        of_block, notes = nominal_stiffness(self.model) if elasticity == "nominal" else matched_stiffness(self.model)
        stiffness = of_block[self.mesh.block]
        K, ties = _anisotropic(self.basis, stiffness), None
        if self.interfaces is not None:
            K = K + interface_stiffness(self.model, self.interfaces, self.basis, self.order)
            ties = self.basis.nodal_dofs[0, self.interfaces.ends[:, :, 0].T]
        u = solve_held(K, self.load, self.supports, self.basis, ties)
        gradient = _mean_gradient(self.basis, u)
        stress = _stress(gradient, stiffness)
        area = self.basis.dx.sum(axis=1)
        block_area = self.model.blocks.moments.area
        triangles, points = _quadratic_triangles(self.basis)
        spin = (gradient[:, 1, 0] - gradient[:, 0, 1]) / 2
        reaction = K @ u - self.load
        node_dofs = nodal_unknowns(self.basis)
        return ContinuumSolution(
            elasticity=elasticity,
            stress=_over_blocks(stress, area, self.mesh.block, block_area),
            displacement=np.column_stack(
                [*(part @ u for part in self.averages), _over_blocks(spin, area, self.mesh.block, block_area)]
            ),
            points=points,
            point_displacement=u[node_dofs],
            triangles=triangles,
            triangle_block=self.mesh.block,
            triangle_stress=stress,
            total_load=self.load[node_dofs].sum(axis=0),
            total_reaction=reaction[node_dofs].sum(axis=0),
            unknowns=int(self.basis.N - self.supports.held.sum()),
            seconds=self.seconds + time.perf_counter() - began,
            notes=(*_departures(self.model, self.interfaces is not None), *notes),
        )


def _departures(model: Model, interfaces: bool) -> tuple[str, ...]:
    """Return what the continuum leaves out of the model or treats in its own way, a sentence each."""
    notes = []
    joint = face_joints(model, find_faces(model.blocks))
    count = int((joint >= 0).sum())
    if count:
        names = ", ".join(f"'{model.joints[number].name}'" for number in np.unique(joint[joint >= 0]))
        what = (
            "are elastic interface elements, which neither slip nor open"
            if interfaces
            else "are taken as unbroken rock"
        )
        notes.append(f"joints{'' if interfaces else ' are ignored'}: {count} of {len(joint)} faces ({names}) {what}")
    if any(isinstance(load, PointLoad) for load in model.loads):
        notes.append("point loads are spread over their blocks, with the same force, moment and average stress")
    if model.in_situ is not None and model.in_situ.method == "direct":
        notes.append("the in-situ field is not set: weights and loads are turned on")
    if model.bolts:
        notes.append(f"bolts are left out: {len(model.bolts)}")
    return tuple(notes)


def _block_averages(basis: Any, block: IntArray, area: FloatArray) -> tuple[Any, Any]:
    """Return the sparse matrices (n_blocks, N) that give the blocks' average displacement in x and in y."""
    import skfem

    constant = basis.with_element(skfem.ElementTriP0())
    gather = sp.csr_matrix((np.ones(len(block)), (block, np.arange(len(block)))), shape=(len(area), len(block)))
    gather = sp.diags(1 / area) @ gather
    x, y = (
        sp.csr_matrix(gather @ skfem.BilinearForm(lambda u, v, _, axis=axis: u[axis] * v).assemble(basis, constant))
        for axis in (0, 1)
    )
    return x, y


def _anisotropic(basis: Any, stiffness: FloatArray) -> Any:
    """Return the stiffness matrix of a material that differs from triangle to triangle, (t, 3, 3)."""
    import skfem
    from skfem.helpers import sym_grad

    C = stiffness.transpose(1, 2, 0)[:, :, :, None]

    def strain(field: Any) -> tuple[Any, Any, Any]:
        e = sym_grad(field)
        return e[0, 0], e[1, 1], 2 * e[0, 1]

    @skfem.BilinearForm
    def form(u: Any, v: Any, _: Any) -> Any:
        of_u, of_v = strain(u), strain(v)
        return sum(sum(C[i, j] * of_u[j] for j in range(3)) * of_v[i] for i in range(3))

    return form.assemble(basis)


def _mean_gradient(basis: Any, u: FloatArray) -> FloatArray:
    """Return the average displacement gradient H[i, j] = du_i/dx_j of every triangle, (t, 2, 2)."""
    total = np.einsum("ijtq,tq->tij", basis.interpolate(u).grad, basis.dx)
    mean: FloatArray = total / basis.dx.sum(axis=1)[:, None, None]
    return mean


def _stress(gradient: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Return the stress (t, 2, 2) [Pa] under a displacement gradient."""
    H = gradient
    strain = np.stack([H[:, 0, 0], H[:, 1, 1], H[:, 0, 1] + H[:, 1, 0]], axis=1)
    xx, yy, xy = np.einsum("tij,tj->it", stiffness, strain)
    return np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2)


def _over_blocks(values: FloatArray, area: FloatArray, block: IntArray, block_area: FloatArray) -> FloatArray:
    """Return the area-weighted mean over each block of a value a triangle (t, ...)."""
    total = np.zeros((len(block_area), *values.shape[1:]))
    np.add.at(total, block, values * area.reshape(-1, *(1,) * (values.ndim - 1)))
    mean: FloatArray = total / block_area.reshape(-1, *(1,) * (values.ndim - 1))
    return mean


def _quadratic_triangles(basis: Any) -> tuple[IntArray, FloatArray]:
    """Return the triangles in VTK's order, counter-clockwise, and the coordinates of all nodes."""
    mesh = basis.mesh
    corners = mesh.p[:, mesh.t]
    side1, side2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    clockwise = side1[0] * side2[1] - side1[1] * side2[0] < 0
    nodes = mesh.t if not basis.facet_dofs.size else np.vstack([mesh.t, mesh.p.shape[1] + mesh.t2f])
    # Sides of skfem's triangles: 0-1, 1-2, 0-2. Turned round, the corners are 0, 2, 1 and the sides 0-2, 2-1, 1-0.
    turned = nodes[[0, 2, 1, 5, 4, 3][: len(nodes)]]
    triangles: IntArray = np.where(clockwise, turned, nodes).T.astype(np.int32)
    points: FloatArray = basis.doflocs[:, nodal_unknowns(basis)[:, 0]].T
    return np.ascontiguousarray(triangles), np.ascontiguousarray(points)
