"""The movement of a run, from its snapshots: a GIF, or the position at a step.

``python -m bsm_mesh.pictures.animation OUT ""`` draws the GIF, with a number instead of the empty text the position.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.frames import Frame, frames_in
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.pictures.canvas import FALLS, GIVEN, MOVED, OUTLINE, WATER, WIDTH
from bsm_mesh.pictures.figures import paper, save
from bsm_mesh.pictures.pictures import add_picture
from bsm_mesh.pictures.plot import BAD_INPUT
from bsm_mesh.pictures.scene import MARGIN, MOST_EDGES
from bsm_mesh.pictures.space_positions import SpacePositions
from bsm_mesh.text.headings import heading
from bsm_mesh.text.tables import engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

    from bsm_mesh.converters.vtk_files import Grid

FRAME_WIDTH, TEXT = 720, 0.75  # pixels; inches above the picture
MOST_FRAMES, COLOURS = 60, 32
FRAME, FIRST_FRAME, LAST_FRAME = 100, 800, 2000  # ms
BEYOND = 0.5  # of the model's size: how far beside it the frame goes at most, to follow what falls


class Positions(Protocol):
    """Positions of the blocks of a run at its snapshots, by the kind of blocks."""

    def extent(self, frame: Frame) -> tuple[FloatArray, FloatArray]:
        """Return the boxes of the blocks as given and where they are in a frame: both corners, (2, 2) [m]."""
        ...

    def greatest(self, frame: Frame) -> float:
        """Return the greatest displacement of a corner [m]."""
        ...

    def add_start(self, axes: Any) -> None:
        """Draw where the blocks were given."""
        ...

    def add_blocks(self, axes: Any, frame: Frame, factor: float, down: IntArray | None) -> Sequence[Any]:
        """Draw the blocks moved by so many times their displacement; return the artists of this frame.

        Blocks that fall have another colour: those given, or those of the frame itself.
        """
        ...


def animate(folder: Path) -> Path:
    """Draw the snapshots of a results folder as ``pictures/movement.gif``, true to scale, and return its path.

    At most `MOST_FRAMES` of them, evenly chosen; unstable blocks are red from the start.
    """
    added, saved = AddedFiles(folder), SavedResults(folder)
    files = _snapshots(saved)
    chosen = np.unique(np.linspace(0, len(files) - 1, min(len(files), MOST_FRAMES - 1)).round().astype(int))
    files = [files[k] for k in chosen]
    unstable = np.array(saved.told["stages"][-1]["unstable_blocks"], dtype=np.int32)
    positions = _positions(saved)
    window = _window(positions, files)
    images = [_still(image) for image in _frames(saved, positions, files, unstable, window)]
    durations = [FIRST_FRAME, *[FRAME] * (len(images) - 2), LAST_FRAME]

    def draw(path: Path) -> None:
        with whole_file(path) as draft:
            images[0].save(
                draft, format="GIF", save_all=True, append_images=images[1:], duration=durations, loop=0, disposal=1
            )

    return add_picture(added, "movement.gif", draw)


def draw_step(folder: Path, step: int) -> Path:
    """Draw the position at the last snapshot of no more than `step` steps, and return the path of the picture."""
    added, saved = AddedFiles(folder), SavedResults(folder)
    files = _snapshots(saved)
    frame = ([each for each in files if each.steps <= step] or files[:1])[-1]
    positions = _positions(saved)
    given, moved = positions.extent(frame)
    room = MARGIN * float(np.hypot(*(given[1] - given[0])))
    window = np.stack([np.minimum(given[0], moved[0]) - room, np.maximum(given[1], moved[1]) + room], 1)
    figure, axes = _stage(window, WIDTH)
    positions.add_start(axes)
    positions.add_blocks(axes, frame, 1.0, None)
    table = saved.water_table(frame.stage)
    axes.plot(*table.transpose(2, 1, 0), color=WATER, linewidth=2.2)
    when = f"position after {frame.steps} of {files[-1].steps} steps{_seconds(saved, frame)}"
    told = f"{when}, true to scale, over the original outlines (grey)"
    axes.set_title(f"{heading(saved.told, 'on its way')}\n{told}", loc="left", fontsize=11, parse_math=False)
    return add_picture(added, f"position_{frame.steps:05d}.png", partial(save, figure))


def _positions(saved: SavedResults) -> Positions:
    return SpacePositions(saved) if saved.in_space else _PlanePositions(saved)


def _snapshots(saved: SavedResults) -> list[Frame]:
    """Return every snapshot, the end included."""
    files = frames_in(saved)
    if len(files) < 2:
        raise ModelError(
            f'{saved.folder}: holds no snapshots of a movement; run again with snapshots = "steps" under [output]'
        )
    return files


def _seconds(saved: SavedResults, frame: Frame) -> str:
    """Return the time of a snapshot where a stage of the run is shaken; nothing elsewhere."""
    shaken = any("shaking" in stage for stage in saved.told["stages"])
    return f", at {frame.time:.4g} s" if shaken and frame.time >= 0 else ""


def _window(positions: Positions, files: Sequence[Frame]) -> FloatArray:
    """Return x and y, least and greatest, of all that is shown, (2, 2) [m]."""
    start, _ = positions.extent(files[0])
    low, high = start
    for frame in files:
        _, moved = positions.extent(frame)
        low, high = np.minimum(low, moved[0]), np.maximum(high, moved[1])
    beyond = BEYOND * float((start[1] - start[0]).max())
    return np.stack([np.maximum(low, start[0] - beyond), np.minimum(high, start[1] + beyond)], axis=1)


def _frames(
    saved: SavedResults, positions: Positions, files: Sequence[Frame], unstable: IntArray, window: FloatArray
) -> Iterator[FloatArray]:
    """Yield the frames, (height, width, 3), the start first."""
    figure, axes = _stage(window, FRAME_WIDTH)
    positions.add_start(axes)
    for number, frame in enumerate([files[0], *files]):
        factor = float(number > 0)
        shown = frame if number else replace(frame, steps=0, time=-1.0)
        drawn = positions.add_blocks(axes, frame, factor, unstable)
        greatest = engineering(factor * positions.greatest(frame), "m")
        when = f"step {shown.steps} of {files[-1].steps}{_seconds(saved, shown)}"
        told = f"{heading(saved.told)}\n{when}, greatest displacement {greatest}"
        axes.set_title(told, loc="left", fontsize=9, parse_math=False)
        canvas: Any = figure.canvas
        canvas.draw()
        figure.set_layout_engine(
            "none"
        )  # the first frame has made room; working it out again takes longer than drawing
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()
        for artist in drawn:
            artist.remove()


def _stage(window: FloatArray, width: int) -> tuple[Figure, Any]:
    """Return a figure so many pixels wide, and axes that show a window (2, 2): x and y, least and greatest [m]."""
    span = window[:, 1] - window[:, 0]
    aspect = min(max(span[1] / span[0], 0.35), 1.4)
    figure = paper((width / 100, width / 100 * aspect + TEXT), 100)
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_xlim(window[0])
    axes.set_ylim(window[1])
    axes.tick_params(labelsize=8)
    axes.set_xlabel("x, m", fontsize=8)
    axes.set_ylabel("y, m", fontsize=8)
    return figure, axes


class _PlanePositions:
    """Positions of polygons."""

    def __init__(self, saved: SavedResults) -> None:
        self._saved = saved
        self._given: Grid | None = None
        self._last: tuple[Frame, Grid] | None = None

    def _read(self, frame: Frame) -> Grid:
        if self._last is None or self._last[0] != frame:
            grid = self._saved.grid(frame.file("blocks"), needs=("displacement", "block_id", "unstable"))
            self._given, self._last = self._given or grid, (frame, grid)
        return self._last[1]

    def extent(self, frame: Frame) -> tuple[FloatArray, FloatArray]:
        grid = self._read(frame)
        moved = grid.points + _moves(grid)
        given, there = (np.stack([points.min(axis=0), points.max(axis=0)]) for points in (grid.points, moved))
        return given, there

    def greatest(self, frame: Frame) -> float:
        return float(np.hypot(*_moves(self._read(frame)).T).max())

    def add_start(self, axes: Any) -> None:
        from matplotlib.collections import PolyCollection

        assert self._given is not None  # the window was asked for before
        outlines = _polygons(self._given, 0.0)
        axes.add_collection(
            PolyCollection(outlines, facecolors="none", edgecolors=GIVEN, linewidths=0.7), autolim=False
        )

    def add_blocks(self, axes: Any, frame: Frame, factor: float, down: IntArray | None) -> Sequence[Any]:
        from matplotlib.collections import PolyCollection

        grid = self._read(frame)
        cells = grid.cell_data
        falls = cells["unstable"] > 0 if down is None else np.isin(cells["block_id"], down)
        order = np.argsort(falls, kind="stable")  # every unstable block lies in front
        outlines = _polygons(grid, factor)
        drawn = PolyCollection(
            [outlines[k] for k in order.tolist()],
            facecolors=[FALLS if falls[k] else MOVED for k in order.tolist()],
            edgecolors=OUTLINE if len(outlines) <= MOST_EDGES else "face",
            linewidths=0.6,
        )
        return [axes.add_collection(drawn, autolim=False)]


def _moves(grid: Grid) -> FloatArray:
    """Return the displacement of every corner, (n_vertices, 2) [m]."""
    moves: FloatArray = grid.point_data["displacement"][:, :2]
    return moves


def _polygons(grid: Grid, factor: float) -> list[FloatArray]:
    return np.split(grid.points + factor * _moves(grid), grid.offsets[1:-1])


def _still(image: FloatArray) -> Image:
    """Return a frame in a few colours."""
    from PIL import Image as Images

    return Images.fromarray(image).quantize(COLOURS)


if __name__ == "__main__":
    try:
        print(draw_step(Path(sys.argv[1]), int(sys.argv[2])) if sys.argv[2] else animate(Path(sys.argv[1])))
    except ModelError as error:
        print(error, file=sys.stderr)
        sys.exit(BAD_INPUT)
