"""Errors that fall with the size of the blocks: Kirsch's hole, triangles as elastic rock, arches; table and picture."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from bsm_mesh.files import whole_file
from examples.numbers.pages import markdown
from tests.scenes.kirsch import error_near, model_of, plate
from tests.scenes.models import LINEAR
from tests.scenes.shapes import gmsh_triangles
from verification.case import error_of
from verification.continuum import kirsch_by_blocks, triangle_strains

PICTURE = Path(__file__).parents[1] / "docs" / "verification.png"
AROUND = (12, 24, 48)
SIZES = (5.0, 2.5, 1.25)
Line = tuple[str, np.ndarray, np.ndarray]


@cache
def kirsch_by_elements(around: int) -> float:
    """Return the L2 error of linear triangles on the quads of `kirsch_by_blocks`, as block averages."""
    from bsm_mesh.converters import solve_continuum

    corners = plate(around)
    return float(error_near(solve_continuum(model_of(corners, "homogeneous"), order=1).stress, corners))


@cache
def kirsch_with_wang(around: int) -> float:
    """Return the same of blocks with the thesis's stiffness, which are another material."""
    import bsm_mesh as bsm

    corners = plate(around)
    return float(error_near(bsm.run(model_of(corners, "wang"), LINEAR).stages[-1].stress, corners))


@cache
def lines() -> tuple[Line, ...]:
    """Return name, number of blocks and error of every line of the picture."""
    quads = np.array([len(plate(around)) for around in AROUND])
    triangles = np.array([len(gmsh_triangles(40.0, 40.0, size)) for size in SIZES])
    return (
        ("Kirsch: blocks, `homogeneous`", quads, np.array([kirsch_by_blocks(around) for around in AROUND])),
        ("Kirsch: blocks, `wang`", quads, np.array([kirsch_with_wang(around) for around in AROUND])),
        ("Kirsch: linear finite elements", quads, np.array([kirsch_by_elements(around) for around in AROUND])),
        ("elastic rock: strains of triangles, `triangle`", triangles,
         np.array([error_of(*triangle_strains(size)) for size in SIZES])),
    )  # fmt: skip


def order_of(count: np.ndarray, error: np.ndarray) -> float:
    """Return the power of the block size with which the error falls, by its last two."""
    return float(np.log(error[-2] / error[-1]) / np.log(np.sqrt(count[-1] / count[-2])))


def table() -> str:
    """Return the table."""
    rows = []
    for name, count, error in lines():
        steps = "; ".join(f"{n}: {100 * e:.2f} %" for n, e in zip(count, error, strict=True))
        rows.append((name, steps, f"{order_of(count, error):.1f}"))
    return markdown(("what", "blocks: error", "order in the block size"), rows)


def draw() -> None:
    """Draw the errors over the number of blocks."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import FixedLocator, NullFormatter, StrMethodFormatter

    figure = Figure(figsize=(8, 4.8), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for (name, count, error), marker in zip(lines(), "os^D", strict=True):
        axes.loglog(count, 100 * error, marker=marker, label=name.replace("`", ""))
    x = np.array([300.0, 4000.0])
    axes.loglog(x, 4.0 * np.sqrt(x[0] / x), "k:", label="first order")
    axes.set_xlabel("blocks")
    axes.set_ylabel("error, %")
    axes.grid(visible=True, which="both", color="#dddddd", linewidth=0.6)
    for axis, ticks in ((axes.xaxis, (200, 500, 1000, 2000, 4000)), (axes.yaxis, (0.01, 0.1, 1, 10))):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())
    figure.legend(frameon=False, fontsize=8, loc="outside upper center", ncols=2)
    with whole_file(PICTURE) as draft:
        figure.savefig(draft, format="png")
