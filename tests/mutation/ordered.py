"""A plugin of pytest (``-p tests.mutation.ordered --ordered FILE``): some tests, in an order, each within a limit.

The file gives processor seconds by the name of a test. A test that takes longer ends the process.
"""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Iterator
from pathlib import Path

import pytest


class Ordered:
    """The plugin."""

    def __init__(self, path: Path) -> None:
        self._limits: dict[str, float] = json.loads(path.read_text(encoding="utf-8"))

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Leave out what is not in the file."""
        by_name = {item.nodeid: item for item in items}
        chosen = [by_name[name] for name in self._limits if name in by_name]
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in self._limits])
        items[:] = chosen

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Set the limit of a test, and lift it again."""
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + self._limits[item.nodeid]) + 1, hard))
        result = yield
        resource.setrlimit(resource.RLIMIT_CPU, (hard, hard))
        return result


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option."""
    parser.addoption("--ordered", type=Path, required=True)


def pytest_configure(config: pytest.Config) -> None:
    """Begin."""
    config.pluginmanager.register(Ordered(config.getoption("--ordered")))
