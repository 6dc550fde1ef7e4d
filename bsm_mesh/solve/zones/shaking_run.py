"""A stage of zones that is shaken: through the record, and on to rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.base_motion import GRAVITY
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.movements import distances
from bsm_mesh.results.records import StepRecord
from bsm_mesh.solve.motion.falling import SETTINGS as COLLAPSE
from bsm_mesh.solve.motion.following import DAMPED, FREE
from bsm_mesh.solve.motion.shaking_faults import divergence, imbalance
from bsm_mesh.solve.motion.shaking_memory import SUMS
from bsm_mesh.solve.zones.shaken_zones import SINGLE, ShakenZones
from bsm_mesh.solve.zones.stage_solution import RUNAWAY, Fall, StageEnd, movement

if TYPE_CHECKING:
    from bsm_mesh.solve.zones.stages import Continuum

SLIP = SUMS.index("slip")
SLIDES_ON = "after the shaking blocks moved on by more than their size"
SMALL = 'small displacements do not follow them; give zones displacement = "large"'
PARTS = 10  # of so many windows after the record without any slip: elastic vibrations are left
SLOW = 0.01  # of a block's weight: blocks are followed as long as it takes to drive them on by `COLLAPSE.runs`


class Watch(Protocol):
    """Gets the times of a stage that is shaken."""

    def __call__(self, motion: ShakenZones, *, now: Callable[[], StageEnd]) -> None:
        """Look at the motion at its present time; `now` returns the stage then."""


def unwatched(motion: ShakenZones, *, now: Callable[[], StageEnd]) -> None:
    """Look at nothing."""


def shaken_through(motion: ShakenZones, shaking: Shaking, watch: Callable[[ShakenZones], None]) -> str:
    """Shake zones to the end of the record, and return the reason for no answer; empty if there is one."""
    count = round(shaking.length / shaking.interval)
    for number in range(1, count + 1):
        motion.go_on(shaking.length if number == count else number * shaking.interval)
        if motion.diverged:
            return divergence(motion.memory, shaking)
        motion.keep_record()
        watch(motion)
    return imbalance(motion.memory, shaking)


def come_to_rest(of: Continuum, motion: ShakenZones, present: BoolArray) -> tuple[str, Fall | None]:
    """Follow zones after the record until they are near rest; return why they are not, and blocks that move on.

    Blocks that slide on are hardly damped, as rigid blocks are; all motion without slip is. Nothing and None: at rest.
    """
    end = motion.memory
    least = SINGLE * (abs(end.springs) or end.greatest_energy)  # of those that nothing loads before the shaking
    size, start = np.sqrt(of.model.blocks.moments.area), movement(of, motion.at.u)
    gone, still = np.zeros_like(present), 0
    motion.damping, motion.is_over = FREE.damping, True
    longest = end.time + time_to_rest(size)
    while motion.kinetic > least and motion.memory.time < longest and not motion.diverged and not gone.any():
        slipped = motion.memory.sums[SLIP]
        go_on(motion)
        still = still + 1 if motion.memory.sums[SLIP] == slipped else 0
        motion.damping = (DAMPED if still >= PARTS else FREE).damping
        gone = (distances(movement(of, motion.at.u) - start) > RUNAWAY * size) & present
    beyond, is_calm, motion.memory = motion.memory.time - end.time, motion.kinetic <= least, end
    if is_calm:
        return "", None
    if not gone.any():
        return f"blocks were not at rest within {beyond:.3g} s after the record", None
    if of.discretization.large:
        return "", Fall(np.flatnonzero(gone).astype(np.int32), SLIDES_ON)
    return f"after the record blocks slide on by more than their size: {SMALL}", None


def time_to_rest(size: FloatArray) -> float:
    """Return for how long blocks of some sizes (n,) [m] are followed to rest, [s]."""
    return float(np.sqrt(2 * COLLAPSE.runs * size.mean() / (SLOW * GRAVITY)))


def go_on(motion: ShakenZones) -> None:
    """Move nodes through a window."""
    memory = motion.memory
    motion.go_on(memory.time + motion.window_cycles * memory.stable)


def shaken_step(of: Continuum, motion: ShakenZones, stage: int, step: int, seconds: float) -> StepRecord:
    """Return the record of a time of a stage that is shaken."""
    state, history = motion.at.state, motion.equations.history
    there = np.zeros(0, dtype=bool) if history is None else history.present
    opens = there if state is None else ~state.closed
    slips = there if state is None else state.closed & ~state.sticking
    return StepRecord(
        stage=stage,
        step=step,
        residual=motion.at.size,
        max_displacement=float(distances(movement(of, motion.at.u)).max(initial=0.0)),
        newton_iterations=0,
        factorizations=0,
        open_contacts=int((opens & there).sum()),
        slipping_contacts=int((slips & there).sum()),
        seconds=seconds,
        method="shaking",
        time=motion.memory.time,
    )
