"""Pictures of a comparison: ``python -m bsm_mesh.pictures.compare_pictures FOLDER FILE=TITLE ...``."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.pictures.canvas import LINE, scaled
from bsm_mesh.pictures.figures import TEXT, entitle, paper, save
from bsm_mesh.pictures.pictures import add_picture
from bsm_mesh.pictures.plot import BAD_INPUT
from bsm_mesh.pictures.scene import MOST_EDGES
from bsm_mesh.text.tables import engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bsm_mesh.converters.vtk_files import Grid

PANEL = 6.0  # inches: width of each side
FURNITURE = 1.9  # inches for title, ticks and the scale of colours
WIDE = 0.45  # height over width of a model, below which the panels stand one above the other


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """The field of the picture: its array, name, unit and colours."""

    array: str
    text: str
    unit: str
    colours: str


QUANTITIES = (
    Quantity(array="displacement", text="displacement", unit="m", colours="viridis"),
    Quantity(array="sigma_1", text="most compressive stress (sigma_1)", unit="Pa", colours="viridis_r"),
)


def draw_comparison(folder: Path, file: str, title: str) -> list[Path]:
    """Draw displacement and stress of a comparison's VTU file; return the pictures."""
    from bsm_mesh.converters.vtk_files import read_vtu

    added, path = AddedFiles(folder), folder / file
    grid = read_vtu(path, needs=("block_id",))
    other = "other program" if path.stem.startswith("compare_with") else "elements"
    return [
        add_picture(added, f"{path.stem}_{each.array}.png", partial(save, _figure(grid, each, title, other)))
        for each in QUANTITIES
        if f"{each.array}_difference" in grid.cell_data
    ]


def _figure(grid: Grid, quantity: Quantity, title: str, other: str) -> Figure:
    """Return both sides on one scale of colours, and the difference on its own."""
    ours, theirs, difference = (_sizes(grid.cell_data[f"{quantity.array}{end}"]) for end in ("", "_fem", "_difference"))
    (x0, y0), (x1, y1) = grid.points.min(axis=0), grid.points.max(axis=0)
    aspect = float(np.clip((y1 - y0) / (x1 - x0), 0.1, 1.6))
    rows, columns = (3, 1) if aspect < WIDE else (1, 3)
    figure = paper((PANEL * columns + 0.5, (PANEL * aspect + FURNITURE) * rows))
    heading = "\n".join([*wrap(title, 30 * columns + 40), quantity.text])
    entitle(figure, heading)
    both = float(min(ours.min(), theirs.min())), float(max(ours.max(), theirs.max()))
    greatest = float(np.abs(difference).max())
    signed = bool(difference.min() < 0)
    panels = (
        ("blocks", ours, both, quantity.colours),
        (other, theirs, both, quantity.colours),
        ("difference", difference, (-greatest if signed else 0.0, greatest), "RdBu_r" if signed else "magma_r"),
    )
    outlines = np.split(grid.points[grid.connectivity], grid.offsets[1:-1])
    for axes, (name, values, ends, colours) in zip(figure.subplots(rows, columns).ravel(), panels, strict=True):
        _panel(figure, axes, outlines, values, ends, colours, quantity.unit)
        most = engineering(float(values[np.abs(values).argmax()]), quantity.unit)
        axes.set_title(f"{name}, greatest {most}", loc="left", fontsize=10, color=TEXT)
        axes.set_xlim(x0, x1)
        axes.set_ylim(y0, y1)
    return figure


def _panel(
    figure: Figure,
    axes: Any,
    outlines: list[FloatArray],
    values: FloatArray,
    ends: tuple[float, float],
    colours: str,
    unit: str,
) -> None:
    """Draw one side, with the scale of its colours."""
    from matplotlib.collections import PolyCollection

    (low, high), prefixed = scaled(np.array(ends), unit)
    factor = ends[1] / high if high else ends[0] / low if low else 1.0
    edges = LINE if len(outlines) <= MOST_EDGES else "face"
    drawn = axes.add_collection(PolyCollection(outlines, array=values / factor, cmap=colours, edgecolors=edges, lw=0.4))
    drawn.set_clim(low, high)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=8, color="#999999")
    bar = figure.colorbar(drawn, ax=axes, location="bottom", fraction=0.05, pad=0.02, aspect=40)
    bar.set_label(prefixed, fontsize=9)
    bar.ax.tick_params(labelsize=8)
    bar.outline.set_visible(False)


def _sizes(values: FloatArray) -> FloatArray:
    sizes: FloatArray = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    return sizes


if __name__ == "__main__":
    try:
        for given in sys.argv[2:]:
            name, _, heading = given.partition("=")
            for picture in draw_comparison(Path(sys.argv[1]), name, heading):
                print(picture, flush=True)
    except ModelError as error:
        print(error, file=sys.stderr)
        sys.exit(BAD_INPUT)
