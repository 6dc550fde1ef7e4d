"""The operations of the one writer, watched, failed and killed."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from bsm_mesh import files

Hook = Callable[..., None]
ON_A_FULL_DISK = {"make", "write", "settle", "keep", "append", "lock"}  # what needs room there
_hooks: list[Hook] = []


def _tell(event: str, arguments: tuple[object, ...]) -> None:
    if event == files.EVENT:
        for hook in _hooks:
            hook(*arguments)


sys.addaudithook(_tell)  # it cannot be removed, the hooks can


@contextmanager
def watched(hook: Hook) -> Iterator[None]:
    """Call a hook with the name and the paths of every operation, before it is done."""
    _hooks.append(hook)
    try:
        yield
    finally:
        _hooks.remove(hook)


def full_disk(number: int, stays: bool) -> Hook:
    """Return a hook that fails the operation of a number, and those that need room after it where it stays full."""
    seen = 0

    def hook(operation: str, path: str, *_: str) -> None:
        nonlocal seen
        seen += 1
        if seen == number or (stays and seen > number and operation in ON_A_FULL_DISK):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), path)

    return hook


def count_operations(action: Callable[[], object]) -> int:
    """Return how many operations an action does."""
    seen: list[object] = []
    with watched(lambda *told: seen.append(told)):
        action()
    return len(seen)


def killed_at(number: int, action: Callable[[], object]) -> None:
    """Do an action in a process that dies, as of kill -9, before its operation of a number (from 1)."""
    child = os.fork()
    if child:
        os.waitpid(child, 0)
        return
    try:
        seen = 0

        def hook(*_: str) -> None:
            nonlocal seen
            seen += 1
            if seen == number:
                os._exit(9)

        with watched(hook):
            action()
    finally:
        os._exit(1)


def names(folder: Path) -> list[str]:
    """Return the names in a folder."""
    return sorted(entry.name for entry in folder.iterdir())


def drafts(folder: Path) -> list[str]:
    """Return the drafts that were left anywhere in a folder."""
    return [str(path.relative_to(folder)) for path in folder.rglob("*") if files.is_draft(path.name)]
