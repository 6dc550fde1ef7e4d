"""Whether a compiled kernel is cached: the first run on a machine waits for the compiler, and says so."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any


def is_compiled(kernel: Any) -> bool:
    """Return whether a kernel compiled with ``cache=True`` is in memory, or was left on disk by an earlier run."""
    if kernel.signatures:
        return True
    function, folder = kernel.py_func, kernel.stats.cache_path
    if folder is None:  # nowhere to keep it
        return False
    stem = f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}-{function.__code__.co_firstlineno}"
    return any(Path(folder).glob(f"{stem}.py{sys.version_info.major}{sys.version_info.minor}*.nbi"))
