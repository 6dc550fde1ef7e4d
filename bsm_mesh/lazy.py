"""Public names that are imported when they are first used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from bsm_mesh.errors import nearest


def names_from(homes: Mapping[str, str], package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a module that hands names on.

    Parameters
    ----------
    homes : mapping of str to str
        The module of every name: that with its definition, or the package of which it is a module.
    package : str
        Name of the module that hands them on, for messages.
    """

    def find(name: str) -> Any:
        if name not in homes:
            hint = "" if name.startswith("_") else nearest(name, homes).partition(" (known")[0]
            raise AttributeError(f"module '{package}' has no attribute '{name}'{hint}")
        home = import_module(homes[name])
        return getattr(home, name) if hasattr(home, name) else import_module(f"{homes[name]}.{name}")

    return find
