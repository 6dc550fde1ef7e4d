"""Pictures in a process of their own: a renderer without its system libraries dies of a segmentation fault."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from bsm_mesh.app.headings import PICTURES_FOLDER
from bsm_mesh.app.storage import find_results
from bsm_mesh.app.summary import read_summary
from bsm_mesh.errors import ModelError
from bsm_mesh.files import remove_abandoned
from bsm_mesh.processes import python_command

BAD_INPUT = 2  # exit code of the drawing process where the results are at fault, not the renderer
CURE = (
    "the renderer needs system libraries: on Debian 'apt-get install libgl1 libegl1 libgl1-mesa-dri', "
    "or use the results without pictures"
)


def draw_in_subprocess(folder: Path, *, animate: bool = False, step: int | None = None) -> list[Path]:
    """Draw the pictures of a results folder into ``pictures/`` and return their paths.

    Parameters
    ----------
    folder : Path
        The folder of a run.
    animate : bool
        Draw the movement as a GIF instead.
    step : int, optional
        Draw the position at the last snapshot of no more than so many steps instead.

    Raises
    ------
    ModelError
        If the folder holds no results, or the renderer fails or dies.
    """
    read_summary(find_results(folder))
    if animate and step is not None:
        raise ModelError("plot: give --animate or --step, not both")
    module, *arguments = ["bsm_mesh.app.pictures", str(folder.absolute())]
    if animate or step is not None:
        module, arguments = "bsm_mesh.app.animation", [*arguments, "" if step is None else str(step)]
    return render(folder, module, *arguments)


def render(folder: Path, module: str, *arguments: str) -> list[Path]:
    """Run a module that draws pictures of a folder in a process of its own, and return their paths.

    Raises
    ------
    ModelError
        If the renderer fails or dies.
    """
    try:
        done = subprocess.run(
            python_command(module, *arguments),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
            cwd=Path(__file__).parent,  # settings of libraries in the current folder are a stranger's: matplotlibrc
            env=_environment(),
        )
    finally:
        remove_abandoned(folder / PICTURES_FOLDER)  # of a renderer that died
    if not 0 <= done.returncode < 256:  # a signal; on Windows an exception's number
        raise ModelError(f"{folder}: the renderer died of signal {-done.returncode}; {CURE}")
    last = (done.stderr.strip().splitlines() or ["no message"])[-1].replace(str(folder.absolute()), str(folder))
    if done.returncode == BAD_INPUT:
        raise ModelError(last)
    if done.returncode:
        raise ModelError(f"{folder}: the pictures could not be drawn: {last}; {CURE}")
    return [folder / PICTURES_FOLDER / Path(line).name for line in done.stdout.splitlines()]


def _environment() -> dict[str, str]:
    """Return the environment with VTK told to use EGL on Linux: it falls back to OSMesa, and asks for no display."""
    environment = dict(os.environ)
    if sys.platform.startswith("linux"):
        environment.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    return environment
