"""Where compiled kernels are kept, and whom a compilation is reported to. Numba is not imported here.

A kernel is a file whose name says what went into it (`bsm_mesh.compiled`), so that it is valid wherever it is found.
All ways of calling use one folder, in the package itself; a wheel may carry it.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from bsm_mesh.files import make_folder, private_folder, whole_file

VARIABLE = "NUMBA_CACHE_DIR"  # names another folder
CURE = f"set the environment variable {VARIABLE} to a folder that can be written to"
PACKAGE = Path(__file__).parent / "_kernels"

Listener = Callable[[int], None]
_listeners: list[Listener] = []
_compiled = 0  # kernels, in this process


class CacheWarning(UserWarning):
    """Compiled code is not kept where it usually is."""


@dataclass(frozen=True, slots=True)
class Places:
    """Folders of compiled kernels.

    Attributes
    ----------
    read : tuple of Path
        Where a kernel is looked for, in this order.
    write : Path or None
        Where a new one is kept; None: nowhere.
    note : str
        Message when one is kept; empty: none.
    """

    read: tuple[Path, ...]
    write: Path | None
    note: str = ""


@cache
def places() -> Places:
    """Return where kernels are: in the package, else in this user's cache, else among this user's temporary files.

    `NUMBA_CACHE_DIR` replaces all three.
    """
    if chosen := os.environ.get(VARIABLE):
        return Places((Path(chosen),), Path(chosen))
    if _is_writable(PACKAGE):
        return Places((PACKAGE,), PACKAGE)
    from numba.misc.appdirs import AppDirs  # where Numba keeps what it cannot keep beside its source

    own = Path(AppDirs(appname="bsm-mesh", appauthor=False).user_cache_dir) / "kernels"
    if _is_writable(own):
        return Places((PACKAGE, own), own)
    folder = private_folder()
    if folder is None:
        note = "there is no folder for compiled code, so that every run compiles for half a minute"
        return Places((PACKAGE,), None, f"{note}; {CURE}")
    note = f"compiled code is kept in {folder}: neither its package's folder nor the home can be written to"
    return Places((PACKAGE, folder), folder, f"{note}; {CURE}")


def read(name: str) -> bytes | None:
    """Return the content of a kernel's file, or None."""
    for place in places().read:
        try:
            return (place / name).read_bytes()
        except OSError:
            continue
    return None


def write(name: str, content: bytes) -> None:
    """Keep a kernel's file; of several processes that do so at once, each leaves a whole one. It stops no run."""
    place = places().write
    _warn(places().note)
    if place is None:
        return
    try:
        make_folder((place / name).parent)
        with whole_file(place / name) as draft:
            draft.write_bytes(content)
    except OSError as error:
        _warn(f"compiled code cannot be kept in {place} ({error.strerror}); {CURE}")


def is_kept(name: str) -> bool:
    """Return whether there is a file of this name."""
    return any((place / name).is_file() for place in places().read)


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Call a function, before each kernel is compiled, the number of it in this process, as long as the block lasts."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def compiling() -> None:
    """Say that a kernel is about to be compiled."""
    global _compiled
    _compiled += 1
    for listener in _listeners:
        listener(_compiled)


def _is_writable(folder: Path) -> bool:
    """Return whether a folder, or the first one above it that is there, takes files."""
    there = next(place for place in (folder, *folder.parents) if os.path.lexists(place))
    return there.is_dir() and os.access(there, os.W_OK | os.X_OK)


_warned: set[str] = set()


def _warn(text: str) -> None:
    """Warn once, whatever the filters: every kernel comes here."""
    if text and text not in _warned:
        _warned.add(text)
        warnings.warn(text, CacheWarning, stacklevel=2)
