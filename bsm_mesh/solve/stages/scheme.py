"""The interface of a scheme for the stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.model.supports import Bars
from bsm_mesh.results.evidence import Proof
from bsm_mesh.results.records import StageResult, StepRecord
from bsm_mesh.solve.stages.checkpoint import Checkpoint, StageProgress

Reporter = Callable[[str], None]
Checker = Callable[[StageResult], tuple[str, ...]]  # what speaks against a stage at rest, a sentence each
Prover = Callable[[Model, IntArray], Proof]  # whether it can be at rest as given; unstable blocks
Observer = Callable[[StepRecord, Callable[[], StageResult]], None]  # a step, and what returns the stage
Recording = Callable[[Callable[[], StageResult]], tuple[float, ...]]  # values of the histories as a stage stands
Finished = Callable[[tuple[StageResult, ...]], None]


@dataclass(frozen=True, eq=False, slots=True)
class Watchers:
    """Callbacks of the stages.

    Attributes
    ----------
    observer : callable
        Gets every step.
    check : callable
        Says what speaks against a stage at rest.
    prove : callable
        Says whether forces within strength balance the loads of a model, of which some blocks fall.
    record : callable
        Measures the histories.
    """

    observer: Observer
    check: Checker
    prove: Prover
    record: Recording


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """The result of a stage in the numbers of its submodel, and the forces in its bars.

    `down` (k,) are the unstable blocks, and `small` (k,) which of them are too small to count.
    """

    stage: StageResult
    bar_forces: FloatArray
    down: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    small: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))


class Scheme(Protocol):
    """A scheme, as used by the stages."""

    options: Options
    linear_solver: str
    in_rows: bool
    """Whether its contacts are those of the start, two a face."""
    moved: FloatArray
    """Displacement of every block since it was given, or placed, (n, 3)."""

    @property
    def state(self) -> object:
        """Its state from stage to stage, and from step to step within one: a dataclass."""

    def restore(self, state: Any) -> None:
        """Go back to a state of the same run; `solve` then continues where it was."""

    def set_in_situ(self) -> tuple[str, ...]:
        """Set the contact forces from the in-situ field; return notes on it."""

    def stage_bars(self, bars: Bars, number: int) -> Bars:
        """Return the supports for a stage."""

    def remove_and_place_blocks(self, stays: BoolArray, comes: BoolArray) -> None:
        """Remove contacts of blocks that do not stay (n,), cut their bolts, place those that come (n,)."""

    def install(self, number: int) -> None:
        """Install the bolts of a stage at the current position, from which its movement counts."""

    def as_given(self, block: IntArray, point: FloatArray) -> FloatArray:
        """Return the positions in the given geometry of points (k, 2) of blocks (k,)."""

    def solve(
        self,
        part: SubModel,
        number: int,
        bars_before: FloatArray,
        observer: Observer,
        accepted: Callable[[], None],
    ) -> Outcome:
        """Return the submodel in equilibrium or collapse, and keep its state; `accepted` is called between steps."""


class Stages(Protocol):
    """The stages of a model, as `solve_stages` goes through them."""

    name: str
    """Of the scheme."""

    @property
    def linear_solver(self) -> str:
        """Name of the solver used."""

    def start(self) -> None:
        """Begin at the start."""

    def recall(self, begun: Checkpoint) -> None:
        """Begin at a checkpoint."""

    def solution(
        self, number: int, before: StageResult | None, progress: StageProgress | None
    ) -> Callable[[], StageResult]:
        """Return what solves a stage after the one before, or one under way, to its end or to a failure."""

    def end(self, number: int) -> None:
        """End a stage."""

    def checkpoint(self, finished: int) -> Checkpoint:
        """Return the checkpoint after so many finished stages."""
