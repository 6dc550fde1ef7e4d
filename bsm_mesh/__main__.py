"""The command ``bsm-mesh``, and ``python -m bsm_mesh``: an interruption is taken from the first moment on."""

from __future__ import annotations

from typing import Any

from bsm_mesh.app.interruption import guarded


def main() -> None:
    """Run a command of the command line."""
    guarded(_command, last=True)


def _command() -> Any:
    from bsm_mesh.app.cli import main as run_command

    return run_command()


if __name__ == "__main__":
    main()
