"""Files of records: where they come from, reading and packing them."""

from __future__ import annotations

import hashlib
import json
import lzma
import platform
import subprocess
from collections.abc import Iterable
from datetime import date
from importlib import metadata
from pathlib import Path

from benchmarks.campaign.outcome import Record
from benchmarks.pages import processor

ROOT = Path(__file__).parents[2]
LIBRARIES = ("numpy", "scipy", "numba", "mkl", "shapely")
Key = tuple[str, int]


def head_of(limit: float) -> Record:
    """Return the first line of a file: the program that ran, and the limit of processor seconds."""
    return {
        "commit": _git("rev-parse", "--short=12", "HEAD"),
        "engine": engine(),
        "date": date.today().isoformat(),
        "processor": processor(),
        "limit": limit,
        "python": platform.python_version(),
        "libraries": {name: _version(name) for name in LIBRARIES},
    }


def engine() -> str:
    """Return what names the state of `bsm_mesh`: git's name of its tree, and of what was changed since."""
    tree = _git("rev-parse", "--short=12", "HEAD:bsm_mesh")
    changes = _git("diff", "HEAD", "--", "bsm_mesh")
    return tree if not changes else f"{tree}+{hashlib.sha256(changes.encode()).hexdigest()[:8]}"


def _git(*arguments: str) -> str:
    try:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:
        return "unknown"
    return done.stdout.strip() if done.returncode == 0 else "unknown"


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "none"


def read(paths: Iterable[Path]) -> tuple[Record, dict[Key, Record]]:
    """Return the head of the first file and all records by family and seed; files may be packed (``.xz``)."""
    heads: list[Record] = []
    records: dict[Key, Record] = {}
    for path in paths:
        data = path.read_bytes()
        text = (lzma.decompress(data) if path.suffix == ".xz" else data).decode()
        head, *lines = (json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines())
        heads.append(head)
        records |= {(line["family"], line["seed"]): line for line in lines}
    return heads[0], records


def limits_of(paths: Iterable[Path]) -> dict[Key, float]:
    """Return the limit of processor seconds of every model in some files."""
    found: dict[Key, float] = {}
    for path in paths:
        head, records = read([path])
        found |= dict.fromkeys(records, float(head["limit"]))
    return found


def pack(head: Record, records: dict[Key, Record], path: Path) -> None:
    """Write records in the order of their names, packed: what is the same again makes the same file."""
    lines = [head, *(records[key] for key in sorted(records))]
    text = "".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines)
    path.write_bytes(lzma.compress(text.encode(), preset=9))
