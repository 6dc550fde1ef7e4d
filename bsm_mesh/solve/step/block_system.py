"""The block system of a run: loads, supports, bolts and contacts at a position, masses and scales."""

from __future__ import annotations

from copy import copy

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.contact_set import gather_contacts
from bsm_mesh.contact.forces import ContactSet, Evaluation, evaluate, turned
from bsm_mesh.contact.history import History, worn
from bsm_mesh.contact.properties import JointCatalogue
from bsm_mesh.contact.rules import RULES
from bsm_mesh.contact.search import Outlines, corner_positions
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import bars_of
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.solve.algebra.constraints import Constraints, constrain_bars
from bsm_mesh.solve.algebra.loads import external_loads, mean_force, reference_weight
from bsm_mesh.solve.bolts.installed import InstalledBolts

STEP = 0.05  # step length d over the block size: turns within it are small, and the rules of contacts hold
BAND = 3.0  # of the contact search, over the step length: corners nearer to an edge are candidates
PRESCRIBED_STEP = 0.5  # largest prescribed movement in a step, over the step length: less than blocks fall in one


class BlockSystem:
    """A model in large displacement: what is constant in a run, and forces as functions of the position.

    A position (n, 3) [m, m, rad] is the displacement of every centroid and the rotation, from the given geometry. Its
    rounding is that of displacements; rounding of coordinates on a national grid would exceed the tolerance.

    Parameters
    ----------
    model : Model
        What is given.
    bolts : InstalledBolts, optional
        Its bolts; where not given the model's own, installed on the blocks as given.
    position : (n, 3) float64 [m, m, rad], optional
        Position of the blocks; that of the given geometry by default.

    Attributes
    ----------
    start : (n, 3) float64 [m, m, rad]
        Position of the given geometry: zero.
    d : float [m]
        Step length.
    mass : (n, 3) float64 [N/m, N/m, N m]
        M of the regularisation: weights, and weights times the polar radius of gyration squared.
    scale : (n, 3) float64
        Forces times `scale`, and movements over it, compare across axes: moments over radii of gyration.
    prescribed_blocks : (n,) bool
        Blocks with all axes constrained: only prescribed displacements move them.
    bolts : InstalledBolts
        The bolts in their last accepted state.
    mean_weight : float [N/m]
        Mean weight of a block, or mean load of a loaded one, if greater: the unit of residuals within a step.
    moving_weight : float [N/m]
        The same of the blocks that are not prescribed.
    residual_scale : float
        Reference weight of reported residuals over `mean_weight`: that of the moving blocks, more in rock under stress.
    """

    def __init__(self, model: Model, bolts: InstalledBolts | None = None, position: FloatArray | None = None) -> None:
        self.model = model
        moments = model.blocks.moments
        self.start = np.zeros((model.blocks.count, 3))
        self.bolts = InstalledBolts.of(model, self.start) if bolts is None else bolts
        self.bars = bars_of(model.supports, model.blocks)
        self.bar_arm = self.bars.point - moments.centroid[self.bars.block]
        at_start = self.constraints_at(self.start, conflicts=True)
        self.prescribed_blocks = at_start.fixed
        fixed = at_start.fixed
        fixed[np.unique(self.bars.block[self.bars.value != 0])] = False
        self.outlines = Outlines.of(model.blocks, fixed)
        self.catalogue = JointCatalogue(model)
        self.applied = point_forces_of(model.acting_loads, model.blocks)
        self.applied_arm = self.applied.point - moments.centroid[self.applied.block]
        self.water = WaterLoad(model)
        self.loads = external_loads(model)
        self.dead = self._dead_forces()
        pretension = self.bolts.evaluate(self.start if position is None else position).forces
        self.mean_weight = reference_weight(model, self.loads, pretension)
        # Beside a base of kilometres, which is fixed, no block would weigh anything: its weight is no part of it.
        self.moving_weight = reference_weight(model, self.loads, pretension, among=~self.prescribed_blocks)
        self.residual_scale = 1.0
        weight = np.maximum(model.weights, 1e-3 * self.mean_weight)
        self.mass = np.column_stack([weight, weight, weight * moments.polar / moments.area])
        self.scale = np.column_stack([np.ones((model.blocks.count, 2)), 1 / moments.gyration])
        self.d = STEP * self.outlines.size
        self._answered: list[tuple[tuple[ContactSet, FloatArray], Evaluation]] = []

    def copy(self) -> BlockSystem:
        """Return the same system with bolts of its own."""
        other = copy(self)
        other._answered = []
        return other

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

    def acting_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads, water and bolt forces, (n, 3)."""
        if not len(self.bolts.alive):
            return self.loads_at(position)
        return self.loads_at(position) + self.bolts.evaluate(position).forces

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

    def constraints_at(self, position: FloatArray, *, conflicts: bool = False) -> Constraints:
        """Return the supports' constraints on small movements from a position."""
        arm = self.bar_arms(position)
        moved = position[self.bars.block]
        reached = ((moved[:, :2] + arm - self.bar_arm) * self.bars.direction).sum(axis=1)
        reached = np.where(self.bars.holds_rotation, moved[:, 2], reached)
        return constrain_bars(self.model, self.bars, arm, self.bars.value - reached, conflicts=conflicts)

    def prescribed_increment(self, supports: Constraints) -> FloatArray:
        """Return the part of the prescribed displacements that is applied in one step.

        It is less than the movement of a falling block in a step, so that blocks keep up with a sinking support.
        """
        size = float(np.abs(supports.prescribed / self.scale).max())
        return supports.prescribed * min(1.0, PRESCRIBED_STEP * self.d / size) if size > 0 else supports.prescribed

    def prescription_complete(self, position: FloatArray) -> bool:
        """Return whether the prescribed displacements are applied in full."""
        left = self.constraints_at(position).prescribed / self.scale
        return float(np.abs(left).max()) <= RULES.rounding * self.outlines.size

    def gather(self, history: History, position: FloatArray, *, first: bool, keeps_lengths: bool = False) -> ContactSet:
        """Return the contacts near a position with their history; the others as in `gather_contacts`."""
        self._answered.clear()  # of other contacts: their memory is needed
        given = self.model, self.outlines, self.catalogue, history, position, BAND * self.d
        return gather_contacts(*given, first=first, keeps_lengths=keeps_lengths)

    def evaluate(self, contacts: ContactSet, position: FloatArray) -> Evaluation:
        """Return the contact forces at a position; the last two are kept, for one method passes its end to the next."""
        for known, answer in self._answered:
            if known[0] is contacts and known[1] is position:
                return answer
        del self._answered[1:]  # before the new one is made
        found = evaluate(contacts, self.catalogue.laws, position)
        self._answered.insert(0, ((contacts, position), found))
        return found

    def set_residual_scale(self, contacts: ContactSet, position: FloatArray) -> None:
        """Set `residual_scale` from the moving blocks' weight and the mean contact force at the start."""
        if self.mean_weight > 0:
            reference = max(self.moving_weight, _mean_contact_force(self.evaluate(contacts, position)))
            self.residual_scale = reference / self.mean_weight

    def static_residual(self, contacts: ContactSet, position: FloatArray) -> float:
        """Return the maximum norm of the static residual over the reference weight."""
        at = self.evaluate(contacts, position)
        residual = self.constraints_at(position).unconstrained(self.acting_at(position) + at.forces, self.scale)
        return float(np.abs(residual).max()) / (self.residual_scale * self.weight(at))

    def wearing_residual(self, contacts: ContactSet, at: Evaluation, residual: float) -> float:
        """Return the static residual once slip up to an evaluation has worn strength off, or `residual`."""
        if not self.catalogue.wears or not (at.closed & ~at.sticking).any():
            return residual
        return max(residual, self.static_residual(worn(contacts, at), at.position))

    def weight(self, at: Evaluation) -> float:
        """Return the unit of residuals within a step [N/m]: mean weight or load, else the mean contact force."""
        return self.mean_weight or _mean_contact_force(at) or 1.0


def _mean_contact_force(at: Evaluation) -> float:
    return mean_force(at.pressure[at.closed], at.shear[at.closed])
