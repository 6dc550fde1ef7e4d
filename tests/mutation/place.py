"""A copy of the checkout in which files are mutated, with compiled kernels of its own, and tests run there."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from .mutants import ROOT

COPIED = ("bsm_mesh", "geometries", "converters", "tests", "docs", "examples", "pyproject.toml", "README.md")
STARTING = 60.0  # processor seconds for imports and collection
WAITING = 40  # times its processor time that a process may take, of a machine that others share
KILLED, SURVIVED, TIMEOUT = "killed", "survived", "timeout"
PASSED = (0, 5)  # what pytest returns: all passed; no test left, of a mutant that changes their names


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
        self._kernels, self._order, self._watched = folder / "kernels", folder / "order.json", folder / "watched.json"
        for old in (self.root, self._cache):
            shutil.rmtree(old, ignore_errors=True)
        self.root.mkdir(parents=True)
        self._kernels.mkdir(exist_ok=True)
        for name in COPIED:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, self.root / name, symlinks=True)
            else:
                shutil.copy2(ROOT / name, self.root / name)

    def watch(self, tests: Iterable[str], limit: float) -> tuple[Ran, dict[str, tuple[float, list[str]]]]:
        """Run test files on the program as it is; return what each test took and called too (`watch.py`).

        Its kernels are compiled, and kept.
        """
        plugin = ["-p", "tests.mutation.watch", f"--watched={self._watched}"]
        ran = self._run([*plugin, "-m", "not slow", *tests], self._kernels, limit)
        return ran, json.loads(self._watched.read_text(encoding="utf-8")) if ran.outcome == SURVIVED else {}

    def run(self, limits: dict[str, float]) -> Ran:
        """Run tests, each within its limit, to the first that fails."""
        self._order.write_text(json.dumps(limits), encoding="utf-8")
        files = dict.fromkeys(name.partition("::")[0] for name in limits)
        plugin = ["-p", "tests.mutation.ordered", f"--ordered={self._order}"]
        return self._run([*plugin, *files], self._cache, STARTING + sum(limits.values()))

    @contextmanager
    def mutant(self, file: str, changed: str) -> Iterator[None]:
        """Put a mutant in the place of a file, with kernels that begin as those of the program as it is.

        Files of kernels are replaced, and not written into, so that links do for copies.
        """
        path = self.root / file
        original = path.with_name(f"{path.name}.original")
        path.rename(original)
        path.write_text(changed, encoding="utf-8")
        _forget(path)
        shutil.copytree(self._kernels, self._cache, copy_function=os.link)
        try:
            yield
        finally:
            original.rename(path)
            _forget(path)
            shutil.rmtree(self._cache)
            shutil.rmtree(self.root / ".hypothesis", ignore_errors=True)

    def _run(self, arguments: list[str], kernels: Path, limit: float) -> Ran:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        inherited = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        environment = {
            **inherited,
            "PYTHONPATH": os.pathsep.join([str(self.root), *_elsewhere()]),
            "NUMBA_CACHE_DIR": str(kernels),
        }
        here = ["-c", "pyproject.toml", "--rootdir", "."]  # or pytest might take the checkout around the copy
        quick = ["-x", "-q", "--tb=no", "-p", "no:cacheprovider", "-p", "no:xdist"]
        process = subprocess.Popen(
            [sys.executable, "-m", "pytest", *here, *quick, *arguments],
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
            outcome = SURVIVED if process.returncode in PASSED else TIMEOUT if ended_by_limit else KILLED
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


def _forget(path: Path) -> None:
    for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
        compiled.unlink()


def _elsewhere() -> list[str]:
    given = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    return [part for part in given if part and Path(part).resolve() != ROOT]
