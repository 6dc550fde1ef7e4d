"""The continuum through the stages of construction, as the Block-Spring Model goes through them.

A stage takes cells away or puts them back and brings loads, a pressure on the new faces, water, bolts and another
strength; the forces that the removed rock exerted on the rest are released by parts. Rock is elastic or yields, and
displacements are small or large; joints and bolts keep their history.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import presence
from bsm_mesh.solve.zones import departures
from bsm_mesh.solve.zones.apart import Apart
from bsm_mesh.solve.zones.elasticity import BlockElasticity
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts
from bsm_mesh.solve.zones.fields import block_averages
from bsm_mesh.solve.zones.interfaces import open_joints
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.mesh import ContinuumMesh, Discretization, continuum_mesh
from bsm_mesh.solve.zones.placed_points import joint_points
from bsm_mesh.solve.zones.solution import ContinuumSolution
from bsm_mesh.solve.zones.stage_run import StageRun
from bsm_mesh.solve.zones.stage_solution import stage_solution
from bsm_mesh.solve.zones.system import refuse_loose
from bsm_mesh.solve.zones.zone_faces import ZoneFaces


class Continuum:
    """A model's mesh and joints in scikit-fem, ready to be solved with different elastic constants.

    Parameters
    ----------
    model : Model
        The model.
    discretization : Discretization
        Elements and interfaces.
    present : sequence of (n,) bool or None
        Blocks that are there in the first stages, if a run lost some that its stages do not take away. The pressures of
        stages do not act on faces of lost blocks.
    mesh : ContinuumMesh, optional
        Its cells; None: those of the discretization. With given cells the forces between blocks that share nodes are
        worked out too (`apart`).
    """

    def __init__(
        self,
        model: Model,
        discretization: Discretization,
        present: Sequence[BoolArray] | None = None,
        mesh: ContinuumMesh | None = None,
    ) -> None:
        import skfem

        departures.refuse(model, discretization.joints, at_rest=mesh is None)
        began = time.perf_counter()
        self.model, self.discretization = model, discretization
        self.as_planned = presence(model.stages, model.blocks)
        self.presence = self.as_planned if present is None else list(present)
        whole = self.mesh = continuum_mesh(model.blocks, discretization) if mesh is None else mesh
        interfaces = None
        if discretization.joints:
            self.mesh, interfaces = open_joints(model, self.mesh, self.presence, discretization.rock_breaks)
        elements = {
            False: (skfem.ElementTriP1, skfem.ElementTriP2),
            True: (skfem.ElementQuad1, skfem.ElementQuadS2),
        }[self.mesh.are_quads]
        element = elements[discretization.order - 1]()
        self.basis = skfem.CellBasis(self.mesh.mesh, skfem.ElementVector(element))
        self.averages = block_averages(self.basis, self.mesh.block, model.blocks.moments.area)
        self.joints: JointPoints | None = None
        self.facets = np.zeros((0, 2), dtype=np.int32)
        self.ties = np.zeros((2, 0), dtype=np.int32)
        faces: ZoneFaces | None = None
        if interfaces is not None and discretization.large:
            faces = ZoneFaces.of(model, whole, self.mesh, discretization.order)
            interfaces = faces.chains.with_ends_covered(interfaces)
        if interfaces is not None and (interfaces.joint.size or faces is not None):
            self.joints = joint_points(model, self.mesh, interfaces, self.basis, discretization.order, faces)
            self.facets = interfaces.facet
            self.ties = self.basis.nodal_dofs[0, interfaces.vertex.T]
        self.apart = None if mesh is None else Apart.of(model, whole, interfaces, self.basis, discretization)
        self.bolts: EmbeddedBolts | None = None
        if model.bolts:
            how = {"elastic": discretization.elastic_bolts, "straight": mesh is not None and not discretization.large}
            self.bolts = EmbeddedBolts.of(model, self.mesh, self.basis, **how)
        self.seconds = time.perf_counter() - began

    def solve(
        self, elasticity: BlockElasticity, count: int | None = None, near: Sequence[FloatArray] = ()
    ) -> tuple[ContinuumSolution, ...]:
        """Return the first `count` stages with these elastic constants, up to the first without equilibrium.

        Each is sought from where the last left the rock, or, for as many as have one, near positions of the blocks,
        (n, 3) each [m, m, rad].
        """
        began = time.perf_counter()
        notes = (
            *departures.notes(self.model, self.joints is not None, self.discretization.rock_breaks),
            *elasticity.notes,
        )
        found: list[ContinuumSolution] = []
        run = StageRun(self, elasticity.stiffness[self.mesh.block])
        for number in range(len(self.presence) if count is None else min(count, len(self.presence))):
            end = run.end_of(number, near[number] if number < len(near) else None)
            refuse_loose(end.loose)
            seconds = self.seconds + time.perf_counter() - began
            found.append(stage_solution(self, end, elasticity.name, seconds, notes))
            if not found[-1].converged:
                break
        return tuple(found)

    @property
    def loaded(self) -> tuple[ContinuumMesh, Any, IntArray]:
        """The cells on which loads act, their basis, and pairs of facets that lie on each other, (k, 2)."""
        return (self.mesh, self.basis, self.facets) if self.apart is None else self.apart.loaded

    def merged(self, forces: FloatArray) -> FloatArray:
        """Return forces on the cells of `loaded` as forces on the unknowns, (N,) [N/m]."""
        return forces if self.apart is None else self.apart.merged(forces)
