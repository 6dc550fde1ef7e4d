"""Work for schedulers that takes no time: workers import it from here."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError


@dataclass(frozen=True)
class Doubling:
    """Doubles x; kills its process where it is reported to, once or always.

    Attributes
    ----------
    folder : Path
        Where it leaves a file a run that is begun.
    kills_once, kills_always : tuple of int
        Runs in which the process dies as of kill -9.
    seconds : float
        Time of a run.
    """

    folder: Path
    kills_once: tuple[int, ...] = ()
    kills_always: tuple[int, ...] = ()
    seconds: float = 0.0
    key: str = "doubling"

    def __call__(self, run: int, values: Mapping[str, Any]) -> dict[str, Any]:
        begun = len(list(self.folder.glob(f"{run}-*")))
        (self.folder / f"{run}-{begun}").touch()
        print("what a library prints")
        if run in self.kills_always or (run in self.kills_once and not begun):
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.seconds)
        return {"status": "stable", "doubled": 2 * values["x"], "process": os.getpid()}


@dataclass(frozen=True)
class NotSent:
    """Cannot be unpickled where it arrives."""

    key: str = "not sent"

    def __reduce__(self) -> Any:
        return os.kill, (0, 0, 0)  # too many arguments


@dataclass(frozen=True)
class Dying:
    """Trials of which one kills its process, once or always, and one has an error of the model."""

    folder: Path
    always: bool

    def run(self, value: float, limit: float | None) -> float:
        if value == 2 and (self.always or not any(self.folder.iterdir())):
            (self.folder / "begun").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if value == 3:
            raise ModelError("of the model")
        return value
