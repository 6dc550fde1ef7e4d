"""Pictures of a comparison: ``python -m bsm_mesh.app.compare_pictures FOLDER FILE=TITLE ...``."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from bsm_mesh.app.added_files import AddedFiles
from bsm_mesh.app.canvas import MOST_EDGES, outline_of, scalar_bar, scaled
from bsm_mesh.app.headings import PICTURES_FOLDER
from bsm_mesh.app.plot import BAD_INPUT
from bsm_mesh.app.tables import engineering
from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file

PANEL = 700  # pixels
LINE = 60  # characters of a line of the title
WIDE = 0.55  # height over width of a model, below which the panels stand one above the other


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """What is drawn: its array, how it is called, its unit and colours."""

    array: str
    text: str
    unit: str
    colours: str


QUANTITIES = (
    Quantity(array="displacement", text="displacement", unit="m", colours="viridis"),
    Quantity(array="sigma_1", text="most compressive principal stress", unit="Pa", colours="viridis_r"),
)


def draw_comparison(folder: Path, file: str, title: str) -> list[Path]:
    """Draw displacement and stress of a comparison's VTU file; return the pictures."""
    import pyvista

    from bsm_mesh.converters.vtk_files import vtk_grid_of

    pyvista.OFF_SCREEN = True
    added = AddedFiles(folder)
    path = folder / file
    grid = pyvista.wrap(vtk_grid_of(path.read_bytes(), path, needs=("block_id",)))
    drawn = []
    for quantity in QUANTITIES:
        if f"{quantity.array}_difference" not in grid.cell_data:
            continue
        name = f"{PICTURES_FOLDER}/{path.stem}_{quantity.array}.png"
        with added.file(name) as draft:
            _draw(grid, quantity, title, draft, "other" if path.stem == "compare_with" else "elements")
        drawn.append(added.folder.path / name)
    return drawn


def _draw(grid: Any, quantity: Quantity, title: str, path: Path, other: str) -> None:
    import pyvista

    ours, theirs, difference = (
        _sizes(np.asarray(grid.cell_data[f"{quantity.array}{end}"])) for end in ("", "_fem", "_difference")
    )
    x0, x1, y0, y1, _, _ = grid.bounds
    aspect = min(max((y1 - y0) / max(x1 - x0, 1e-300), 0.2), 1.4)
    shape = (3, 1) if aspect < WIDE else (1, 3)
    height = int(PANEL * aspect) + 160
    plotter = pyvista.Plotter(
        off_screen=True, shape=shape, window_size=(PANEL * shape[1], height * shape[0]), border=False
    )
    plotter.set_background("white")
    limits = float(min(ours.min(), theirs.min())), float(max(ours.max(), theirs.max()))
    panels = (
        ("blocks", ours, limits, quantity.colours),
        (other, theirs, limits, quantity.colours),
        ("difference", difference, None, "RdBu_r" if difference.min() < 0 else "magma_r"),
    )
    for place, (name, values, ends, colours) in enumerate(panels):
        plotter.subplot(*((place, 0) if shape[0] == 3 else (0, place)))
        greatest = engineering(float(values[np.abs(values).argmax()]), quantity.unit)
        head = "\n".join([*wrap(title, LINE), quantity.text, ""]) if place == 0 else ""
        _panel(plotter, grid, values, quantity.unit, ends, colours, f"{head}{name}, greatest {greatest}", name)
    try:
        with whole_file(path) as draft:
            plotter.screenshot(str(draft))
    finally:
        plotter.close()


def _panel(
    plotter: Any,
    grid: Any,
    values: FloatArray,
    unit: str,
    ends: tuple[float, float] | None,
    colours: str,
    caption: str,
    name: str,
) -> None:
    """Draw one side into the current panel."""
    greatest = float(np.abs(values).max())
    ends = ends or ((-greatest, greatest) if values.min() < 0 else (0.0, greatest))
    factor, prefixed = _factor(ends, unit)
    shown = grid.copy()
    shown.cell_data["shown"] = values / factor
    plotter.add_mesh(
        shown,
        scalars="shown",
        clim=[end / factor for end in ends],
        cmap=colours,
        show_edges=grid.n_cells <= MOST_EDGES,
        edge_color="#555555",
        line_width=0.5,
        lighting=False,
        scalar_bar_args={
            **scalar_bar(f"{name}, {prefixed}"),
            "height": 0.09,
            "title_font_size": 16,
            "label_font_size": 14,
        },
    )
    plotter.add_mesh(outline_of(grid), color="black", line_width=2)
    lines = caption.count("\n") + 1
    top = 1 - (30 + 22 * lines) / plotter.window_size[1] * plotter.shape[0]
    plotter.add_text(caption, position=(0.03, top), viewport=True, font_size=9, color="black")
    plotter.enable_parallel_projection()
    plotter.view_xy()
    plotter.camera.tight(padding=0.25, adjust_render_window=False)
    x, y, z = plotter.camera.focal_point
    plotter.camera.position = (x, y, z + float(grid.length))
    plotter.reset_camera_clipping_range()


def _factor(ends: tuple[float, float], unit: str) -> tuple[float, str]:
    """Return what values are divided by to be in a unit with a suitable prefix, and that unit."""
    greatest = np.array([max(abs(ends[0]), abs(ends[1]))])
    shown, prefixed = scaled(greatest, unit)
    return float(greatest[0] / shown[0]) if shown[0] else 1.0, prefixed


def _sizes(values: FloatArray) -> FloatArray:
    sizes: FloatArray = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    return sizes


if __name__ == "__main__":
    try:
        for given in sys.argv[2:]:
            name, _, heading = given.partition("=")
            for picture in draw_comparison(Path(sys.argv[1]), name, heading):
                print(picture)
    except ModelError as error:
        print(error, file=sys.stderr)
        sys.exit(BAD_INPUT)
