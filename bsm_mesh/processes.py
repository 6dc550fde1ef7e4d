"""Modules of ours in a Python of their own: code that may die, or never end, does so there."""

from __future__ import annotations

import sys
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
