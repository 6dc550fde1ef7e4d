"""Pictures in a process of their own, so that its memory and settings end with it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from bsm_mesh.errors import ModelError
from bsm_mesh.files import remove_abandoned
from bsm_mesh.folder.own_files import link_on_the_way, place_in
from bsm_mesh.folder.saved_results import find_results
from bsm_mesh.folder.summary import read_summary
from bsm_mesh.processes import python_command, run_with_lines
from bsm_mesh.text.headings import PICTURES_FOLDER

BAD_INPUT = 2  # exit code of the drawing process where the results or what is asked for are at fault
EARLIER = ("displacement", "joints_state", "bolts")  # what a report shows of stages before the last
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
    look : (azimuth, plunge), optional [degrees]
        View of blocks in space; by default at the blocks that fall.
    only : tuple of str
        Names of pictures, or words that several begin with, as ``joints``; by default all.
    beside : tuple of (name, path)
        Tables, and folders of other runs, that are compared with the histories; the name may be empty.
    for_report : bool
        Only those of a report that are not there yet: of stages before the last `EARLIER`.
    """

    stage: str | None = None
    window: tuple[float, float, float, float] | None = None
    look: tuple[float, float] | None = None
    only: tuple[str, ...] = ()
    beside: tuple[tuple[str, str], ...] = ()
    for_report: bool = False


def in_silence(_: str) -> None:
    """Report nothing."""


def draw_in_subprocess(
    folder: Path,
    choice: PictureChoice | None = None,
    report: Callable[[str], None] = in_silence,
    *,
    animate: bool = False,
    step: int | None = None,
) -> list[Path]:
    """Draw the pictures of a results folder into ``pictures/`` and return their paths.

    Parameters
    ----------
    folder : Path
        The folder of a run.
    choice : PictureChoice, optional
        Which ones; by default all of every stage.
    report : callable
        Gets the name of each picture when it is drawn, with its number.
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
    return render(folder, report, module, *arguments)


def render(folder: Path, report: Callable[[str], None], module: str, *arguments: str) -> list[Path]:
    """Run a module that draws pictures of a folder in a process of its own, and return their paths.

    Each line of its output is the path of a picture that is drawn; `report` gets its name with its number.

    Raises
    ------
    ModelError
        If the renderer fails or dies.
    """
    drawn: list[Path] = []

    def heard(line: str) -> None:
        drawn.append(folder / PICTURES_FOLDER / Path(line).name)
        report(f"picture {len(drawn)}: {drawn[-1].name}")

    try:
        done = run_with_lines(
            python_command(module, *arguments),
            heard,
            cwd=Path(__file__).parent,  # settings of libraries in the current folder are a stranger's: matplotlibrc
        )
    finally:
        if link_on_the_way(folder, PICTURES_FOLDER, itself=True) is None:
            remove_abandoned(folder / PICTURES_FOLDER)  # of a renderer that died
    if not 0 <= done.returncode < 256:  # a signal; on Windows an exception's number
        died = f"the drawing process was killed (signal {-done.returncode}), possibly out of memory"
        raise ModelError(f"{folder}: {died}; {CURE}")
    last = (done.stderr.strip().splitlines() or ["no message"])[-1].replace(str(folder.absolute()), str(folder))
    if done.returncode == BAD_INPUT:
        raise ModelError(last)
    if done.returncode:
        raise ModelError(f"{folder}: the pictures could not be drawn: {last}; {CURE}")
    return drawn
