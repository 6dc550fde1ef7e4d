"""Which steps of a movement are kept as snapshots: a bounded number, evenly spread.

Every snapshot has all arrays of a stage's end, since ParaView drops arrays that one time does not have. At 200
snapshots every second one is removed and the stride doubles, so that 100 to 200 remain of a run of any length.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from bsm_mesh.results.clock import Clock
from bsm_mesh.results.records import StepRecord

if TYPE_CHECKING:
    from bsm_mesh.converters.result_files import Instant

MOST_SNAPSHOTS = 200  # of each kind of file


class Snapshots:
    """Takes every step, until there are `MOST_SNAPSHOTS`: then every second goes, and of what follows as well.

    So a run of any length leaves between half of `MOST_SNAPSHOTS` and all of them, evenly spread over its steps.

    Attributes
    ----------
    instants : list of Instant
        The snapshots that there are.
    """

    def __init__(self) -> None:
        self.instants: list[Instant] = []
        self._taken, self._stride, self._clock = 0, 1, Clock()

    @property
    def told(self) -> dict[str, Any]:
        """How far it is, as JSON can say it."""
        instants = [[instant.time, instant.stage, instant.step, instant.moment] for instant in self.instants]
        return {"taken": self._taken, "stride": self._stride, "clock": asdict(self._clock), "instants": instants}

    def recall(self, told: dict[str, Any]) -> None:
        """Be where it was when it reported so."""
        from bsm_mesh.converters.result_files import Instant

        self._taken, self._stride, self._clock = told["taken"], told["stride"], Clock(**told["clock"])
        self.instants = [Instant(*numbers) for numbers in told["instants"]]

    def instant(self, record: StepRecord) -> Instant | None:
        """Count a step, and return its instant if it is its turn."""
        from bsm_mesh.converters.result_files import Instant

        self._taken += 1
        moment = self._clock.tick(record)
        return None if self._taken % self._stride else Instant(self._taken, record.stage, record.step, moment)

    @property
    def zero(self) -> float:
        """Moment from which played times count."""
        return self._clock.zero or 0.0

    def add(self, instant: Instant) -> list[Instant]:
        """Add a snapshot that was written, and return those that are to go."""
        self.instants.append(instant)
        if len(self.instants) < MOST_SNAPSHOTS:
            return []
        self._stride *= 2
        gone = [old for old in self.instants if old.time % self._stride]
        self.drop(gone)
        return gone

    def drop(self, gone: list[Instant]) -> None:
        """Forget some snapshots."""
        self.instants = [kept for kept in self.instants if kept not in gone]
