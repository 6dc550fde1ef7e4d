"""The rock of zones at its nodes, as the cycles of explicit motion take it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.motion.contact_columns import CLOSURE, CONTACT, GROWTH, SLIP, STRENGTH, WORK
from bsm_mesh.solve.motion.real_masses import critical_dashpots
from bsm_mesh.solve.zones.equilibrium import Equations, Iterate
from bsm_mesh.solve.zones.joint_history import JointHistory
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.large_rock import LargeRock
from bsm_mesh.solve.zones.moving_points import MovingPoints
from bsm_mesh.solve.zones.supports import HeldDisplacements, nodal_unknowns
from bsm_mesh.solve.zones.tangents import PointStiffness
from bsm_mesh.solve.zones.zone_masses import cell_masses, sums_of_cells, sums_of_points

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stages import Continuum


class MovingRock:
    """Nodes, masses and supports of the rock that is there.

    Parameters
    ----------
    of : Continuum
        The cells.
    stiffness : (t, 3, 3) float64 [Pa]
        Of every cell.
    present : (n,) bool
        Which blocks are there.
    equations : Equations
        Of the rock.
    outer : (N,) float64 [N/m]
        Weight, loads and water.

    Attributes
    ----------
    nodes : (k, 2) int
        Unknowns of every node.
    extent : float [m]
        Width or height of all blocks as given, the larger.
    mass : (k,) float64 [kg/m]
        Of the nodes; 0 where no cell is there.
    moves : (k,) bool
        Which nodes supports do not hold in all directions.
    own, supports : (f,) uint32, tuple of arrays
        Nodes without a support, and those with one, as `advance_zones` takes them.
    block : (c,) int
        Block of every cell with a node that moves.
    parts : sparse (n, k)
        Parts of the mass of every block at nodes.
    in_joints : (N,) float64 [N/m]
        Forces of the water in joints, which small displacements do not turn.
    pieces : (k,) int32, (p, 5) float64
        Pieces of rock without a support of every node, -1: none, and room for each, as `advance_zones` takes them.
    cells : tuple of arrays
        These cells, as `advance_zones` takes them.
    """

    def __init__(
        self, of: Continuum, stiffness: FloatArray, present: BoolArray, equations: Equations, outer: FloatArray
    ) -> None:
        basis, block = of.basis, of.mesh.block
        on = present[block]
        self.outer = outer
        self.nodes = nodal_unknowns(basis)
        self.extent = float(np.ptp(basis.doflocs, axis=1).max())
        self._node_of = np.zeros(basis.N, dtype=np.int64)
        self._node_of[self.nodes] = np.arange(len(self.nodes))[:, None]
        corner = self._node_of[basis.element_dofs[::2]]
        masses = cell_masses(of.model, basis, block, on)
        self.mass = np.bincount(corner.ravel(), masses.ravel(), len(self.nodes)).astype(np.float64)
        self._own_mass = self.mass
        self.parts = _mass_parts(masses[:, on], block[on], corner[:, on], (len(present), len(self.nodes)))
        self.in_joints = np.zeros(basis.N)
        if equations.large is None and equations.joints is not None and equations.history is not None:
            water = equations.history.water * equations.history.present
            self.in_joints = equations.joints.opening_rows.T @ water
        self._dofs = basis.element_dofs
        rock = LargeRock.of(basis, stiffness, on, None) if equations.large is None else equations.large.rock
        self._of_cells = sums_of_cells(rock.entries(rock.at(np.zeros(basis.N), self._dofs)), corner.T, len(self.nodes))
        self._rows: tuple[JointPoints | None, Any] = (None, None)
        self._set_supports(equations.free.supports)
        moving = self.moves[corner].any(axis=0)  # the others keep their stress, on nodes that supports hold
        initial = np.zeros((*rock.weight.shape, 3)) if rock.initial is None else rock.initial
        parts = corner.T.astype(np.uint32), rock.gradient, rock.weight, rock.stiffness, initial
        self.block = block[moving]
        self.pieces = self._free_pieces(corner[:, on])
        self.cells: tuple[Any, ...] = (
            *(np.ascontiguousarray(part[moving]) for part in parts),
            equations.large is not None,
        )

    def _set_supports(self, held: HeldDisplacements) -> None:
        """Set the nodes with a support, and projectors onto their free directions."""
        if held.rows.shape[0]:
            raise ModelError(
                "a support that holds blocks, or a point between nodes, cannot hold zones that are shaken; hold a "
                "boundary, fix the blocks, or leave zones out"
            )
        given = held.held[self.nodes]
        rows = np.flatnonzero(given.any(axis=1))
        axes = np.broadcast_to(np.eye(2), (len(rows), 2, 2))
        if held.turn is not None:
            turn = sp.csr_matrix(held.turn)
            at = self.nodes[rows]
            axes = np.stack(
                [np.stack([np.asarray(turn[at[:, i], at[:, j]]).ravel() for j in (0, 1)], axis=1) for i in (0, 1)],
                axis=1,
            )
        projector = np.zeros((len(rows), 3, 3))
        projector[:, :2, :2] = np.einsum("kij,kj,klj->kil", axes, ~given[rows], axes)
        self._projector, self._supported = projector, rows
        self.moves = (self.mass > 0) & ~given.all(axis=1)
        self.own = np.flatnonzero((self.mass > 0) & ~given.any(axis=1)).astype(np.uint32)
        still = np.zeros((len(self.mass), 3))
        self.supports = rows.astype(np.uint32), projector, still

    def _free_pieces(self, corner: IntArray) -> tuple[IntArray, FloatArray]:
        """Return `pieces` of cells with nodes (w, t): blocks that share nodes are one piece."""
        count = len(self.nodes)
        pairs = np.tile(corner[0], len(corner)), corner.ravel()  # each cell ties its first node to all its others
        graph = sp.coo_matrix((np.ones(len(pairs[0]), np.int8), pairs), shape=(count, count))
        total, piece = connected_components(graph, directed=False)
        stays = np.zeros(total, dtype=bool)
        stays[piece[np.append(self._supported, np.flatnonzero(self.mass <= 0))]] = True
        return np.where(stays[piece], -1, piece).astype(np.int32), np.zeros((total, 5))

    def projected(self, vectors: FloatArray) -> FloatArray:
        """Return vectors at nodes (k, 3) with those at supports along their free directions only."""
        found = vectors.copy()
        found[self._supported] = np.einsum("kij,kj->ki", self._projector, vectors[self._supported])
        found[self.mass <= 0] = 0.0
        return found

    def on_nodes(self, forces: FloatArray) -> FloatArray:
        """Return forces on unknowns (N,) at the nodes, (k, 3)."""
        found = np.zeros((len(self.nodes), 3))
        found[:, :2] = forces[self.nodes]
        return found

    def strain_energy(self, equations: Equations, u: FloatArray) -> float:
        """Return the strain energy of the rock at displacements u (N,), [N]."""
        if equations.large is None:
            return float(u @ (equations.stiffness @ u) / 2)
        return equations.large.rock.energy(u, self._dofs)

    def points(self, joints: JointPoints, history: JointHistory, u: FloatArray) -> tuple[Any, FloatArray]:
        """Return points of joints as kernels take them, and derivatives of opening and slip (q, 2, m, 2)."""
        opening, slip = joints.relative(u)
        water = history.water * history.present
        if isinstance(joints, MovingPoints):
            nodes = self._node_of[joints.unknown[:, ::2]].astype(np.uint32)
            rows = np.ascontiguousarray(np.repeat(joints.parts[..., None], 2, axis=3))
            gradient, given, slid = joints.gradients(u).reshape(rows.shape), joints.given, joints.places.slid
        else:
            if self._rows[0] is not joints:
                self._rows = joints, _dense(joints, self._node_of, self.nodes)
            nodes, rows = self._rows[1]
            gradient, given, slid = rows, np.zeros((0, 2, 2)), np.zeros_like(slip)
        return (nodes, rows, given, np.column_stack([opening, slip, slid]), water), gradient

    def critical_dashpots(self, joints: JointPoints, nodes: IntArray, gradient: FloatArray) -> FloatArray:
        """Return the critical dashpots of points across joints, (q,) [N s/m2]; their nodes and derivatives given."""
        inverse = np.divide(1.0, self.mass, out=np.zeros_like(self.mass), where=self.moves)
        sums = (gradient[:, 0] ** 2 * inverse[nodes][:, :, None]).sum(axis=(1, 2))
        return critical_dashpots(joints.normal_stiffness, sums)

    def be_heavier(self, least: FloatArray) -> None:
        """Let every node have its own mass, or a least one (k,) [kg/m] where that is greater."""
        self.mass = np.where(self._own_mass > 0, np.maximum(self._own_mass, least), 0.0)

    @property
    def of_unknowns(self) -> FloatArray:
        """Masses of the unknowns, (N,) [kg/m]."""
        found = np.zeros_like(self.outer)
        found[self.nodes] = self.mass[:, None]
        return found

    def stiffness_sums(self, equations: Equations, at: Iterate, springs: FloatArray) -> FloatArray:
        """Return the stiffness sums of nodes (k,) [Pa], as springs to the ground that are stiffer than all there is.

        Points of joints have springs (q,) [Pa].
        """
        found = self._of_cells.copy()
        if equations.joints is not None and equations.history is not None:
            points, gradient = self.points(equations.joints, equations.history, at.u)
            found += sums_of_points(springs, gradient, points[0], len(found))
        if equations.bolts is not None and at.bolts is not None:
            K = abs(sp.csr_matrix(equations.bolts.tangent(at.bolts)))
            found += np.asarray(K.sum(axis=1)).ravel()[self.nodes].max(axis=1)
        return found

    def bolts(self, equations: Equations, at: Iterate) -> Any:
        """Return the stiffness and the forces of bolts, as kernels take them."""
        where = self.on_nodes(at.u)
        if equations.bolts is None or at.bolts is None:
            return np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0), np.zeros_like(where), where
        order = self.nodes.ravel()
        K = sp.csr_matrix(sp.csr_matrix(equations.bolts.tangent(at.bolts))[order][:, order])
        return K.indptr, K.indices, K.data, self.on_nodes(equations.bolts.forces(at.bolts)), where

    def stiffness(self, equations: Equations, at: Iterate, points: FloatArray) -> Any:
        """Return the stiffness (free, free) with all joints closed, their springs (q,) [Pa] as stiff as given."""
        joints, none = equations.joints, np.zeros_like(points)
        springs = None if joints is None else PointStiffness(points, points, none, none)
        if equations.large is None:
            K = equations.tangents.at(springs)
        else:
            K = equations.large.tangent(at.u, joints, at.state, springs)
        if equations.bolts is not None and at.bolts is not None:
            K = K + equations.free.reduced_matrix(equations.bolts.tangent(at.bolts))
        return K

    @property
    def no_points(self) -> Any:
        """Points of no joint, as kernels take them."""
        empty = np.zeros((0, 2, 1, 2))
        return np.zeros((0, 1), np.uint32), empty, np.zeros((0, 2, 2)), np.zeros((0, 3)), np.zeros(0)

    @property
    def no_laws(self) -> dict[str, Any]:
        """Laws of no joint."""
        names = {"contacts": CONTACT, "strengths": STRENGTH, "closures": CLOSURE, "slips": SLIP}
        return {name: np.zeros(0, kind) for name, kind in (names | {"growths": GROWTH, "works": WORK}).items()}


def _mass_parts(masses: FloatArray, block: IntArray, corner: IntArray, shape: tuple[int, int]) -> Any:
    """Return the parts of blocks' masses at their nodes, sparse (n, k), from masses of cells (w, t)."""
    columns = masses.ravel(), (np.tile(block, len(masses)), corner.ravel())
    whole = sp.csr_matrix(columns, shape=shape)
    whole.data /= np.repeat(np.asarray(whole.sum(axis=1)).ravel(), np.diff(whole.indptr))
    return whole


def _dense(joints: JointPoints, node_of: IntArray, nodes: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the nodes of points (q, m), and opening and slip from their displacements (q, 2, m, 2)."""
    parts = [sp.coo_matrix(rows) for rows in (joints.opening_rows, joints.slip_rows)]
    row = np.concatenate([part.row for part in parts]).astype(np.int64)
    column = np.concatenate([part.col for part in parts]).astype(np.int64)
    which = np.repeat([0, 1], [len(part.row) for part in parts])
    node = node_of[column]
    pair, number = np.unique(row * len(nodes) + node, return_inverse=True)
    point = pair // len(nodes)
    place = np.arange(len(pair)) - np.searchsorted(point, point)
    width = int(place.max(initial=0)) + 1
    found = np.zeros((len(joints.length), 2, width, 2))
    of_point: Any = np.zeros((len(joints.length), width), np.uint32)  # as the list of kernels has it
    of_point[point, place] = pair % len(nodes)
    axis = (nodes[node, 1] == column).astype(np.int64)
    np.add.at(found, (row, which, place[number.reshape(-1)], axis), np.concatenate([part.data for part in parts]))
    return of_point, found
