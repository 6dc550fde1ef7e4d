"""Times of the states of a run, for files that are played: seconds where blocks are shaken, steps elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bsm_mesh.results.records import StageResult, StepRecord


@dataclass(slots=True)
class Clock:
    """Counts a step that has no time as 1, and steps of shaken stages by their seconds.

    Attributes
    ----------
    moment : float
        After the last step.
    stage : int
        Of the last step.
    began : float
        Moment at which this stage began.
    zero : float or None
        Moment at which the first shaken stage began; None before it. Played times count from there.

    Examples
    --------
    >>> clock = Clock()
    >>> clock.zero is None, clock.moment
    (True, 0.0)
    """

    moment: float = 0.0
    stage: int = 0
    began: float = 0.0
    zero: float | None = None

    def tick(self, record: StepRecord) -> float:
        """Count a step, and return the moment after it."""
        if record.stage != self.stage:
            self.stage, self.began = record.stage, self.moment
        if record.time is None:
            self.moment += 1
        else:
            self.zero = self.began if self.zero is None else self.zero
            self.moment = max(self.moment, self.began + record.time)
        return self.moment


def ends_of(stages: Iterable[StageResult]) -> tuple[list[float], float]:
    """Return the moments of the ends of stages, and the one from which played times count."""
    clock, ends = Clock(), list[float]()
    for stage in stages:
        for step in stage.steps:
            clock.tick(step)
        ends.append(clock.moment)
    return ends, clock.zero or 0.0
