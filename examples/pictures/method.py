"""The picture of the method: ``python examples/pictures/method.py`` draws docs/method.png."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection

from bsm_mesh.pictures.canvas import OPENS, ROCKS, SLIPS
from bsm_mesh.pictures.figures import TEXT, paper, save

TARGET = Path(__file__).parents[2] / "docs/method.png"
LEFT = np.array([(0, 0), (2.1, 0), (1.7, 1.9), (0, 1.6)])
RIGHT = np.array([(2.25, 0), (4.2, 0), (4.2, 1.5), (1.85, 1.9)])
TOP = np.array([(0, 1.75), (1.72, 2.06), (4.2, 1.65), (4.2, 3.2), (0, 3.2)])


def main() -> None:
    """Draw blocks with the springs between them, a contact, and the law of a joint."""
    figure = paper((14.0, 4.6), 100)
    blocks, contact, law = figure.subplots(1, 3, width_ratios=(1.25, 1.0, 1.0))
    _draw_blocks(blocks)
    _draw_contact(contact)
    _draw_law(law)
    save(figure, TARGET)


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


def _draw_blocks(axes: Any) -> None:
    outlines = [LEFT, RIGHT, TOP]
    axes.add_collection(PolyCollection(outlines, facecolors=ROCKS[0], edgecolors=TEXT, linewidths=1.4))
    for name, (x, y) in (("block 0", (0.8, 0.8)), ("block 1", (3.2, 0.7)), ("block 2", (2.0, 2.6))):
        axes.text(x, y, name, ha="center", va="center", fontsize=11, color=TEXT)
    pairs = (((0.15, 1.64), (0.15, 1.78)), ((1.6, 1.87), (1.58, 2.03)), ((1.95, 1.86), (1.97, 2.02)))
    pairs += (((4.05, 1.52), (4.05, 1.68)), ((2.08, 0.1), (2.24, 0.1)), ((1.74, 1.7), (1.89, 1.7)))
    for one, other in pairs:
        axes.plot(*np.array([one, other]).T, color=OPENS, linewidth=4, solid_capstyle="round")
    axes.annotate("", xy=(2.0, 3.2), xytext=(2.0, 3.75), arrowprops={"arrowstyle": "-|>", "color": "#8a1c1c"})
    axes.text(2.1, 3.5, "weights and loads", fontsize=9, va="center")
    axes.plot([0, 4.2], [-0.02, -0.02], color="black", linewidth=3)
    axes.text(2.1, -0.15, "held", fontsize=9, ha="center", va="top")
    axes.set(xlim=(-0.2, 4.4), ylim=(-0.4, 3.9), aspect="equal")
    axes.axis("off")
    _title(
        axes, "Rigid blocks; each moves by u, v and a rotation.\nWhere corners lie on edges there are springs (blue)."
    )


def _draw_contact(axes: Any) -> None:
    below = np.array([(0, 0), (4, 0), (4, 1.2), (0, 1.2)])
    above = np.array([(0.4, 2.2), (4, 2.2), (4, 3.4), (0.4, 3.4)])
    axes.add_collection(PolyCollection([below, above], facecolors=ROCKS[0], edgecolors=TEXT, linewidths=1.4))
    for x in (0.6, 3.6):
        _spring(axes, np.array([x, 1.2]), np.array([x, 2.2]), OPENS)
        _spring(axes, np.array([x, 1.35]), np.array([x - 0.9 if x > 1 else x + 0.9, 1.35]), SLIPS)
    axes.text(1.75, 1.95, "normal: rock and joint\nin series", fontsize=9, color=OPENS, ha="center", va="center")
    axes.text(2.1, 1.38, "shear", fontsize=9, color="#8a5a00", ha="center", va="center")
    axes.set(xlim=(-0.2, 4.2), ylim=(-0.3, 3.8), aspect="equal")
    axes.axis("off")
    _title(
        axes, "A face has two contacts, at the ends of what its\nblocks share. They move along and end as blocks move."
    )


def _draw_law(axes: Any) -> None:
    slip = np.array([0, 1.0, 3.0])
    axes.plot(slip, [0, 1.0, 1.0], color=SLIPS, linewidth=2.2, label="high pressure")
    axes.plot([0, 0.5, 3.0], [0, 0.5, 0.5], color=SLIPS, linewidth=2.2, linestyle="--", label="low pressure")
    axes.annotate("slips: cohesion + pressure x tan(friction)", (1.1, 1.0), (0.35, 1.17), fontsize=9, color=TEXT)
    axes.annotate("sticks: shear stiffness", (0.4, 0.4), (0.62, 0.16), fontsize=9, color=TEXT,
                  arrowprops={"arrowstyle": "-", "color": "#888888"})  # fmt: skip
    axes.set(xlim=(0, 3), ylim=(0, 1.35), xticks=[], yticks=[], xlabel="slip", ylabel="shear force")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.legend(fontsize=9, frameon=False, loc="lower right")
    _title(axes, "A joint sticks, slips or opens. Equilibrium of all\nblocks is found, or the unstable blocks.")


if __name__ == "__main__":
    main()
