"""Locks on files, which the system takes back when a process dies, with a record of who holds them."""

from __future__ import annotations

import errno
import json
import os
import platform
from datetime import datetime
from pathlib import Path
from typing import Any

from bsm_mesh.files import is_alive, tell

HELD = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP)
BEYOND = 1 << 30  # the byte that Windows locks: beyond the record, which others may read


def take_lock(path: Path) -> int | None:
    """Return a descriptor that holds the lock of a file, made if need be; None where another process holds it.

    Raises
    ------
    OSError
        If the file cannot be made.
    """
    while True:
        tell("lock", path)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            if not _lock(descriptor, path):
                os.close(descriptor)
                return None
            there = os.path.lexists(path) and os.path.samestat(os.fstat(descriptor), os.lstat(path))
            if there or os.name == "nt":
                _record(descriptor)
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # its former holder has removed it in between


def free_lock(path: Path, descriptor: int) -> None:
    """Give a lock back and remove its file."""
    if os.name == "nt":  # which removes no open file
        os.close(descriptor)
    try:
        tell("free", path)
        path.unlink(missing_ok=True)  # while it is held: nobody can have taken it
    except OSError:  # it stays, and hinders nobody
        return
    finally:
        if os.name != "nt":
            os.close(descriptor)


def holder(path: Path) -> str:
    """Return who holds a lock, in words."""
    told = _recorded(path)
    if not told:
        return "another process"
    return f"process {told.get('process')} on {told.get('host')} since {told.get('since')}"


def _lock(descriptor: int, path: Path) -> bool:
    try:
        if os.name == "nt":
            import msvcrt

            os.lseek(descriptor, BEYOND, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
        else:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in HELD:
            return False
        if error.errno not in NO_LOCKS:
            raise
        told = _recorded(path)  # a file system without locks: what the record says
        process = told.get("process")
        return not told or (told.get("host") == platform.node() and isinstance(process, int) and not is_alive(process))
    return True


def _record(descriptor: int) -> None:
    now = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
    text = json.dumps({"process": os.getpid(), "host": platform.node(), "since": now})
    os.lseek(descriptor, 0, os.SEEK_SET)
    os.ftruncate(descriptor, 0)
    os.write(descriptor, f"{text}\n".encode())


def _recorded(path: Path) -> dict[str, Any]:
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return told if isinstance(told, dict) else {}
