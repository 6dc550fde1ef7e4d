"""The picture of Newmark's displacement: the record with the yield accelerations, and sliding over time."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from bsm_mesh.pictures.figures import entitle, paper, save
from bsm_mesh.safety.earthquake import SIGNS, Newmark

DPI = 130
COLOURS = {"left": "#1565c0", "right": "#c62828"}
TIMES = 2001  # of the curve of the record


def draw_newmark(answer: Newmark, title: str, path: Path) -> None:
    """Draw the acceleration of the base over time, and below it how far blocks slide to either side."""
    figure = paper((8.0, 6.5), DPI)
    above, below = figure.subplots(2, 1, sharex=True)
    base, interval = BaseMotion(answer.shaking), answer.shaking.own_length / (TIMES - 1)
    time = interval * np.arange(TIMES, dtype=np.float64)
    acceleration = base.acceleration_at(time, interval) * base.axis[0] / GRAVITY
    above.plot(time, acceleration, color="#444444", linewidth=0.8, label="base")
    for side in answer.sides:
        if side.yields is not None:
            level = -SIGNS[side.side] * side.yields  # the base accelerates to the other side
            label = f"yield acceleration, blocks to the {side.side}"
            above.axhline(level, color=COLOURS[side.side], linewidth=1, linestyle="--", label=label)
        for slides, style, word in ((side.sliding, "-", ""), (side.turned, ":", ", record turned over")):
            if slides is not None:
                label = f"to the {side.side}{word}: {slides.permanent:.3g} m"
                below.plot(slides.time, slides.displacement, style, color=COLOURS[side.side], label=label)
    if answer.shaken is not None:
        for side in answer.sides:
            far = answer.shaken.moved[side.side][1]
            label = f"shaken stage, to the {side.side}: {far:.3g} m ({answer.shaken.status.value})"
            below.axhline(far, color=COLOURS[side.side], linewidth=0.8, linestyle="-.", label=label)
    above.set_ylabel("acceleration of the base [g]")
    below.set_ylabel("displacement [m]")
    below.set_xlabel("time [s]")
    for axes in (above, below):
        axes.grid(visible=True, color="#dddddd", linewidth=0.6)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=8, framealpha=0.85, edgecolor="none")
    entitle(figure, title)
    save(figure, path)
