"""The state of a model with zones, which changes from stage to stage."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.loads import ActingLoad
from bsm_mesh.model.model import Model
from bsm_mesh.solve.bolts.memory import BoltMemory
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts
from bsm_mesh.solve.zones.fills import Fill
from bsm_mesh.solve.zones.ground import PoreWater
from bsm_mesh.solve.zones.joint_history import JointHistory
from bsm_mesh.solve.zones.joint_points import JointPoints
from bsm_mesh.solve.zones.met_points import with_met
from bsm_mesh.solve.zones.moving_points import Met, MovingPoints, Places


@dataclass(eq=False, slots=True)
class ZonesState:
    """Displacements, joints, bolts and loads; `model` and `joints` have the strength and the gravity of the stage."""

    model: Model
    u: FloatArray
    origin: FloatArray
    joints: JointPoints | None
    history: JointHistory | None
    bolts: EmbeddedBolts | None
    loads: tuple[ActingLoad, ...]
    water: PoreWater | None
    pressures: FloatArray
    relief: FloatArray  # of rock that yields
    fallen: BoolArray  # blocks (n,) that were taken away
    unreleased: list[tuple[FloatArray, float]] = field(default_factory=list)  # forces; part released
    fills: tuple[Fill, ...] = ()

    def held_back(self, part: float) -> FloatArray:
        """Return the rest of excavation forces once a part is released; forget parts released whole."""
        self.unreleased = [(forces, max(released, part)) for forces, released in self.unreleased]
        self.unreleased = [(forces, released) for forces, released in self.unreleased if released < 1]
        return sum(((1 - released) * forces for forces, released in self.unreleased), np.zeros_like(self.u))

    def recall(self, memory: ZonesMemory) -> None:
        """Take the state variables of a memory."""
        self.u, self.origin, self.history = memory.u, memory.origin, memory.history
        self.bolts = None if self.bolts is None or memory.bolts is None else self.bolts.recalled(memory.bolts)
        if isinstance(self.joints, MovingPoints) and memory.places is not None:
            self.joints = with_met(self.joints, memory.met).facing(memory.places)
        self.pressures, self.relief = memory.pressures, memory.relief
        self.unreleased, self.fills, self.fallen = list(memory.unreleased), memory.fills, memory.fallen

    def without(self, down: IntArray) -> ZonesState:
        """Return the state without blocks (k,) that fall."""
        fallen = self.fallen.copy()
        fallen[down] = True
        return replace(self, fallen=fallen, bolts=None if self.bolts is None else self.bolts.without(fallen))


class Part(NamedTuple):
    """A part of a stage: its name, the blocks that are there (n,), the parts from this one on, the state before."""

    name: str
    present: BoolArray
    parts: tuple[float, ...]
    before: ZonesState


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ZonesMemory:
    """State variables at the end of a stage; all else follows from the model.

    Attributes
    ----------
    u, origin : (N,) float64 [m]
        Displacements, and those from which results count.
    history : JointHistory or None
        Of the joints.
    places : Places or None
        Of joints that slide in large displacement.
    met : Met
        Points where faces came upon other blocks.
    bolts : BoltMemory or None
        Of the bolts.
    pressures : float64 [N/m]
        Of stages on new faces.
    relief : (c, i, 4) float64 [Pa]
        Of rock that yields.
    unreleased : tuple of ((N,) float64 [N/m], float)
        Excavation forces, and the part of each that is released.
    fills : tuple of Fill
        Rock that was put back.
    fallen : (n,) bool
        Blocks that were taken away.
    reactions : (N,) float64 [N/m]
        Of supports that hold blocks or points between nodes.
    """

    u: FloatArray
    origin: FloatArray
    history: JointHistory | None
    places: Places | None
    met: Met
    bolts: BoltMemory | None
    pressures: FloatArray
    relief: FloatArray
    unreleased: tuple[tuple[FloatArray, float], ...]
    fills: tuple[Fill, ...]
    fallen: BoolArray
    reactions: FloatArray

    @classmethod
    def of(cls, state: ZonesState, reactions: FloatArray) -> ZonesMemory:
        """Return the memory of a state, with the reactions (N,) [N/m]."""
        return cls(
            u=state.u,
            origin=state.origin,
            history=state.history,
            places=state.joints.places if isinstance(state.joints, MovingPoints) else None,
            met=state.joints.met if isinstance(state.joints, MovingPoints) else Met.none(),
            bolts=None if state.bolts is None else BoltMemory.of(state.bolts.bolts),
            pressures=state.pressures,
            relief=state.relief,
            unreleased=tuple(state.unreleased),
            fills=state.fills,
            fallen=state.fallen,
            reactions=reactions,
        )
