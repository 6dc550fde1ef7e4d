"""What the program starts in a process of its own, run in this one: to start one takes longer than what is done there.

That it is started, what it reads and what becomes of it where it dies is held by test_pictures, test_processes and
test_apart, which start it.
"""

from __future__ import annotations

import contextlib
import io
import os
import runpy
import sys
import warnings
from collections.abc import Callable, Sequence
from subprocess import CompletedProcess
from typing import Any
from unittest import mock

from bsm_mesh.processes import python_command

BEFORE = len(python_command("module")) - 1  # words of the command before the module


def run_here(
    command: Sequence[str], heard: Callable[[str], None] = lambda _: None, *, cwd: str | os.PathLike[str], **_: Any
) -> CompletedProcess[str]:
    """Run the module of a `python_command`, as `subprocess.run` or `run_with_lines` would."""
    module = command[BEFORE]
    out, err, code = io.StringIO(), io.StringIO(), 0
    with (
        mock.patch.object(sys, "argv", list(command[BEFORE:])),
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(),
    ):
        warnings.filterwarnings("ignore", "'.*' found in sys.modules")
        try:
            runpy.run_module(module, run_name="__main__")
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
    for line in out.getvalue().splitlines():
        heard(line)
    return CompletedProcess(command, code, out.getvalue(), err.getvalue())
