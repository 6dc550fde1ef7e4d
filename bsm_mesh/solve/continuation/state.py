"""State after an accepted step: with it a run continues as if it had not been interrupted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.results.records import StepRecord
from bsm_mesh.solve.bolts.memory import BoltMemory
from bsm_mesh.solve.continuation.pace import Pace
from bsm_mesh.solve.motion.shaking_memory import ShakingMemory
from bsm_mesh.solve.step.system import History


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class CollapseMemory:
    """Memory of the collapse criterion, an entry a block.

    Attributes
    ----------
    last_supported : (n, axes) float64 [m, rad]
        Position when it last had a contact or a support.
    detached, thrown : (n,) bool
        Without either after the last step; and not before.
    rest : (n, axes) float64 [m, rad]
        Position at the last equilibrium.
    sizes_moved : (n,) int64
        Whole sizes that it moved by.
    speed : (n,) float64 [sqrt(m)]
        Its speed when that last grew.
    """

    last_supported: FloatArray
    detached: BoolArray
    thrown: BoolArray
    rest: FloatArray
    sizes_moved: IntArray
    speed: FloatArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class CycleMemory:
    """Contacts after a cycle of Wang's iteration, for the next, in rising order of their keys.

    Attributes
    ----------
    key : (m,) int64
        Their keys.
    part : (m,) float64
        Part of its shear stiffness that it keeps since it slides, with the sign of its shear; 0: it does not slide.
    borne : (m,) int64
        Cycles in a row in which it was closed.
    """

    key: IntArray
    part: FloatArray
    borne: IntArray

    @classmethod
    def none(cls) -> CycleMemory:
        """Return the memory before the first cycle."""
        whole = np.zeros(0, np.int64)
        return cls(key=whole, part=np.zeros(0), borne=whole)

    def of(self, key: IntArray) -> CycleMemory:
        """Return the memory of contacts by their keys (m,), in that order; nothing of those that it does not know."""
        if not self.key.size:
            return CycleMemory(key=key, part=np.zeros(len(key)), borne=np.zeros(len(key), np.int64))
        place = np.minimum(np.searchsorted(self.key, key), len(self.key) - 1)
        known = self.key[place] == key
        return CycleMemory(key=key, part=self.part[place] * known, borne=self.borne[place] * known)

    def sorted(self) -> CycleMemory:
        """Return the same in rising order of the keys."""
        order = np.argsort(self.key)
        return CycleMemory(key=self.key[order], part=self.part[order], borne=self.borne[order])


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class LoopState:
    """The state of a continuation between two steps; all else follows from its start.

    Attributes
    ----------
    number : int
        Steps so far.
    position : (n, axes) float64 [m, rad]
        The accepted position.
    history : History
        Of the contacts there.
    velocity : (n, axes) float64 or None
        As in `Iterate`.
    quiet : bool
        Whether the last step ended in equilibrium: the next confirms it.
    bolts : BoltMemory
        Of the bolts there.
    pace : Pace
        When an equilibrium is looked for.
    collapse : CollapseMemory
        Of the collapse criterion.
    residual_scale, start_residual : float
        As found by the first step.
    double_precision : str
        Digest of the last step's pattern if its matrix needed factors of double precision; else empty.
    cycle : CycleMemory
        Of the last cycle of Wang's iteration; empty otherwise.
    steps : tuple of StepRecord
        Records of the steps so far.
    shaken : ShakingMemory or None
        How far the stage was shaken.
    """

    number: int
    position: FloatArray
    history: History
    velocity: FloatArray | None
    quiet: bool
    bolts: BoltMemory
    pace: Pace
    collapse: CollapseMemory
    residual_scale: float
    start_residual: float
    double_precision: str
    cycle: CycleMemory
    steps: tuple[StepRecord, ...]
    shaken: ShakingMemory | None = None


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ContinuationState:
    """State of the scheme over stages, in the numbers of the whole, and over the steps of the present one.

    Attributes
    ----------
    moved : (n, axes) float64 [m, rad]
        Displacement of every block where the loop began.
    history : History
        Contact history there; none while a loop continues, which has its own.
    bolts : BoltMemory
        Of the bolts there.
    origin : (n, axes) float64 [m, rad]
        Where the movement of the stage counts from.
    velocity : (n, axes) float64 or None
        Of blocks that continue after a fall.
    intact : bool
        Whether nothing was solved yet.
    linear_solver : str
        Name of the solver used.
    loop : LoopState or None
        Of the loop under way.
    shaken : ShakingMemory or None
        How far the stage was shaken before blocks were taken away.
    """

    moved: FloatArray
    history: History
    bolts: BoltMemory
    origin: FloatArray
    velocity: FloatArray | None
    intact: bool
    linear_solver: str
    loop: LoopState | None
    shaken: ShakingMemory | None = None
