"""Marks over blocks: every unstable block, supports, loads, gravity, water table, bolts, numbers of blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import counted, numbered
from bsm_mesh.movements import lengths, translations
from bsm_mesh.pictures.canvas import BOLTS, FALLS, WATER, Sheet, middle
from bsm_mesh.pictures.figures import TEXT
from bsm_mesh.pictures.scene import Scene
from bsm_mesh.results.bolts import BoltStatus
from bsm_mesh.text.tables import engineering, weights

MOST_RINGS = 6  # groups of blocks that are ringed and named: the largest
MOST_SUPPORTS, MOST_LOADS = 500, 300  # marks in the visible part, were they spread over all of it
LEAST_RING = 0.018  # of the visible part: radius of the ring round a flake
WIDEST_RING = 0.3  # of the visible part: a larger one would hide more than it shows
# Of a name from its ring, in points: the first at which it meets no other.
NAME_PLACES = ((28, 24), (28, 64), (28, -24), (90, 24), (90, 64), (150, 24), (28, -64), (90, -64))
LEADER_POINTS = 12  # at which a line from a ring to its name is looked at
NAME_MARGIN = 5  # pixels
LONGEST_LOAD = 0.06  # of the visible part
LEAST_LOAD = 1e-6  # of the greatest: smaller ones are rounding
ROUNDING = 1e-12  # of the greatest weight or load: the rest of a block's loads but for its weight and water
ROOM_FOR_NUMBER = 0.022  # of the visible part: size of a block whose number can be read
ENOUGH = 600  # blocks; the numbers of more are too many
OF_LOADS = "#8a1c1c"
GRAVITY = 0.03  # of the visible part: length of its arrow


def add_gone(sheet: Sheet, factor: float = 0.0, *, note: str = "") -> str:
    """Draw the blocks that have gone, ring and name them, and return what to say of them.

    They are drawn at `factor` times their displacement, fallen blocks in the initial position. Blocks too small to
    count (`falls.ignore_below`) have no ring. `note` ends the text.
    """
    scene, stage = sheet.scene, sheet.scene.stage
    x0, y0, x1, y1 = scene.view
    centre = middle(scene, np.arange(scene.results.blocks.count), factor)
    out = ~((centre > (x0, y0)) & (centre < (x1, y1))).all(axis=1)
    told = []
    taken, counts = np.zeros_like(scene.down), np.ones_like(scene.down)
    taken[[fall.block for fall in stage.falls]] = True
    chips = [fall.block for fall in stage.falls if fall.ignored]
    counts[[*chips, *stage.small_blocks.tolist()]] = False
    for mask, colour, style, what in (
        (scene.down, FALLS, "-", "falling"),
        (scene.apart & ~scene.down, "#f0b27a", "-", "at rest after large displacement"),
        (taken, "none", "--", "removed after the fall"),
    ):
        blocks = np.flatnonzero(mask)
        if not len(blocks):
            continue
        hatch = "////" if colour == FALLS else None
        look = {"facecolors": colour, "edgecolors": "black", "linewidths": 0.9, "linestyles": style, "hatch": hatch}
        here, given = np.flatnonzero(mask & ~out & ~taken), np.flatnonzero(mask & (out | taken))
        for those, drawn in ((here, factor), (given, 0.0)):
            if len(those):
                sheet.blocks(those, drawn, **look, zorder=2.4)
                those = those[counts[those]]
                add_rings(sheet, those, middle(scene, those, drawn))
        sheet.explain_patch(what, facecolor=colour, edgecolor="black", linestyle=style, hatch=hatch)
        beyond = (
            ", outside the picture, drawn in the initial position" if factor and (out & mask & ~taken).any() else ""
        )
        if counts[blocks].any():
            told.append(f"{numbered('block', blocks[counts[blocks]], 6)} {what}{beyond}")
    told += [f"{counted(len(chips), 'fragment')} too small to count removed"] * bool(chips)
    return "; ".join(["", *told, *([note] if note else [])]) if told else ""


def add_excluded(sheet: Sheet) -> str:
    """Draw the blocks that have gone in a picture with a colour scale: they are in none of its colours."""
    return add_gone(sheet, note="excluded from the colour scale")


def add_rings(sheet: Sheet, blocks: IntArray, centre: FloatArray) -> None:
    """Draw a ring round each group of blocks that lie together, and name it; `centre` (k, 2) [m] is where they are."""
    scene = sheet.scene
    given = scene.results.blocks
    bulk = given.moments.bulk
    radius = np.maximum(0.9 * given.moments.size[blocks], LEAST_RING * scene.size)
    groups = [np.flatnonzero(mine) for mine in _together(centre, radius)]
    groups.sort(key=lambda group: -float(bulk[blocks[group]].sum()))
    weight = _weight(scene)
    for group in groups[:MOST_RINGS]:
        low, high = (centre[group] - radius[group, None]).min(axis=0), (centre[group] + radius[group, None]).max(axis=0)
        at, across = (low + high) / 2, float((high - low).max())
        if across > WIDEST_RING * scene.size:  # so many are seen without a ring; the largest of them is pointed at
            at, across = centre[group[bulk[blocks[group]].argmax()]], 0.0
        total = bulk[blocks[group]].sum()
        text = f"{numbered('block', blocks[group], 6)}\n{total:.3g} {given.bulk_unit}"
        text += f", {engineering(float(weight[blocks[group]].sum()), given.force_unit)}" if weight.any() else ""
        add_name(sheet, at, text, FALLS, NAME_PLACES, across=across)


def add_name(
    sheet: Sheet,
    at: FloatArray,
    text: str,
    colour: str,
    places: Sequence[tuple[float, float]],
    *,
    across: float = 0.0,
    leftwards: float = 0.7,
) -> None:
    """Write a name near a point within the picture, where it hides no other name, ring, line to a name, or title.

    Parameters
    ----------
    sheet : Sheet
        The picture.
    at : (2,) float64 [m]
        The point.
    text, colour : str
        The name, and the colour of its frame.
    places : sequence of (right, up)
        Of a name from its point, in points; the first within the frame at which it meets no other is taken, then
        the first outside, or the last.
    across : float [m]
        Diameter of a ring round the point; 0: none.
    leftwards : float
        Part of the picture's width beyond which names stand to the left.
    """
    from matplotlib.patches import Circle
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

    x0, y0, x1, y1 = sheet.scene.view
    part = (at - (x0, y0)) / (x1 - x0, y1 - y0)
    if not ((part > 0) & (part < 1)).all():
        return
    if across > 0:
        sheet.axes.add_patch(Circle(tuple(at), across / 2, fill=False, edgecolor=colour, linewidth=2.0, zorder=5))
    side, up = (-1 if part[0] > leftwards else 1), (-1 if part[1] > 0.75 else 1)
    edge = at + across / 2 * np.array([0.7 * side, 0.7 * up])
    sheet.axes.apply_aspect()  # the frame is as large as the picture leaves it
    frame = sheet.axes.get_window_extent()
    for within, (right, above) in [(True, place) for place in places] + [(False, place) for place in places]:
        name = sheet.axes.annotate(
            text,
            xy=tuple(edge),
            xytext=(right * side, above * up),
            textcoords="offset points",
            ha="left" if side > 0 else "right",
            va="center",
            fontsize=9,
            color=TEXT,
            zorder=6,
            parse_math=False,
            bbox={"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": colour, "alpha": 0.92},
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 1.2},
        )
        name.get_window_extent()  # puts it where it belongs
        framed = Text.get_window_extent(name)
        box = framed.padded(NAME_MARGIN)
        start, end = sheet.axes.transData.transform(edge), np.array([(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2])
        line = [start + along * (end - start) for along in np.linspace(0.0, 1.0, LEADER_POINTS)]
        mine = [box, *(Bbox([point, point]).padded(1) for point in line)]
        outside = framed.y0 < frame.y0 or framed.y1 > frame.y1  # over a title or labels of an axis
        is_free = not any(new.overlaps(old) for new in mine for old in sheet.names) and not (within and outside)
        if is_free or (not within and (right, above) == places[-1]):
            ring = Bbox(sheet.axes.transData.transform([at - across / 2, at + across / 2]))
            sheet.names += [*mine, ring]
            return
        name.remove()


def _together(centre: FloatArray, radius: FloatArray) -> list[BoolArray]:
    """Return which circles overlap each other, directly or by others, a mask a group."""
    from scipy.sparse.csgraph import connected_components

    if len(centre) > ENOUGH:
        return []
    apart = np.hypot(*(centre[:, None] - centre[None, :]).transpose(2, 0, 1))
    count, group = connected_components(apart < radius[:, None] + radius[None, :], directed=False)
    return [group == number for number in range(count)]


def _weight(scene: Scene) -> FloatArray:
    """Return the weight of every block, (n,) [N/m], in space [N]."""
    weight = weights(scene.results, scene.stage)
    for fall in scene.stage.falls:  # they are there no more
        weight[fall.block] = fall.weight
    return weight


def add_supports(sheet: Sheet) -> None:
    """Draw where supports hold the blocks: a triangle where in all directions, a circle where in some."""
    evidence, scene = sheet.scene.stage.evidence, sheet.scene
    if evidence is None or not len(evidence.bar_block) or not sheet.shows_outside:
        return
    points, of_point = np.unique(evidence.bar_point.round(9), axis=0, return_inverse=True)
    along = np.zeros(points.shape)
    np.maximum.at(along, of_point.reshape(-1), np.abs(evidence.bar_direction))
    both = (along > 0.1).all(axis=1)
    chosen = scene.spread(scene.flat(points), MOST_SUPPORTS)
    for mask, label, style in (
        (both, "fixed", {"marker": "^", "markersize": 7, "color": TEXT}),
        (
            ~both,
            "fixed in one direction" if scene.is_plane else "fixed in some directions",
            {"marker": "o", "markersize": 5, "color": TEXT, "markerfacecolor": "white"},
        ),
    ):
        mine = chosen[np.asarray(mask)[chosen]]
        if len(mine):
            sheet.points(points[mine], **style)
            sheet.explain(label, linestyle="none", **style)


def add_loads(sheet: Sheet) -> None:
    """Draw the loads on the blocks, but weight and water, as arrows that end at the blocks' faces.

    They are thinned where they are crowded; the key says how large the greatest is.
    """
    scene, stage = sheet.scene, sheet.scene.stage
    if stage.evidence is None:
        return
    applied = translations(stage.loads) - translations(stage.water) - stage.evidence.weight
    size = lengths(applied)
    greatest = float(size[scene.shown].max(initial=0.0))
    if greatest <= ROUNDING * float(np.abs(translations(stage.loads)).max(initial=0.0)):
        return
    given, blocks = scene.results.blocks, scene.shown[size[scene.shown] > LEAST_LOAD * greatest]
    sense = scene.flat(applied[blocks] / size[blocks, None])
    at = middle(scene, blocks) - 0.5 * given.moments.size[blocks][:, None] * sense
    chosen = scene.spread(at, MOST_LOADS)
    vector = scene.flat(applied[blocks[chosen]]) * (LONGEST_LOAD * scene.size / greatest)
    arrows(sheet, at[chosen] - vector, vector, OF_LOADS)
    sheet.explain(
        f"loads, greatest {engineering(greatest, given.force_unit)}", color=OF_LOADS, marker=">", linewidth=1.5
    )


def arrows(sheet: Sheet, tail: FloatArray, vector: FloatArray, colour: Any, **style: Any) -> Any:
    """Draw arrows (k, 2) from their tails, true to scale in metres, and return them."""
    given = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.0022, "zorder": 4, **style}
    values = () if isinstance(colour, str) else (colour,)
    colours = {"color": colour} if isinstance(colour, str) else {}
    return sheet.axes.quiver(*tail.T, *vector.T, *values, **colours, **given)


def add_gravity(sheet: Sheet) -> None:
    """Draw the direction of gravity in the upper left corner."""
    evidence = sheet.scene.stage.evidence
    if not sheet.scene.is_plane:  # it has a direction of its own in the picture
        return
    pull = np.zeros(2) if evidence is None else evidence.weight.sum(axis=0)
    if not pull.any():
        return
    x0, _, _, y1 = sheet.scene.view
    sense = pull / np.hypot(*pull)
    length = GRAVITY * sheet.scene.size
    at = np.array([x0 + 0.6 * length, y1 - 1.6 * length])
    arrows(sheet, (at - length / 2 * sense)[None], (length * sense)[None], TEXT, width=0.003, zorder=7)
    sheet.axes.text(*(at - length * sense), "g", fontsize=10, color=TEXT, ha="center", va="center", zorder=7)


def add_water_table(sheet: Sheet) -> None:
    """Draw the water table."""
    table = sheet.scene.stage.water_table
    if len(table):
        sheet.lines(table, colors=WATER, linewidths=2.2, zorder=3)
        sheet.explain("water table", color=WATER, linewidth=2.2)


def add_bolts(sheet: Sheet) -> None:
    """Draw the bolts that are there, with their heads."""
    ends, _ = bolt_lines(sheet.scene)
    if not len(ends):
        return
    sheet.lines(ends, colors=BOLTS, linewidths=2.2, zorder=4)
    add_heads(sheet)
    head = {"marker": "o", "markersize": 4, "markerfacecolor": TEXT, "markeredgecolor": TEXT}
    sheet.explain("bolt with head", color=BOLTS, linewidth=2.2, **head)


def add_heads(sheet: Sheet) -> None:
    """Draw the heads of the bolts as dots, and bolts that lie in a single block as crosses."""
    bolts = sheet.scene.stage.bolts
    place, of_alone = sheet.scene.flat(bolts.original[bolts.node_start[:-1]]), {"marker": "x", "color": TEXT}
    heads = (bolts.status != BoltStatus.ABSENT) & ~bolts.alone
    sheet.axes.plot(*place[heads].T, linestyle="none", marker="o", markersize=4, color=TEXT, zorder=5)
    if bolts.alone.any():
        sheet.axes.plot(*place[bolts.alone].T, linestyle="none", markersize=5, zorder=5, **of_alone)
        sheet.explain("bolt in a single block, without effect", linestyle="none", markersize=5, **of_alone)


def bolt_lines(scene: Scene) -> tuple[FloatArray, IntArray]:
    """Return both ends of the elements that are there, as they are seen, (k, 2, 2) [m], and their numbers."""
    bolts = scene.stage.bolts
    element = np.flatnonzero(bolts.alive)
    first = bolts.first_node[element]
    seen = scene.flat(bolts.original)
    return np.stack([seen[first], seen[first + 1]], axis=1), element


def add_numbers(sheet: Sheet) -> bool:
    """Write the numbers of the blocks in which they can be read; return whether there are any."""
    return len(sheet.scene.shown) <= ENOUGH and sheet.numbers(ROOM_FOR_NUMBER)


def told_count(sheet: Sheet) -> str:
    """Return how many blocks are there, and how many of them are seen."""
    scene = sheet.scene
    seen = "" if len(scene.shown) == len(scene.here) else f", {len(scene.shown)} of them seen"
    return f"{counted(len(scene.here), 'block')}{seen}"
