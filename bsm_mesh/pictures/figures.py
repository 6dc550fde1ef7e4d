"""The paper that charts are drawn on, and how they are written: Matplotlib without a display."""

from __future__ import annotations

from contextlib import chdir
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.files import whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LETTERS = 8.0  # of a title in an inch, so that wide ones fit
TEXT, FRAME = "#222222", "#bbbbbb"


def paper(size: tuple[float, float], dpi: float = 100.0) -> Figure:
    """Return an empty figure of a size in inches, whose parts make room for each other."""
    with chdir(Path(__file__).parent):  # a matplotlibrc in the current folder is a stranger's, and may hold code
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def entitle(figure: Figure, title: str) -> None:
    """Write the title as every picture has it, broken where it is too wide, and pale frames round its axes."""
    width = round(LETTERS * figure.get_figwidth())  # Matplotlib breaks a line after it has made room for one line
    title = "\n".join("\n".join(wrap(line, width)) for line in title.splitlines())
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold", color=TEXT, parse_math=False)
    for axes in figure.axes:
        for side in axes.spines.values():
            side.set_color(FRAME)


def plain_texts(figure: Figure) -> Figure:
    """Return a figure whose texts are shown as they are: a ``$`` in a name begins no formula, which may be none.

    Labels of ticks stay: those of logarithmic axes are formulas.
    """
    from matplotlib.text import Text

    axes = [axis for part in figure.axes for axis in (part.xaxis, part.yaxis)]
    ticks = {id(label) for axis in axes for label in (*axis.get_ticklabels(which="both"), axis.offsetText)}
    for text in figure.findobj(Text):
        if id(text) not in ticks:
            text.set_parse_math(False)
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG, and return its path; folders that are missing are made.

    A palette of its 256 most useful colours makes the file a quarter as large, and the eye sees no difference.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas = FigureCanvasAgg(plain_texts(figure))
    canvas.draw()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    with whole_file(path, parents=True) as draft:
        image.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(draft, format="PNG")
    return path
