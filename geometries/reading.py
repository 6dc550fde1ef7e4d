"""Paths as they are given. Files that are read are regular ones, and text in UTF-8."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bsm_mesh import reading
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries.errors import GeometryError


@contextmanager
def faults_of_geometry() -> Iterator[None]:
    """Raise the faults with a file as a `GeometryError`."""
    try:
        yield
    except ModelError as error:
        raise GeometryError(error.faults) from error


def as_path(name: str, value: object) -> Path:
    """Return the input as a path; raise `GeometryError` for a value that is no path, by its name."""
    with faults_of_geometry():
        return reading.as_path(name, value)


def refuse_special(path: str | os.PathLike[str]) -> None:
    """Raise `GeometryError` for a file that is not regular: a pipe or a device may never end."""
    with faults_of_geometry():
        reading.refuse_special(path)


def read_text(path: Path) -> str:
    """Return the text of a file in UTF-8, with or without a byte order mark.

    Raises
    ------
    GeometryError
        If it cannot be read, or is in another encoding.
    """
    with faults_of_geometry():
        return reading.read_text(path)
