"""Pictures in a process of their own: what drawing needs of memory and settings is gone with it."""

from __future__ import annotations

import json
import subprocess
from dataclasses import asdict, dataclass
from pathlib import Path

from bsm_mesh.errors import ModelError
from bsm_mesh.files import remove_abandoned
from bsm_mesh.folder.own_files import link_on_the_way, place_in
from bsm_mesh.folder.saved_results import find_results
from bsm_mesh.folder.summary import read_summary
from bsm_mesh.processes import python_command
from bsm_mesh.text.headings import PICTURES_FOLDER

BAD_INPUT = 2  # exit code of the drawing process where the results or what is asked for are at fault
CURE = "use the results without pictures"


@dataclass(frozen=True, kw_only=True)
class PictureChoice:
    """Which pictures are drawn.

    Attributes
    ----------
    stage : str, optional
        Name or number of the stage, -1 the last one; by default all.
    window : (x0, y0, x1, y1), optional [m]
        The visible part; by default the whole model.
    only : tuple of str
        Names of pictures, or words that several begin with, as ``joints``; by default all.
    beside : tuple of (name, path)
        Tables, and folders of other runs, that are compared with the histories; the name may be empty.
    """

    stage: str | None = None
    window: tuple[float, float, float, float] | None = None
    only: tuple[str, ...] = ()
    beside: tuple[tuple[str, str], ...] = ()


def draw_in_subprocess(
    folder: Path, choice: PictureChoice | None = None, *, animate: bool = False, step: int | None = None
) -> list[Path]:
    """Draw the pictures of a results folder into ``pictures/`` and return their paths.

    Parameters
    ----------
    folder : Path
        The folder of a run.
    choice : PictureChoice, optional
        Which ones; by default all of every stage.
    animate : bool
        Draw the movement as a GIF instead.
    step : int, optional
        Draw the position at the last snapshot of no more than so many steps instead.

    Raises
    ------
    ModelError
        If the folder holds no results, there is no such picture, stage or window, or drawing fails.
    """
    place_in(find_results(folder), PICTURES_FOLDER, itself=True)
    read_summary(find_results(folder))
    if animate and step is not None:
        raise ModelError("plot: give --animate or --step, not both")
    module, *arguments = [
        "bsm_mesh.pictures.pictures",
        str(folder.absolute()),
        json.dumps(asdict(choice or PictureChoice())),
    ]
    if animate or step is not None:
        if choice is not None and choice != PictureChoice():
            raise ModelError("plot: --animate and --step exclude --stage, --window, --only or --with")
        module, arguments = "bsm_mesh.pictures.animation", [arguments[0], "" if step is None else str(step)]
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
        )
    finally:
        if link_on_the_way(folder, PICTURES_FOLDER, itself=True) is None:
            remove_abandoned(folder / PICTURES_FOLDER)  # of a renderer that died
    if not 0 <= done.returncode < 256:  # a signal; on Windows an exception's number
        raise ModelError(f"{folder}: drawing died of signal {-done.returncode}, perhaps for want of memory; {CURE}")
    last = (done.stderr.strip().splitlines() or ["no message"])[-1].replace(str(folder.absolute()), str(folder))
    if done.returncode == BAD_INPUT:
        raise ModelError(last)
    if done.returncode:
        raise ModelError(f"{folder}: the pictures could not be drawn: {last}; {CURE}")
    return [folder / PICTURES_FOLDER / Path(line).name for line in done.stdout.splitlines()]
