"""``python examples/pictures/method.py`` draws the picture of the method, docs/method.png, and those of the theory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection

from bsm_mesh.pictures.canvas import BOLTS, FALLS, HOLDS, OPENS, ROCKS, SLIPS
from bsm_mesh.pictures.figures import TEXT, paper, save

DOCS = Path(__file__).parents[2] / "docs"
DARK, DIMENSION = "#8a5a00", "#777777"
LEFT = np.array([(0, 0), (2.1, 0), (1.7, 1.9), (0, 1.6)])
RIGHT = np.array([(2.25, 0), (4.2, 0), (4.2, 1.5), (1.85, 1.9)])
TOP = np.array([(0, 1.75), (1.72, 2.06), (4.2, 1.65), (4.2, 3.2), (0, 3.2)])
NO_ARROW = {"arrowstyle": "-", "color": "#888888"}


def main() -> None:
    """Draw the method, a contact, corners, a bolt and the loop of a run."""
    _row("method", (14.0, 4.6), (1.25, 1.0, 1.0), _draw_blocks, _draw_contact, _draw_law)
    _row("theory_contact", (10.5, 3.8), (1.3, 1.0), _draw_face, _draw_series)
    _row("theory_corner", (14.0, 4.6), (1.0, 1.0, 1.0), _draw_wedge, _draw_node, _draw_straight_edge)
    _row("theory_bolt", (14.0, 4.6), (1.5, 1.0, 1.0), _draw_bolt, _draw_element_law, _draw_bond_law)
    _row("theory_loop", (11.0, 5.6), (1.0,), _draw_loop)


def _row(name: str, size: tuple[float, float], widths: tuple[float, ...], *panels: Callable[[Any], None]) -> None:
    """Draw panels side by side into a picture of the docs."""
    figure = paper(size, 100)
    for axes, panel in zip(figure.subplots(1, len(panels), width_ratios=widths, squeeze=False)[0], panels, strict=True):
        panel(axes)
    save(figure, DOCS / f"{name}.png")


def _spring(axes: Any, start: np.ndarray, end: np.ndarray, colour: str, turns: int = 5) -> None:
    """Draw a spring between two points."""
    along, length = end - start, float(np.hypot(*(end - start)))
    across = np.array([-along[1], along[0]]) / length
    part = np.linspace(0.15, 0.85, 2 * turns + 1)
    sides = np.where(np.arange(2 * turns + 1) % 2 == 0, 1.0, -1.0) * 0.14 * min(1.0, 3 * length)
    sides[[0, -1]] = 0.0
    points = np.vstack([start, start + part[:, None] * along + sides[:, None] * 0.5 * across, end])
    axes.plot(*points.T, color=colour, linewidth=1.6)


def _title(axes: Any, text: str) -> None:
    axes.set_title(text, loc="left", fontsize=10)


def _rock(axes: Any, *outlines: Any) -> None:
    """Draw blocks by their corners."""
    blocks = [np.array(outline, dtype=float) for outline in outlines]
    axes.add_collection(PolyCollection(blocks, facecolors=ROCKS[0], edgecolors=TEXT, linewidths=1.4))


def _frame(axes: Any, left: float, right: float, bottom: float, top: float) -> None:
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", anchor="N")
    axes.axis("off")


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float], colour: str, style: str = "-|>") -> None:
    axes.annotate("", xy=end, xytext=start, arrowprops={"arrowstyle": style, "color": colour, "linewidth": 1.6})


def _write(axes: Any, x: float, y: float, text: str, colour: str = TEXT, **more: Any) -> None:
    axes.text(x, y, text, color=colour, **{"fontsize": 9, "ha": "center", "va": "center", **more})


def _plain_chart(axes: Any, x: str, y: str) -> None:
    axes.set(xticks=[], yticks=[], xlabel=x, ylabel=y)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _draw_blocks(axes: Any) -> None:
    _rock(axes, LEFT, RIGHT, TOP)
    for name, (x, y) in (("block 0", (0.8, 0.8)), ("block 1", (3.2, 0.7)), ("block 2", (2.0, 2.6))):
        _write(axes, x, y, name, fontsize=11)
    pairs = (((0.15, 1.64), (0.15, 1.78)), ((1.6, 1.87), (1.58, 2.03)), ((1.95, 1.86), (1.97, 2.02)))
    pairs += (((4.05, 1.52), (4.05, 1.68)), ((2.08, 0.1), (2.24, 0.1)), ((1.74, 1.7), (1.89, 1.7)))
    for one, other in pairs:
        axes.plot(*np.array([one, other]).T, color=OPENS, linewidth=4, solid_capstyle="round")
    _arrow(axes, (2.0, 3.75), (2.0, 3.2), "#8a1c1c")
    axes.text(2.1, 3.5, "weights and loads", fontsize=9, va="center")
    axes.plot([0, 4.2], [-0.02, -0.02], color="black", linewidth=3)
    axes.text(2.1, -0.15, "held", fontsize=9, ha="center", va="top")
    _frame(axes, -0.2, 4.4, -0.4, 3.9)
    _title(
        axes, "Rigid blocks; each moves by u, v and a rotation.\nWhere corners lie on edges there are springs (blue)."
    )


def _draw_contact(axes: Any) -> None:
    _rock(axes, [(0, 0), (4, 0), (4, 1.2), (0, 1.2)], [(0.4, 2.2), (4, 2.2), (4, 3.4), (0.4, 3.4)])
    for x in (0.6, 3.6):
        _spring(axes, np.array([x, 1.2]), np.array([x, 2.2]), OPENS)
        _spring(axes, np.array([x, 1.35]), np.array([x - 0.9 if x > 1 else x + 0.9, 1.35]), SLIPS)
    _write(axes, 1.75, 1.95, "normal: rock and joint\nin series", OPENS)
    _write(axes, 2.1, 1.38, "shear", DARK)
    _frame(axes, -0.2, 4.2, -0.3, 3.8)
    _title(
        axes, "A face has two contacts, at the ends of what its\nblocks share. They move along and end as blocks move."
    )


def _draw_law(axes: Any) -> None:
    slip = np.array([0, 1.0, 3.0])
    axes.plot(slip, [0, 1.0, 1.0], color=SLIPS, linewidth=2.2, label="high pressure")
    axes.plot([0, 0.5, 3.0], [0, 0.5, 0.5], color=SLIPS, linewidth=2.2, linestyle="--", label="low pressure")
    axes.annotate("slips: cohesion + pressure x tan(friction)", (1.1, 1.0), (0.35, 1.17), fontsize=9, color=TEXT)
    axes.annotate("sticks: shear stiffness", (0.4, 0.4), (0.62, 0.16), fontsize=9, color=TEXT, arrowprops=NO_ARROW)
    axes.set(xlim=(0, 3), ylim=(0, 1.35))
    _plain_chart(axes, "slip", "shear force")
    axes.legend(fontsize=9, frameon=False, loc="lower right")
    _title(axes, "A joint sticks, slips or opens. Equilibrium of all\nblocks is found, or the unstable blocks.")


def _draw_face(axes: Any) -> None:
    _rock(axes, [(0, 0), (4.6, 0), (4.6, 1.4), (0, 1.4)], [(1.0, 2.2), (5.6, 2.2), (5.6, 3.6), (1.0, 3.6)])
    for x, side in ((1.0, 1.0), (4.6, -1.0)):
        _spring(axes, np.array([x, 1.4]), np.array([x, 2.2]), OPENS)
        _spring(axes, np.array([x, 1.55]), np.array([x + 0.9 * side, 1.55]), SLIPS)
    for x, y, name, foot in ((2.3, 0.7, "h_b", 1.4), (3.3, 2.9, "h_a", 2.2)):
        axes.plot(x, y, "o", color=TEXT, markersize=4)
        _arrow(axes, (x, y), (x, foot), DIMENSION, "<|-|>")
        _write(axes, x + 0.1, (y + foot) / 2, name, ha="left")
    _write(axes, 4.4, 3.2, "block a, rock E_a", fontsize=10)
    _write(axes, 0.9, 0.4, "block b, rock E_b", fontsize=10)
    _arrow(axes, (1.0, 1.9), (4.6, 1.9), DIMENSION, "<|-|>")
    _write(axes, 2.8, 2.05, "L, the length that both share")
    _write(axes, 2.8, 1.58, "shear: L/2 each", DARK)
    _frame(axes, -0.2, 5.8, -0.2, 3.8)
    _title(
        axes,
        "Two edges share a face of length L. It has a normal spring (blue)\nand a shear spring (orange) at both ends.",
    )


def _draw_series(axes: Any) -> None:
    for bottom, name, stiffness, colour in (
        (0.0, "rock of block b", "E_b / h_b", HOLDS),
        (1.2, "joint", "K joint", OPENS),
        (2.4, "rock of block a", "E_a / h_a", HOLDS),
    ):
        _spring(axes, np.array([0.8, bottom]), np.array([0.8, bottom + 1.2]), colour)
        axes.plot([0.5, 1.1], [bottom, bottom], color=TEXT, linewidth=1.2)
        _write(axes, 1.3, bottom + 0.6, f"{name}: {stiffness}", ha="left", fontsize=10)
    axes.plot([0.5, 1.1], [3.6, 3.6], color=TEXT, linewidth=1.2)
    _frame(axes, 0.0, 4.2, -0.2, 3.8)
    _title(axes, "One spring of a face, per area: rock, joint and rock\nin series (Wang Eqs. 3.24-3.27).")


def _draw_wedge(axes: Any) -> None:
    _rock(axes, [(0, 0), (2.2, 0), (2.2, 1.5), (0, 1.5)], [(1.9, 1.25), (4.2, 1.55), (4.0, 3.4), (1.6, 3.1)])
    axes.plot(2.2, 1.5, "o", color=FALLS, markersize=5)
    axes.plot(1.9, 1.25, "o", color=OPENS, markersize=5)
    middle = {"fontsize": 9, "ha": "center", "va": "center", "arrowprops": NO_ARROW}
    closes = "this corner enters\nthe upper block\nby 0.2: it closes"
    stays = "this corner enters\nthe lower block\nby 0.25: it stays open"
    axes.annotate(closes, (2.2, 1.5), (3.4, 0.7), color=FALLS, **middle)
    axes.annotate(stays, (1.9, 1.25), (0.85, 0.7), color=OPENS, **middle)
    _frame(axes, -0.2, 4.5, -0.2, 3.9)
    _title(axes, "Two corners: of both candidates, the one with\nthe smaller penetration closes.")


def _draw_node(axes: Any) -> None:
    cells = [[(x, y), (x + 1.9, y), (x + 1.9, y + 1.6), (x, y + 1.6)] for y in (0.0, 1.7) for x in (0.0, 2.0)]
    _rock(axes, *cells)
    for name, x, y in (("a", 0.6, 0.5), ("b", 3.3, 0.5), ("c", 0.6, 2.8), ("d", 3.3, 2.8)):
        _write(axes, x, y, name, fontsize=11)
    for one, other in (((0.3, 1.6), (0.3, 1.7)), ((1.75, 1.6), (1.75, 1.7)), ((2.15, 1.6), (2.15, 1.7)),
                       ((3.6, 1.6), (3.6, 1.7)), ((1.9, 0.3), (2.0, 0.3)), ((1.9, 1.45), (2.0, 1.45)),
                       ((1.9, 1.85), (2.0, 1.85)), ((1.9, 3.0), (2.0, 3.0))):  # fmt: skip
        axes.plot(*np.array([one, other]).T, color=OPENS, linewidth=4, solid_capstyle="round")
    for start, end in (((0.9, 0.8), (1.8, 1.5)), ((3.0, 2.5), (2.1, 1.8))):
        _arrow(axes, start, end, FALLS)
    _write(axes, 0.64, 1.3, "no force\nuntil they move", FALLS, fontsize=8.5)
    _frame(axes, -0.2, 4.5, -0.2, 3.9)
    _title(axes, "A node of the mesh: neighbours have contacts (blue).\nThe diagonal pair a, d has none.")


def _draw_straight_edge(axes: Any) -> None:
    _rock(
        axes,
        [(0, 0), (2.0, 0), (2.0, 1.4), (0, 1.4)],
        [(2.1, 0), (4.2, 0), (4.2, 1.4), (2.1, 1.4)],
        [(0.3, 1.55), (3.9, 1.55), (3.9, 3.0), (0.3, 3.0)],
    )
    axes.plot(2.05, 1.55, "o", markerfacecolor="white", markeredgecolor=TEXT, markersize=7)
    axes.annotate("node of the mesh on\na straight edge", (2.05, 1.6), (2.05, 2.3), fontsize=9, ha="center",
                  arrowprops=NO_ARROW)  # fmt: skip
    for x in (0.35, 1.9, 2.2, 3.85):
        axes.plot([x, x], [1.4, 1.55], color=OPENS, linewidth=4, solid_capstyle="round")
    _frame(axes, -0.2, 4.5, -0.2, 3.9)
    _title(axes, "A node on a straight edge is no corner: a block\nthat slides past it stays on the straight line.")


def _draw_bolt(axes: Any) -> None:
    _rock(axes, [(0, 0), (1.9, 0), (1.7, 3.2), (0, 3.2)], [(2.1, 0), (4.3, 0), (4.5, 3.2), (1.9, 3.2)],
          [(4.5, 0), (6.4, 0), (6.4, 3.2), (4.7, 3.2)])  # fmt: skip
    nodes = np.array([(0.0, 1.6), (3.2, 1.6), (6.0, 1.6)])
    axes.plot(*nodes.T, color=BOLTS, linewidth=3)
    for (x, y), name in zip(
        nodes, ("head: bonded\nto the first block", "node at mid-length\nin the block", "tip"), strict=True
    ):
        axes.plot(x, y, "o", color=TEXT, markersize=7)
        _write(axes, max(x, 0.75), y + 0.55, name)
    for x, name in ((0.95, "element E A / L"), (5.4, "element")):
        _write(axes, x, 1.35, name, BOLTS)
    for x in (1.9, 4.5):
        _arrow(axes, (x - 0.25, 0.95), (x - 0.25, 0.55), DARK)
        _arrow(axes, (x + 0.25, 0.55), (x + 0.25, 0.95), DARK)
    _write(axes, 3.2, 0.75, "dowel: shear across\nthe joint (option)", DARK)
    _frame(axes, -0.2, 6.6, -0.2, 3.4)
    _title(axes, "A bolt across two joints: elements between nodes.\nEach node is bonded to its block.")


def _draw_element_law(axes: Any) -> None:
    axes.plot([-1.3, 0.0, 1.2, 3.0], [0, 0, 1.0, 1.0], color=BOLTS, linewidth=2.2)
    axes.plot([2.3, 1.1], [1.0, 0.0], color=BOLTS, linewidth=1.6, linestyle="--")
    _write(axes, -0.65, 0.09, "no compression")
    _write(axes, 2.1, 1.08, "yield force")
    _write(axes, 2.4, 0.45, "unloading\nis elastic")
    axes.set(xlim=(-1.3, 3.0), ylim=(-0.05, 1.3))
    _plain_chart(axes, "elongation", "tension of an element")
    _title(axes, "Elements yield at constant force\n(Wang Eqs. 5.2-5.5).")


def _draw_bond_law(axes: Any) -> None:
    axes.plot([0.0, 0.0, 3.0], [0, 1.0, 1.0], color=BOLTS, linewidth=2.2, label="rigid bond")
    axes.plot([0.0, 0.9, 3.0], [0, 1.0, 1.0], color=BOLTS, linewidth=1.6, linestyle="--", label="bond_stiffness")
    _write(axes, 1.6, 1.1, "bond strength times length (Eq. 5.7)")
    axes.set(xlim=(-0.1, 3.0), ylim=(-0.05, 1.3))
    _plain_chart(axes, "slip", "force of a node's bond")
    axes.legend(fontsize=9, frameon=False, loc="lower right")
    _title(axes, "A bond slips at its capacity.")


def _box(axes: Any, x: float, y: float, text: str, colour: str = ROCKS[0], width: float = 2.6) -> None:
    """Write a text in a box about a point."""
    left, right, bottom, top = x - width / 2, x + width / 2, y - 0.36, y + 0.36
    shape = [(left, bottom), (right, bottom), (right, top), (left, top)]
    axes.add_collection(PolyCollection([shape], facecolors=colour, edgecolors=TEXT, linewidths=1.2))
    _write(axes, x, y, text)


def _draw_loop(axes: Any) -> None:
    steps = (
        "(1) search for contacts, with history;\nset up the equations of the step",
        "(2) try the methods of the phase,\nin order",
        "(3) accept the first result that is in\nrange and no unstable equilibrium",
        "(4) commit slip, failure and bolts",
        "(5) verdict?",
    )
    for number, text in enumerate(steps):
        _box(axes, 2.0, 4.6 - 1.05 * number, text, width=3.6)
        if number:
            _arrow(axes, (2.0, 5.29 - 1.05 * number), (2.0, 4.96 - 1.05 * number), TEXT)
    axes.plot([0.2, -0.3, -0.3], [0.4, 0.4, 4.6], color=TEXT, linewidth=1.6)
    _arrow(axes, (-0.3, 4.6), (0.2, 4.6), TEXT)
    _write(axes, -0.45, 2.5, "none yet: next step", rotation=90)
    phases = (
        ("start", "nearby equilibrium, dynamic relaxation, explicit motion"),
        ("after a change", "nearby equilibrium by subdomains, dynamic relaxation, explicit motion"),
        ("near rest", "regularised Newton, exact Newton, explicit motion"),
        ("moving", "explicit motion"),
    )
    for number, (phase, methods) in enumerate(phases):
        y = 4.55 - 0.42 * number
        _write(axes, 4.4, y, phase, ha="left", fontweight="bold")
        _write(axes, 5.7, y, methods, ha="left")
    axes.plot([4.25, 4.25], [3.15, 4.7], color=DIMENSION, linewidth=1.2)
    axes.plot([3.8, 4.25], [3.55, 3.55], color=DIMENSION, linewidth=1.2)
    for number, (name, text, colour) in enumerate((
        ("stable", "two steps end in equilibrium, and the check confirms it", ROCKS[4]),
        ("unstable", "blocks move beyond the limit, run on, or lose all contact", ROCKS[3]),
        ("not converged", "step limit, or no method ends a step", ROCKS[5]),
    )):  # fmt: skip
        y = 1.9 - 0.85 * number
        _box(axes, 5.4, y, name, colour, 1.7)
        _write(axes, 6.4, y, text, ha="left")
        _arrow(axes, (3.8, 0.4), (4.55, y), TEXT)
    _frame(axes, -0.7, 10.4, -0.2, 5.1)
    _title(axes, "A run: steps from one accepted state to the next, until a verdict.")


if __name__ == "__main__":
    main()
