"""Signs of progress while a command works: a bar on a terminal, plain lines when piped. All on stderr."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from bsm_mesh import kernel_files
from bsm_mesh.errors import one_line
from bsm_mesh.solving import SILENCE
from bsm_mesh.text.terminal import quietly, say

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

    from bsm_mesh.results.records import StepRecord


class Progress:
    """Shows the progress and, after each step, how far equilibrium is.

    Parameters
    ----------
    quiet : bool
        Say nothing, nor let geometry scripts print.
    verbose : bool
        Keep a line for every step, with the methods that were tried.
    total : int, optional
        How much there is to do, where that is known: a bar shows how much is done.
    """

    def __init__(self, *, quiet: bool = False, verbose: bool = False, total: int | None = None) -> None:
        self._quiet, self._verbose, self._total = quiet, verbose, total
        self._bar: Bar | None = None
        self._began = time.perf_counter()
        self._told, self._text = -SILENCE, ""
        self._listening = kernel_files.listening(self._compiling)
        self._hushed = quietly(quiet)

    def __enter__(self) -> Self:
        stop_early()
        self._listening.__enter__()
        self._hushed.__enter__()
        if (
            not (self._quiet or self._verbose)
            and sys.stderr.isatty()
            and os.environ.get("TERM") not in ("dumb", "unknown")
        ):
            from rich.console import Console
            from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as Bar

            console = Console(stderr=True)
            spinner = SpinnerColumn("dots" if console.encoding.startswith("utf") else "line")
            bar = [] if self._total is None else [BarColumn()]
            columns = (spinner, *bar, TextColumn("{task.description}", markup=False), TimeElapsedColumn())
            self._bar = Bar(*columns, console=console, transient=True)
            self._bar.start()
            self._bar.add_task("", total=self._total)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._hushed.__exit__(kind, error, trace)
        self._listening.__exit__(kind, error, trace)
        if self._bar is not None:
            self._bar.stop()

    def report(self, text: str, done: int | None = None) -> None:
        """Say the progress, in a few words, and how much of the total is done."""
        self._text, self._told = text, time.perf_counter() - self._began
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], description=one_line(text), completed=done)
        elif not self._quiet:
            say(f"[{self._told:7.2f} s] {text}", err=True)

    def often(self, text: str, done: int | None = None) -> None:
        """Say the progress where that changes many times a second: piped, one line every few seconds."""
        if self._bar is not None or time.perf_counter() - self._began - self._told > SILENCE:
            self.report(text, done)

    def _compiling(self, number: int) -> None:
        """Say that kernels are compiled, from the first one on."""
        what = self._text.partition("; compiling")[0]
        say_it = self.report if number == 1 else self.often
        say_it(f"{what}; compiling, once on this machine: kernel {number}")

    def step(self, record: StepRecord) -> None:
        """Say how far an accepted step has come."""
        from bsm_mesh.results.movement import step_in_words  # not while libraries are imported

        text = step_in_words(record)
        if self._verbose:
            vain = f" ({', '.join(record.tried)} without success)" if record.tried else ""
            text = f"{text}, by {record.method}{vain}"
        (self.report if record.time is None or self._verbose else self.often)(text)


@contextmanager
def reading(path: Path, *, quiet: bool = False) -> Iterator[Progress]:
    """Show that a folder is read, and then the progress that the command reports."""
    with Progress(quiet=quiet) as progress:
        progress.report(f"reading {path}")
        yield progress


_early: list[Progress] = []


def start_early(text: str, *, quiet: bool) -> None:
    """Show a sign of life on a terminal while libraries are imported, until a `Progress` takes over."""
    if not quiet and sys.stderr.isatty():
        begun = Progress().__enter__()
        _early.append(begun)
        begun.report(text)


def stop_early() -> None:
    """Clear it away, if it is there."""
    while _early:
        _early.pop().__exit__(None, None, None)


@contextmanager
def early() -> Iterator[None]:
    """Clear it away at the end of a command that never came to a `Progress`, before its message."""
    try:
        yield
    finally:
        stop_early()
