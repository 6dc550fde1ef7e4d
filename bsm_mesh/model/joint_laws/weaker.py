"""The weaker of two laws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.joint_laws.law import JointResponse, handed_on, remembered_by
from bsm_mesh.model.joint_laws.mohr_coulomb import MohrCoulomb


@dataclass(frozen=True, slots=True)
class Weaker:
    """The weaker of two laws at the pressure: two rocks that meet without a joint."""

    one: MohrCoulomb
    other: MohrCoulomb

    @property
    def wear_length(self) -> float | None:
        """The shorter of both laws' [m]; None: neither wears."""
        both = [law.wear_length for law in (self.one, self.other) if law.wear_length is not None]
        return min(both, default=None)

    @property
    def remembers(self) -> tuple[str, ...]:
        """State variables that one of both depends on."""
        return tuple(dict.fromkeys(remembered_by(self.one) + remembered_by(self.other)))

    def respond(
        self,
        pressure: FloatArray,
        trial_shear: FloatArray,
        length: FloatArray,
        failed: BoolArray,
        *memory: FloatArray,
    ) -> JointResponse:
        """Return the response of the law that carries less."""
        given, both = (pressure, trial_shear, length), (self.one, self.other)
        a, b = (law.respond(*given, *handed_on(law, self, failed, memory)) for law in both)
        first = a.shear <= b.shear
        return JointResponse(
            shear=np.where(first, a.shear, b.shear),
            by_pressure=np.where(first, a.by_pressure, b.by_pressure),
            strength=np.minimum(a.strength, b.strength),
            sticking=a.sticking & b.sticking,
            failed=np.where(first, a.failed, b.failed),
        )

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lines of both laws."""
        of_both = zip(self.one.strength_lines(length), self.other.strength_lines(length), strict=True)
        slope, intercept = (np.concatenate(pair, axis=1) for pair in of_both)
        return slope, intercept

    def reduced(self, factor: float) -> Weaker:
        """Return the weaker of both laws divided by a factor."""
        return Weaker(self.one.reduced(factor), self.other.reduced(factor))
