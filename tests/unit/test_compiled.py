"""The first run on a machine says that it compiles; later ones do not."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from bsm_mesh.compiled import is_compiled
from bsm_mesh.solve.contacts.force_kernels import fill_tangent
from tests.scenes.small_case import environment

pytestmark = pytest.mark.robust

ASK = """
import sys
from pathlib import Path
import numpy as np
from bsm_mesh.compiled import is_compiled
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


KERNELS = """
from bsm_mesh.compiled import njit

@njit()
def first(x):
    return x + 1

@njit(error_model="numpy")
def second(x):
    return first(x) + 1
"""
CALL = "import kernels; print(kernels.second(1), kernels.second.stats.cache_path)"


def call_kernels(folder: Path, **settings: str) -> tuple[str, str]:
    """Return what a process says that runs kernels beside which nothing can be kept, nor at home."""
    (folder / "kernels.py").write_text(KERNELS)
    (folder / "__pycache__").touch()  # no folder can be made there, not even by a superuser
    told = {key: value for key, value in environment().items() if key != "NUMBA_CACHE_DIR"}
    told |= {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null", "TMPDIR": str(folder), **settings}
    done = subprocess.run(
        [sys.executable, "-c", CALL], env=told, cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout, done.stderr


def test_where_nothing_can_be_kept_a_folder_of_ones_own_serves(tmp_path: Path) -> None:
    said, warned = call_kernels(tmp_path)
    (own,) = tmp_path.glob("bsm-mesh-*")
    assert own.stat().st_mode & 0o077 == 0
    assert said.startswith(f"3 {own}")
    assert warned.count("CacheWarning: ") == 1
    assert "NUMBA_CACHE_DIR" in warned
    assert list(own.rglob("*.nbi"))


def test_what_others_can_write_to_is_no_place_for_code(tmp_path: Path) -> None:
    own = tmp_path / f"bsm-mesh-{os.getuid()}"
    own.mkdir()
    own.chmod(0o777)
    said, warned = call_kernels(tmp_path)
    assert said == "3 None\n"
    assert warned.count("CacheWarning: there is no folder for compiled code") == 1
    assert not list(own.iterdir())


def test_damaged_compiled_code_is_made_anew(tmp_path: Path) -> None:
    call_kernels(tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "kept"))
    kept = [*(tmp_path / "kept").rglob("*.nb[ic]")]
    whole = [path.read_bytes() for path in kept]
    for path, content in zip(kept, whole, strict=True):
        path.write_bytes(content[: len(content) // 2])
    said, warned = call_kernels(tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "kept"))
    assert said.startswith("3 ")
    assert warned == ""
    assert [path.stat().st_size for path in kept] == [len(content) for content in whole]


def test_settings_in_the_current_folder_do_not_say_where_code_is_kept(tmp_path: Path) -> None:
    (tmp_path / "yaml.py").write_text("def safe_load(file):\n    return {'cache_dir': 'evil'}\n")
    (tmp_path / ".numba_config.yaml").touch()
    said, _ = call_kernels(tmp_path, PYTHONPATH=f"{tmp_path}{os.pathsep}{environment()['PYTHONPATH']}")
    assert "evil" not in said
    assert not (tmp_path / "evil").exists()


CALLER = """
from bsm_mesh.compiled import njit
from called import PART, called

@njit()
def kernel(x):
    return called(x) + PART
"""
CALLED = """
from bsm_mesh.compiled import njit

PART = {part}

@njit()
def called(x):
    return x + {more}
"""
TELL = "from caller import kernel; print(kernel(0), sum(kernel.stats.cache_hits.values()))"


def test_a_kernel_is_compiled_anew_where_another_file_changes_that_went_into_it(tmp_path: Path) -> None:
    """Seen: after a change of the file called, alone, the kernel of before was run."""
    (tmp_path / "caller.py").write_text(CALLER)
    told = {**environment(), "NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    said = []
    for part, more in [(10, 1), (10, 1), (10, 2), (20, 2), (20, 2)]:
        (tmp_path / "called.py").write_text(CALLED.format(part=part, more=more))
        command = [sys.executable, "-B", "-c", TELL]
        done = subprocess.run(command, env=told, cwd=tmp_path, capture_output=True, text=True, check=True)
        said.append(done.stdout.split())
    assert said == [["11", "0"], ["11", "1"], ["12", "0"], ["22", "0"], ["22", "1"]]
