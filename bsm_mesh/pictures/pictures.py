"""The pictures of a results folder: ``python -m bsm_mesh.pictures.pictures OUT``, the wishes as JSON after it.

A picture of a stage is a figure of Matplotlib (`figure_of`), whoever writes it. Those of the last stage have the
picture's name alone, as ``displacement.png``; those of stages before have their number too:
``displacement_stage_0.png``.

Matplotlib draws them and not VTK, which needs OpenGL, has no round ticks and cannot be shown in a notebook; in space
too, with a depth buffer of our own (docs/decisions, D0001).
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.errors import ModelError, as_given, nearest
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.storage import load_results
from bsm_mesh.model.values import is_number, parts_of
from bsm_mesh.pictures.beside import with_sources
from bsm_mesh.pictures.block_pictures import (
    draw_arrows,
    draw_deformation,
    draw_displacement,
    draw_final_position,
    draw_model,
    draw_principal_stresses,
    draw_sigma_1,
)
from bsm_mesh.pictures.bolt_map import draw_bolt_utilisation, draw_bolts
from bsm_mesh.pictures.bolt_pictures import draw_bolt_forces
from bsm_mesh.pictures.canvas import Sheet, finish
from bsm_mesh.pictures.figures import save
from bsm_mesh.pictures.flow_pictures import draw_discharge, draw_head
from bsm_mesh.pictures.history_pictures import draw_histories
from bsm_mesh.pictures.joint_net import draw_joint_net
from bsm_mesh.pictures.joint_pictures import (
    draw_opening,
    draw_pressure,
    draw_slip,
    draw_state,
    draw_thrust,
    draw_utilisation,
)
from bsm_mesh.pictures.line_pictures import draw_extensometers, draw_profiles
from bsm_mesh.pictures.plot import BAD_INPUT, EARLIER, PictureChoice
from bsm_mesh.pictures.point_pictures import draw_points
from bsm_mesh.pictures.scene import Scene, Window
from bsm_mesh.pictures.shaking_pictures import (
    draw_energy,
    draw_peak_acceleration,
    draw_permanent,
    draw_time_histories,
)
from bsm_mesh.pictures.sheets import new_sheet, scene_of
from bsm_mesh.pictures.water_pictures import draw_water
from bsm_mesh.pictures.zone_pictures import (
    draw_zone_displacement,
    draw_zone_sigma_1,
    draw_zone_sigma_3,
    draw_zone_yielding,
)
from bsm_mesh.results.results import Results
from bsm_mesh.text.headings import PICTURES_FOLDER, stage_heading, stage_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES: dict[str, Callable[[Sheet], str | None]] = {
    "model": draw_model,
    "displacement": draw_displacement,
    "displacement_arrows": draw_arrows,
    "deformation": draw_deformation,
    "final_position": draw_final_position,
    "sigma_1": draw_sigma_1,
    "principal_stresses": draw_principal_stresses,
    "thrust": draw_thrust,
    "joints_state": draw_state,
    "joints_slip": draw_slip,
    "joints_opening": draw_opening,
    "joints_utilisation": draw_utilisation,
    "joints_pressure": draw_pressure,
    "water_pressure": draw_water,
    "flow_head": draw_head,
    "flow_discharge": draw_discharge,
    "bolts": draw_bolts,
    "bolts_utilisation": draw_bolt_utilisation,
    "shaking_acceleration": draw_peak_acceleration,
    "shaking_displacement": draw_permanent,
    "zones_displacement": draw_zone_displacement,
    "zones_sigma_1": draw_zone_sigma_1,
    "zones_sigma_3": draw_zone_sigma_3,
    "zones_yielding": draw_zone_yielding,
}


def _draw_forces_of_bolts(results: Results, number: int, title: str, figure: Figure | None = None) -> Figure | None:
    return draw_bolt_forces(results.stages[number].bolts, title, figure)


OF_THE_PLANE = ("displacement_arrows", "principal_stresses", "thrust", "water_pressure")
FOLLOWING = ("final_position",)  # shows what has left the model's box
OF_A_STAGE: dict[str, Callable[[Results, int, str, Figure | None], Figure | None]] = {
    "bolt_forces": _draw_forces_of_bolts,
    "shaking_histories": draw_time_histories,
    "shaking_energy": draw_energy,
}
OF_THE_RUN = {
    "stereonet": draw_joint_net,
    "histories": draw_histories,
    "extensometers": draw_extensometers,
    "profiles": draw_profiles,
    "points": draw_points,
}
CHARTS = (*OF_A_STAGE, *OF_THE_RUN)  # of no place in the model
NAMES = (*PICTURES, *CHARTS)


def figure_of(
    results: Results,
    name: str,
    stage: int | str = -1,
    window: Window | None = None,
    figure: Figure | None = None,
    look: tuple[float, float] | None = None,
) -> Figure | None:
    """Return a picture of a stage, or None where there is nothing to show.

    Parameters
    ----------
    results : Results
        The result.
    name : str
        One of `NAMES`, or ``joints`` for their state. ``histories``, ``extensometers``, ``profiles`` and
        ``points`` are of the whole run.
    stage : int or str
        Number of the stage, negative: from the last one; or its name.
    window : (x0, y0, x1, y1), optional [m]
        The visible part.
    figure : matplotlib.figure.Figure, optional
        The figure to draw on; by default one of its own, as large as suits.
    look : (azimuth, plunge), optional [degrees]
        From where blocks in space are seen.

    Raises
    ------
    ModelError
        If there is no such picture or stage, or the window is none, or of a chart.
    """
    (name, *_) = chosen_pictures(["joints_state" if name == "joints" else name])
    refuse_window(window, [name])
    number = stage_number(results, stage)
    if name in CHARTS:
        return _chart(results, number, name, figure)
    scene = scene_of(results, number, stage_heading(results, number), window=window, look=look)
    return _figure(scene, name, figure)


def _figure(scene: Scene, name: str, figure: Figure | None = None) -> Figure | None:
    if name in OF_THE_PLANE and not scene.is_plane:
        return None
    if name in FOLLOWING and scene.window is None:
        scene = replace(scene, window=scene.following)
    sheet = new_sheet(scene, figure)
    caption = PICTURES[name](sheet)
    return None if caption is None else finish(sheet, caption)


def _chart(results: Results, number: int, name: str, figure: Figure | None = None) -> Figure | None:
    """Return a chart: of a stage, or of the whole run."""
    if name in OF_A_STAGE:
        return OF_A_STAGE[name](results, number, stage_heading(results, number), figure)
    return OF_THE_RUN[name](results, stage_heading(results, len(results.stages) - 1), figure)


def chosen_pictures(only: Sequence[str]) -> list[str]:
    """Return the names of the pictures that are asked for: all, some, or all that begin with one of the words.

    Raises
    ------
    ModelError
        If there is none of a name.
    """
    names = list(NAMES)
    found: set[str] = set()
    for word in only:
        begins = isinstance(word, str) and bool(word)
        mine = {name for name in names if begins and name.startswith(word)}
        mine = {word} if begins and word in mine else mine
        if not mine:
            raise ModelError(f"plot: there is no picture {as_given(word)}{nearest(word, names, len(names))}")
        found |= mine
    return [name for name in names if name in found or not only]


def draw_pictures(folder: Path, choice: PictureChoice) -> Iterator[Path]:
    """Draw the pictures of a results folder, and yield the path of each when it is drawn."""
    names = chosen_pictures(choice.only)
    refuse_window(choice.window, names)
    added = AddedFiles(folder)  # before anything is read: what is drawn belongs to what is there now
    results = load_results(folder)
    for name, path in choice.beside:
        results = with_sources(results, {name: path})

    def is_there(name: str) -> bool:
        return choice.for_report and (added.folder.place / PICTURES_FOLDER / name).is_file()

    nothing = True
    stages = range(len(results.stages)) if choice.stage is None else [stage_number(results, choice.stage)]
    for number in stages:
        title = stage_heading(results, number)
        scene = scene_of(results, number, title, window=choice.window, look=choice.look)
        is_last = number == len(results.stages) - 1
        suffix = "" if is_last else f"_stage_{number}"
        suffix += "" if choice.window is None else "_window"
        mine = [name for name in names if is_last or not choice.for_report or name in EARLIER]
        of_place = [name for name in mine if name in PICTURES]
        charts = [name for name in mine if name in OF_A_STAGE and choice.window is None]
        for name in [*of_place, *charts]:
            if is_there(f"{name}{suffix}.png"):
                continue
            figure = _figure(scene, name) if name in PICTURES else _chart(results, number, name)
            if figure is not None:
                nothing = False
                yield add_picture(added, f"{name}{suffix}.png", partial(save, figure))
    for name in [name for name in names if name in OF_THE_RUN and choice.window is None]:
        figure = None if is_there(f"{name}.png") else _chart(results, -1, name)
        if figure is not None:
            nothing = False
            yield add_picture(added, f"{name}.png", partial(save, figure))
    if nothing and choice.only:
        raise ModelError(f"plot: there is nothing to show in {' and '.join(map(repr, choice.only))}")


def refuse_window(window: Window | None, names: Sequence[str]) -> None:
    """Raise a `ModelError` where a window is none, or all that is asked for are charts, which show no place."""
    if window is None:
        return
    if set(names) <= set(CHARTS):
        raise ModelError(f"plot: {' and '.join(names)} show no part of the model; leave the window (--window) away")
    parts = parts_of(window) or []
    if len(parts) != 4 or not all(map(is_number, parts)) or not (parts[0] < parts[2] and parts[1] < parts[3]):
        told = " ".join(f"{each:g}" if is_number(each) else as_given(each) for each in parts) or as_given(window)
        raise ModelError(f"plot: window (--window) {told} must be X0 Y0 X1 Y1 with x0 below x1 and y0 below y1")


def add_picture(added: AddedFiles, name: str, draw: Callable[[Path], object]) -> Path:
    """Add what `draw` draws to the pictures of a results folder, and return its path."""
    with added.file(f"{PICTURES_FOLDER}/{name}") as draft:
        draw(draft)
    return added.folder.path / PICTURES_FOLDER / name


if __name__ == "__main__":
    try:
        for picture in draw_pictures(Path(sys.argv[1]), PictureChoice(**json.loads(sys.argv[2]))):
            print(picture, flush=True)
    except ModelError as error:
        print(error, file=sys.stderr)
        sys.exit(BAD_INPUT)
