"""How pictures of blocks look: the sheet, its axes and colours, scale and key; and numbers with their prefix."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.movements import translations
from bsm_mesh.pictures.figures import TEXT, entitle, paper
from bsm_mesh.pictures.scene import Scene
from bsm_mesh.text.tables import engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 1400  # pixels
DPI = 100
TALLEST, NARROWEST = 11.0, 8.0  # inches
ABOVE, BESIDE = 1.5, 1.7  # inches for title and key, and for ticks and the scale of colours
LETTERS = 11.0  # of the title in an inch

# Told apart by all eyes (Okabe and Ito); pale ones behind lines.
FALLS, SLIPS, OPENS, HOLDS, WATER, BOLTS = "#d55e00", "#e69f00", "#0072b2", "#9a9a9a", "#56b4e9", "#006d4e"
SETS = ("#222222", "#0072b2", "#cc79a7", "#009e73", "#8a5a00", "#882255")
ROCKS = ("#f4f1ea", "#dcd3bf", "#dfe7ee", "#ece0ea", "#dcebdf", "#cfcfcf")
NUMBER: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7, "color": "#6b6b6b", "zorder": 2.5}
LINE, FAINT = "#555555", "#c9c3b4"
MOVED, OUTLINE, GIVEN = "#c9d8ea", "#33475b", "#b9b2a3"  # blocks where they are, over where they were given


@dataclass(eq=False, kw_only=True)
class Sheet:
    """A picture under way.

    Attributes
    ----------
    figure, axes
        Of Matplotlib.
    scene : Scene
        The scene that is drawn.
    key : list
        Entries of the key below the picture.
    names : list
        Boxes of names in the picture, of their rings and of the lines between, which others keep clear of [pixels].
    """

    figure: Figure
    axes: Any
    scene: Scene
    key: list[Any] = field(default_factory=list)
    names: list[Any] = field(default_factory=list)

    def polygons(self, outlines: list[FloatArray], **style: Any) -> Any:
        """Add polygons, and return their collection."""
        from matplotlib.collections import PolyCollection

        return self.axes.add_collection(PolyCollection(outlines, **style), autolim=False)

    def blocks(self, blocks: IntArray, factor: float = 0.0, **style: Any) -> Any:
        """Add blocks (k,), moved by so many times their displacement, and return their collection."""
        return self.polygons(self.scene.polygons(blocks, factor), **style)

    def outline(self, factor: float = 0.0, **style: Any) -> None:
        """Add the outline of the body, its blocks moved by so many times their displacement."""
        self.lines(self.scene.outline(factor), **style)

    def points(self, points: FloatArray, **style: Any) -> None:
        """Add marks at points (k, 2) [m]."""
        self.axes.plot(*points.T, linestyle="none", clip_on=False, zorder=4, **style)

    @property
    def shows_outside(self) -> bool:
        """Whether what lies on the outer faces is seen."""
        return True

    def faces(self, chosen: IntArray, factor: float = 0.0, *, widths: FloatArray | float, **style: Any) -> Any:
        """Add joint faces (k,), moved by so many times their displacement, as lines of widths in points."""
        return self.lines(self.scene.face_lines(factor)[chosen], linewidths=widths, **style)

    def background(self, factor: float = 0.0) -> None:
        """Add the blocks behind joint faces."""
        add_paper(self, factor)

    def numbers(self, room: float) -> bool:
        """Write numbers of blocks larger than a part of the visible one; return whether there are any."""
        scene, moments = self.scene, self.scene.results.blocks.moments
        wide = moments.size[scene.shown] > room * scene.size
        blocks = scene.shown[wide & ~scene.apart[scene.shown]]
        x0, y0, x1, y1 = scene.view
        for block, (x, y) in zip(blocks.tolist(), moments.centroid[blocks].tolist(), strict=True):
            if x0 < x < x1 and y0 < y < y1:
                self.axes.text(x, y, str(block), **NUMBER)
        return bool(len(blocks))

    def complete(self) -> str:
        """Draw what waits until all is known, and return what to say of it in the caption."""
        return ""

    def lines(self, ends: FloatArray, **style: Any) -> Any:
        """Add straight lines (k, 2, 2), and return their collection."""
        from matplotlib.collections import LineCollection

        return self.axes.add_collection(LineCollection(list(ends), **style), autolim=False)

    def explain(self, label: str, **style: Any) -> None:
        """Add a line or a mark to the key."""
        from matplotlib.lines import Line2D

        self.key.append(Line2D([], [], label=label, **style))

    def explain_patch(self, label: str, **style: Any) -> None:
        """Add a patch of a colour to the key."""
        from matplotlib.patches import Patch

        self.key.append(Patch(label=label, **style))

    def scale(self, mapped: Any, title: str) -> None:
        """Add the scale of colours of a collection."""
        bar = self.figure.colorbar(mapped, ax=self.axes, fraction=0.03, pad=0.015, aspect=30)
        bar.set_label(title, fontsize=10)
        bar.ax.tick_params(labelsize=9)
        bar.outline.set_visible(False)


def empty_axes(scene: Scene, figure: Figure | None, place: tuple[int, int, int]) -> tuple[Figure, Any]:
    """Return figure and empty axes for a scene, a figure of its own where none is given."""
    x0, y0, x1, y1 = scene.view
    if figure is None:
        figure = paper(_paper_size((y1 - y0) / (x1 - x0)), DPI)
        room: Any = figure.get_layout_engine()
        room.set(h_pad=0.08)  # inches: title and caption do not touch
    axes = figure.add_subplot(*place)
    axes.set_aspect("equal")
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)
    axes.set_xlabel("x, m", fontsize=9)
    axes.set_ylabel("y, m", fontsize=9)
    axes.tick_params(labelsize=9, color="#999999")
    axes.set_axisbelow(True)
    return figure, axes


def finish(sheet: Sheet, caption: str) -> Figure:
    """Write title, caption and key, and return the figure."""
    caption += sheet.complete()
    width = int(LETTERS * (sheet.figure.get_figwidth() - BESIDE))
    told = "\n".join(textwrap.wrap(caption, int(1.25 * width)))
    entitle(sheet.figure, sheet.scene.title)
    sheet.axes.set_title(told, loc="left", fontsize=10, color=TEXT, parse_math=False)
    add_key(sheet.figure, sheet.key)
    return sheet.figure


def add_key(figure: Figure, key: list[Any]) -> None:
    """Write a key below the picture, where anything is to be explained."""
    if key:
        columns = min(len(key), max(2, int(figure.get_figwidth() / 2.3)))
        figure.legend(handles=key, loc="outside lower center", ncols=columns, fontsize=9, frameon=False)


def _paper_size(aspect: float) -> tuple[float, float]:
    """Return width and height of the paper for a view of so many times its width [in]."""
    width = WIDTH / DPI
    height = (width - BESIDE) * aspect + ABOVE
    if height > TALLEST:
        height = TALLEST
        width = max((height - ABOVE) / aspect + BESIDE, NARROWEST)
    return width, height


def prefixed_unit(values: FloatArray, unit: str) -> tuple[float, str]:
    """Return by what values are divided for an SI prefix that suits their greatest magnitude, and the unit with it."""
    greatest = float(np.abs(np.nan_to_num(values)).max(initial=0.0))
    _, _, prefixed = engineering(greatest, unit).partition(" ")
    factor = {"G": 1e9, "M": 1e6, "k": 1e3, "m": 1e-3, "u": 1e-6}.get(prefixed[: -len(unit)], 1.0)
    return factor, prefixed


def scaled(values: FloatArray, unit: str) -> tuple[FloatArray, str]:
    """Return values with an SI prefix that suits their greatest magnitude, and the unit with it."""
    factor, prefixed = prefixed_unit(values, unit)
    return values / factor, prefixed


def limits(values: FloatArray) -> tuple[tuple[float, float], str]:
    """Return the ends of the colour scale, and what to say where a few outliers lie beyond them."""
    if not len(values):
        return (0.0, 1.0), ""
    least, low, high, greatest = np.percentile(values, [0, 1, 99, 100])
    if greatest - least <= 2 * (high - low) or high == low:
        return (float(least), float(greatest)), ""
    return (float(low), float(high)), "; colours end at the 1st and 99th percentile"


def add_blocks(sheet: Sheet, values: FloatArray, title: str, colours: str, among: BoolArray | None = None) -> str:
    """Draw the blocks that stay, or those `among` (n,), by a value (n,); return what to say of the scale's ends."""
    scene = sheet.scene
    chosen = scene.shown[(~scene.apart if among is None else among)[scene.shown]]
    (low, high), remark = limits(values[chosen])
    drawn = sheet.blocks(
        chosen,
        array=values[chosen],
        cmap=colours,
        edgecolors=LINE if scene.outlines_seen else "face",
        linewidths=0.3,
        antialiaseds=scene.outlines_seen,
    )
    drawn.set_clim(low, high)
    sheet.scale(drawn, title)
    return remark


