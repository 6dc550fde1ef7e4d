"""Pictures of a factor of safety: movement against the factor, and what fails."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.app.figures import entitle, paper, save
from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.results.joint_faces import joint_faces
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import ContactStatus, StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.safety.answer import Safety
from bsm_mesh.safety.bracket import Verdict

DPI = 130
COLOURS = {Verdict.STABLE: "#2e7d32", Verdict.UNSTABLE: "#c62828", Verdict.UNDECIDED: "#9e9e9e"}
MARKS = {Verdict.STABLE: "o", Verdict.UNSTABLE: "s", Verdict.UNDECIDED: "D"}
SLIPS, OPENS, FAILS, PAPER = "#e08214", "#1f6fb2", "#ef9a9a", "#f4f1ea"
LEAST_MOVEMENT = 1e-5  # of a block's size: nothing smaller is told apart in the picture
SHOWN = 0.5  # sizes of the largest block that fails: what moved farther is drawn no farther, what moved less as far


def draw_movement(safety: Safety, limit_of_movement: float, title: str, path: Path) -> None:
    """Draw the greatest movement of a block against the value that was tried, with the bracket."""
    figure = paper((8.0, 5.0), DPI)
    axes = figure.add_subplot()
    stable = [trial for trial in safety.trials if trial.verdict is Verdict.STABLE]
    rows = [(trial.value, max(trial.moved, LEAST_MOVEMENT)) for trial in stable]
    axes.plot(*np.reshape(rows, (-1, 2)).T, color=COLOURS[Verdict.STABLE], linewidth=1, alpha=0.5)
    for verdict in Verdict:
        mine = [trial for trial in safety.trials if trial.verdict is verdict]
        if mine:
            moved = [max(trial.moved, LEAST_MOVEMENT) for trial in mine]
            axes.plot(
                [trial.value for trial in mine], moved, MARKS[verdict], color=COLOURS[verdict], label=verdict.value
            )
    if safety.stable is not None and safety.unstable is not None:
        axes.axvspan(safety.stable, safety.unstable, color="#fdd835", alpha=0.6, label="the limit lies here")
    if np.isfinite(safety.limit.factor):
        axes.axvline(safety.limit.factor, color="black", linestyle="--", linewidth=1, label="bound by limit analysis")
    axes.axhline(limit_of_movement, color="#777777", linestyle=":", label="counts as failure from here on")
    axes.set_yscale("log")
    axes.set_xlabel(safety.quantity, parse_math=False)
    axes.set_ylabel("greatest movement of a block over its size")
    axes.legend(fontsize=8, frameon=False)
    entitle(figure, title)
    save(figure, path)


def draw_mechanism(safety: Safety, title: str, path: Path) -> None:
    """Draw joints that slip or open in the last stable state, and the blocks that fail in the first unstable one."""
    good, bad = safety.stable, safety.unstable
    corners = next(iter(safety.states.values())).blocks.vertices
    width, height = corners.max(axis=0) - corners.min(axis=0)
    figure = paper((13.0, 1.2 + 6.2 * float(np.clip(height / width, 0.25, 1.5))), DPI)
    left, right = figure.subplots(1, 2)
    if good is not None and good in safety.states:
        _draw_joints(left, safety.states[good])
        left.set_title(f"last stable, {good:.4g}: joints that slip (orange) or are open (blue)", fontsize=10)
    if bad is not None and bad in safety.states:
        fails = np.zeros(0, dtype=np.int32) if safety.mechanism is None else safety.mechanism.blocks
        factor = _draw_failure(right, safety.states[bad], fails)
        shown = f", {factor:.2g} times as far" if factor > 1.05 else ""
        right.set_title(f"first unstable, {bad:.4g}: blocks that fail (red), and where they go{shown}", fontsize=10)
    entitle(figure, title)
    save(figure, path)


def _draw_joints(axes: Any, results: Results) -> None:
    from matplotlib.collections import LineCollection

    stage = results.stages[-1]
    outlines = _outlines(results, stage, stage.stage_displacement)
    _draw_blocks(axes, outlines, np.zeros(len(outlines), dtype=bool))
    faces = joint_faces(results, stage)
    ends = np.stack([faces.start + faces.start_displacement, faces.end + faces.end_displacement], axis=1)
    for status, colour in ((ContactStatus.SLIPPING, SLIPS), (ContactStatus.OPEN, OPENS)):
        lines = ends[faces.status == status]
        axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=2.2))


def _draw_failure(axes: Any, results: Results, fails: IntArray) -> float:
    """Draw the blocks at the end, those that fail marked; return how many times their movement is exaggerated."""
    stage, blocks = results.stages[-1], results.blocks
    size = np.sqrt(blocks.moments.area)
    chosen = np.zeros(blocks.count, dtype=bool)
    chosen[fails] = True
    here = np.flatnonzero(stage.present)
    moved = stage.stage_displacement.copy()
    far = np.hypot(*moved[:, :2].T)
    shown, greatest = SHOWN * float(size[chosen].max(initial=0.0)), float(far[chosen].max(initial=0.0))
    factor = max(1.0, shown / greatest) if greatest > 0 else 1.0
    moved *= (factor * np.minimum(1.0, shown / np.maximum(factor * far, 1e-300)))[:, None]
    _draw_blocks(axes, _outlines(results, stage, moved), chosen[here])
    start = blocks.moments.centroid + (stage.displacement - stage.stage_displacement)[:, :2]
    rows = here[chosen[here] & (far[here] > 0)]
    arrows = {"angles": "xy", "scale_units": "xy", "scale": 1, "color": "#8e0000", "width": 0.004, "zorder": 3}
    axes.quiver(*start[rows].T, *moved[rows, :2].T, **arrows)
    return factor


def _outlines(results: Results, stage: StageResult, moved: FloatArray) -> list[FloatArray]:
    """Return the corners of the blocks that are there, moved (n, 3) from where the stage found them."""
    blocks, owner = results.blocks, results.blocks.owner
    there = stage.displacement - stage.stage_displacement + moved
    corners = blocks.vertices + displacement_of(blocks, there, owner, blocks.vertices)
    sizes = np.diff(blocks.offsets)[stage.present]
    return np.split(corners[stage.present[owner]], np.cumsum(sizes)[:-1])


def _draw_blocks(axes: Any, outlines: list[FloatArray], chosen: BoolArray) -> None:
    from matplotlib.collections import PolyCollection

    colours = [FAILS if each else PAPER for each in chosen]
    axes.add_collection(PolyCollection(outlines, facecolors=colours, edgecolors="#777777", linewidths=0.5))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("x, m", fontsize=8)
    axes.set_ylabel("y, m", fontsize=8)
    axes.tick_params(labelsize=8)
