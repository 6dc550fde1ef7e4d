"""The same cells with nodes of their own in every block: forces between blocks that share nodes.

Rock without a joint is one piece: blocks there share nodes, and the solution knows no force between them. If the cells
of different blocks share no node, the forces at the nodes of every block are known. Neighbours and supports balance
them. Statics does not determine the share of each face at a node of several blocks: it is the least, as in a network of
equal conductors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import ContactForces, ContactStatus
from bsm_mesh.solve.algebra.loads import force_sums
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts
from bsm_mesh.solve.zones.fields import block_averages, forces_of_stress
from bsm_mesh.solve.zones.ground import PoreWater
from bsm_mesh.solve.zones.interfaces import Interfaces, interfaces_between, opened, shared_pieces
from bsm_mesh.solve.zones.joint_history import JointHistory
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.loads import load_vector, weightless
from bsm_mesh.solve.zones.mesh import ContinuumMesh, Discretization
from bsm_mesh.solve.zones.met_points import with_met
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.placed_points import joint_points
from bsm_mesh.solve.zones.supports import nodal_unknowns, support_rows
from bsm_mesh.solve.zones.zone_faces import ZoneFaces

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stage_solution import StageEnd


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Apart:
    """The cells, with no node in two blocks.

    Attributes
    ----------
    model : Model
        The input.
    mesh, basis
        The cells, and the basis of the vector-valued element on them.
    facets : (k, 2) int32
        Pairs of facets that lie on each other.
    whole : (l, 2) int32
        Pairs of pieces of edges where blocks are one piece of rock.
    merged_dof : (M,) int32
        The unknown that is solved for, of every unknown here.
    unknowns : int
        How many are solved for.
    joints : JointPoints or None
        The points of joints on these cells.
    bolts : EmbeddedBolts or None
        The bolts on these cells.
    averages : pair of sparse (n_blocks, M)
        Give the blocks' average displacement in x and y.
    """

    model: Model
    mesh: ContinuumMesh
    basis: Any
    facets: IntArray
    whole: IntArray
    merged_dof: IntArray
    unknowns: int
    joints: JointPoints | None
    bolts: EmbeddedBolts | None
    averages: tuple[Any, Any]

    @classmethod
    def of(
        cls, model: Model, whole: ContinuumMesh, interfaces: Interfaces | None, basis: Any, elements: Discretization
    ) -> Apart:
        """Return the cells of a mesh apart.

        Parameters
        ----------
        model : Model
            Its blocks, joints and bolts.
        whole : ContinuumMesh
            The cells before joints were opened.
        interfaces : Interfaces or None
            Those of the cells that are solved for.
        basis : skfem.CellBasis
            Of these.
        elements : Discretization
            Their order.
        """
        import skfem

        one, other, _ = shared_pieces(model, whole)
        pairs = np.stack([one, other], axis=1).astype(np.int32)
        mesh = opened(model, whole, whole.piece_facet[one])
        own = skfem.CellBasis(mesh.mesh, basis.elem)
        merged = np.zeros(own.N, dtype=np.int32)
        merged[own.element_dofs] = basis.element_dofs
        joints, is_open = None, np.zeros(len(pairs), dtype=bool)
        if interfaces is not None and (interfaces.joint.size or elements.large):
            is_open = np.isin(one, interfaces.pieces)
            between = interfaces_between(mesh, interfaces.pieces, interfaces.joint)
            faces = ZoneFaces.of(model, whole, mesh, elements.order) if elements.large else None
            joints = joint_points(model, mesh, between, own, elements.order, faces)
        bolts = EmbeddedBolts.of(model, mesh, own, straight=not elements.large) if model.bolts else None
        return cls(
            model=model,
            mesh=mesh,
            basis=own,
            facets=mesh.piece_facet[pairs],
            whole=pairs[~is_open],
            merged_dof=merged,
            unknowns=basis.N,
            joints=joints,
            bolts=bolts,
            averages=block_averages(own, mesh.block, model.blocks.moments.area),
        )

    @property
    def loaded(self) -> tuple[ContinuumMesh, Any, IntArray]:
        """The cells on which loads act, as `Continuum.loaded` returns them."""
        return self.mesh, self.basis, self.facets

    @property
    def node_block(self) -> IntArray:
        """Block of every node."""
        nodes = np.zeros(self.basis.N, dtype=np.int32)
        nodes[self.basis.element_dofs] = self.mesh.block
        found: IntArray = nodes[nodal_unknowns(self.basis)[:, 0]]
        return found

    def merged(self, forces: FloatArray) -> FloatArray:
        """Return forces (M,) as forces on the unknowns that are solved for."""
        return np.bincount(self.merged_dof, forces, minlength=self.unknowns).astype(np.float64)

    def held_back(self, end: StageEnd) -> FloatArray:
        """Return the part of excavation forces that is held back, (M,) [N/m], shared by the blocks at a node."""
        there = end.present[self.node_block][self._node_of_dof].astype(np.float64)
        sharing = np.maximum(self.merged(there), 1.0)
        shared: FloatArray = there * (end.held_back / sharing)[self.merged_dof]
        return shared

    @property
    def _node_of_dof(self) -> IntArray:
        node = np.zeros(self.basis.N, dtype=np.int32)
        unknowns = nodal_unknowns(self.basis)
        node[unknowns] = np.arange(len(unknowns))[:, None]
        return node

    def left_of_water(
        self, water: PoreWater, found: FloatArray, history: JointHistory | None, present: BoolArray
    ) -> FloatArray:
        """Return what integration leaves of the water on every block that is there, spread over it, (M,) [N/m].

        Where the table crosses a cell, or a joint's own pressure ends at it, points of integration see it in part. With
        this the water's force and moment on every block are exact.

        Parameters
        ----------
        water : PoreWater
            The table.
        found : (M,) float64 [N/m]
            Forces by integration over the rock.
        history : JointHistory or None
            Has the pressures of the joints' own water.
        present : (n,) bool
            Which blocks are there.
        """
        model, blocks = self.model, self.model.blocks
        if self.joints is not None and history is not None:
            between = present[self.joints.block].all(axis=1)
            found = found + self.joints.opening_rows.T @ (history.water * between)
        left = (
            water.load.of_present(present).on_blocks(blocks.vertices, blocks.moments.centroid)
            - self.sums(found, *self.as_given)
        ) * present[:, None]
        block, arm = np.arange(blocks.count, dtype=np.int32), np.zeros((blocks.count, 2))
        arm[:, 0] = blocks.moments.gyration
        turning = np.stack([np.zeros(blocks.count), left[:, 2] / (2 * arm[:, 0])], axis=1)
        centroid = blocks.moments.centroid
        forces = PointForces(
            block=np.tile(block, 3),
            point=np.concatenate([centroid, centroid + arm, centroid - arm]),
            force=np.concatenate([left[:, :2], turning, -turning]),
        )
        return load_vector(weightless(model), self.mesh, self.basis, [forces], present)

    def placed(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where nodes (k, 2) and centroids (n, 2) are [m], at displacements u (N,) of the unknowns."""
        own, (node, centroid) = u[self.merged_dof], self.as_given
        moved = np.stack([part @ own for part in self.averages], axis=1)
        return node + own[nodal_unknowns(self.basis)], centroid + moved

    @property
    def as_given(self) -> tuple[FloatArray, FloatArray]:
        """Nodes (k, 2) and centroids (n, 2) as given [m]."""
        return self.basis.doflocs[:, nodal_unknowns(self.basis)[:, 0]].T, self.model.blocks.moments.centroid

    def sums(self, forces: FloatArray, node: FloatArray, centroid: FloatArray) -> FloatArray:
        """Return the sums of forces at nodes (M,) [N/m] on every block, (n, 3): Fx, Fy, moment about the centroid.

        `node` (k, 2) and `centroid` (n, 2) are where nodes and centroids are [m].
        """
        return force_sums(self.nodal_forces(forces, node), centroid)

    def nodal_forces(self, forces: FloatArray, node: FloatArray) -> PointForces:
        """Return forces (M,) [N/m] that are not zero as forces at nodes, which are at (k, 2) [m]."""
        nodal = forces[nodal_unknowns(self.basis)]
        acting = np.flatnonzero(nodal.any(axis=1))
        return PointForces(block=self.node_block[acting], point=node[acting], force=nodal[acting])

    def out_of_balance(self, end: StageEnd) -> FloatArray:
        """Return what supports and faces of whole rock have to balance in every block, (M,) [N/m]."""
        block, size = self.mesh.block, self.basis.N
        on = end.present[block]
        u = end.u[self.merged_dof]
        for fill in end.fills:
            filled = fill.blocks[self.node_block][self._node_of_dof]
            u = u - filled * fill.u[self.merged_dof]
        if end.large is not None:
            rock, dofs = end.large.rock, self.basis.element_dofs
            internal = rock.forces(rock.at(u, dofs), dofs, size)
        else:
            internal = end.rock.forces(on, u, self.basis.element_dofs, size)
            given = end.without_strain(block)
            if given is not None:
                internal = internal + forces_of_stress(self.basis, given)
        joints = self.joints
        if joints is not None and end.at.state is not None and end.history is not None:
            if isinstance(joints, MovingPoints) and isinstance(end.joints, MovingPoints):
                joints = with_met(joints, end.joints.met).facing(end.joints.places)
            internal = internal + joints.forces(u, end.at.state, end.history)
        if self.bolts is not None and end.bolts is not None and end.at.bolts is not None:
            internal = internal - replace(end.bolts, rows=self.bolts.rows).forces(end.at.bolts)
        return end.load - self.held_back(end) - internal

    def reactions(self, end: StageEnd) -> FloatArray:
        """Return the forces of the supports on every block's nodes, (M,) [N/m].

        Blocks that share a held node share its reaction, as far as a support holds them there.
        """
        model = end.model
        given = support_rows(model.supports, model.blocks, self.mesh, self.basis, self.averages, end.present)
        of_rows = -(given.rows.T @ end.at.multipliers)
        total = -end.at.residual - self.merged(of_rows)
        node, direction, _ = given.nodal
        unknowns = nodal_unknowns(self.basis)
        merged = self.merged_dof[unknowns[node]]
        gram = np.zeros((self.unknowns, 2, 2))
        np.add.at(gram, merged[:, 0], direction[:, :, None] * direction[:, None, :])
        held = np.unique(merged[:, 0])
        share = np.zeros((self.unknowns, 2))
        both = np.zeros((self.unknowns, 2))
        both[merged[:, 0]] = total[merged]
        share[held] = np.einsum("kij,kj->ki", np.linalg.pinv(gram[held], rcond=1e-9, hermitian=True), both[held])
        size = (share[merged[:, 0]] * direction).sum(axis=1)
        found: FloatArray = np.asarray(of_rows, dtype=np.float64)
        np.add.at(found, unknowns[node], size[:, None] * direction)
        return found

    def ties(self, end: StageEnd, left: FloatArray, node: FloatArray) -> ContactForces:
        """Return the forces between blocks where they are one piece of rock, as contacts at the nodes of their faces.

        Parameters
        ----------
        end : StageEnd
            Which blocks are there.
        left : (M,) float64 [N/m]
            Unbalanced forces and reactions.
        node : (k, 2) float64 [m]
            Where the nodes are.
        """
        mesh, count = self.mesh, self.mesh.mesh.p.shape[1]
        owner = mesh.block[mesh.mesh.f2t[0, mesh.piece_facet]]
        pairs = self.whole[end.present[owner[self.whole]].all(axis=1)]
        one, other = pairs.T
        ends = mesh.piece_ends
        nodes = [(ends[one, 0], ends[other, 1]), (ends[one, 1], ends[other, 0])]
        weight = np.array([0.5, 0.5])
        if self.basis.facet_dofs.size:
            nodes.insert(1, (count + mesh.piece_facet[one], count + mesh.piece_facet[other]))
            weight = np.array([1.0, 4.0, 1.0]) / 6
        first, second = (np.stack(side, axis=1).ravel() for side in zip(*nodes, strict=True))  # piece after piece
        unknowns = nodal_unknowns(self.basis)
        flow = _flows(first, second, left[unknowns])
        start, finish = (node[ends[one, k]] for k in (0, 1))
        along = finish - start
        length = np.hypot(*along.T)
        tangent = along / np.maximum(length, np.finfo(float).tiny)[:, None]
        normal = np.repeat(np.stack([tangent[:, 1], -tangent[:, 0]], axis=1), len(weight), axis=0)
        m, zero = len(flow), np.zeros(len(flow))
        return ContactForces(
            block_a=np.repeat(owner[other], len(weight)),
            block_b=np.repeat(owner[one], len(weight)),
            point=node[first],
            normal=normal,
            length=(length[:, None] * weight).ravel(),
            normal_force=(flow * normal).sum(axis=1),
            shear_force=flow[:, 1] * normal[:, 0] - flow[:, 0] * normal[:, 1],
            opening=zero,
            slip=zero,
            status=np.full(m, int(ContactStatus.STICKING), dtype=np.int8),
            utilisation=zero,
            joint=np.full(m, -1, dtype=np.int32),
            water_pressure=zero,
        )


def _flows(first: IntArray, second: IntArray, left: FloatArray) -> FloatArray:
    """Return the forces (k, 2) on the first of two nodes of each pair (k,) that balance `left` (nodes, 2) at all nodes.

    Of all that do so, those with the least sum of squares.
    """
    if not len(first):
        return np.zeros((0, 2))
    size, weight = len(left), np.ones(len(first))
    graph = sp.coo_matrix((weight, (first, second)), shape=(size, size)).tocsr()
    together = graph + graph.T
    laplacian = sp.diags(np.asarray(together.sum(axis=1)).ravel()) - together
    _, part = connected_components(graph, directed=False)
    pinned = np.zeros(size)
    pinned[np.unique(part, return_index=True)[1]] = 1.0  # the sum over a part is zero, and so is its first potential
    potential = splu(sp.csc_matrix(laplacian + sp.diags(pinned)), permc_spec="MMD_AT_PLUS_A").solve(left)
    found: FloatArray = potential[second] - potential[first]
    return found
