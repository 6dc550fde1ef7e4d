"""Memory that was freed, back to the operating system."""

from __future__ import annotations

import ctypes
import sys
from functools import cache
from typing import Any


def give_back() -> None:
    """Give back the free memory of the heap, where the C library keeps it: glibc does.

    Polygons in GEOS leave much, and arrays up to 32 MB, which it puts between others that stay. Larger ones find little
    place there: they are mapped anew, and leave nothing.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Any:
    """Return glibc's `malloc_trim`, or None."""
    return getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
