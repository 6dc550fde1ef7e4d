"""When a run writes a checkpoint, and the files that may go once it is there."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bsm_mesh.files import remove
from bsm_mesh.folder.checkpoint_file import write_checkpoint
from bsm_mesh.folder.own_files import CHECKPOINT

if TYPE_CHECKING:
    from bsm_mesh.solve.stages.checkpoint import Checkpoint


@dataclass(slots=True)
class CheckpointSettings:
    """When a checkpoint is written, in addition to the ends of stages.

    Attributes
    ----------
    interval : float [s]
        From one to the next at most, as far as a single step does not take longer.
    """

    interval: float = 120.0


SETTINGS = CheckpointSettings()


class Checkpoints:
    """The checkpoints of a run, each in place of the one before.

    Attributes
    ----------
    identity : dict
        Digests that must agree for a run to continue.
    superseded : list of str
        Files that the last checkpoint needs and the next does not: they are removed when that is there.
    """

    def __init__(self) -> None:
        self.identity: dict[str, Any] = {}
        self.superseded: list[str] = []
        self._written = self._offered = time.monotonic()

    def is_due(self, *, ended: bool) -> bool:
        """Return whether one is to be written now: at the end of a stage, or if after the next step it may be late."""
        now = time.monotonic()
        step, self._offered = now - self._offered, now
        return ended or now + step - self._written >= SETTINGS.interval

    def write(self, place: Path, checkpoint: Checkpoint, told: dict[str, Any]) -> None:
        """Write one into a folder, with its other data, and remove what nobody needs any more."""
        write_checkpoint(place / CHECKPOINT, {"identity": self.identity, **told}, checkpoint)
        for name in self.superseded:
            remove(place / name)
        self.superseded.clear()
        self._written = self._offered = time.monotonic()
