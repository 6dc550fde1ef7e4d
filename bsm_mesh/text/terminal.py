"""Where text leaves for the terminal: everything that a command says goes through here.

Control characters of names are escaped here and in the text of a `ModelError`. Files and pictures keep names as given.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import warnings
from collections.abc import Iterator
from contextvars import ContextVar
from typing import Any

from bsm_mesh.errors import one_line, printable

_QUIET: ContextVar[bool] = ContextVar("quiet", default=True)  # in Python


@contextlib.contextmanager
def quietly(quiet: bool) -> Iterator[None]:
    """Show the lines that geometry scripts print meanwhile, or drop them where a command is `quiet`."""
    before = _QUIET.set(quiet)
    try:
        yield
    finally:
        _QUIET.reset(before)


def is_quiet() -> bool:
    """Return whether a quiet command is at work, or none."""
    return _QUIET.get()


def say(text: object, *, err: bool = False) -> None:
    """Write one line on stdout, or on stderr; characters that would steer the terminal are escaped."""
    if err:
        complain(one_line(str(text)))
    else:
        print(one_line(str(text)))


def complain(text: str) -> None:
    """Write a message of one line or several on stderr; a stderr that takes nothing ends no command."""
    with contextlib.suppress(OSError):
        print(printable(text), file=sys.stderr, flush=True)


@contextlib.contextmanager
def plain_warnings() -> Iterator[None]:
    """Write what libraries and we warn of as one line each, instead of with its place in the code."""
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: complain(f"note: {one_line(str(message))}")
        yield


def say_json(content: Any) -> None:
    """Write JSON on stdout, in ASCII."""
    text = json.dumps(content, indent=2)
    print(text.replace("\x7f", "\\u007f"))  # the one control character that JSON leaves as it is


def mend_streams() -> None:
    r"""Make stdin, stdout and stderr fit to be used, whatever they are.

    What their encoding does not have is written as an escape, ``Gr\xf6\xdfe``. One that was closed leads nowhere;
    otherwise the next file that is opened would have its number, and get the output of a library.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        mode = "w" if number else "r"
        if not _is_open(number):
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 - for as long as we run
        elif number and hasattr(getattr(sys, name), "reconfigure"):
            getattr(sys, name).reconfigure(errors="backslashreplace")


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True
