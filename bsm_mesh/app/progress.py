"""What a person sees while a command works: a bar on a terminal, plain lines when piped. All on stderr."""

from __future__ import annotations

import os
import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from bsm_mesh.app.terminal import say
from bsm_mesh.errors import one_line
from bsm_mesh.results.records import StepRecord

if TYPE_CHECKING:
    from rich.progress import Progress as Bar


class Progress:
    """Tells what is being done and, after each step, how far equilibrium is.

    Parameters
    ----------
    quiet : bool
        Say nothing.
    verbose : bool
        Keep a line for every step, with the methods that were tried.
    """

    def __init__(self, *, quiet: bool = False, verbose: bool = False) -> None:
        self._quiet, self._verbose = quiet, verbose
        self._bar: Bar | None = None
        self._began = time.perf_counter()

    def __enter__(self) -> Self:
        if (
            not (self._quiet or self._verbose)
            and sys.stderr.isatty()
            and os.environ.get("TERM") not in ("dumb", "unknown")
        ):
            from rich.console import Console
            from rich.progress import Progress as Bar
            from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn

            console = Console(stderr=True)
            spinner = SpinnerColumn("dots" if console.encoding.startswith("utf") else "line")
            columns = (spinner, TextColumn("{task.description}", markup=False), TimeElapsedColumn())
            self._bar = Bar(*columns, console=console, transient=True)
            self._bar.start()
            self._bar.add_task("")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def report(self, text: str) -> None:
        """Say what is being done, in a few words."""
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], description=one_line(text))
        elif not self._quiet:
            say(f"[{time.perf_counter() - self._began:7.2f} s] {text}", err=True)

    def step(self, record: StepRecord) -> None:
        """Say how far an accepted step has come."""
        text = (
            f"stage {record.stage}, step {record.step}: residual {record.residual:.1e}, "
            f"displacement {record.max_displacement:.3g} m"
        )
        if self._verbose:
            vain = f" ({', '.join(record.tried)} in vain)" if record.tried else ""
            text = f"{text}, by {record.method}{vain}"
        self.report(text)
