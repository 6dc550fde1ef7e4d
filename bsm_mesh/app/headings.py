"""What every picture of a results folder bears, and where it is written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.files import make_folder

PICTURES_FOLDER = "pictures"  # their folder, in that of the results


def heading(told: Mapping[str, Any], state: str = "") -> str:
    """Return the model's title with the stage, where there are several, and a state, by default the verdict."""
    stage = told["stages"][-1]
    at = f"stage {stage['name']}, " if len(told["stages"]) > 1 else ""
    return f"{told['title'] or 'bsm-mesh'}: {at}{state or stage['status'].replace('_', ' ')}"


@contextmanager
def pictures_folder(folder: Path) -> Iterator[Path]:
    """Give the folder for the pictures of a results folder; say so where it cannot be written to."""
    target = folder / PICTURES_FOLDER
    try:
        make_folder(target)
        yield target
    except OSError as error:
        raise ModelError(f"{target}: cannot be written: {error.strerror or error}") from error
