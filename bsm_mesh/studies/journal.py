"""The runs of a study that are finished, on the disk itself as each reaches its end: a line of JSON a run.

Each line has a checksum over the run, its answers and the study's inputs. A changed number, or a line of another
study, is an error.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.files import append_line

SUM = "sha256"  # the last entry of a line
MOST_TOLD = 10  # lines


@dataclass(frozen=True, slots=True)
class Journal:
    """A file to which only lines are added; a line that a killed process left torn does not count.

    Attributes
    ----------
    path : Path
        The file.
    key : str
        Source of the runs: study, model, program.
    """

    path: Path
    key: str = ""

    def add(self, run: int, answers: Mapping[str, Any]) -> None:
        """Add a run that is finished; when this returns it is on the disk itself."""
        row = {"run": run, **answers}
        append_line(self.path, json.dumps({**row, SUM: self._checksum(row)}, allow_nan=False))

    def rows(self) -> dict[int, dict[str, Any]]:
        """Return the answers of the finished runs, by their numbers.

        Raises
        ------
        ModelError
            If the file cannot be read, or a line is not as it was written for this study.
        """
        try:
            text = self.path.read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise ModelError(f"{self.path} cannot be read: {error.strerror or error}") from None
        rows: dict[int, dict[str, Any]] = {}
        changed = []
        for number, line in enumerate(text.split("\n"), start=1):
            try:
                told = json.loads(line)
            except (RecursionError, ValueError):  # blank, or torn
                continue
            if not isinstance(told, dict) or told.pop(SUM, None) != self._checksum(told):
                changed.append(str(number))
            else:
                rows.setdefault(told.pop("run"), told)
        if changed:
            raise ModelError(
                f"{self.path}: line {', '.join(changed[:MOST_TOLD])} is not as this study wrote it; remove the "
                "changed lines, and these runs are done again"
            )
        return rows

    def _checksum(self, row: Mapping[str, Any]) -> str:
        return hashlib.sha256(f"{self.key}\n{json.dumps(row, sort_keys=True)}".encode()).hexdigest()
