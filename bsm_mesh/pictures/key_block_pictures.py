"""Pictures of key blocks: the free faces, and whole blocks where they fall or slide, seen from any side."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.pictures.figures import TEXT, paper, save
from bsm_mesh.pictures.look import Look
from bsm_mesh.pictures.painter import Layer, Painter, Seen
from bsm_mesh.pictures.space_scene import frame
from bsm_mesh.pictures.space_sheet import ARROW, draw_directions
from bsm_mesh.pictures.surfaces import Sides
from bsm_mesh.reading import as_path
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.key_blocks.modes import FALLS, HELD, NOT_JUDGED, STAYS
from bsm_mesh.three_d.key_blocks.record import KeyBlocks

KINDS = (  # label and colour
    ("not judged: reaches a side", "#f4f4f4"),
    ("not removable", "#d9d9d9"),
    ("removable, stays", "#b9cfe4"),
    ("slides above the required factor", "#f2d16b"),
    ("slides below the required factor", "#ee8a33"),
    ("falls", "#c5281c"),
)
UNSTABLE = 4  # the first kind that is
EDGE, DPI, SIZE, MARGIN = "#555555", 110, (9.0, 7.0), 0.02
MAX_NAMED = 12  # blocks: more names hide each other


def draw_key_blocks(
    path: str | os.PathLike[str],
    blocks: Polyhedra,
    found: KeyBlocks,
    *,
    look: tuple[float, float] | None = None,
    title: str = "",
) -> Path:
    """Draw the blocks at free faces by their mode in block theory, as PNG; return the path.

    Parameters
    ----------
    path : path
        The file, ``.png``.
    blocks : Polyhedra
        The rock.
    found : KeyBlocks
        Of this rock.
    look : (azimuth, plunge), optional [degrees]
        View: clockwise from north, and downwards from the level, negative upwards; by default at the faces of the
        unstable blocks. Faces that turn their rock to the viewer are left out.
    title : str
        Heading.

    Raises
    ------
    ModelError
        If the name does not end in .png, or the view is no direction.
    """
    from matplotlib.colors import to_rgb

    target = as_path("path", path)
    if target.suffix.lower() != ".png":
        raise ModelError(f"{target}: the picture is a PNG; give a name that ends in .png")
    kind, sides = _kinds(found), Sides(blocks)
    chosen, colour = _sides(sides, found, kind)
    eye = _look(sides, found, chosen, colour) if look is None else Look.checked(*look)
    to_the_eye = sides.outward[chosen] @ eye.axes[2] < 0
    chosen, colour = chosen[to_the_eye], colour[to_the_eye]
    corners, offsets = sides.polygons(chosen)
    shades = np.array([to_rgb(shade) for _, shade in KINDS])
    layer = Layer(
        corners=corners,
        offsets=offsets,
        part=sides.block[chosen],
        colours=shades[colour],
        edge=np.array(to_rgb(EDGE)),
    )
    figure = paper(SIZE, DPI)
    axes = figure.add_subplot()
    axes.axis("off")
    x0, y0, x1, _ = view = frame(eye.flat(corners), MARGIN)
    painter = Painter(look=eye, view=view, width=round(SIZE[0] * DPI), layers=[layer])
    seen = painter.paint(axes)
    if seen is not None:
        _name_blocks(axes, found, kind, seen)
    for number in np.unique(kind).tolist():
        label, shade = KINDS[number]
        required = f" {found.required:g}" if "factor" in label else ""
        label = f"{label}{required}: {int((kind == number).sum())}"
        axes.fill([], [], facecolor=shade, edgecolor=EDGE, lw=0.4, label=label)
    axes.legend(loc="lower left", fontsize=8, frameon=False)
    length = ARROW * (x1 - x0)
    draw_directions(axes, eye.flat, (x1 - 1.5 * length, y0 + 0.8 * length), length)
    named = "; numbers: block and its factor of safety" if (kind >= UNSTABLE).any() else ""
    axes.set_title(f"{title or 'Key blocks'}\n{eye}{named}", loc="left")
    return save(figure, target)


def _kinds(found: KeyBlocks) -> IntArray:
    """Return the number in `KINDS` of every block at a free face."""
    slides = np.where(found.round > 0, UNSTABLE, UNSTABLE - 1)
    modes = (NOT_JUDGED, HELD, STAYS, FALLS)
    kinds: IntArray = np.select([found.mode == mode for mode in modes], [0, 1, 2, len(KINDS) - 1], slides)
    return kinds


def _sides(sides: Sides, found: KeyBlocks, kind: IntArray) -> tuple[IntArray, IntArray]:
    """Return the sides that are drawn, on free faces and all of unstable blocks, and their kinds."""
    of_block = np.full(sides.blocks.count, -1)
    of_block[found.block] = kind
    of_side = of_block[sides.block]
    drawn = (np.isin(sides.face, found.free_faces) & (of_side >= 0)) | (of_side >= UNSTABLE)
    chosen = np.flatnonzero(drawn)
    return chosen, of_side[chosen]


def _look(sides: Sides, found: KeyBlocks, chosen: IntArray, kind: IntArray) -> Look:
    """Return a view on the free faces of the unstable blocks, or else on all free faces."""
    free = np.isin(sides.face[chosen], found.free_faces)
    unstable = free & (kind >= UNSTABLE)
    return Look.along(-sides.outward[chosen[unstable if unstable.any() else free]].sum(axis=0))


def _name_blocks(axes: Any, found: KeyBlocks, kind: IntArray, seen: Seen) -> None:
    """Ring and name the unstable blocks where they are seen, the largest first; slivers are not named."""
    block, middles, _ = seen.middles()
    rows = np.flatnonzero((kind >= UNSTABLE) & ~found.sliver & np.isin(found.block, block))
    rows = rows[np.argsort(-found.volume[rows])][:MAX_NAMED]
    for (x, y), row in zip(middles[np.searchsorted(block, found.block[rows])], rows, strict=True):
        factor = f" {found.factor[row]:.2f}" if found.mode[row] != FALLS else ""
        text = f"{found.block[row]}{factor}"
        place = {"xytext": (8, 8), "textcoords": "offset points", "zorder": 5}
        axes.annotate(text, (x, y), fontsize=8, color=TEXT, **place)
        axes.plot([x], [y], "o", ms=14, mfc="none", mec=TEXT, mew=1.0, zorder=5)
