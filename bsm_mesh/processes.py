"""Modules of ours in a Python of their own: code that may die, or never end, does so there."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

from bsm_mesh.errors import ModelError

# The folder of this checkout goes last: an installed package needs no help to be found. It is no place for `-m`, which
# would put it, or without -P the current folder, before Python's own modules.
_RUN = (
    "import runpy, sys; root, *sys.argv = sys.argv[1:]; sys.path.append(root); "
    "runpy.run_module(sys.argv[0], run_name='__main__')"
)


def python_command(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a module with arguments.

    ``python -m`` looks for every module in the current folder first: a ``random.py`` that happens to lie there would be
    run. With ``-P`` neither that folder nor the one of a script is looked at.

    Raises
    ------
    ModelError
        In a Python inside another program, which does not know its own.
    """
    if not sys.executable:
        raise ModelError("this Python is part of another program and cannot start itself: run bsm-mesh by its own")
    return [sys.executable, "-P", "-c", _RUN, str(Path(__file__).parents[1]), module, *arguments]


def limit_process(seconds: int, memory: int) -> None:
    """Limit the processor time [s] and address space [bytes] that this process may still take, where a system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    room = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    limits = {
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_CPU: math.ceil(used + seconds),
        resource.RLIMIT_AS: min(memory, max(1 << 30, room)),
    }
    for kind, most in limits.items():
        hard = resource.getrlimit(kind)[1]
        with suppress(OSError, ValueError):  # macOS knows no limit of address space
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def run_with_lines(command: list[str], heard: Callable[[str], None], *, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, and pass on each line of its output as it is written.

    Parameters
    ----------
    command : list of str
        As of `python_command`.
    heard : callable
        Gets each line, without its end. Where it raises, or the run is interrupted, the process is killed.
    cwd : Path
        The current folder of the process.
    """
    pipe = subprocess.PIPE
    with (
        subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, encoding="utf-8", errors="replace", cwd=cwd
        ) as process,
        ThreadPoolExecutor(1) as reader,  # of its errors: a full pipe would stop it
    ):
        assert process.stdout is not None
        assert process.stderr is not None
        errors, lines = reader.submit(process.stderr.read), []
        try:
            for line in process.stdout:
                lines.append(line)
                heard(line.rstrip("\n"))
        except BaseException:
            process.kill()
            raise
        return subprocess.CompletedProcess(command, process.wait(), "".join(lines), errors.result())
