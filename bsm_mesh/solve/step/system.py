"""Interface of a block system for a step, in any number of dimensions: forces, supports, contacts at a position."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from copy import copy
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Bars
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.algebra.constraints import Constraints, constrain_bars
from bsm_mesh.solve.algebra.loads import reference_weight
from bsm_mesh.solve.bolts.installed import InstalledBolts

STEP = 0.05  # step length d over the block size: turns within it are small, and the rules of contacts hold
BAND = 3.0  # of the contact search, over the step length: corners nearer to an edge are candidates
PRESCRIBED_STEP = 0.5  # largest prescribed movement in a step, over the step length: less than blocks fall in one

Contacts: TypeAlias = Any  # a contact set of the system's own kind: `count`, `candidates`, `within_tolerance`
Evaluation: TypeAlias = Any  # its forces at a position: `position`, `forces`, `closed`, `sticking`, `at_strength`
History: TypeAlias = Any  # state variables of its contacts


class System(ABC):
    """A model in large displacement: constants of a run, and forces as functions of the position.

    A position has a row a block: the displacement of its centroid from the given geometry and its rotation, (n, 3) in
    the plane and (n, 6) in space; `axes` is the number of columns. Rounding is that of displacements; rounding of
    coordinates on a national grid would exceed the tolerance.

    Attributes
    ----------
    start : (n, axes) float64 [m, rad]
        Position of the given geometry: zero.
    size, block_size : float, (n,) float64 [m]
        Median size of the blocks that can move, and size of each.
    centroid : (n, 2 or 3) float64 [m]
        Centroids as given.
    d : float [m]
        Step length.
    mass : (n, axes) float64 [N/m, N m]
        M of the regularisation: weights, and weights times the radius of gyration squared.
    scale : (n, axes) float64
        Forces times `scale`, and movements over it, compare across axes: moments over radii of gyration.
    prescribed_blocks : (n,) bool
        Blocks with all axes constrained: only prescribed displacements move them.
    bolts : InstalledBolts
        The bolts in their last accepted state.
    loads : (n, axes) float64
        Weights, loads and water on the given geometry.
    mean_weight : float [N/m]
        Mean weight of a block, or mean load of a loaded one, if greater: the unit of residuals within a step.
    moving_weight : float [N/m]
        The same of the blocks that are not prescribed.
    residual_scale : float
        Reference weight of reported residuals over `mean_weight`: that of the moving blocks, more in rock under stress.
    """

    catalogue: Any
    in_motion: Callable[..., Any]  # explicit motion from a step, as `motion.cycles.Cycles`: its room lies above this
    evaluate_contacts: ClassVar[Callable[..., Evaluation]]
    bars: Bars
    size: float
    block_size: FloatArray
    prescribed_blocks: BoolArray
    centroid: FloatArray
    loads: FloatArray

    def __init__(self, model: Model, bolts: InstalledBolts | None) -> None:
        self.model, self.axes = model, model.blocks.axes
        self.start = np.zeros((model.blocks.count, self.axes))
        self.bolts = InstalledBolts.of(model, self.start) if bolts is None else bolts
        self._answered: list[tuple[tuple[Contacts, FloatArray], Evaluation]] = []

    def _set_scales(self, size: float, pretension: FloatArray) -> None:
        """Set what follows from weights and sizes; `loads` and `prescribed_blocks` are there."""
        model, gyration = self.model, self.model.blocks.moments.gyration[:, None]
        self.size, self.d, self.residual_scale = size, STEP * size, 1.0
        self.mean_weight = reference_weight(model, self.loads, pretension)
        # Beside a base of kilometres, which is fixed, no block would weigh anything: its weight is no part of it.
        self.moving_weight = reference_weight(model, self.loads, pretension, among=~self.prescribed_blocks)
        weight = np.maximum(model.weights, 1e-3 * self.mean_weight)
        moves = self.centroid.shape[1]
        turns = self.axes - moves
        self.mass = np.hstack([np.tile(weight[:, None], moves), np.tile(self._rotary(weight)[:, None], turns)])
        self.scale = np.hstack([np.ones((len(weight), moves)), np.tile(1 / gyration, turns)])

    @abstractmethod
    def _rotary(self, weight: FloatArray) -> FloatArray:
        """Return weights (n,) times the squares of the radii of gyration, (n,) [N m]."""

    @property
    @abstractmethod
    def blocks_across(self) -> float:
        """Blocks along a side of a square, or cubic, model of as many."""

    def copy(self) -> Self:
        """Return the same system with bolts of its own."""
        other = copy(self)
        other._answered = []
        return other

    @property
    @abstractmethod
    def constant_loads(self) -> FloatArray | None:
        """Weights (n, axes) where nothing else acts; None where what acts depends on where the blocks are."""

    @abstractmethod
    def loads_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads and water, (n, axes)."""

    @abstractmethod
    def load_stiffness(self, position: FloatArray) -> FloatArray | None:
        """Return the derivatives of minus `loads_at` by the movement of every block, (n, axes, axes); None: zero."""

    @abstractmethod
    def bar_arms(self, position: FloatArray) -> FloatArray:
        """Return the arms from centroids to supported points at a position, (n_bars, 2 or 3) [m]."""

    @abstractmethod
    def reached(self, position: FloatArray) -> FloatArray:
        """Return how far bars are displaced along their directions, or rotated, at a position, (n_bars,) [m or rad]."""

    @abstractmethod
    def placed(self, position: FloatArray) -> FloatArray:
        """Return where centroids are at a position, (n, 2 or 3) [m]."""

    @abstractmethod
    def moved_by(self, position: FloatArray, movement: FloatArray) -> FloatArray:
        """Return positions after a finite movement (n, axes), exact in the rotations."""

    @abstractmethod
    def movement_between(self, position: FloatArray, other: FloatArray) -> FloatArray:
        """Return the finite movement (n, axes) from one position to another: `moved_by` backwards."""

    @abstractmethod
    def gather(self, history: History, position: FloatArray, *, first: bool, keeps_lengths: bool = False) -> Contacts:
        """Return the contacts near a position with their history; `first`: closed ones are intact.

        `keeps_lengths`: faces that slide off others keep their lengths, in time.
        """

    @abstractmethod
    def commit(self, contacts: Contacts, at: Evaluation, position: FloatArray) -> tuple[History, int]:
        """Return the history after an accepted step, and the number of contacts that failed in it."""

    @abstractmethod
    def searched_again(self, contacts: Contacts, at: Evaluation, position: FloatArray) -> Contacts:
        """Return contacts searched at a position within a step: what slides still remembers where it began to."""

    @abstractmethod
    def worn(self, contacts: Contacts, at: Evaluation) -> Contacts:
        """Return contacts as slip in an accepted step has left them: where strength wore off their shear is cut."""

    @abstractmethod
    def some(self, contacts: Contacts, rows: IntArray, block: IntArray) -> Contacts:
        """Return some of the contacts, their blocks renumbered (n,)."""

    @abstractmethod
    def mean_contact_force(self, at: Evaluation) -> float:
        """Return the mean force of the contacts that carry [N/m]."""

    @abstractmethod
    def stiffness_sums(self, contacts: Contacts, at: Evaluation) -> tuple[float, float]:
        """Return the sums of normal and shear stiffness of the contacts within tolerance [N/m2]."""

    @abstractmethod
    def max_relative_movement(self, contacts: Contacts, movement: FloatArray) -> float:
        """Return the largest relative movement of neighbouring blocks [m]."""

    @abstractmethod
    def shares_inside(self, position: FloatArray, block: IntArray) -> FloatArray:
        """Return which part of each of some blocks (k,) lies inside others, (k,)."""

    @abstractmethod
    def tangent(
        self, contacts: Contacts, at: Evaluation, pattern: BlockPattern, regularization: float = 0.0
    ) -> FloatArray:
        """Return the blocks of the contacts' tangent; open and slipping ones keep a part of their stiffness."""

    @abstractmethod
    def first_tangent(self, contacts: Contacts, at: Evaluation, pattern: BlockPattern) -> FloatArray:
        """Return the elastic tangent of a step from rest: every contact within tolerance closed and sticking."""

    @abstractmethod
    def elastic_tangent(self, contacts: Contacts, at: Evaluation, pattern: BlockPattern) -> FloatArray:
        """Return the stiffest possible tangent: contacts that are closed or within tolerance closed and sticking."""

    def acting_at(self, position: FloatArray) -> FloatArray:
        """Return weights, loads, water and bolt forces, (n, axes)."""
        if not len(self.bolts.alive):
            return self.loads_at(position)
        return self.loads_at(position) + self.bolts.evaluate(position).forces

    def constraints_at(self, position: FloatArray, *, conflicts: bool = False) -> Constraints:
        """Return the supports' constraints on small movements from a position."""
        left = self.bars.value - self.reached(position)
        return constrain_bars(self.model, self.bars, self.bar_arms(position), left, conflicts=conflicts)

    def prescribed_increment(self, supports: Constraints) -> FloatArray:
        """Return the part of the prescribed displacements that is applied in one step.

        It is less than the movement of a falling block in a step, so that blocks keep up with a sinking support.
        """
        size = float(np.abs(supports.prescribed / self.scale).max())
        return supports.prescribed * min(1.0, PRESCRIBED_STEP * self.d / size) if size > 0 else supports.prescribed

    def prescription_complete(self, position: FloatArray) -> bool:
        """Return whether the prescribed displacements are applied in full."""
        left = self.constraints_at(position).prescribed / self.scale
        return float(np.abs(left).max()) <= RULES.rounding * self.size

    def evaluate(self, contacts: Contacts, position: FloatArray) -> Evaluation:
        """Return the contact forces at a position; the last two are kept, for one method passes its end to the next."""
        for known, answer in self._answered:
            if known[0] is contacts and known[1] is position:
                return answer
        del self._answered[1:]  # before the new one is made
        found = self.evaluate_contacts(contacts, self.catalogue.laws, position)
        self._answered.insert(0, ((contacts, position), found))
        return found

    def set_residual_scale(self, contacts: Contacts, position: FloatArray) -> None:
        """Set `residual_scale` from the moving blocks' weight and the mean contact force at the start."""
        if self.mean_weight > 0:
            reference = max(self.moving_weight, self.mean_contact_force(self.evaluate(contacts, position)))
            self.residual_scale = reference / self.mean_weight

    def static_residual(self, contacts: Contacts, position: FloatArray) -> float:
        """Return the maximum norm of the static residual over the reference weight."""
        at = self.evaluate(contacts, position)
        residual = self.constraints_at(position).unconstrained(self.acting_at(position) + at.forces, self.scale)
        return float(np.abs(residual).max()) / (self.residual_scale * self.weight(at))

    def wearing_residual(self, contacts: Contacts, at: Evaluation, residual: float) -> float:
        """Return the static residual once slip up to an evaluation has worn strength off, or `residual`."""
        if not self.catalogue.wears or not (at.closed & ~at.sticking).any():
            return residual
        return max(residual, self.static_residual(self.worn(contacts, at), at.position))

    def weight(self, at: Evaluation) -> float:
        """Return the unit of residuals within a step [N/m]: mean weight or load, else the mean contact force."""
        return self.mean_weight or self.mean_contact_force(at) or 1.0
