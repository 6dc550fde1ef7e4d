"""Newmark's sliding block: how far a block slides that resists every acceleration of its base up to a yield one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.base_motion import BaseMotion

INSTANTS = 20_001  # at least; and ten between two values of a record


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Sliding:
    """How a block slides.

    Attributes
    ----------
    time : (k,) float64 [s]
        From 0 to where it is at rest again.
    velocity, displacement : (k,) float64 [m/s, m]
        Of the block relative to the base, to its side.
    """

    time: FloatArray
    velocity: FloatArray
    displacement: FloatArray

    @property
    def permanent(self) -> float:
        """Displacement at the end [m]."""
        return float(self.displacement[-1])


def slide(base: BaseMotion, part: float, resistance: float) -> Sliding:
    """Return how far a block slides to one side only, by integrating the record twice.

    It starts when the base accelerates to the other side by more than the resistance. It stops when its velocity
    relative to the base is used up.

    Parameters
    ----------
    base : BaseMotion
        The record.
    part : float
        Of the base's velocity that pushes the block to its side: -1 to the side of the base's axis, 1 to the other.
    resistance : float [m/s2]
        The yield acceleration, above 0.

    References
    ----------
    Newmark, N. M. (1965). Effects of earthquakes on dams and embankments. Geotechnique 15, 139-160.

    Examples
    --------
    A pulse of a = 0.5 g for 0.3 s over 0.2 g: (a - y) t^2 / 2 a / y.

    >>> import bsm_mesh as bsm
    >>> pulse = bsm.Shaking(waveform="pulse", frequency=1, cycles=0.3, amplitude=0.5 * 9.81)
    >>> round(slide(BaseMotion(pulse), 1.0, 0.2 * 9.81).permanent, 5)
    0.33109
    """
    time = base.instants(INSTANTS)
    pushed = part * base.velocity_at(time) - resistance * time
    # What the base gains over the resistance moves the block; it never moves backwards, so the lowest value is rest.
    velocity: FloatArray = pushed - np.minimum.accumulate(pushed)
    displacement = np.append(0.0, np.cumsum((velocity[1:] + velocity[:-1]) / 2 * np.diff(time)))
    if velocity[-1] > 0:  # the base keeps its velocity: the resistance alone slows the block
        left = velocity[-1] / resistance * np.linspace(0, 1, 101)[1:]
        time = np.append(time, time[-1] + left)
        displacement = np.append(displacement, displacement[-1] + velocity[-1] * left - resistance * left**2 / 2)
        velocity = np.append(velocity, velocity[-1] - resistance * left)
    return Sliding(time=time, velocity=velocity, displacement=displacement)
