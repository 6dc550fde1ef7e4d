"""Kernels compiled by Numba, and kept on disk: the first run on a machine waits for the compiler, and says so.

That they cannot be kept (neither this package's folder nor the home can be written to, the disk is full, what was kept
is damaged) stops no run: they are compiled anew. So are they after a change of anything that was compiled into them,
be it in another file: a new version runs no kernel of a former one.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bsm_mesh.files import private_folder

_CONFIGURED = "numba" in sys.modules  # by whoever imported it before us

import numba  # noqa: E402
from numba.core.caching import FunctionCache, IndexDataCacheFile  # noqa: E402
from numba.core.dispatcher import Dispatcher  # noqa: E402

if not _CONFIGURED:
    # Numba takes settings from the current folder too (.numba_config.yaml, where PyYAML is installed). What is kept
    # holds code, so that a stranger must not say where.
    numba.config.CACHE_DIR = os.environ.get("NUMBA_CACHE_DIR", "")

CURE = "set the environment variable NUMBA_CACHE_DIR to a folder that can be written to"


class CacheWarning(UserWarning):
    """Compiled code is not kept where it usually is."""


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return Numba's decorator of this name, with a cache on disk that stops no run.

    Parameters
    ----------
    **options
        As for ``numba.njit``, ``cache`` aside.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        dispatcher = numba.njit(**options)(function)
        cache = _cache(function)
        if cache is not None:
            dispatcher._cache = cache  # as its enable_caching() does with a FunctionCache
        return dispatcher

    return compiled


def is_compiled(kernel: Any) -> bool:
    """Return whether a kernel is in memory, or was left on disk by an earlier run."""
    if kernel.signatures:
        return True
    function, folder = kernel.py_func, kernel.stats.cache_path
    if folder is None:  # nowhere to keep it
        return False
    stem = f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}-{function.__code__.co_firstlineno}"
    return any(Path(folder).glob(f"{stem}.py{sys.version_info.major}{sys.version_info.minor}*.nbi"))


class _KernelCache(FunctionCache):  # type: ignore[misc]
    """Numba's cache of a function; what it cannot read or write is done without.

    Numba looks at the kernel's own file alone, here it is also other files whose kernels it calls that count.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        locator = self._impl.locator
        if type(locator).__module__ == FunctionCache.__module__:  # else a stranger's, with a stamp of its own
            stamp = _stamp(function, locator.get_source_stamp())
            self._cache_file = IndexDataCacheFile(self.cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what was kept for a signature, or None."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # unpickling something damaged raises anything
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _warn(f"compiled code cannot be kept in {self.cache_path} ({error.strerror}); {CURE}")


def _cache(function: Callable[..., Any]) -> _KernelCache | None:
    """Return the cache of a function: where Numba keeps it, else in a folder of this user's among temporary files."""
    with contextlib.suppress(RuntimeError):  # no place for it
        return _KernelCache(function)
    folder = private_folder()
    if folder is None:
        _warn(f"there is no folder for compiled code, so that every run compiles for half a minute; {CURE}")
        return None
    _warn(f"compiled code is kept in {folder}: neither its package's folder nor the home can be written to; {CURE}")
    numba.config.CACHE_DIR = str(folder)
    with contextlib.suppress(RuntimeError):
        return _KernelCache(function)
    return None


_stamps: dict[str, str] = {}  # of files, by name


def _stamp(function: Callable[..., Any], own: object) -> str:
    """Return a digest of what may be compiled into a kernel: its file, numbers, and files whose kernels it may call."""
    seen, file = function.__globals__, function.__code__.co_filename
    called = {v.py_func.__code__.co_filename for v in seen.values() if isinstance(v, Dispatcher)} - {file}
    numbers = sorted(f"{name}={value!r}" for name, value in seen.items() if _is_number(value))
    told = (own, numbers, sorted(_stamps[other] for other in called if other in _stamps))
    _stamps[file] = hashlib.sha256(repr(told).encode()).hexdigest()
    return _stamps[file]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) or (isinstance(value, tuple) and all(map(_is_number, value)))


_warned: set[str] = set()


def _warn(text: str) -> None:
    """Warn once, whatever the filters: every kernel comes here."""
    if text not in _warned:
        _warned.add(text)
        warnings.warn(text, CacheWarning, stacklevel=2)
