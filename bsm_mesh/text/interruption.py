"""Ctrl-C, SIGTERM and SIGHUP end a command in one line, at whatever moment they come.

Nothing heavy is imported here: from this module on an interruption is taken.
"""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any

from bsm_mesh.signals import NAMES
from bsm_mesh.text.terminal import complain

EXIT_INTERRUPTED = 130
CLEARING_UP = 2.0  # s; within it a further signal changes nothing, later it ends the process at once
SOON = 0.05  # s


class Interrupted(KeyboardInterrupt):
    """The process received a signal to end; the text is the name of the signal."""


class _Watch:
    """The signals that reach this process."""

    def __init__(self) -> None:
        self.before: dict[int, Any] = {}
        self.first = 0.0  # when the signal came that is being heeded
        self.missed: tuple[str, threading.Timer] | None = None  # a signal that could not be raised, until it comes anew

    def take(self, number: int, frame: FrameType | None) -> None:
        """Raise `Interrupted`, once."""
        if self.first and time.monotonic() - self.first < CLEARING_UP:
            return
        if self.first:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        self.first, self.missed = time.monotonic(), None
        raise Interrupted(signal.Signals(number).name)

    def again(self, error: BaseException) -> None:
        """Take a signal anew that came where Python cannot raise: in a destructor, or in a call back from a library."""
        self.first = 0.0
        number = signal.Signals[str(error)]
        repeat = threading.Timer(SOON, _send, (number,))
        repeat.daemon = True
        self.missed = number.name, repeat
        repeat.start()

    def end_of_missed(self) -> str:
        """Return the name of the signal that was missed, which does not come anew; empty if there is none."""
        if self.missed is None:
            return ""
        name, repeat = self.missed
        repeat.cancel()
        self.first, self.missed = time.monotonic(), None
        return name


def _send(number: signal.Signals) -> None:
    """Send a signal to the main thread, which ends a system call that it waits in."""
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, number)
    else:
        _thread.interrupt_main(number)


_watch = _Watch()


def guarded(command: Callable[[], Any], *, last: bool = False, tell: bool = True) -> Any:
    """Run a command so that an interruption ends it in one line and with exit code 130.

    Parameters
    ----------
    command : callable
        What to run.
    last : bool
        Whether nothing of the process comes after it; signals then change nothing any more.
    tell : bool
        Whether the line is written.
    """
    with _handled(last=last):
        try:
            return command()
        except KeyboardInterrupt as error:
            name = str(error) if isinstance(error, Interrupted) else "SIGINT"
            notes = getattr(error, "__notes__", [])
        except Exception as error:  # of a library that misses what the call back was to do in which the signal came
            name, notes = _watch.end_of_missed(), getattr(error, "__notes__", [])
            if not name:
                raise
        if tell:
            _tell(name, notes)
        sys.exit(EXIT_INTERRUPTED)


def heed_again() -> None:
    """Put back the handlers that others took away: Gmsh does, in a script that does not end it."""
    for number in _watch.before:
        signal.signal(number, _watch.take)


def _tell(name: str, notes: list[str]) -> None:
    which = "" if name == "SIGINT" else f" ({name})"
    try:
        complain(f"interrupted{which}: {'; '.join(notes) or 'nothing is half-written'}")
    except (OSError, ValueError):  # the terminal is gone
        return


@contextmanager
def _handled(*, last: bool) -> Iterator[None]:
    """Have signals raise `Interrupted`; those that the process was started to ignore (nohup) stay ignored."""
    if _watch.before or threading.current_thread() is not threading.main_thread():
        yield
        return
    for number in (getattr(signal, name) for name in NAMES if hasattr(signal, name)):
        before = signal.getsignal(number)
        if before is not signal.SIG_IGN and before is not None:
            _watch.before[number] = before
            signal.signal(number, _watch.take)
    unraisable, uncaught = sys.unraisablehook, sys.excepthook

    def swallowed(told: sys.UnraisableHookArgs) -> None:
        if isinstance(told.exc_value, Interrupted):
            _watch.again(told.exc_value)
        else:
            unraisable(told)

    def printed(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if isinstance(error, Interrupted):
            _watch.again(error)
        else:
            uncaught(kind, error, trace)

    sys.unraisablehook, sys.excepthook = swallowed, printed
    try:
        yield
    finally:
        for number, before in _watch.before.items():
            signal.signal(number, signal.SIG_IGN if last else before)
        _watch.before.clear()
        _watch.first, _watch.missed = 0.0, None
        if not last:
            sys.unraisablehook, sys.excepthook = unraisable, uncaught
