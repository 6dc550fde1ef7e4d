"""Kernels of a mutant: one is compiled anew where it, or a kernel that is compiled into it, has changed.

Numba takes a kernel from its cache while the kernel's own file is as it was, though a kernel that it calls from another
file has changed; and compiles all kernels of a changed file, though only one has. Here the stamp of a kernel is its
source, that of all kernels that it calls, one through the other, and the constants that they see. So kernels of many
mutants, and of many versions, may begin from one cache.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Iterator
from functools import cache
from types import CodeType, ModuleType
from typing import Any

from numba.core.caching import UserProvidedCacheLocator
from numba.core.dispatcher import Dispatcher

LOCATOR = f"{__name__}.ByContent"  # of NUMBA_CACHE_LOCATOR_CLASSES


class ByContent(UserProvidedCacheLocator):  # type: ignore[misc]
    """Where Numba keeps a kernel: in ``NUMBA_CACHE_DIR``, with a stamp of what is compiled into it."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        super().__init__(py_func, py_file)
        self._function = py_func

    def get_source_stamp(self) -> Stamp:
        """Return the stamp."""
        return Stamp(self._function)


class Stamp:
    """A digest of a kernel, taken when it is asked for: by then the module is read to its end."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function

    def __eq__(self, other: object) -> bool:
        return other == digest(self._function)

    def __hash__(self) -> int:
        return hash(digest(self._function))

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        return str, (digest(self._function),)


@cache
def digest(function: Callable[..., Any]) -> str:
    """Return a digest of all that is compiled into a kernel."""
    found = hashlib.sha256()
    for part in compiled_into(function):
        constants = [(n, v) for n, v in _seen(part) if not isinstance(v, Dispatcher | ModuleType)]
        found.update(inspect.getsource(part).encode())
        found.update("".join(f"{n}={_text(v)};" for n, v in constants).encode())
    return found.hexdigest()


def compiled_into(function: Callable[..., Any]) -> list[Callable[..., Any]]:
    """Return a function, and the kernels that it calls, one through the other."""
    found = [function]
    for part in found:
        found += [new for _, v in _seen(part) if isinstance(v, Dispatcher) and (new := v.py_func) not in found]
    return found


def _seen(function: Callable[..., Any]) -> Iterator[tuple[str, Any]]:
    """Yield what the names in a function stand for outside it, and those of modules of the package."""
    names, scope = sorted(_names(function.__code__)), function.__globals__
    modules = [v for n in names if isinstance(v := scope.get(n), ModuleType) and v.__name__.startswith("bsm_mesh")]
    for space in (scope, *map(vars, modules)):
        yield from ((name, space[name]) for name in names if name in space)


def _names(code: CodeType) -> set[str]:
    inner = (_names(part) for part in code.co_consts if isinstance(part, CodeType))
    return set(code.co_names).union(*inner)


def _text(value: Any) -> str:
    return value.__qualname__ if callable(value) else repr(value)
