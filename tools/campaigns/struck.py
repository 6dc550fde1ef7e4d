"""A run of the program that is struck: at its n-th operation on files it is killed, or the disk is full.

``python -m tools.campaigns.struck N ROOT LOG ARGUMENTS...`` runs ``bsm-mesh ARGUMENTS`` and kills itself before
operation N on files in ROOT (0: never). Into LOG go a line when it begins, one an operation, one when a stage makes its
first step, one when
a step has ended. Checkpoints are written after every step.
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import Any

from tests.audited_operations import watched

ENDS = 8  # operations where a run begins and where it ends, which no sample leaves out


def sample(last: int, every: int) -> list[int]:
    """Return each n-th of so many operations, and all at both ends: the folders are set up and exchanged there."""
    return [n for n in range(1, last + 1) if n % every == 0 or n <= ENDS or n > last - ENDS]


def main(number: int, root: Path, log: int, arguments: list[str]) -> None:
    """Run the program; it does not come back from operation `number`."""
    from bsm_mesh.__main__ import main as program
    from bsm_mesh.folder import checkpoints
    from bsm_mesh.text import progress

    checkpoints.SETTINGS.interval = 0.0
    stages: set[int] = set()
    step = progress.Progress.step

    def tell_stage(self: Any, record: Any) -> None:
        if record.stage not in stages:
            stages.add(record.stage)
            os.write(log, f"stage {record.stage}\n".encode())
        os.write(log, b"step\n")
        step(self, record)

    progress.Progress.step = tell_stage  # type: ignore[method-assign]

    def strike(seen: int, told: str) -> None:
        os.write(log, f"{seen} {told}\n".encode())
        if seen == number:
            os.kill(os.getpid(), signal.SIGKILL)

    os.write(log, b"begins\n")
    with watched(root, strike):
        sys.argv[1:] = arguments
        program()


if __name__ == "__main__":
    main(
        int(sys.argv[1]), Path(sys.argv[2]), os.open(sys.argv[3], os.O_WRONLY | os.O_CREAT | os.O_APPEND), sys.argv[4:]
    )
