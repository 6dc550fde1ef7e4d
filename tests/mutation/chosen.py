"""Which tests a mutant is tried with: those of its files that call the changed function, the fastest first."""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .mutants import ROOT, Mutant, read
from .place import SURVIVED, Place

SHARING = ('scope="', "@cache")  # in a test file: what one test calls, others of the file may stand on
BEYOND = "import subprocess"  # in a test file: what its tests call in other processes is not seen
CACHED = {"cache", "lru_cache"}  # decorators of a function that is called once for all
WATCHING = 3600.0  # processor seconds at most for tests of the program as it is
COMPILING = 90.0  # processor seconds that a limit gives for kernels
SLOWER = 10.0  # times its measured time, and
BESIDE = 10.0  # processor seconds more that a test may take of a mutant

Tests = dict[str, tuple[float, list[str]]]  # name: processor seconds, functions called


@dataclass(frozen=True)
class Function:
    """The function around a line: where it begins, and whether it is a kernel, or called once for all."""

    begin: int
    is_kernel: bool = False
    is_cached: bool = False


def function_at(source: str, line: int) -> Function | None:
    """Return the innermost function around a line."""
    found = None
    for node in ast.walk(ast.parse(source)):  # from the outermost inwards
        if isinstance(node, ast.FunctionDef):
            begin = min(node.lineno, *(part.lineno for part in node.decorator_list), node.lineno)
            if begin <= line <= (node.end_lineno or begin):
                names = {n.id for part in node.decorator_list for n in ast.walk(part) if isinstance(n, ast.Name)}
                found = Function(begin, "njit" in names, bool(names & CACHED))
    return found


class Watched:
    """What tests take and call, kept in a file while the package, scenes and the test's file are as they were."""

    def __init__(self, folder: Path, place: Place) -> None:
        self._place, self._path = place, folder / f"tests-{_digest()}.json"
        kept = json.loads(self._path.read_text(encoding="utf-8")) if self._path.exists() else {}
        self._files: dict[str, tuple[str, Tests]] = {name: (digest, tests) for name, (digest, tests) in kept.items()}

    def _watch(self, files: Iterable[str]) -> None:
        """Run the test files that are not known, on the program as it is."""
        new = [name for name in sorted(set(files)) if self._files.get(name, ("",))[0] != _sha(self._text(name))]
        if not new:
            return
        ran, seen = self._place.watch(new, WATCHING)
        if ran.outcome != SURVIVED:
            raise SystemExit(f"tests fail on the program as it is: {ran.failed or ran.outcome}")
        print(f"{len(new)} test files in {ran.seconds:.0f} s, kernels compiled on the way")
        for name in new:
            own = {test: row for test, row in seen.items() if test.partition("::")[0] == name}
            self._files[name] = (
                _sha(self._text(name)),
                _shared(own) if any(s in self._text(name) for s in SHARING) else own,
            )
        self._path.write_text(json.dumps(self._files), encoding="utf-8")

    def limits(self, mutant: Mutant, files: Iterable[str]) -> dict[str, float]:
        """Return the tests of files that concern a mutant, the fastest first, and the processor seconds they may take.

        None where no test calls the function. What is done while a module is imported all tests concern.
        """
        self._watch(files)
        tests = {name: row for file in files for name, row in self._files[file][1].items()}
        function = function_at(read(mutant.file), mutant.line)
        if function is not None and not function.is_cached:
            called, beyond = f"{mutant.file}:{function.begin}", {file for file in files if BEYOND in self._text(file)}
            tests = {n: row for n, row in tests.items() if called in row[1] or n.partition("::")[0] in beyond}
        compiling = COMPILING if function is None or function.is_kernel else 0.0
        order = sorted(tests, key=lambda name: tests[name][0])
        return {name: SLOWER * tests[name][0] + BESIDE + compiling for name in order}

    def _text(self, name: str) -> str:
        """Return a test file as the place has it, which was copied when it was made."""
        return (self._place.root / name).read_text(encoding="utf-8")


def _shared(tests: Tests) -> Tests:
    calls = sorted({name for _, called in tests.values() for name in called})
    return {name: (seconds, calls) for name, (seconds, _) in tests.items()}


def _digest() -> str:
    """Return a digest of what tests run."""
    paths = [path for folder in ("bsm_mesh", "tests/scenes") for path in (ROOT / folder).rglob("*.py")]
    return _sha("".join(path.read_text(encoding="utf-8") for path in sorted(paths)))


def _sha(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]
