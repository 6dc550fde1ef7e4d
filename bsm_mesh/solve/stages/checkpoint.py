"""A checkpoint of a run: with it, and the results of finished stages, a run continues as if it had never ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.flow.coupling import FlowState
from bsm_mesh.model.loads import PointForces
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.records import StageResult, StepRecord


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class StageProgress:
    """How far a stage is that is not at its end.

    Attributes
    ----------
    part : int
        Which of the released parts of its excavation forces is being solved, from 0.
    before : (n, 3) float64 [m, m, rad]
        Displacement of every block at its start.
    steps : tuple of StepRecord
        Its steps so far.
    fallen : tuple of Fall
        Blocks that fell in it and were taken away.
    start_residual : float or None
        Before its first step; None in its first part.
    notes : tuple of str
        Notes that belong to it.
    """

    part: int
    before: FloatArray
    steps: tuple[StepRecord, ...]
    fallen: tuple[Fall, ...]
    start_residual: float | None
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Checkpoint:
    """The state of a run between two steps or two stages, in the numbers of the whole.

    Of blocks with zones the scheme carries all that follows `present`.

    Attributes
    ----------
    finished : int
        Stages that are at their end; their results are no part of it.
    stage : StageProgress or None
        The stage under way; None between two.
    scheme : object
        State of the scheme: its `state`.
    present : (n,) bool
        Which blocks are there.
    bar_forces : (n_bars,) float64 [N/m]
        Forces in the supports.
    origin : (n, 3) float64 [m, m, rad]
        Where displacements count from.
    forces : tuple of PointForces
        Loads so far.
    unreleased : tuple of (PointForces, float)
        Excavation forces, and the part of each that is released.
    fallen : tuple of int
        Blocks that fell and were taken away.
    flow : FlowState or None
        Where flow and blocks are stable.
    """

    finished: int
    stage: StageProgress | None = None
    scheme: object
    present: BoolArray
    bar_forces: FloatArray = field(default_factory=lambda: np.zeros(0))
    origin: FloatArray = field(default_factory=lambda: np.zeros(0))
    forces: tuple[PointForces, ...] = ()
    unreleased: tuple[tuple[PointForces, float], ...] = ()
    fallen: tuple[int, ...] = ()
    flow: FlowState | None = None

    @property
    def last_stage(self) -> int:
        """Number of the stage under way, or of the last finished."""
        return self.finished if self.stage is not None else max(0, self.finished - 1)


Keep: TypeAlias = Callable[[Callable[[], Checkpoint], bool], None]
"""Gets what makes the checkpoint, and whether a stage has ended; it is to be called at once, if at all."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Resumption:
    """Where a run continues and where it ends, and what keeps its checkpoints.

    Attributes
    ----------
    begun : Checkpoint or None
        Where it continues; None: it begins at the start.
    stages : tuple of StageResult
        Results of the stages that were finished there.
    keep : callable
        Gets a checkpoint after every step and stage.
    until : int or None
        Number of the stage at whose end the run ends, 0 for the first; None: the last.
    """

    begun: Checkpoint | None = None
    stages: tuple[StageResult, ...] = ()
    keep: Keep = lambda make, ended: None
    until: int | None = None
