"""The block system of polyhedra in space: loads, supports and contacts at a position."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.edges import pairs_of
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.movements import turned
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.step.system import BAND, STEP, System
from bsm_mesh.three_d.contacts.contact_set import ContactSet, contacts_of, given_points
from bsm_mesh.three_d.contacts.forces import (
    Evaluation,
    commit,
    elastic_contacts,
    evaluate,
    sticking,
    tangent_stiffness,
    updated,
    worn,
)
from bsm_mesh.three_d.contacts.history import PointHistory, PolygonPoints
from bsm_mesh.three_d.contacts.kernels import max_relative_movement
from bsm_mesh.three_d.contacts.meetings import Meetings
from bsm_mesh.three_d.contacts.properties import PolygonCatalogue
from bsm_mesh.three_d.contacts.renewal import SLID, Renewal, points_apart, touching_points
from bsm_mesh.three_d.contacts.rotations import moved_by, movement_between
from bsm_mesh.three_d.contacts.surfaces import Surfaces
from bsm_mesh.three_d.loads.external import ExternalLoads


class BlockSystem(System):
    """The polyhedra of a model in large displacement.

    `touching` has the points of blocks as given that touch on parts of faces, at edges or at corners.

    A position (n, 6) is the displacement of every centroid and its rotation vector, from the given geometry.

    Parameters
    ----------
    model : Model
        The model.
    bolts : InstalledBolts, optional
        Its bolts; where not given the model's own, installed on the blocks as given.
    position : (n, 6) float64 [m, rad], optional
        Where blocks are; as given by default.
    """

    evaluate_contacts = staticmethod(evaluate)

    def __init__(self, model: Model, bolts: InstalledBolts | None = None, position: FloatArray | None = None) -> None:
        super().__init__(model, bolts)
        moments = model.blocks.moments
        self.centroid, self.block_size = moments.centroid, moments.size
        self.bars = bars_of(model.supports, model.blocks)
        self.bar_arm = self.bars.point - self.centroid[self.bars.block]
        self.prescribed_blocks = self.constraints_at(self.start, conflicts=True).fixed
        moves = ~self.prescribed_blocks
        self.catalogue = PolygonCatalogue(model)
        self._external = ExternalLoads(model)
        self.water = self._external.water
        self.loads = self.loads_at(self.start)
        size = float(np.median(self.block_size[moves] if moves.any() else self.block_size))
        self._set_scales(size, self.bolts.evaluate(self.start if position is None else position).forces)
        self._renewal = self._renewal_of(model)

    def _renewal_of(self, model: Model) -> Renewal:
        assert in_space(model.blocks)
        held, band = self.prescribed_blocks, BAND * self.d
        surfaces = Surfaces(blocks=model.blocks, rule=model.contact_points)
        apart = points_apart(surfaces, self.start, held, band, self.size)
        apart = apart.some(self.catalogue.have_stiffness(apart))
        self.touching = touching_points(apart, self.size)
        given = given_points(model, held).with_more(apart)
        known = pairs_of(given.block_a, given.block_b)
        return Renewal(
            surfaces=surfaces,
            catalogue=self.catalogue,
            given=given,
            contacts=contacts_of(given, PolygonPoints.none(), self.catalogue),
            held=held,
            meetings=Meetings(surfaces.near_free_faces(self.start, held, SLID * self.size, known), self.block_size),
            block_size=self.block_size,
            size=self.size,
            band=band,
        )

    @property
    def touching_pairs(self) -> IntArray:
        """Pairs of blocks that share no face, and touch as given, (k, 2)."""
        pairs = np.sort(np.stack([self.touching.block_a, self.touching.block_b], axis=1), axis=1)
        found: IntArray = np.unique(pairs, axis=0)
        return found

    def _rotary(self, weight: FloatArray) -> FloatArray:
        rotary: FloatArray = weight * self.model.blocks.moments.gyration**2
        return rotary

    @property
    def blocks_across(self) -> float:
        """Blocks along a side of a cubic model of as many."""
        return float(np.cbrt(len(self.start)))

    @property
    def constant_loads(self) -> FloatArray | None:
        """Weights (n, 6) where nothing else acts; None where what acts depends on where the blocks are."""
        return self.loads if self._external.are_weights and not len(self.bolts.alive) else None

    def loads_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads and water, (n, 6)."""
        return self._external.at(position)

    def load_stiffness(self, position: FloatArray) -> FloatArray | None:
        """Return the derivatives of minus `loads_at` by the movement of every block, (n, 6, 6); None: all are zero."""
        return self._external.stiffness(position)

    def point_forces_at(self, position: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return block, point and force of every load at a position."""
        loads = self._external
        return loads.block, self.placed(position)[loads.block] + loads.arms(position), loads.force

    def bar_arms(self, position: FloatArray) -> FloatArray:
        """Return the arms from centroids to supported points at a position, (n_bars, 3) [m]."""
        return turned(self.bar_arm, position[self.bars.block, 3:])

    def reached(self, position: FloatArray) -> FloatArray:
        """Return how far bars are displaced along their directions, or rotated about them, (n_bars,) [m or rad]."""
        moved = position[self.bars.block]
        shift = moved[:, :3] + self.bar_arms(position) - self.bar_arm
        along = np.where(self.bars.holds_rotation[:, None], moved[:, 3:], shift)
        found: FloatArray = (along * self.bars.direction).sum(axis=1)
        return found

    def placed(self, position: FloatArray) -> FloatArray:
        """Return where centroids are at a position, (n, 3) [m]."""
        placed: FloatArray = self.centroid + position[:, :3]
        return placed

    def moved_by(self, position: FloatArray, movement: FloatArray) -> FloatArray:
        """Return positions after a finite movement (n, 6) about instant axes."""
        return moved_by(position, movement)

    def movement_between(self, position: FloatArray, other: FloatArray) -> FloatArray:
        """Return the finite movement (n, 6) about instant axes from one position to another."""
        return movement_between(position, other)

    def gather(
        self, history: PointHistory, position: FloatArray, *, first: bool, keeps_lengths: bool = False
    ) -> ContactSet:
        """Return the contact points with their history; `first`: all are intact."""
        self._answered.clear()
        return self._renewal.contacts_at(history, position, first=first)

    def passed_faces(self, contacts: ContactSet, position: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the pairs of blocks (k, 2) whose faces passed each other without contact, and depths [m]."""
        return self._renewal.passed(contacts, position)

    def commit(self, contacts: ContactSet, at: Evaluation, position: FloatArray) -> tuple[PointHistory, int]:
        """Return the history after an accepted step, and the number of contacts that failed in it."""
        return commit(contacts, at, self.size)

    def searched_again(self, contacts: ContactSet, at: Evaluation, position: FloatArray) -> ContactSet:
        """Return contacts as a search within a step finds them."""
        return updated(contacts, at, self.size)

    def worn(self, contacts: ContactSet, at: Evaluation) -> ContactSet:
        """Return contacts as slip in an accepted step has left them."""
        return worn(contacts, at)

    def some(self, contacts: ContactSet, rows: IntArray, block: IntArray) -> ContactSet:
        """Return some of the contacts, their blocks renumbered (n,)."""
        return contacts.some(rows, block)

    def mean_contact_force(self, at: Evaluation) -> float:
        """Return the mean force of the contacts that bear [N]."""
        size = np.hypot(at.pressure, at.size)[at.closed]
        return float(size[size > 0].mean()) if (size > 0).any() else 0.0

    def stiffness_sums(self, contacts: ContactSet, at: Evaluation) -> tuple[float, float]:
        """Return the sums of normal and shear stiffness of the contacts within tolerance [N/m]."""
        near = contacts.within_tolerance
        return float(at.normal_stiffness[near].sum()), float(contacts.shear_stiffness[near].sum())

    def max_relative_movement(self, contacts: ContactSet, movement: FloatArray) -> float:
        """Return the largest relative movement of neighbouring blocks [m].

        That of blocks whose edges may meet counts more: a step length is the width of a shared area that counts.
        """
        blocks = contacts.candidates.block_a, contacts.candidates.block_b
        meeting = np.ascontiguousarray(contacts.meeting.T)
        largest: float = max_relative_movement(*blocks, movement, self.block_size)
        nearest: float = max_relative_movement(*meeting, movement, self.block_size)
        return max(largest, STEP / RULES.min_overlap * nearest)

    def shares_inside(self, position: FloatArray, block: IntArray) -> FloatArray:
        """Return zeros (k,): faces that come near are found before blocks sink into them."""
        return np.zeros(len(block))

    def tangent(
        self, contacts: ContactSet, at: Evaluation, pattern: BlockPattern, regularization: float = 0.0
    ) -> FloatArray:
        """Return the 6 x 6 blocks of the contacts' tangent."""
        return tangent_stiffness(contacts, at, pattern.place, len(pattern.column), regularization)

    def first_tangent(self, contacts: ContactSet, at: Evaluation, pattern: BlockPattern) -> FloatArray:
        """Return the elastic tangent of a step from rest."""
        return self.tangent(contacts, sticking(contacts, at, contacts.within_tolerance), pattern)

    def elastic_tangent(self, contacts: ContactSet, at: Evaluation, pattern: BlockPattern) -> FloatArray:
        """Return the stiffest possible tangent."""
        return self.tangent(contacts, sticking(contacts, at, elastic_contacts(contacts, at, self.size)), pattern)
