"""Files that are read are regular ones: a pipe or a device may never end, or never begin."""

from __future__ import annotations

import os
import stat

from bsm_mesh.errors import ModelError

SPECIAL = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def refuse_special(path: str | os.PathLike[str]) -> None:
    """Raise `ModelError` for what is there but no regular file; what is not there is told when it is opened."""
    if fault := special_fault(path):
        raise ModelError(fault)


def special_fault(path: str | os.PathLike[str]) -> str | None:
    """Return why a path is not to be read, or None.

    A folder is no special file: opening it says so at once.
    """
    try:
        kind = SPECIAL.get(stat.S_IFMT(os.stat(path).st_mode))
    except (OSError, ValueError):
        return None
    if kind is None:
        return None
    return f"{os.fspath(path)}: is {kind}, which may never end; write it to a file and give that"
