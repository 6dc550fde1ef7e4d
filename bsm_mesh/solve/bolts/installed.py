"""Installed bolts: state of accepted steps, forces at a position, tangent."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.bolt_layout import BoltLayout, lay_out_bolts
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.bolts.chain import AT_LIMIT
from bsm_mesh.solve.bolts.dowels import DowelEvaluation, Dowels
from bsm_mesh.solve.bolts.evaluation import BoltEvaluation
from bsm_mesh.solve.bolts.geometry import BoltGeometry, geometry_of
from bsm_mesh.solve.bolts.kernels import (
    add_bolt_forces,
    add_bolt_tangent,
    bolt_couplings,
    couple,
    element_lines,
    find_places,
    solve_bolts,
)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class InstalledBolts:
    """The bolts of a model with their state after accepted steps.

    Attributes
    ----------
    layout : BoltLayout
        Nodes and elements.
    pairs : two (n_pairs,) int32
        Different blocks that a bolt couples: each with every other on the same bolt.
    arm : (n_nodes, 2) or (n_nodes, 3) float64 [m]
        From the centroid of its block to each node, in the block's own axes.
    stiffness : (n_elements,) float64 [N/m]
        E A over length (Wang Eq. 5.2).
    alive : (n_elements,) bool
        Installed, and in blocks that are there.
    rest : (n_elements,) float64 [m]
        Length at zero tension, with pretension and plastic stretch.
    yielded : (n_elements,) float64 [m]
        Plastic stretch.
    anchor : (n_nodes,) float64 [m]
        Slip at zero bond force: where rigid, the slip so far.
    dowels : Dowels
        Where bolts that resist shear cross joints.
    """

    layout: BoltLayout
    pairs: tuple[IntArray, IntArray]
    arm: FloatArray
    stiffness: FloatArray
    alive: BoolArray
    rest: FloatArray
    yielded: FloatArray
    anchor: FloatArray
    dowels: Dowels

    @classmethod
    def of(cls, model: Model, position: FloatArray) -> InstalledBolts:
        """Return the bolts of a model, those without a stage installed at a position (n_blocks, axes).

        Raises
        ------
        ModelError
            For bolts that end in the void or run along an edge.
        """
        layout = lay_out_bolts(model.bolts, model.blocks, model.stages)
        bolts = cls._not_installed(layout, model.blocks.moments.centroid)
        return bolts.install(0, position)

    @classmethod
    def none(cls) -> InstalledBolts:
        """Return no bolts."""
        return cls._not_installed(BoltLayout.none(), np.zeros((0, 2)))

    @classmethod
    def at_points(cls, layout: BoltLayout) -> InstalledBolts:
        """Return bolts, none of them installed, in rock that is not rigid: what holds them moves point by point.

        Node k is fixed to a body of its own, k, and the near and the far side of crossing c are the bodies
        ``n_nodes + 2 c`` and ``n_nodes + 2 c + 1``; a position has a row a body. None of them has an arm.
        """
        nodes = len(layout.block)
        bolts = cls._not_installed(replace(layout, block=np.arange(nodes, dtype=np.int32)), layout.point)
        return replace(bolts, dowels=bolts.dowels.at_points(nodes))

    @classmethod
    def _not_installed(cls, layout: BoltLayout, centroid: FloatArray) -> InstalledBolts:
        first = layout.first_node
        length = layout.station[first + 1] - layout.station[first]
        return cls(
            layout=layout,
            pairs=(np.zeros(0, np.int32), np.zeros(0, np.int32)),
            arm=layout.point - centroid[layout.block],
            stiffness=layout.axial_stiffness[layout.bolt_of_element] / length,
            alive=np.zeros(len(first), dtype=bool),
            rest=length,
            yielded=np.zeros(len(first)),
            anchor=np.zeros(len(layout.block)),
            dowels=geometry_of(layout.point).dowels.of(layout, centroid),
        )

    @property
    def _geometry(self) -> BoltGeometry:
        return geometry_of(self.arm)

    @property
    def arrays(self) -> tuple[Any, ...]:
        """Nodes, elements and strength, as the kernels of explicit motion take them."""
        layout = self.layout
        return (
            layout.node_start,
            layout.block,
            self.arm,
            layout.point,
            layout.first_node,
            self.alive,
            self.stiffness,
            self.rest,
            layout.yield_force,
            layout.capacity,
            layout.bond_stiffness,
            self.anchor,
            layout.spacing,
        )

    def install(self, stage: int, position: FloatArray) -> InstalledBolts:
        """Return a copy with the bolts of a stage installed at a position: they are strained by later movements only.

        Parameters
        ----------
        stage : int
            Number of the stage; 0: bolts that name none.
        position : (n_blocks, axes) float64 [m, rad]
            Position at installation.
        """
        layout = self.layout
        if not self.alive.size:
            return self
        moved, _ = self._geometry.node_movements(position, layout.block, self.arm)
        length, _ = element_lines(layout.point, moved, layout.first_node)
        bolt = layout.bolt_of_element
        tensioned = length - layout.pretension[bolt] / self.stiffness
        chosen = (layout.stage == stage)[bolt]
        alive = self.alive | chosen
        return replace(
            self,
            pairs=coupled_pairs(layout, alive),
            alive=alive,
            rest=np.where(chosen, tensioned, self.rest),
            dowels=self.dowels.install(position, chosen),
        )

    def without(self, gone: BoolArray) -> InstalledBolts:
        """Return a copy cut where blocks (n_blocks,) are removed; the rest of a bolt stays active."""
        first = self.layout.first_node
        cut = gone[self.layout.block[first]] | gone[self.layout.block[first + 1]]
        alive = self.alive & ~cut
        return replace(self, pairs=coupled_pairs(self.layout, alive), alive=alive)

    def in_part(self, part: SubModel) -> InstalledBolts:
        """Return the bolts in the block numbers of a submodel; nodes of absent blocks have no force."""
        number = np.where(part.present, np.cumsum(part.present) - 1, 0).astype(np.int32)
        layout = replace(self.layout, block=number[self.layout.block])
        dowels = replace(self.dowels, near=number[self.dowels.near], far=number[self.dowels.far])
        return replace(self, layout=layout, pairs=coupled_pairs(layout, self.alive), dowels=dowels)

    def after(self, other: InstalledBolts) -> InstalledBolts:
        """Return a copy with the state of another."""
        dowels = replace(self.dowels, rest=other.dowels.rest)
        return replace(self, rest=other.rest, yielded=other.yielded, anchor=other.anchor, dowels=dowels)

    def on_blocks(self, at: BoltEvaluation) -> PointForces:
        """Return the forces at both ends of every element and on both sides of every crossing, on the blocks [N/m]."""
        first, dowels = self.layout.first_node, self.dowels
        force = at.direction * (at.tension / self.layout.spacing[self.layout.bolt_of_element])[:, None]
        shear = at.dowels.across * (at.dowels.force / dowels.spacing)[:, None]
        block, point = self.layout.block, at.point
        return PointForces(
            block=np.concatenate([block[first], block[first + 1], dowels.near, dowels.far]),
            point=np.concatenate([point[first], point[first + 1], at.dowels.point, at.dowels.point]),
            force=np.concatenate([force, -force, shear, -shear]),
        )

    def evaluate(self, position: FloatArray) -> BoltEvaluation:
        """Return the forces at a position (n_blocks, axes), every bolt in equilibrium with its bond."""
        layout = self.layout
        if not layout.block.size:  # no bolt compiles nothing; a bolt of one node has no element
            return BoltEvaluation.none(position, self.dowels.evaluate(position, self.alive))
        moved, arm = self._geometry.node_movements(position, layout.block, self.arm)
        length, direction = element_lines(layout.point, moved, layout.first_node)
        stretch = length - self.rest
        tension, slip = solve_bolts(
            layout.node_start,
            self.alive,
            self.stiffness,
            stretch,
            layout.yield_force,
            layout.capacity,
            layout.bond_stiffness,
            self.anchor,
        )
        return self._forces(
            position.shape,
            point=layout.point + moved,
            arm=arm,
            length=length,
            direction=direction,
            stretch=stretch,
            tension=tension,
            slip=slip,
            dowels=self.dowels.evaluate(position, self.alive),
        )

    def with_forces(self, at: BoltEvaluation, tension: FloatArray, shear: FloatArray) -> BoltEvaluation:
        """Return an evaluation with other tensions (n_elements,) and shear forces at crossings (k,) [N]."""
        return self._forces(
            at.forces.shape,
            point=at.point,
            arm=at.arm,
            length=at.length,
            direction=at.direction,
            stretch=at.stretch,
            tension=tension,
            slip=self._bond_force(tension) / self.layout.bond_stiffness,
            dowels=replace(at.dowels, force=shear),
        )

    def strained(self, at: BoltEvaluation, coupling: FloatArray, U: FloatArray) -> BoltEvaluation:
        """Return the forces after further small displacements U (n_blocks, 3), the coupling unchanged."""
        layout, first = self.layout, self.layout.first_node
        u, v, turn = U[layout.block].T
        moved = np.stack([u - turn * at.arm[:, 1], v + turn * at.arm[:, 0]], axis=1)
        stretch = ((moved[first + 1] - moved[first]) * at.direction).sum(axis=1)
        sheared = self.dowels.strained(at.dowels, U, self.alive)
        tension = at.tension + couple(layout.node_start, coupling, stretch)
        return replace(self.with_forces(at, tension, sheared.force), dowels=sheared)

    def _forces(self, shape: tuple[int, ...], dowels: DowelEvaluation, **found: FloatArray) -> BoltEvaluation:
        """Return the evaluation with what follows from tensions and shear: bond forces, and forces on the blocks."""
        layout = self.layout
        tension = found["tension"]
        forces = np.zeros(shape)
        self.dowels.add_forces(dowels, forces)
        add_bolt_forces(
            layout.node_start, layout.block, layout.spacing, found["arm"], found["direction"], tension, forces
        )
        return BoltEvaluation(bond_force=self._bond_force(tension), dowels=dowels, forces=forces, **found)

    def _bond_force(self, tension: FloatArray) -> FloatArray:
        """Return the force of every node on the rock (Wang Eq. 5.6), (n_nodes,)."""
        force = np.zeros(len(self.layout.block))
        force[self.layout.first_node] += tension
        force[self.layout.first_node + 1] -= tension
        return force

    def places(self, pattern: BlockPattern) -> IntArray:
        """Return where in a matrix each pair of a bolt's nodes stands, for `add_tangent`."""
        if not self.alive.size:
            return np.zeros(0, np.int32)
        places: IntArray = find_places(pattern.row_start, pattern.column, self.layout.node_start, self.layout.block)
        return places

    def coupling(self, at: BoltEvaluation) -> FloatArray:
        """Return the derivatives of the tensions by the stretches, a matrix a bolt (`bolt_couplings`)."""
        layout = self.layout
        if not self.alive.size:
            return np.zeros(0)
        found: FloatArray = bolt_couplings(
            layout.node_start,
            self.alive,
            self.stiffness,
            at.stretch,
            layout.yield_force,
            layout.capacity,
            layout.bond_stiffness,
            at.slip,
            at.tension,
        )
        return found

    def add_tangent(self, at: BoltEvaluation, places: IntArray, data: FloatArray, *, turning: bool = True) -> None:
        """Add the tangent of minus the forces to the blocks of a matrix, in place (Wang Eq. 5.21).

        `turning`: with the turning of the bolts under their tension, which small displacements leave out.
        """
        add_bolt_tangent(
            self.layout.node_start,
            self.layout.spacing,
            self.coupling(at),
            at.tension if turning else np.zeros_like(at.tension),
            at.arm,
            at.direction,
            at.length,
            places,
            data,
        )
        self.dowels.add_tangent(at.dowels, self.alive, places, data, turning=turning)

    def commit(self, at: BoltEvaluation) -> InstalledBolts:
        """Return the bolts after an accepted step: slip and plastic stretch stay."""
        layout, first = self.layout, self.layout.first_node
        strained = at.stretch + at.slip[first + 1] - at.slip[first]
        over = np.where(self.yielding(at), np.maximum(strained - at.tension / self.stiffness, 0.0), 0.0)
        return replace(
            self,
            rest=self.rest + over,
            yielded=self.yielded + over,
            anchor=at.slip - at.bond_force / layout.bond_stiffness,
            dowels=self.dowels.commit(at.dowels),
        )

    def yielding(self, at: BoltEvaluation) -> BoolArray:
        """Return which elements are at the yield force of the steel, (n_elements,)."""
        bolt = self.layout.bolt_of_element
        found: BoolArray = self.alive & (at.tension >= self.layout.yield_force[bolt] * (1 - AT_LIMIT))
        return found


def coupled_pairs(layout: BoltLayout, alive: BoolArray) -> tuple[IntArray, IntArray]:
    """Return the pairs of different blocks that a bolt couples: each with every other on the same bolt."""
    working = np.zeros(len(layout.block), dtype=bool)
    working[layout.first_node[alive]] = working[layout.first_node[alive] + 1] = True
    lower, higher = [np.zeros(0, np.int32)], [np.zeros(0, np.int32)]
    for first, last in pairwise(layout.node_start):
        blocks = np.unique(layout.block[first:last][working[first:last]])
        i, j = np.triu_indices(len(blocks), 1)
        lower.append(blocks[i])
        higher.append(blocks[j])
    return np.concatenate(lower), np.concatenate(higher)
