"""What a command costs from start to end: Python, imports, compiled kernels from their cache, the work itself."""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from argparse import Namespace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
WALL = ROOT / "examples/tilted_wall/model.toml"
COMMANDS = {
    "import": ("-c", "import bsm_mesh"),
    "help": ("-m", "bsm_mesh", "--help"),
    "run": ("-m", "bsm_mesh", "run", str(WALL), "--quiet", "--output"),  # geometry, mesh, solution, files
}
Row = dict[str, Any]


def run_start(kind: str, n: int, given: Namespace) -> Row:
    """Return the row of a command's second use; the first compiles, and fills the caches of the machine."""
    row: Row = {}
    for _ in range(2):
        with tempfile.TemporaryDirectory() as folder:
            words = [sys.executable, *COMMANDS[kind], *([folder] if kind == "run" else [])]
            began, before = time.perf_counter(), _children()
            subprocess.run(words, cwd=ROOT, check=True, capture_output=True)
            row = {"seconds": time.perf_counter() - began, "processor": _children() - before}
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024**2
    return row | {"blocks": n, "verdict": "done", "memory": memory, "note": " ".join(COMMANDS[kind][:3])}


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
