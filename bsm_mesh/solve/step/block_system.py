"""Blocks in motion with all that stays the same in a run: loads and supports where they stand, contacts, measures."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.search import Outlines, corner_positions
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.solve.algebra.constraints import Constraints, constrain_bars
from bsm_mesh.solve.algebra.loads import external_loads, mean_force, reference_weight
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.contacts.contact_set import gather_contacts
from bsm_mesh.solve.contacts.forces import Evaluation, MovingContacts, evaluate, turned
from bsm_mesh.solve.contacts.history import History
from bsm_mesh.solve.contacts.smoothed_forces import evaluate_smoothed

STEP = 0.05  # of the block size: step length d
BAND = 3.0  # of the step length: corners nearer than this to an edge are candidates for contact
DRIVEN = 0.5  # of the step length: how far supports move blocks in a step
REACHED = 1e-6  # of the step length: what a prescribed displacement may lack at the end


class MovingModel:
    """A model whose blocks move.

    Positions are movements from where the blocks were given, (n, 3) [m, m, rad]: of the centroid, and the rotation. So
    their rounding is that of movements; of coordinates on a national grid it would be greater than what is asked for.

    Parameters
    ----------
    model : Model
        What is given.
    bolts : InstalledBolts, optional
        Its bolts; where not given the model's own, installed on the blocks as given.
    position : (n, 3) float64 [m, m, rad], optional
        Where the blocks are; where they were given, if not.

    Attributes
    ----------
    start : (n, 3) float64 [m, m, rad]
        The position in which the blocks were given: no movement.
    d : float [m]
        Step length.
    mass : (n, 3) float64 [N/m, N/m, N m]
        What regularises: weights, and weights times the polar radius of gyration squared.
    scale : (n, 3) float64
        Forces times `scale`, and movements over it, compare across axes: moments over radii of gyration.
    driven : (n,) bool
        Blocks that only their supports move.
    bolts : InstalledBolts
        The bolts with what accepted steps have left in them.
    mean_weight : float [N/m]
        Mean weight of a block, or mean load of a loaded one, if greater: by it steps are measured.
    stressed : float
        The reference weight over it, by which residuals are measured: 1, or more where contacts bear more at the start.
    """

    def __init__(self, model: Model, bolts: InstalledBolts | None = None, position: FloatArray | None = None) -> None:
        self.model = model
        moments = model.blocks.moments
        self.start = np.zeros((model.blocks.count, 3))
        self.bolts = InstalledBolts.of(model, self.start) if bolts is None else bolts
        self.bars = bars_of(model.supports, model.blocks)
        self.bar_arm = self.bars.point - moments.centroid[self.bars.block]
        at_start = self.constraints_at(self.start, conflicts=True)
        held = np.zeros(model.blocks.count, dtype=bool)
        held[at_start.block[at_start.held == 3]] = True
        self.driven = held.copy()
        held[np.unique(self.bars.block[self.bars.value != 0])] = False
        self.outlines = Outlines.of(model.blocks, held)
        self.catalogue = JointCatalogue(model)
        self.applied = point_forces_of(model.acting_loads, model.blocks)
        self.applied_arm = self.applied.point - moments.centroid[self.applied.block]
        self.water = WaterLoad(model)
        self.loads = external_loads(model)
        self.dead = self._dead_forces()
        pretension = self.bolts.evaluate(self.start if position is None else position).forces
        self.mean_weight = reference_weight(model, self.loads, pretension)
        self.stressed = 1.0
        weight = np.maximum(model.weights, 1e-3 * self.mean_weight)
        self.mass = np.column_stack([weight, weight, weight * moments.polar / moments.area])
        self.scale = np.column_stack([np.ones((model.blocks.count, 2)), 1 / moments.gyration])
        self.d = STEP * self.outlines.size
        self._answered: list[tuple[tuple[object, ...], Evaluation]] = []

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

        Loads keep their direction and move with their point on the block; the water's pressure is that of where the
        block is.
        """
        if not len(self.applied.block) and not self.water.acts:
            return self.loads
        loads = self.water_at(position)
        loads[:, :2] += self.dead
        arm = turned(self.applied_arm, position[self.applied.block, 2])
        force = self.applied.force
        np.add.at(loads[:, 2], self.applied.block, arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])
        return loads

    def acting_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads, water and bolt forces, (n, 3)."""
        if not len(self.bolts.alive):
            return self.loads_at(position)
        return self.loads_at(position) + self.bolts.evaluate(position).forces

    def water_at(self, position: FloatArray) -> FloatArray:
        """Return the water's force and moment on every block where it stands, (n, 3)."""
        placed = self.outlines.placed(position)
        return self.water.on_blocks(corner_positions(self.outlines, placed), placed[:, :2])

    def point_forces_at(self, position: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return block, point and force of every load as the blocks stand."""
        placed = self.outlines.placed(position)[self.applied.block]
        return self.applied.block, placed[:, :2] + turned(self.applied_arm, placed[:, 2]), self.applied.force

    def bar_arms(self, position: FloatArray) -> FloatArray:
        """Return the arms from centroids to held points as the blocks stand, (n_bars, 2) [m]."""
        return turned(self.bar_arm, position[self.bars.block, 2])

    def constraints_at(self, position: FloatArray, *, conflicts: bool = False) -> Constraints:
        """Return the supports' constraints on small movements from a position."""
        arm = self.bar_arms(position)
        moved = position[self.bars.block]
        reached = ((moved[:, :2] + arm - self.bar_arm) * self.bars.direction).sum(axis=1)
        reached = np.where(self.bars.holds_rotation, moved[:, 2], reached)
        return constrain_bars(self.model, self.bars, arm, self.bars.value - reached, conflicts=conflicts)

    def given(self, supports: Constraints) -> FloatArray:
        """Return the part of the prescribed displacements that is applied in one step.

        It is less than blocks fall in a step, so that those on a support that sinks keep up with it.
        """
        size = float(np.abs(supports.given / self.scale).max())
        return supports.given * min(1.0, DRIVEN * self.d / size) if size > 0 else supports.given

    def reached(self, position: FloatArray) -> bool:
        """Return whether the prescribed displacements are applied in full."""
        return float(np.abs(self.constraints_at(position).given / self.scale).max()) <= REACHED * self.d

    def gather(self, history: History, position: FloatArray, *, first: bool) -> MovingContacts:
        """Return the contacts near a position with their history; `first`: touching ones are intact."""
        self._answered.clear()  # by other contacts: room for these
        return gather_contacts(self.model, self.outlines, self.catalogue, history, position, BAND * self.d, first=first)

    def evaluate(
        self,
        contacts: MovingContacts,
        position: FloatArray,
        friction_pressure: FloatArray | None = None,
        smoothing: float = 0.0,
    ) -> Evaluation:
        """Return the contact forces at a position; `friction_pressure` as `moving.evaluate` takes it.

        With a smoothing [N], those of smoothed laws.

        One way to solve a step hands its position to the next, and a path asks by both laws in turn: so the last two
        answers are kept for the same arrays.
        """
        asked = contacts, position, friction_pressure, smoothing
        for known, answer in self._answered:
            if all(now is then for now, then in zip(asked, known, strict=True)):
                return answer
        del self._answered[1:]  # before the new one is made
        laws = self.catalogue.laws
        if smoothing:
            found: Evaluation = evaluate_smoothed(contacts, laws, position, smoothing)
        else:
            found = evaluate(contacts, laws, position, friction_pressure)
        self._answered.insert(0, (asked, found))
        return found

    def starts_from(self, contacts: MovingContacts, position: FloatArray) -> None:
        """Take note of how stressed the rock is where blocks begin to move."""
        if self.mean_weight > 0:
            self.stressed = max(1.0, _mean_borne(self.evaluate(contacts, position)) / self.mean_weight)

    def static_residual(self, contacts: MovingContacts, position: FloatArray) -> float:
        """Return the greatest force out of balance over the reference weight."""
        at = self.evaluate(contacts, position)
        missing = self.constraints_at(position).scaled(self.acting_at(position) + at.forces, self.scale)
        return float(np.abs(missing).max()) / (self.stressed * self.weight(at))

    def weight(self, at: Evaluation) -> float:
        """Return the mean weight or load by which steps are measured [N/m]; without either the mean contact force."""
        return self.mean_weight or _mean_borne(at) or 1.0


def _mean_borne(at: Evaluation) -> float:
    return mean_force(at.pressure[at.bearing], at.shear[at.bearing])
