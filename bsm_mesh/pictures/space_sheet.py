"""A picture of blocks in space under way: their sides painted, marks that faces hide, scale and directions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.pictures.canvas import DPI, FAINT, GIVEN, LINE, NUMBER, Sheet
from bsm_mesh.pictures.figures import TEXT
from bsm_mesh.pictures.painter import Layer, Painter, Seen
from bsm_mesh.pictures.space_scene import SpaceScene
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.text.exaggeration import round_factor
from bsm_mesh.text.tables import engineering
from bsm_mesh.three_d.blocks.polygons import vector_areas

EDGE = "#6f6a60"
BAR = 0.2  # of the view's width: greatest length of the scale
ARROW = 0.06  # of the view's width: a direction that lies in the picture
SHORT = 0.25  # of it: a shorter one has no name
DIRECTIONS = (("E", (1.0, 0.0, 0.0)), ("N", (0.0, 1.0, 0.0)), ("up", (0.0, 0.0, 1.0)))


@dataclass(eq=False, kw_only=True)
class _Painted:
    """Faces with a colour that may depend on a scale, whose ends are known when all is drawn."""

    corners: FloatArray
    offsets: IntArray
    part: IntArray
    colours: Any
    edge: str | None
    hatched: bool = False


@dataclass(eq=False, kw_only=True)
class SpaceSheet(Sheet):
    """A picture of blocks in space."""

    scene: SpaceScene
    painted: list[_Painted] = field(default_factory=list)
    marks: list[tuple[FloatArray, dict[str, Any]]] = field(default_factory=list)
    ghost: bool = False
    room_for_number: float = np.inf

    def blocks(self, blocks: IntArray, factor: float = 0.0, **style: Any) -> Any:
        """Paint blocks (k,), moved by so many times their displacement; style as of a collection of Matplotlib.

        Returns the scale of their colours where they have an ``array`` of values.
        """
        sides, faces = self.scene.sides_of(blocks, factor), style.get("facecolors")
        if isinstance(faces, str) and faces == "none":
            self._draw_edges(blocks, style)
            return None
        mapped, row = _mapped(style), np.zeros(self.scene.results.blocks.count, dtype=np.int64)
        row[blocks] = np.arange(len(blocks))
        edge = style.get("edgecolors", LINE)
        of = row[self.scene.sides.block[sides]]
        colours = (mapped, style["array"][of]) if mapped else faces if isinstance(faces, str) else np.array(faces)[of]
        movement = factor * self.scene.stage.displacement if factor else None
        corners, offsets = self.scene.sides.polygons(sides, movement)
        kept = vector_areas(corners, offsets) @ self.scene.eye.axes[2] < 0  # those that turn to the viewer
        if not isinstance(colours, str):
            colours = (mapped, colours[1][kept]) if mapped else colours[kept]
        self.painted.append(
            _Painted(
                corners=corners[np.repeat(kept, np.diff(offsets))],
                offsets=np.concatenate([[0], np.cumsum(np.diff(offsets)[kept])]),
                part=self.scene.sides.block[sides[kept]],
                colours=colours,
                edge={"face": None, FAINT: EDGE}.get(edge, edge),  # faint ones are lost on shaded faces
                hatched=bool(style.get("hatch")),
            )
        )
        return mapped

    def _draw_edges(self, blocks: IntArray, style: dict[str, Any]) -> None:
        """Draw the edges of blocks as given over all that is painted."""
        scene = self.scene
        chosen = np.zeros(scene.results.blocks.count, dtype=np.bool_)
        chosen[blocks] = True
        ends = scene.edges(np.flatnonzero(scene.sides.bare(chosen)))
        look = {"colors": style["edgecolors"], "linewidths": style.get("linewidths", 1.0)}
        self.lines(ends, linestyles=style.get("linestyles", "-"), zorder=style.get("zorder", 1), **look)

    def outline(self, factor: float = 0.0, **style: Any) -> None:
        """Add the edges of the body as given: faint ones where outer faces are cut away, or as a style says."""
        self.ghost = self.ghost or self.scene.cut
        if style.get("linestyles"):  # where the blocks were, over where they are
            self.lines(self.scene.body, **style)

    @property
    def shows_outside(self) -> bool:
        """Whether what lies on the outer faces is seen."""
        return not (self.ghost or self.scene.cut)

    def points(self, points: FloatArray, **style: Any) -> None:
        """Add marks at points (k, 3) [m], where no face hides them."""
        self.marks.append((points, style))

    def background(self, factor: float = 0.0) -> None:
        """Add the edges of the body alone: blocks would hide what lies between them."""
        self.ghost = True

    def faces(self, chosen: IntArray, factor: float = 0.0, *, widths: FloatArray | float, **style: Any) -> Any:
        """Paint contact polygons (k,) of the stage; their own width shows how large they are."""
        blocks: Any = self.scene.results.blocks
        polygons = blocks.contact_polygons.some(self.scene.faces.polygon[chosen])
        block = np.repeat(polygons.block_b, np.diff(polygons.offsets))
        moved = displacement_of(blocks, factor * self.scene.stage.displacement, block, polygons.corners)
        mapped = _mapped(style)
        self.painted.append(
            _Painted(
                corners=polygons.corners + moved,
                offsets=polygons.offsets,
                part=blocks.count + chosen,
                colours=(mapped, style["array"]) if mapped else style["colors"],
                edge=LINE,
            )
        )
        return mapped

    def numbers(self, room: float) -> bool:
        """Write numbers of blocks of which more is seen than a part of the picture; return whether there may be any."""
        self.room_for_number = room
        return True

    def complete(self) -> str:
        """Paint all, and return from where it is seen."""
        scene = self.scene
        layers = [_layer(one) for one in self.painted if len(one.part)]
        width = round(self.figure.get_figwidth() * DPI * 0.9)
        seen = Painter(look=scene.eye, view=scene.view, width=width, layers=layers).paint(self.axes)
        x0, y0, x1, y1 = scene.view
        self.axes.set(xlim=(x0, x1), ylim=(y0, y1), xticks=[], yticks=[], xlabel="", ylabel="")
        if self.ghost:
            self.lines(scene.body, colors=GIVEN, linewidths=0.8, zorder=1)
        for points, style in self.marks:
            place = scene.flat(points)
            clear = slice(None) if seen is None else seen.in_front(place, scene.eye.distance(points))
            self.axes.plot(*place[clear].T, linestyle="none", zorder=4, **style)
        if seen is not None and np.isfinite(self.room_for_number):
            self._write_numbers(seen)
        self._draw_scale()
        self._draw_directions()
        cut = ", outer faces cut away" if scene.cut else ""
        return f"; {scene.eye}{cut}"

    def _write_numbers(self, seen: Seen) -> None:
        block, middle, size = seen.middles()
        large = size > self.room_for_number * self.scene.size
        large[large] = ~self.scene.apart[block[large]]
        for number, (x, y) in zip(block[large].tolist(), middle[large].tolist(), strict=True):
            self.axes.text(x, y, str(number), **NUMBER)

    def _draw_scale(self) -> None:
        """Draw a length at the lower right; without perspective it holds for all that lies across the view."""
        x0, y0, x1, _ = self.scene.view
        length = round_factor(BAR * (x1 - x0))
        right, low = x1 - 0.02 * (x1 - x0), y0 + 0.03 * (x1 - x0)
        self.axes.plot([right - length, right], [low, low], color=TEXT, linewidth=2.5, solid_capstyle="butt", zorder=6)
        text = engineering(length, "m")
        self.axes.annotate(
            text, (right - length / 2, low), xytext=(0, 4), textcoords="offset points", ha="center", va="bottom",
            fontsize=9, color=TEXT, zorder=6,
        )  # fmt: skip

    def _draw_directions(self) -> None:
        """Draw east, north and up at the lower left, as they are seen."""
        x0, y0, x1, _ = self.scene.view
        length = ARROW * (x1 - x0)
        draw_directions(self.axes, self.scene.flat, (x0 + 1.3 * length, y0 + 1.3 * length), length)


def draw_directions(
    axes: Any, flat: Callable[[FloatArray], FloatArray], at: tuple[float, float], length: float
) -> None:
    """Draw east, north and up as `flat` sees them, from a point; one that lies in the picture is so long [m]."""
    for name, vector in DIRECTIONS:
        end = length * flat(np.array([vector]))[0]
        if np.hypot(*end) < SHORT * length:
            continue
        style = {"arrowstyle": "-|>", "color": TEXT, "lw": 1.3}
        axes.annotate("", tuple(at + end), at, zorder=6, arrowprops=style)
        axes.text(*(at + 1.25 * end), name, fontsize=9, color=TEXT, ha="center", va="center", zorder=6)


def _mapped(style: dict[str, Any]) -> Any:
    """Return the scale of colours for the values of a style, or None."""
    if style.get("array") is None:
        return None
    from matplotlib.cm import ScalarMappable

    mapped = ScalarMappable(cmap=style["cmap"])
    mapped.set_array(style["array"])
    return mapped


def _layer(one: _Painted) -> Layer:
    """Return faces with the colours that they have by the scale as it is now."""
    from matplotlib.colors import to_rgb, to_rgba_array

    mapped = isinstance(one.colours, tuple)
    colours = one.colours[0].to_rgba(one.colours[1]) if mapped else to_rgba_array(one.colours)
    return Layer(
        corners=one.corners,
        offsets=one.offsets,
        part=one.part,
        colours=np.broadcast_to(colours[:, :3], (len(one.part), 3)),
        edge=None if one.edge is None else np.array(to_rgb(one.edge)),
        hatched=one.hatched,
    )
