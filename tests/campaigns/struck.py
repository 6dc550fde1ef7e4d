"""A run of the program that is struck: at its n-th operation on files it is killed, or the disk is full.

``python -m tests.campaigns.struck N ROOT LOG ARGUMENTS...`` runs ``bsm-mesh ARGUMENTS`` and kills itself before
operation N on files in ROOT (0: never). Into LOG go a line when it begins, one an operation, one when a stage makes its
first step, one when
a step has ended. Checkpoints are written after every step.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

OURS = "bsm_mesh.files"  # told by the project's one writer, before each operation
CHANGES = ("os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod")
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
ENDS = 8  # operations where a run begins and where it ends, which no sample leaves out
_hooks: list[Callable[[str, str], None]] = []
_told_by_ours = False


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    global _told_by_ours
    if not _hooks:
        return
    if event == "open":
        path, mode, flags = arguments
        if not isinstance(path, str | bytes | os.PathLike):
            return
        changes = any(letter in mode for letter in "wax+") if isinstance(mode, str) else bool((flags or 0) & WRITES)
        if not changes:
            return
        told, paths = "open", [path]
    elif event == OURS:
        told, paths = f"{event} {arguments[0]}", list(arguments[1:])
    elif event in CHANGES:
        told, paths = event, [part for part in arguments if isinstance(part, str | bytes | os.PathLike)]
    else:
        return
    begins, _told_by_ours = _told_by_ours and event != OURS, event == OURS
    if begins or not paths:  # the same operation, told by Python too: nothing has happened in between
        return
    for hook in list(_hooks):
        hook(told, os.path.abspath(os.fsdecode(paths[0])))


sys.addaudithook(_audit)  # it cannot be removed; the hooks can


@contextmanager
def watched(root: Path, act: Callable[[int, str], None]) -> Iterator[None]:
    """Call `act` with the number (from 1) and the name of every operation on files in a folder, before it is done."""
    seen, inside = 0, f"{root.resolve()}{os.sep}"

    def hook(told: str, path: str) -> None:
        nonlocal seen
        if path.startswith(inside):
            seen += 1
            act(seen, f"{told} {path.removeprefix(inside)}")

    _hooks.append(hook)
    try:
        yield
    finally:
        _hooks.remove(hook)


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
