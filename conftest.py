"""Which cases of a test belong to which tier."""

import pytest


def is_heavy(item: pytest.Item) -> bool:
    """Return whether the whole test is marked, and not this case alone."""
    marks = [mark.name for mark in getattr(getattr(item, "function", None), "pytestmark", [])]
    return "heavy" in marks


@pytest.hookimpl(tryfirst=True)  # before cases are selected by their marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the cases of a heavy test as slow, but for the first one: every change runs one, a release all."""
    seen = set()
    for item in items:
        if is_heavy(item) and hasattr(item, "callspec"):
            test = item.nodeid.split("[")[0]
            if test in seen:
                item.add_marker(pytest.mark.slow)
            seen.add(test)
