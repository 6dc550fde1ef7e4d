"""The movement of a run, from its snapshots: a GIF, or the position at a step.

``python -m bsm_mesh.app.animation OUT ""`` draws the GIF, with a number instead of the empty text the position.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from bsm_mesh.app.added_files import AddedFiles
from bsm_mesh.app.canvas import MOST_EDGES, Scene, save_picture
from bsm_mesh.app.headings import heading
from bsm_mesh.app.pictures import add_picture, add_position, read_grid
from bsm_mesh.app.plot import BAD_INPUT
from bsm_mesh.app.storage import SavedResults
from bsm_mesh.app.tables import engineering
from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file

if TYPE_CHECKING:
    from PIL.Image import Image

Series: TypeAlias = list[tuple[float, str]]
"""Times and names of the files of snapshots."""

WIDTH, TEXT_HEIGHT = 720, 60  # pixels
MOST_FRAMES, COLOURS = 60, 32
FRAME, FIRST_FRAME, LAST_FRAME = 100, 800, 2000  # ms
BEYOND = 0.5  # of the model's size: how far beside it the frame goes at most, to follow what falls


def animate(folder: Path) -> Path:
    """Draw the snapshots of a results folder as ``pictures/movement.gif``, true to scale, and return its path.

    At most `MOST_FRAMES` of them, evenly chosen; blocks that come down are red from the start.
    """
    added, saved = AddedFiles(folder), SavedResults(folder)
    files = _snapshots(saved)
    chosen = np.unique(np.linspace(0, len(files) - 1, min(len(files), MOST_FRAMES - 1)).round().astype(int))
    files = [files[k] for k in chosen]
    unstable = np.array(saved.told["stages"][-1]["unstable_blocks"], dtype=np.int32)
    window = _window(saved, files)
    images = [_still(image) for image in _frames(saved, files, unstable, window)]
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
    earlier = [entry for entry in files if entry[0] <= step] or files[:1]
    time, file = earlier[-1]
    grid = _read(saved, file)
    scene = Scene(
        grid=grid,
        title=heading(saved.told, "on its way"),
        size=float(grid.length),
        joints=np.zeros((0, 2, 2)),
        water=saved.water_table(int(Path(file).stem.split("_")[1])),
    )

    def draw(plotter: Any, scene: Scene) -> str:
        add_position(plotter, scene)
        return f"position after {time:g} of {files[-1][0]:g} steps, true to scale, over the original outlines (grey)"

    return add_picture(added, f"position_{time:05.0f}.png", partial(save_picture, scene, draw))


def _snapshots(saved: SavedResults) -> Series:
    """Return time and file of every snapshot, the end included."""
    files = saved.series("blocks")
    if len(files) < 2:
        raise ModelError(
            f'{saved.folder}: holds no snapshots of a movement; run again with snapshots = "steps" under [output]'
        )
    return files


def _read(saved: SavedResults, file: str) -> Any:
    return read_grid(saved, file, needs=("displacement", "block_id"))


def _window(saved: SavedResults, files: Series) -> FloatArray:
    """Return x and y, least and greatest, of all that is shown, (2, 2) [m]."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    start = np.zeros((2, 2))
    for number, (_, file) in enumerate(files):
        grid = _read(saved, file)
        if number == 0:
            start = np.array([grid.points.min(axis=0)[:2], grid.points.max(axis=0)[:2]])
            low, high = start
        moved = (grid.points + grid.point_data["displacement"])[:, :2]
        low, high = np.minimum(low, moved.min(axis=0)), np.maximum(high, moved.max(axis=0))
    beyond = BEYOND * float((start[1] - start[0]).max())
    return np.stack([np.maximum(low, start[0] - beyond), np.minimum(high, start[1] + beyond)], axis=1)


def _frames(saved: SavedResults, files: Series, unstable: IntArray, window: FloatArray) -> Iterator[FloatArray]:
    """Yield the frames, (height, width, 3), the start first."""
    import pyvista

    pyvista.OFF_SCREEN = True
    span = window[:, 1] - window[:, 0]
    aspect = min(max(span[1] / span[0], 0.35), 1.4)
    height = int(WIDTH * aspect) + TEXT_HEIGHT
    plotter = pyvista.Plotter(off_screen=True, window_size=(WIDTH, height))
    plotter.set_background("white")
    plotter.enable_parallel_projection()
    plotter.view_xy()
    scale = max(span[0] / WIDTH, span[1] / (height - TEXT_HEIGHT)) * 1.06  # metres a pixel
    x, y = window.mean(axis=1)
    camera = plotter.camera
    camera.focal_point, camera.position = (x, y + scale * TEXT_HEIGHT / 2, 0), (x, y + scale * TEXT_HEIGHT / 2, 1)
    camera.parallel_scale = scale * height / 2
    try:
        for number, (time, file) in enumerate([(0.0, files[0][1]), *files]):
            grid = _read(saved, file)
            move = np.asarray(grid.point_data["displacement"]) * (number > 0)
            if number == 0:
                plotter.add_mesh(grid.copy(), style="wireframe", color="#b9b2a3", line_width=1, lighting=False)
            _show(plotter, grid, move, unstable)
            greatest = engineering(float(np.linalg.norm(move, axis=1).max()), "m")
            text = f"{heading(saved.told)}\nstep {time:g} of {files[-1][0]:g}, greatest displacement {greatest}"
            plotter.add_text(text, position=(10, height - 44), font_size=8, color="black", name="text")
            plotter.camera.clipping_range = (0.1, 10.0)
            yield np.asarray(plotter.screenshot(return_img=True))
    finally:
        plotter.close()


def _show(plotter: Any, grid: Any, move: FloatArray, unstable: IntArray) -> None:
    moved = grid.copy()
    moved.points = grid.points + move
    falls = np.isin(np.asarray(grid.cell_data["block_id"]), unstable)
    for name, chosen, colour in (("stable", ~falls, "#c9d8ea"), ("unstable", falls, "#d9776b")):
        plotter.remove_actor(name, render=False)
        if chosen.any():
            part = moved.extract_cells(np.flatnonzero(chosen))
            edges = grid.n_cells <= MOST_EDGES
            plotter.add_mesh(
                part,
                color=colour,
                show_edges=edges,
                edge_color="#33475b",
                lighting=False,
                name=name,
                reset_camera=False,
            )


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
