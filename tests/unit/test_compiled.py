"""The first run on a machine says that it compiles; later ones do not."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

from small_case import environment

from bsm_mesh.contact.compiled import is_compiled
from bsm_mesh.solve.contacts.force_kernels import fill_tangent

ASK = """
import sys
from pathlib import Path
import numpy as np
from bsm_mesh.contact.compiled import is_compiled
from bsm_mesh.solve.contacts.force_kernels import relative_positions as kernel
print(is_compiled(kernel))
if sys.argv[1] == "call":
    i = np.zeros(1, np.int32)
    kernel(np.zeros((1, 3)), i, i, np.zeros((1, 8)))
    print(is_compiled(kernel))
"""


def ask(folder: Path, what: str) -> list[str]:
    told = {**environment(), "NUMBA_CACHE_DIR": os.fspath(folder)}
    done = subprocess.run([sys.executable, "-c", ASK, what], env=told, capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_compiled_code_is_found_on_disk(tmp_path: Path) -> None:
    assert ask(tmp_path, "call") == ["False", "True"]
    assert ask(tmp_path, "look") == ["True"]


def test_a_cache_that_cannot_be_looked_at() -> None:
    kernel = SimpleNamespace(signatures=(), py_func=fill_tangent.py_func, stats=SimpleNamespace(cache_path=None))
    assert not is_compiled(kernel)
