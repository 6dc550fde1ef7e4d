"""Starters: folders with a geometry script and a model file that a user copies and changes."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.files import make_folder, whole_file


def starter_names() -> list[str]:
    """Return the names of the starters."""
    return sorted(entry.name for entry in resources.files(__name__).iterdir() if (entry / "model.toml").is_file())


def next_command(case: str) -> str:
    """Return the command that reads a starter's model file."""
    return "key-blocks" if case == "key_blocks" else "run"


def write_starter(case: str, folder: Path) -> list[Path]:
    """Copy a starter into a new or empty folder and return the files.

    Raises
    ------
    ModelError
        For an unknown case, or a folder that holds something already.
    """
    if case not in starter_names():
        raise ModelError(f"there is no starter '{case}'{nearest(case, starter_names())}")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ModelError(f"{folder} exists and is not empty; name a new folder")
    make_folder(folder)
    written = []
    for source in starter_files(case):
        target = folder / source.name
        with whole_file(target) as draft:
            draft.write_bytes(source.read_bytes())
        written.append(target)
    return written


def starter_files(case: str) -> list[Traversable]:
    """Return the files of a starter."""
    files = [entry for entry in (resources.files(__name__) / case).iterdir() if entry.is_file()]
    return sorted(files, key=lambda entry: entry.name)
