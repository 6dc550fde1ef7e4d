"""How long a shaken stage will take: time step, number of time steps and processor time, by its first time steps."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.shaken_motion import UNDAMPED


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeSteps:
    """An estimate of the time steps of a shaken stage: the blocks are where they are given.

    Contacts that close in earlier stages, or during the shaking, make time steps shorter. The implicit integrator
    takes more where it halves them.

    Attributes
    ----------
    stage : str
        Name of the stage.
    integrator : str
        Its integrator.
    time_step : float [s]
        The longest time step.
    steps : int
        Number of time steps of the shaking.
    seconds : float [s]
        Processor time of the shaking on this machine, from a few of its time steps. Following blocks to rest is not
        in it.
    block : int or None
        The block that allows the shortest time step; None of the implicit integrator.
    shorter : float
        How many times as long a time step the median block allows.
    scaling : float
        A usual `Shaking.mass_scaling` that makes the time step longer; 1: none does, or it is given.
    longer, heavier : float, int
        How many times as long it makes the time step, and how many blocks it makes heavier.
    """

    stage: str
    integrator: str
    time_step: float
    steps: int
    seconds: float
    block: int | None = None
    shorter: float = 1.0
    scaling: float = 1.0
    longer: float = 1.0
    heavier: int = 0


def shortest(steps: FloatArray, number: IntArray) -> dict[str, Any]:
    """Return the number of the block that allows the shortest of time steps (n,) [s], and the median over it."""
    limited = steps[np.isfinite(steps)]
    if not limited.size:
        return {}
    block = int(steps.argmin())
    return {"block": int(number[block]), "shorter": float(np.median(limited) / steps[block])}


def estimated(name: str, shaking: Shaking, blocks: Any) -> TimeSteps:
    """Return the estimate of a stage, whose blocks, rigid or with zones, are followed for a few time steps."""
    intervals = round(shaking.length / shaking.interval)
    each = blocks.steps_to(shaking.interval)
    time_step = shaking.interval / each
    sample = min(each, UNDAMPED.cycles) * time_step  # a whole window at most
    blocks.go_on(sample)
    steps, began = blocks.memory.cycles, process_time()
    blocks.go_on(min(blocks.memory.time + sample, shaking.length))
    spent, taken = process_time() - began, blocks.memory.cycles - steps
    seconds = intervals * each * spent / taken if taken else 0.0
    return TimeSteps(
        stage=name, integrator=shaking.integrator, time_step=time_step, steps=intervals * each, seconds=seconds
    )
