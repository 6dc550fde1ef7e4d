"""The runs of a study that are finished, on the disk itself as each comes to its end: a line of JSON a run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.files import append_line


@dataclass(frozen=True, slots=True)
class Journal:
    """A file to which only lines are added; a line that a killed process left torn does not count.

    Attributes
    ----------
    path : Path
        The file.
    """

    path: Path

    def add(self, run: int, answers: Mapping[str, Any]) -> None:
        """Add a run that is finished; when this returns it is on the disk itself."""
        append_line(self.path, json.dumps({"run": run, **answers}, allow_nan=False))

    def rows(self) -> dict[int, dict[str, Any]]:
        """Return the answers of the finished runs, by their numbers.

        Raises
        ------
        ModelError
            If the file cannot be read.
        """
        try:
            text = self.path.read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise ModelError(f"{self.path} cannot be read: {error.strerror or error}") from None
        rows: dict[int, dict[str, Any]] = {}
        for line in text.split("\n"):
            try:
                told = json.loads(line)
            except ValueError:  # blank, or torn
                continue
            if isinstance(told, dict) and isinstance(told.get("run"), int):
                rows.setdefault(told.pop("run"), told)
        return rows
