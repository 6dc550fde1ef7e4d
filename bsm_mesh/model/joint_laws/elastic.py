"""No limit of strength."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.joint_laws.law import JointResponse


@dataclass(frozen=True, slots=True)
class Elastic:
    """No limit of strength."""

    def respond(
        self, pressure: FloatArray, trial_shear: FloatArray, length: FloatArray, failed: BoolArray
    ) -> JointResponse:
        """Return the trial shear."""
        whole = np.ones(len(pressure), dtype=bool)
        return JointResponse(
            shear=trial_shear,
            by_pressure=np.zeros_like(pressure),
            strength=np.full_like(pressure, np.inf),
            sticking=whole,
            failed=failed.copy(),
        )

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return no line."""
        return np.zeros((len(length), 0)), np.zeros((len(length), 0))

    def reduced(self, factor: float) -> Elastic:
        """Return the law itself: it has no strength to divide."""
        return self
