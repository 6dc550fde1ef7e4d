"""What a campaign has done and found, on disk: a campaign that is stopped continues where it was."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .inputs import ROOT

KEPT = 3  # inputs of each finding


def sources() -> str:
    """Return a digest of the program and of the campaigns: counts are of one state of both."""
    told = hashlib.sha256()
    for folder in ("bsm_mesh", "converters", "geometries", "tools/campaigns"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            told.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return told.hexdigest()[:12]


class State:
    """A campaign's state in a folder: ``state.json``, and a folder for every finding.

    Parameters
    ----------
    folder : Path
        Of all campaigns.
    campaign : str
        Name of this one.
    seed : int
        Of its random numbers.
    """

    def __init__(self, folder: Path, campaign: str, seed: int) -> None:
        self.folder = folder / f"{campaign}-{seed}-{sources()}"
        self.folder.mkdir(parents=True, exist_ok=True)
        self._file = self.folder / "state.json"
        self.told: dict[str, Any] = {
            "campaign": campaign,
            "seed": seed,
            "sources": sources(),
            "parts": {},
            "findings": {},
        }
        if self._file.exists():
            self.told = json.loads(self._file.read_text())

    def part(self, name: str) -> dict[str, Any]:
        """Return what is known of a part (a target, a model): its chunks that are done, counts, seconds."""
        found: dict[str, Any] = self.told["parts"].setdefault(name, {"done": [], "counts": {}, "seconds": 0.0})
        return found

    def add(self, name: str, chunk: Any, counts: Mapping[str, int], seconds: float) -> None:
        """Add the outcome of a chunk, and save."""
        part = self.part(name)
        part["done"].append(chunk)
        part["seconds"] += seconds
        for kind, count in counts.items():
            part["counts"][kind] = part["counts"].get(kind, 0) + count
        self.save()

    def find(self, part: str, index: Any, kind: str, signature: str, detail: str) -> Path | None:
        """Add a finding; return the folder for its input, if another example of it is wanted."""
        key = f"{part}: {kind}: {signature}"
        finding = self.told["findings"].setdefault(
            key, {"part": part, "kind": kind, "signature": signature, "count": 0, "examples": []}
        )
        finding["count"] += 1
        if len(finding["examples"]) >= KEPT:
            return None
        finding["examples"].append(index)
        folder = self.folder / "findings" / f"{hashlib.sha256(key.encode()).hexdigest()[:10]}-{index}"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "finding.txt").write_text(
            f"{key}\ninput {index} of seed {self.told['seed']}\n\n{detail}\n", errors="replace"
        )
        return folder

    def save(self) -> None:
        """Write the state, whole."""
        draft = self._file.with_suffix(".tmp")
        draft.write_text(json.dumps(self.told, indent=1))
        os.replace(draft, self._file)

    def lines(self) -> list[str]:
        """Return what is known, a line each."""
        lines = []
        for name, part in self.told["parts"].items():
            counts = part["counts"]
            rest = ", ".join(f"{kind} {count}" for kind, count in sorted(counts.items()))
            pace = sum(counts.values()) / part["seconds"] if part["seconds"] else 0.0
            lines.append(f"{name}: {sum(counts.values())} inputs ({pace:.0f} a second of work): {rest}")
        for key, finding in sorted(self.told["findings"].items(), key=lambda item: -item[1]["count"]):
            lines.append(f"  {finding['count']:6d}  {key[:300]}  (input {finding['examples'][0]})")
        return lines
