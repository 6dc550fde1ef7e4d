"""Paths as they are given. Files that are read are regular ones, and text in UTF-8."""

from __future__ import annotations

import os
from pathlib import Path

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.reading import path_fault, special_fault


def as_path(name: str, value: object) -> Path:
    """Return what is given as a path; raise `GeometryError` for what is none, by its name."""
    if fault := path_fault(name, value):
        raise GeometryError(fault)
    assert isinstance(value, str | os.PathLike)
    return Path(value)


def refuse_special(path: str | os.PathLike[str]) -> None:
    """Raise `GeometryError` for what is there but no regular file: a pipe or a device may never end."""
    if fault := special_fault(path):
        raise GeometryError(fault)


def read_text(path: Path) -> str:
    """Return the text of a file in UTF-8, with or without a byte order mark.

    Raises
    ------
    GeometryError
        If it cannot be read, or is in another encoding.
    """
    refuse_special(path)
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as fault:
        raise GeometryError(f"{path}: cannot be read: {fault.strerror or fault}") from fault
    except UnicodeDecodeError as fault:
        line = fault.object[: fault.start].count(b"\n") + 1
        raise GeometryError(
            f"{path}, line {line}: is no text in UTF-8 (Latin-1, perhaps?); save the file as UTF-8"
        ) from fault
    except ValueError as fault:  # a NUL in the path
        raise GeometryError(f"{path}: is no path; correct it") from fault
