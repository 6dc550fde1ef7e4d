"""A shaken stage as a result: its energies over time, the peaks of every block, and how it was followed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, Portable, show_only
from bsm_mesh.model.submodel import SubModel

ENERGIES = ("input", "loads", "kinetic", "springs", "bolts", "slip", "dashpots", "mass_damping", "quiet", "error")
"""Energies put in by the base or waves and by weight, loads and water; the energies that take them; the remainder."""


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class ShakingResult(Portable):
    """How blocks moved while they were shaken.

    Attributes
    ----------
    time : (k,) float64 [s]
        Times of the values.
    base_acceleration : (k,) float64 [m/s2]
        Of the base at them, along its direction, as a mean over a time step.
    energy : (k, 10) float64 [N]
        Energies since the start, per metre of thickness, a column each of `ENERGIES`. `input` is the work of the base
        or of waves; `loads` that of weights, loads and water, less the energy of removed blocks. Movement, springs,
        bolts, slip, dashpots, mass damping and quiet boundaries take it; the rest is `error`.
    peak_velocity : (n,) float64 [m/s]
        Greatest speed of every block relative to the base; with zones of any of its nodes.
    peak_acceleration : (n,) float64 [m/s2]
        Greatest acceleration of every block's centroid, that of the base included.
    slip_energy : (j + 1,) float64 [N]
        What slip took in every joint of ``Results.joint_names``, and in unjointed rock.
    end_velocity : float [m/s]
        Greatest speed of a block at the end.
    time_step : float [s]
        The smallest.
    cycles, windows : int
        Time steps, and how often contacts were evaluated in double precision.
    heavier : (n,) bool
        Blocks that were heavier than real at any time (`Shaking.mass_scaling`).
    heaviest : float
        Greatest mass over the real one.
    imbalance : float
        Greatest `error` over the greatest of all energies.
    """

    time: FloatArray
    base_acceleration: FloatArray
    energy: FloatArray
    peak_velocity: FloatArray
    peak_acceleration: FloatArray
    slip_energy: FloatArray
    end_velocity: float
    time_step: float
    cycles: int
    windows: int
    heavier: BoolArray
    heaviest: float
    imbalance: float

    def __post_init__(self) -> None:
        show_only(self)

    def in_whole(self, part: SubModel) -> ShakingResult:
        """Return the same in the numbers of the whole."""
        return replace(
            self,
            peak_velocity=part.in_whole(self.peak_velocity),
            peak_acceleration=part.in_whole(self.peak_acceleration),
            heavier=_in_whole(part, self.heavier),
        )


def _in_whole(part: SubModel, chosen: BoolArray) -> BoolArray:
    whole = np.zeros(len(part.present), dtype=bool)
    whole[part.block] = chosen
    return whole


def imbalance_of(energy: FloatArray) -> float:
    """Return the greatest error over the greatest of all energies (k, 10); 0 where there is none.

    Examples
    --------
    >>> imbalance_of(np.array([[100.0, 0, 60, 0, 0, 39, 0, 0, 0, 1]]))
    0.01
    """
    greatest = float(np.abs(energy[:, :-1]).max(initial=0.0))
    return float(np.abs(energy[:, -1]).max(initial=0.0)) / greatest if greatest > 0 else 0.0
