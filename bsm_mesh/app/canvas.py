"""What pictures of blocks are made of: the scene, outlines and joints, scales, and the file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.app.tables import engineering
from bsm_mesh.arrays import FloatArray
from bsm_mesh.files import whole_file

WIDTH = 1400  # pixels
MOST_EDGES = 40_000  # blocks; more and their outlines hide the colours


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """What the pictures of one stage share.

    Attributes
    ----------
    grid : pyvista.UnstructuredGrid
        The blocks with their results.
    title : str
        Title of the model, stage and verdict.
    size : float [m]
        Diagonal of the model.
    joints : (k, 2, 2) float64 [m]
        Both ends of every jointed face.
    water : (k, 2, 2) float64 [m]
        Both ends of the straight pieces of the water table.
    bolts : pyvista.UnstructuredGrid or None
        The bolts with their forces, if there are any.
    """

    grid: Any
    title: str
    size: float
    joints: FloatArray
    water: FloatArray
    bolts: Any = None

    @property
    def outlines(self) -> bool:
        """Whether the outlines of the blocks are drawn."""
        return bool(self.grid.n_cells <= MOST_EDGES)


def save_picture(scene: Scene, draw: Callable[[Any, Scene], str], path: Path) -> Path:
    """Draw one picture and write it whole or not at all."""
    import pyvista

    x0, x1, y0, y1, _, _ = scene.grid.bounds
    aspect = min(max((y1 - y0) / max(x1 - x0, 1e-300), 0.35), 1.4)
    plotter = pyvista.Plotter(off_screen=True, window_size=(WIDTH, int(WIDTH * aspect * 0.86) + 150))
    plotter.set_background("white")
    caption = draw(plotter, scene)
    if len(scene.water):
        _add_lines(plotter, scene.water, 0.012 * scene.size, "#1f6fd0", 3.0)
        caption = f"{caption}; water table in blue"
    height = plotter.window_size[1]
    plotter.add_text(f"{scene.title}\n{caption}", position=(20, height - 64), font_size=11, color="black")
    plotter.enable_parallel_projection()
    plotter.view_xy()
    plotter.camera.tight(padding=0.2, adjust_render_window=False)
    x, y, z = plotter.camera.focal_point  # tight leaves the camera 1 m above the middle: inside a large model
    plotter.camera.position = (x, y, z + scene.size)
    plotter.reset_camera_clipping_range()
    try:
        with whole_file(path) as draft:
            plotter.screenshot(str(draft))
    finally:
        plotter.close()
    return path


def scalar_bar(title: str) -> dict[str, Any]:
    """Return how the scale of colours looks, below the picture."""
    return {
        "title": title,
        "color": "black",
        "fmt": "%.3g",
        "n_labels": 5,
        "width": 0.5,
        "height": 0.055,
        "position_x": 0.25,
        "position_y": 0.012,
        "title_font_size": 22,
        "label_font_size": 18,
        "vertical": False,
    }


def scaled(values: FloatArray, unit: str) -> tuple[FloatArray, str]:
    """Return values with an SI prefix that suits their greatest magnitude, and the unit with it."""
    greatest = float(np.abs(values).max(initial=0.0))
    _, _, prefixed = engineering(greatest, unit).partition(" ")
    factor = {"G": 1e9, "M": 1e6, "k": 1e3, "m": 1e-3, "u": 1e-6}.get(prefixed[: -len(unit)], 1.0)
    return values / factor, prefixed


def _limits(values: FloatArray) -> tuple[tuple[float, float], str]:
    """Return the ends of the colour scale, and what to say where a few outliers lie beyond them."""
    least, low, high, greatest = np.percentile(values, [0, 1, 99, 100])
    if greatest - least <= 2 * (high - low) or high == low:
        return (float(least), float(greatest)), ""
    return (float(low), float(high)), "; colours end at the 1st and 99th percentile"


def add_blocks(plotter: Any, scene: Scene, values: FloatArray, title: str, colours: str) -> str:
    """Draw the blocks by a value, and return what to say about the ends of the colours."""
    limits, remark = _limits(values)
    grid = scene.grid.copy()
    grid.cell_data["shown"] = values
    plotter.add_mesh(
        grid,
        scalars="shown",
        clim=limits,
        cmap=colours,
        show_edges=scene.outlines,
        edge_color="#555555",
        line_width=0.5,
        lighting=False,
        scalar_bar_args=scalar_bar(title),
    )
    _add_joints(plotter, scene)
    return remark


def add_paper(plotter: Any, scene: Scene) -> None:
    """Draw the blocks as a light background with their outlines."""
    plotter.add_mesh(
        scene.grid, color="#f4f1ea", show_edges=scene.outlines, edge_color="#d0cabc", line_width=0.5, lighting=False
    )
    _add_joints(plotter, scene)
    plotter.add_mesh(outline_of(scene.grid), color="black", line_width=2)


def _add_joints(plotter: Any, scene: Scene) -> None:
    """Draw the joints as thin dark lines over the blocks, where there are some."""
    if len(scene.joints):
        _add_lines(plotter, scene.joints, 0.006 * scene.size, "#111111", 1.6)


def _add_lines(plotter: Any, lines: FloatArray, height: float, colour: str, width: float) -> None:
    """Draw lines (k, 2, 2) at a height above the blocks."""
    import pyvista

    points = np.column_stack([lines.reshape(-1, 2), np.full(2 * len(lines), height)])
    plotter.add_mesh(pyvista.line_segments_from_points(points), color=colour, line_width=width, lighting=False)


def outline_of(grid: Any) -> Any:
    """Return the outline of the body: edges of the blocks that no other block shares."""
    surface = grid.extract_surface(algorithm=None).clean(tolerance=1e-9)
    return surface.extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
    )
