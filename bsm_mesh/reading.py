"""Paths as they are given. Files that are read are regular ones: a pipe or a device may never end, or never begin."""

from __future__ import annotations

import os
import re
import shlex
import stat
from pathlib import Path

from bsm_mesh.errors import ModelError

FORMULA = re.compile("'*[=+@-]")  # how a text begins that a spreadsheet runs, or that was kept from it
SPECIAL = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def as_path(name: str, value: object) -> Path:
    """Return the input as a path; raise `ModelError` for a value that is no path, by its name."""
    try:
        if isinstance(value, str | os.PathLike) and isinstance(os.fspath(value), str):
            return Path(value)
    except TypeError:  # a class that only says that it is a path
        pass
    raise ModelError(f"{name} is of the kind {type(value).__name__}; it must be a path, for example a text in quotes")


def as_typed(command: str, path: str | os.PathLike[str]) -> str:
    """Return a command with a path as they are typed in a terminal: a path with spaces in quotes.

    Examples
    --------
    >>> as_typed("plot", "out/cut"), as_typed("plot", "out/upper cut")
    ('bsm-mesh plot out/cut', "bsm-mesh plot 'out/upper cut'")
    """
    return shlex.join(["bsm-mesh", command, os.fspath(path)])


def as_given_text(cell: str) -> str:
    """Return the text in a cell of a table: without the apostrophe that keeps a spreadsheet from running it.

    Examples
    --------
    >>> as_given_text("'=1+1"), as_given_text("J1"), as_given_text("'J1'")
    ('=1+1', 'J1', "'J1'")
    """
    return cell[1:] if cell.startswith("'") and FORMULA.match(cell) else cell


def refuse_special(path: str | os.PathLike[str]) -> None:
    """Raise `ModelError` for a file that is not regular; a missing file is reported when it is opened."""
    if fault := special_fault(path):
        raise ModelError(fault)


def read_text(path: Path) -> str:
    """Return the text of a regular file in UTF-8, with or without a byte order mark.

    Raises
    ------
    ModelError
        If it cannot be read, or is in another encoding.
    """
    refuse_special(path)
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as fault:
        raise ModelError(f"{path}: cannot be read: {fault.strerror or fault}") from fault
    except UnicodeDecodeError as fault:
        line = fault.object[: fault.start].count(b"\n") + 1
        raise ModelError(
            f"{path}, line {line}: is no text in UTF-8 (Latin-1, perhaps?); save the file as UTF-8"
        ) from fault
    except ValueError as fault:  # a NUL in the path
        raise ModelError(f"{path}: is no path; correct it") from fault


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
