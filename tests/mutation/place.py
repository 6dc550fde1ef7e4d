"""A copy of the checkout in which files are mutated, with compiled kernels of its own, and tests run there."""

from __future__ import annotations

import ast
import hashlib
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from .mutants import ROOT

COPIED = ("bsm_mesh", "geometries", "converters", "tests", "docs", "examples", "pyproject.toml", "README.md")
WAITING = 20  # times its processor time that a process may take, of a machine that others share
KILLED, SURVIVED, TIMEOUT = "killed", "survived", "timeout"


@dataclass(frozen=True)
class Ran:
    """How tests went: killed, survived or timeout; processor seconds; the test that failed."""

    outcome: str
    seconds: float
    failed: str = ""


class Place:
    """The copy."""

    def __init__(self, folder: Path) -> None:
        self.root, self._cache = folder / "checkout", folder / "kernels-of-mutant"
        self.warm_folder = folder / f"kernels-{_digest()}"  # compiled from these sources
        for old in (self.root, self._cache):
            shutil.rmtree(old, ignore_errors=True)
        self.root.mkdir(parents=True)
        self.warm_folder.mkdir(exist_ok=True)
        for name in COPIED:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, self.root / name, symlinks=True)
            else:
                shutil.copy2(ROOT / name, self.root / name)

    def warm(self, tests: Iterable[str], limit: float) -> Ran:
        """Run tests of the program as it is: its kernels are compiled, and kept."""
        return self._run(tests, self.warm_folder, limit)

    def run(self, tests: Iterable[str], limit: float) -> Ran:
        """Run tests, to the first that fails."""
        return self._run(tests, self._cache, limit)

    @contextmanager
    def mutant(self, file: str, changed: str) -> Iterator[None]:
        """Put a mutant in the place of a file.

        Numba takes a kernel from its cache while the kernel's own file is as it was, and compiled into it are those
        that it calls from others. So all that import the file, one through the other, are compiled anew.
        """
        path = self.root / file
        original = path.with_name(f"{path.name}.original")
        path.rename(original)
        path.write_text(changed, encoding="utf-8")
        _forget(path)
        stale = {(Path(name).parent.name, Path(name).stem) for name in importers(file)}

        def is_stale(folder: str, names: list[str]) -> list[str]:
            room = Path(folder).name.rpartition("_")[0]
            return [name for name in names if (room, name.partition(".")[0]) in stale]

        shutil.copytree(self.warm_folder, self._cache, ignore=is_stale, copy_function=os.link)
        try:
            yield
        finally:
            original.rename(path)
            _forget(path)
            shutil.rmtree(self._cache)
            shutil.rmtree(self.root / ".hypothesis", ignore_errors=True)

    def _run(self, tests: Iterable[str], kernels: Path, limit: float) -> Ran:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(self.root), *_elsewhere()]),
            "NUMBA_CACHE_DIR": str(kernels),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", *tests]
        process = subprocess.Popen(
            command,
            cwd=self.root,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # of a mutant that writes beyond an array
            text=True,
            start_new_session=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5)),
        )
        try:
            said, _ = process.communicate(timeout=WAITING * limit)
            ended_by_limit = process.returncode in (-signal.SIGXCPU, -signal.SIGKILL)
            outcome = SURVIVED if process.returncode == 0 else TIMEOUT if ended_by_limit else KILLED
        except subprocess.TimeoutExpired:
            said, outcome = "", TIMEOUT
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        failed = [line.split()[1] for line in said.splitlines() if line.startswith(("FAILED", "ERROR "))]
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return Ran(outcome, seconds, failed[0] if failed else "")


def _digest() -> str:
    """Return a digest of the package: a cached kernel holds those of other files that it calls."""
    found = hashlib.sha256()
    for path in sorted((ROOT / "bsm_mesh").rglob("*.py")):
        found.update(path.read_bytes())
    return found.hexdigest()[:12]


def _forget(path: Path) -> None:
    for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
        compiled.unlink()


def _elsewhere() -> list[str]:
    given = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    return [part for part in given if part and Path(part).resolve() != ROOT]


@cache
def _importers() -> dict[str, set[str]]:
    """Return the files of the package that import each file of it."""
    found: dict[str, set[str]] = {}
    for path in sorted((ROOT / "bsm_mesh").rglob("*.py")):
        name = str(path.relative_to(ROOT))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("bsm_mesh"):
                module = str(node.module).replace(".", "/")
                for file in (f"{module}.py", *(f"{module}/{alias.name}.py" for alias in node.names)):
                    found.setdefault(file, set()).add(name)
    return found


def importers(file: str) -> set[str]:
    """Return a file and all that import it, one through the other."""
    found, ahead = {file}, [file]
    while ahead:
        new = _importers().get(ahead.pop(), set()) - found
        found |= new
        ahead += new
    return found
