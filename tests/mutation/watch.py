"""A plugin of pytest (``-p tests.mutation.watch --watched FILE``): what each test takes and which functions it calls.

Written are, of every test, its processor seconds without those of the compiler, and the functions of the package that
Python calls while it runs, with the kernels that are compiled into those called; a function is a file and the line
where it begins, decorators included. What is called while modules are imported counts for all tests.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import CodeType
from typing import Any

import pytest
from numba.core import event
from numba.core.dispatcher import Dispatcher

from bsm_mesh.compiled import compiled_into

from .mutants import FOLDERS, ROOT


class Calls:
    """Functions that were called since the last look."""

    def __init__(self) -> None:
        self.codes: dict[int, CodeType] = {}  # by their identity: a hash reads all of a code

    def begin(self) -> None:
        """See what is called from here on, in threads that begin later too."""
        sys.setprofile(self._see)
        threading.setprofile(self._see)

    def _see(self, frame: Any, happening: str, _: Any) -> None:
        if happening == "call":
            self.codes[id(frame.f_code)] = frame.f_code

    def take(self) -> dict[int, CodeType]:
        """Return them, and forget them."""
        taken, self.codes = self.codes, {}
        sys.setprofile(self._see)  # whoever measured in between may have taken it away
        return taken


class Compiling(event.Listener):  # type: ignore[misc]
    """Processor seconds of the compiler."""

    def __init__(self) -> None:
        self.seconds, self._depth, self._begin = 0.0, 0, 0.0
        event.register("numba:compile", self)

    def on_start(self, event: Any) -> None:
        """Begin, at the outermost kernel."""
        if self._depth == 0:
            self._begin = time.process_time()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """End, at the outermost kernel."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.process_time() - self._begin


class Watch:
    """The plugin."""

    def __init__(self, path: Path) -> None:
        self._path, self._calls, self._compiling = path, CALLS, Compiling()
        self._tests: dict[str, tuple[float, dict[int, CodeType]]] = {}
        self._at_import: dict[int, CodeType] = {}

    def pytest_collection_finish(self) -> None:
        """Modules are imported."""
        self._at_import = self._calls.take()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Watch a test, its fixtures included."""
        begin = time.process_time() - self._compiling.seconds
        result = yield
        seconds = time.process_time() - self._compiling.seconds - begin
        self._tests[item.nodeid] = round(seconds, 2), self._calls.take()
        return result

    def pytest_sessionfinish(self) -> None:
        """Write what was seen."""
        sys.setprofile(None)
        kernels = {id(v.py_func.__code__): v for v in _package() if isinstance(v, Dispatcher)}
        rows = {
            test: [seconds, sorted(_functions(self._at_import | called, kernels))]
            for test, (seconds, called) in self._tests.items()
        }
        self._path.write_text(json.dumps(rows), encoding="utf-8")


def _package() -> Iterator[Any]:
    for name, module in list(sys.modules.items()):
        if name.startswith("bsm_mesh"):
            yield from list(vars(module).values())


def _functions(called: dict[int, CodeType], kernels: dict[int, Any]) -> set[str]:
    codes = list(called.values())
    for number in called.keys() & kernels.keys():
        codes += [part.py_func.__code__ for part in compiled_into(kernels[number])]
    places = ((Path(code.co_filename), code.co_firstlineno) for code in codes)
    named = (f"{file.relative_to(ROOT)}:{line}" for file, line in places if file.is_relative_to(ROOT))
    return {name for name in named if name.startswith(FOLDERS)}


CALLS = Calls()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option, and begin to look: the package is not imported yet."""
    CALLS.begin()
    parser.addoption("--watched", type=Path, required=True)


def pytest_configure(config: pytest.Config) -> None:
    """Begin."""
    config.pluginmanager.register(Watch(config.getoption("--watched")))