def add_paper(sheet: Sheet, factor: float = 0.0, *, rocks: bool = False) -> None:
    """Draw the blocks as a light background with their outlines; by their rock, with a key, where asked."""
    scene, blocks = sheet.scene, sheet.scene.results.blocks
    chosen = scene.shown[~scene.apart[scene.shown]]
    rock = blocks.rock[chosen] if rocks else np.zeros(len(chosen), np.int32)
    colours = np.array(ROCKS, dtype=object)[rock % len(ROCKS)]
    edges = {"edgecolors": FAINT if scene.outlines_seen else "face", "linewidths": 0.4}
    sheet.blocks(chosen, factor, facecolors=list(colours), **edges)
    if rocks:
        for number in np.unique(rock).tolist():
            sheet.explain_patch(blocks.rock_names[number], facecolor=ROCKS[number % len(ROCKS)], edgecolor=FAINT)
    add_outline(sheet, factor)


def add_outline(sheet: Sheet, factor: float = 0.0) -> None:
    """Draw the outline of the body."""
    sheet.outline(factor, colors="black", linewidths=1.2)


def add_joints(sheet: Sheet, factor: float = 0.0, *, sets: bool = False) -> None:
    """Draw the joints as thin lines; by their set, with a key, where asked. In space they are edges of the blocks."""
    scene = sheet.scene
    if not scene.is_plane:
        return
    faces, names = scene.faces, scene.results.joint_names
    chosen = (faces.joint >= 0) & ~gone(scene)
    lines, joint = scene.face_lines(factor)[chosen], faces.joint[chosen]
    if not sets:
        sheet.lines(lines, colors=TEXT, linewidths=0.8)
        return
    for number in np.unique(joint).tolist():
        style = {"color": SETS[number % len(SETS)], "linewidth": 1.2}
        sheet.lines(lines[joint == number], **style)
        sheet.explain(f"joint {names[number]}", **style)


def gone(scene: Scene) -> Any:
    """Return which faces are of unstable blocks, or of blocks too small to count that moved far, (k,) bool."""
    return (scene.down | scene.strays)[scene.face_pairs].any(axis=1)


def middle(scene: Scene, blocks: IntArray, factor: float = 0.0) -> FloatArray:
    """Return the centroids of blocks, moved by so many times their displacement, as they are seen, (k, 2) [m]."""
    centre = scene.results.blocks.moments.centroid[blocks] + factor * translations(scene.stage.displacement[blocks])
    return scene.flat(centre)
