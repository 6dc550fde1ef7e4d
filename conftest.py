"""Which cases of a test belong to which tier."""

from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent / "tests" / "examples"  # every page and every example, one by one


@pytest.hookimpl(tryfirst=True)  # before cases are selected by their marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the heavy cases of a test as slow, but for the first one: every change runs one, a release all."""
    seen = set()
    for item in items:
        if hasattr(item, "callspec") and item.get_closest_marker("heavy") and not is_marked_alone(item):
            test = item.nodeid.split("[")[0]
            if test in seen:
                item.add_marker(pytest.mark.slow)
            seen.add(test)


def is_marked_alone(item: pytest.Item) -> bool:
    """Return whether a case is marked, of a test of examples that is not heavy as a whole."""
    marks = [mark.name for mark in getattr(getattr(item, "function", None), "pytestmark", [])]
    return EXAMPLES in item.path.parents and "heavy" not in marks
