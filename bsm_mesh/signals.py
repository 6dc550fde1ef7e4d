"""Signals kept back while Python must not raise. Nothing of the project is imported here."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")  # those that end a process, as far as the system knows them


@contextmanager
def signals_held() -> Iterator[None]:
    """Keep signals that Python handles back within, and take the first of them at the end.

    Some C code dies where an exception is raised amid it, as VTK's does while it is imported. Python handles signals
    in its main thread alone; in another one there is nothing to keep back.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    known = [getattr(signal, name) for name in NAMES if hasattr(signal, name)]
    handled = {number: handler for number in known if callable(handler := signal.getsignal(number))}
    try:
        for number in handled:
            signal.signal(number, lambda number, _: came.append(number))
        yield
    finally:
        for number, handler in handled.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])
