"""The command ``bsm-mesh``, and ``python -m bsm_mesh``: an interruption is taken from the first moment on."""

from __future__ import annotations

import gc
from typing import Any

from bsm_mesh.text.interruption import guarded


def main() -> None:
    """Run a command of the command line."""
    try:
        guarded(_command, last=True)
    finally:
        gc.freeze()  # Python's own end collects a million objects otherwise, for memory that the process gives back


def _command() -> Any:
    from bsm_mesh.commands.cli import main as run_command

    return run_command()


if __name__ == "__main__":
    main()
