"""Operations on files in a folder by Python's audit events, those that the one writer does not announce included."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

OURS = "bsm_mesh.files"  # told by the project's one writer, before each operation
CHANGES = ("os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod")
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
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
