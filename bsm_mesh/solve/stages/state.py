"""The state that a run of stages carries from one to the next, and its checkpoints."""

from __future__ import annotations

from dataclasses import dataclass, field

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.flow.coupling import FlowState
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Bars
from bsm_mesh.model.water import Water
from bsm_mesh.solve.stages.checkpoint import Checkpoint, StageProgress
from bsm_mesh.solve.stages.new_faces import concatenate
from bsm_mesh.solve.stages.relaxation import Relaxation
from bsm_mesh.solve.stages.scheme import Scheme


@dataclass(eq=False, slots=True)
class StageState:
    """The state that changes from stage to stage, in the numbers of the whole; `model` has the stage's strength."""

    model: Model
    present: BoolArray
    bars: Bars
    bar_forces: FloatArray
    forces: list[PointForces]
    water: Water | None
    origin: FloatArray
    relaxation: Relaxation = field(default_factory=Relaxation)
    fallen: list[int] = field(default_factory=list)
    flow: FlowState | None = None

    @classmethod
    def recalled(cls, begun: Checkpoint, model: Model, bars: Bars, water: Water | None) -> StageState:
        """Return the state at a checkpoint."""
        return cls(
            model=model,
            present=begun.present,
            bars=bars,
            bar_forces=begun.bar_forces.copy(),
            forces=list(begun.forces),
            water=water,
            relaxation=Relaxation(begun.unreleased),
            origin=begun.origin.copy(),
            fallen=list(begun.fallen),
            flow=begun.flow,
        )

    def checkpoint(self, finished: int, scheme: Scheme, stage: StageProgress | None = None) -> Checkpoint:
        """Return the checkpoint after so many finished stages, `stage` being under way."""
        return Checkpoint(
            finished=finished,
            stage=stage,
            scheme=scheme.state,
            present=self.present,
            bar_forces=self.bar_forces.copy(),
            origin=self.origin.copy(),
            forces=tuple(self.forces),
            unreleased=self.relaxation.held,
            fallen=tuple(self.fallen),
            flow=self.flow,
        )

    def take_away(self, down: IntArray) -> None:
        """Take blocks (k,) away that fell: nothing holds them, and they hold nothing."""
        self.fallen.extend(down.tolist())
        self.present = self.present.copy()
        self.present[down] = False
        self.origin[down] = 0.0
        self.bar_forces[~self.present[self.bars.block]] = 0.0

    @property
    def all_forces(self) -> PointForces:
        """Loads, and the part of excavation forces that still acts."""
        return concatenate([*self.forces, *self.relaxation.acting])
