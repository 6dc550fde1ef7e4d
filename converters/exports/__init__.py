"""Models written for other programs, with a list of the features that these do not support."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from bsm_mesh.errors import ModelError
from bsm_mesh.model.model import Model

PROGRAMS = ("3dgrid", "abaqus", "compas_dem", "lmgc90", "udec")


def export(model: Model, program: str, path: Path) -> tuple[str, ...]:
    """Write a model as input of another program; return what that cannot say, a sentence each.

    Parameters
    ----------
    model : Model
        The model.
    program : str
        One of `PROGRAMS`.
    path : Path
        The file to write.

    Raises
    ------
    ModelError
        If there is no such program, or the file cannot be written.
    """
    if program not in PROGRAMS:
        raise ModelError(f"there is no export to '{program}'; known: {', '.join(PROGRAMS)}")
    writer = import_module(f"bsm_mesh.converters.exports.to_{program}")
    try:
        left_out: tuple[str, ...] = writer.write(model, path)
    except OSError as error:
        raise ModelError(f"cannot write {path}: {error.strerror or error}; choose another folder") from error
    return left_out
