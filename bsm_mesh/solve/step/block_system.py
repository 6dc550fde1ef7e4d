"""The block system of polygons in the plane: loads, supports and contacts at a position."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.contact_set import gather_contacts
from bsm_mesh.contact.force_kernels import max_relative_movement
from bsm_mesh.contact.forces import ContactSet, Evaluation, evaluate, rows_by_law
from bsm_mesh.contact.history import History, commit, restore_history, worn
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.search import Outlines, corner_positions
from bsm_mesh.contact.tangents import elastic_tangent, first_tangent, tangent_stiffness
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.movements import turned
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.algebra.loads import external_loads, mean_force
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.step.system import BAND, System


class BlockSystem(System):
    """The polygons of a model in large displacement; a position (n, 3) is u, v and theta of every block.

    Parameters
    ----------
    model : Model
        The model.
    bolts : InstalledBolts, optional
        Its bolts; where not given the model's own, installed on the blocks as given.
    position : (n, 3) float64 [m, m, rad], optional
        Position of the blocks; that of the given geometry by default.
    """

    evaluate_contacts = staticmethod(evaluate)

    def __init__(self, model: Model, bolts: InstalledBolts | None = None, position: FloatArray | None = None) -> None:
        super().__init__(model, bolts)
        moments = model.blocks.moments
        self.bars = bars_of(model.supports, model.blocks)
        self.bar_arm = self.bars.point - moments.centroid[self.bars.block]
        at_start = self.constraints_at(self.start, conflicts=True)
        self.prescribed_blocks = at_start.fixed
        fixed = at_start.fixed
        fixed[np.unique(self.bars.block[self.bars.value != 0])] = False
        self.outlines = Outlines.of(model.blocks, fixed)
        self.block_size, self.centroid = self.outlines.block_size, self.outlines.centroid
        self.catalogue = JointCatalogue(model)
        self.applied = point_forces_of(model.acting_loads, model.blocks)
        self.applied_arm = self.applied.point - moments.centroid[self.applied.block]
        self.water = WaterLoad(model)
        self.loads = external_loads(model)
        self.dead = self._dead_forces()
        pretension = self.bolts.evaluate(self.start if position is None else position).forces
        self._set_scales(self.outlines.size, pretension)

    def _rotary(self, weight: FloatArray) -> FloatArray:
        moments = self.model.blocks.moments
        rotary: FloatArray = weight * moments.polar / moments.area
        return rotary

    @property
    def blocks_across(self) -> float:
        """Blocks along a side of a square model of as many."""
        return float(np.sqrt(len(self.start)))

    def _dead_forces(self) -> FloatArray:
        """Return weights and the forces of loads, which keep their direction, (n, 2)."""
        total = self.model.gravity_forces
        np.add.at(total, self.applied.block, self.applied.force)
        return total

    @property
    def constant_loads(self) -> FloatArray | None:
        """Weights (n, 3) where nothing else acts; None where what acts depends on where the blocks are."""
        plain = not (len(self.bolts.alive) or len(self.applied.block) or self.water.acts)
        return self.loads if plain else None

    def loads_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads and water, (n, 3).

        Loads keep their direction and follow their point on the block; water pressure follows the position.
        """
        if not len(self.applied.block) and not self.water.acts:
            return self.loads
        loads = self.water_at(position)
        loads[:, :2] += self.dead
        arm = turned(self.applied_arm, position[self.applied.block, 2])
        force = self.applied.force
        np.add.at(loads[:, 2], self.applied.block, arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])
        return loads

    def load_stiffness(self, position: FloatArray) -> FloatArray | None:
        """Return the derivatives of minus `loads_at` by the movement of every block, (n, 3, 3); None: all are zero."""
        if not len(self.applied.block) and not self.water.acts:
            return None
        placed = self.outlines.placed(position)
        stiffness = self.water.stiffness(corner_positions(self.outlines, placed), placed[:, :2])
        arm = turned(self.applied_arm, position[self.applied.block, 2])
        np.add.at(stiffness[:, 2, 2], self.applied.block, (arm * self.applied.force).sum(axis=1))
        return stiffness

    def water_at(self, position: FloatArray) -> FloatArray:
        """Return force and moment of the water on every block at a position, (n, 3)."""
        placed = self.outlines.placed(position)
        return self.water.on_blocks(corner_positions(self.outlines, placed), placed[:, :2])

    def point_forces_at(self, position: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return block, point and force of every load at a position."""
        placed = self.outlines.placed(position)[self.applied.block]
        return self.applied.block, placed[:, :2] + turned(self.applied_arm, placed[:, 2]), self.applied.force

    def bar_arms(self, position: FloatArray) -> FloatArray:
        """Return the arms from centroids to supported points at a position, (n_bars, 2) [m]."""
        return turned(self.bar_arm, position[self.bars.block, 2])

    def reached(self, position: FloatArray) -> FloatArray:
        """Return how far bars are displaced along their directions, or rotated, at a position, (n_bars,) [m or rad]."""
        arm, moved = self.bar_arms(position), position[self.bars.block]
        reached = ((moved[:, :2] + arm - self.bar_arm) * self.bars.direction).sum(axis=1)
        found: FloatArray = np.where(self.bars.holds_rotation, moved[:, 2], reached)
        return found

    def placed(self, position: FloatArray) -> FloatArray:
        """Return where centroids are at a position, (n, 2) [m]."""
        return self.outlines.placed(position)[:, :2]

    def moved_by(self, position: FloatArray, movement: FloatArray) -> FloatArray:
        """Return positions after a finite movement (n, 3) about instant centres: the exponential map of SE(2)."""
        return moved_by(position, movement)

    def movement_between(self, position: FloatArray, other: FloatArray) -> FloatArray:
        """Return the finite movement (n, 3) about instant centres from one position to another."""
        return step_between(position, other)

    def gather(self, history: History, position: FloatArray, *, first: bool, keeps_lengths: bool = False) -> ContactSet:
        """Return the contacts near a position with their history; the others as in `gather_contacts`."""
        self._answered.clear()  # of other contacts: their memory is needed
        given = self.model, self.outlines, self.catalogue, history, position, BAND * self.d
        return gather_contacts(*given, first=first, keeps_lengths=keeps_lengths)

    def commit(self, contacts: ContactSet, at: Evaluation, position: FloatArray) -> tuple[History, int]:
        """Return the history after an accepted step, and the number of contacts that failed in it."""
        return commit(contacts, at, position, self.size)

    def searched_again(self, contacts: ContactSet, at: Evaluation, position: FloatArray) -> ContactSet:
        """Return contacts searched at a position within a step: what slides still remembers where it began to."""
        history, _ = commit(contacts, at, position, self.size)
        return restore_history(self.gather(history, position, first=False), contacts, at, self.size)

    def worn(self, contacts: ContactSet, at: Evaluation) -> ContactSet:
        """Return contacts as slip in an accepted step has left them."""
        return worn(contacts, at)

    def mean_contact_force(self, at: Evaluation) -> float:
        """Return the mean force of the contacts that carry [N/m]."""
        return mean_force(at.pressure[at.closed], at.shear[at.closed])

    def stiffness_sums(self, contacts: ContactSet, at: Evaluation) -> tuple[float, float]:
        """Return the sums of normal and shear stiffness of the contacts within tolerance [N/m2]."""
        near = contacts.within_tolerance
        return float(at.normal_stiffness[near].sum()), float(at.springs.stiffness[near].sum())

    def max_relative_movement(self, contacts: ContactSet, movement: FloatArray) -> float:
        """Return the largest relative movement of neighbouring blocks [m]."""
        blocks = contacts.candidates.block_a, contacts.candidates.block_b
        largest: float = max_relative_movement(*blocks, movement, self.block_size)
        return largest

    def shares_inside(self, position: FloatArray, block: IntArray) -> FloatArray:
        """Return which part of the area of each of some blocks (k,) lies inside others, (k,)."""
        from bsm_mesh.results.shared_area import shares_inside

        corners = corner_positions(self.outlines, self.outlines.placed(position))
        return shares_inside(corners, self.model.blocks.offsets, block)

    def tangent(
        self, contacts: ContactSet, at: Evaluation, pattern: BlockPattern, regularization: float = 0.0
    ) -> FloatArray:
        """Return the 3 x 3 blocks of the contacts' tangent, as in `tangent_stiffness`."""
        return tangent_stiffness(contacts, at, pattern.place, len(pattern.column), regularization)

    def first_tangent(self, contacts: ContactSet, at: Evaluation, pattern: BlockPattern) -> FloatArray:
        """Return the elastic tangent of a step from rest."""
        return first_tangent(contacts, at, pattern.place, len(pattern.column))

    def elastic_tangent(self, contacts: ContactSet, at: Evaluation, pattern: BlockPattern) -> FloatArray:
        """Return the stiffest possible tangent."""
        return elastic_tangent(contacts, at, pattern.place, len(pattern.column), self.size)

    def some(self, contacts: ContactSet, rows: IntArray, block: IntArray) -> ContactSet:
        """Return some of the contacts, their blocks renumbered (n,); an opposing candidate is among them."""
        number = np.full(contacts.count, -1, np.int32)
        number[rows] = np.arange(len(rows))
        candidates = _rows_of(contacts.candidates, rows)
        opposing_candidate = candidates.opposing_candidate
        entering = number[contacts.entering]
        plain = ("outlines", "candidates", "opposing", "entering", "entering_direction", "by_law", "features")
        others = {field.name for field in fields(contacts)}.difference(plain)
        return ContactSet(
            outlines=contacts.outlines,
            candidates=replace(
                candidates,
                block_a=block[candidates.block_a],
                block_b=block[candidates.block_b],
                opposing_candidate=np.where(opposing_candidate >= 0, number[opposing_candidate], -1),
            ),
            by_law=rows_by_law(contacts.law[rows]),
            opposing=np.flatnonzero(opposing_candidate >= 0),
            entering=entering[entering >= 0],
            features=contacts.features.of(number),
            entering_direction=contacts.entering_direction[entering >= 0],
            **{name: getattr(contacts, name)[rows] for name in others},
        )


def _rows_of(table: Any, rows: IntArray) -> Any:
    """Return a dataclass of arrays with some of their rows."""
    return replace(table, **{field.name: getattr(table, field.name)[rows] for field in fields(table)})


def moved_by(position: FloatArray, step: FloatArray) -> FloatArray:
    """Return positions after a finite movement (n, 3) about instant centres: the exponential map of SE(2).

    A block that rotates about a stiff corner keeps the corner in place. Plain addition would move the corner by the
    square of the angle, and the line search would shorten every step to that.
    """
    u, v, turn = step.T
    sinc = np.sinc(turn / np.pi)
    versed = np.sin(turn / 2) * np.sinc(turn / (2 * np.pi))  # (1 - cos) / turn
    moved: FloatArray = position + np.column_stack([sinc * u - versed * v, versed * u + sinc * v, turn])
    return moved


def step_between(position: FloatArray, other: FloatArray) -> FloatArray:
    """Return the finite movement (n, 3) about instant centres from one position to another: `moved_by` backwards."""
    u, v, turn = (other - position).T
    sinc = np.sinc(turn / np.pi)
    versed = np.sin(turn / 2) * np.sinc(turn / (2 * np.pi))
    square = sinc**2 + versed**2  # 0 at a full turn, which no step makes
    step: FloatArray = np.column_stack([(sinc * u + versed * v) / square, (sinc * v - versed * u) / square, turn])
    return step
