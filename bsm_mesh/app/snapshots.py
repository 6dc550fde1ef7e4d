"""Snapshots of a movement, written to disk as it happens: a bounded number, and none kept in memory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.errors import ModelError
from bsm_mesh.files import make_folder, remove
from bsm_mesh.results.records import Results, StepRecord

if TYPE_CHECKING:
    from bsm_mesh.converters.result_files import Instant

MOST_SNAPSHOTS = 200  # of each kind of file


def no_snapshots(record: StepRecord, results: Callable[[], Results]) -> None:
    """Write nothing of a step."""


class SnapshotWriter:
    """Writes every step, until there are `MOST_SNAPSHOTS`: then every second goes, and of what follows as well.

    So a run of any length leaves between half of `MOST_SNAPSHOTS` and all of them, evenly spread over its steps. The
    PVD files list what there is at any time: ParaView can follow the run, and an interrupted run leaves its movement.

    Parameters
    ----------
    folder : Path
        Where to; it is made with the first snapshot, and the snapshots of an earlier run in it are removed.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.instants: list[Instant] = []
        self._taken, self._stride = 0, 1

    def __call__(self, record: StepRecord, results: Callable[[], Results]) -> None:
        """Write the results of a step if it is its turn; `bsm_mesh.run` calls this."""
        from bsm_mesh.converters.result_files import Instant

        self._taken += 1
        if self._taken % self._stride:
            return
        try:
            self._write(Instant(self._taken, record.stage, record.step), results())
        except OSError as error:
            raise ModelError(
                f"cannot write snapshots to {self.folder}: {error.strerror or error}; choose another folder"
            ) from error

    def _write(self, instant: Instant, results: Results) -> None:
        from bsm_mesh.converters.result_files import list_snapshots, remove_snapshots, write_snapshot

        if not self.instants:
            make_folder(self.folder)
            remove(self.folder / "summary.json")  # the mark of a complete run
            remove_snapshots(self.folder)
        write_snapshot(results, self.folder, instant)
        self.instants.append(instant)
        full = len(self.instants) >= MOST_SNAPSHOTS
        if full:
            self._stride *= 2
            self.instants = [kept for kept in self.instants if kept.time % self._stride == 0]
        list_snapshots(self.folder, self.instants)
        if full:
            remove_snapshots(self.folder, keep=self.instants)
