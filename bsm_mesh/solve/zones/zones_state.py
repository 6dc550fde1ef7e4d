"""What changes from stage to stage of a model with zones."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.loads import ActingLoad
from bsm_mesh.model.model import Model
from bsm_mesh.solve.zones.embedded_bolts import EmbeddedBolts
from bsm_mesh.solve.zones.fills import Fill
from bsm_mesh.solve.zones.ground import PoreWater
from bsm_mesh.solve.zones.joint_history import JointHistory
from bsm_mesh.solve.zones.joint_points import JointPoints


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
    unreleased: list[tuple[FloatArray, float]] = field(default_factory=list)  # forces; part released
    fills: tuple[Fill, ...] = ()

    def held_back(self, part: float) -> FloatArray:
        """Return the rest of excavation forces once a part is released; forget parts released whole."""
        self.unreleased = [(forces, max(released, part)) for forces, released in self.unreleased]
        self.unreleased = [(forces, released) for forces, released in self.unreleased if released < 1]
        return sum(((1 - released) * forces for forces, released in self.unreleased), np.zeros_like(self.u))
