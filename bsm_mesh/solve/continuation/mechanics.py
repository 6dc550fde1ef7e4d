"""The mechanics of a model's blocks, in the plane or in space: all that the shared loop and scheme ask of either."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from bsm_mesh import space
from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.solve.bolts.installed import InstalledBolts
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.solve.stages.scheme import Outcome
from bsm_mesh.solve.step.system import History, System

if TYPE_CHECKING:
    from bsm_mesh.results.bolts import BoltForces


class Mechanics(Protocol):
    """The rooms of one kind of blocks."""

    def system(self, model: Model, bolts: InstalledBolts | None, position: FloatArray | None) -> System:
        """Return the block system of a model, its bolts installed, its blocks at a position (n, axes)."""

    def no_history(self) -> History:
        """Return the empty contact history of the start."""

    def in_situ_history(self, model: Model) -> tuple[History, tuple[str, ...]]:
        """Return the contact history under the in-situ field, and notes on it."""

    def between(self, history: History, stays: BoolArray) -> History:
        """Return the history of contacts between blocks that stay, (n,)."""

    def in_part(self, history: History, part: SubModel) -> History:
        """Return the history in the numbers of a submodel."""

    def in_whole(self, history: History, part: SubModel) -> History:
        """Return the history of a submodel in the numbers of the whole."""

    def with_filled_blocks(
        self, history: History, model: Model, comes: BoolArray, present: BoolArray, moved: FloatArray
    ) -> tuple[History, FloatArray]:
        """Return the history with contacts of filled blocks (n,), without force, and movements with theirs."""

    def outcome(
        self, system: System, motion: Motion, origin: FloatArray, bars_before: FloatArray, bolts: BoltForces
    ) -> Outcome:
        """Return the record of a stage's end; displacements count from `origin` (n, axes)."""


def mechanics_of(model: Model) -> Mechanics:
    """Return the mechanics of a model's blocks."""
    if in_space(model.blocks):
        return space.Space()
    from bsm_mesh.solve.continuation.plane import Plane

    return Plane()
