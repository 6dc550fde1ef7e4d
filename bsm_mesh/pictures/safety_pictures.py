"""Pictures of a factor of safety: movement against the factor, and what fails."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.safety_files import MECHANISM, MOVEMENT
from bsm_mesh.model.kinds import in_space
from bsm_mesh.pictures.canvas import FALLS, LETTERS, LINE, ROCKS, Sheet, add_key
from bsm_mesh.pictures.figures import TEXT, entitle, paper, save
from bsm_mesh.pictures.joint_pictures import draw_state
from bsm_mesh.pictures.marks import add_rings, arrows
from bsm_mesh.pictures.scene import Scene
from bsm_mesh.pictures.sheets import new_sheet
from bsm_mesh.pictures.zone_pictures import draw_moved_zones, draw_zone_yielding
from bsm_mesh.results.movement import displacement_of
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.safety.answer import Safety, with_unit
from bsm_mesh.safety.bracket import Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 130
COLOURS = {Verdict.STABLE: "#2e7d32", Verdict.UNSTABLE: "#c62828", Verdict.UNDECIDED: "#9e9e9e"}
MARKS = {Verdict.STABLE: "o", Verdict.UNSTABLE: "s", Verdict.UNDECIDED: "D"}
LEAST_MOVEMENT = 1e-5  # of a block's size: nothing smaller is distinguished in the picture
BELOW = " (below the dotted line: blocks fall, or limit analysis proves that they must move)"
SHOWN = 0.5  # sizes of the largest block that fails: what moved further is drawn no further, what moved less as far


def draw_safety(answer: Safety, movement: float, title: str, added: AddedFiles) -> list[str]:
    """Draw the pictures of an answer into its folder, and return their names; `movement` counts as failure."""
    with added.file(MOVEMENT) as draft:
        draw_movement(answer, movement, title, draft)
    if not answer.states or any(in_space(state.blocks) for state in answer.states.values()):
        return [MOVEMENT]
    with added.file(MECHANISM) as draft:
        draw_mechanism(answer, title, draft)
    return [MOVEMENT, MECHANISM]


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
            label = verdict.value
            if verdict is Verdict.UNSTABLE and min(moved) <= limit_of_movement:
                label += BELOW
            axes.plot([trial.value for trial in mine], moved, MARKS[verdict], color=COLOURS[verdict], label=label)
    if safety.stable is not None and safety.unstable is not None:
        axes.axvspan(safety.stable, safety.unstable, color="#fdd835", alpha=0.6, label="the limit lies here")
    if np.isfinite(safety.limit.factor):
        axes.axvline(safety.limit.factor, color="black", linestyle="--", linewidth=1, label="bound by limit analysis")
    axes.axhline(limit_of_movement, color="#777777", linestyle=":", label="failure above this displacement")
    axes.set_yscale("log")
    axes.set_xlabel(f"{safety.quantity} [{safety.unit}]" if safety.unit else safety.quantity, parse_math=False)
    axes.set_ylabel("greatest displacement of a block, in parts of its size")
    axes.legend(fontsize=8, framealpha=0.9, edgecolor="none")
    entitle(figure, title)
    save(figure, path)


def draw_mechanism(safety: Safety, title: str, path: Path) -> None:
    """Draw the state of the joints in the last stable state, and the blocks that fail in the first unstable one."""
    good, bad = safety.stable, safety.unstable
    corners = next(iter(safety.states.values())).blocks.vertices
    width, height = corners.max(axis=0) - corners.min(axis=0)
    figure = paper((13.0, 1.7 + 6.2 * float(np.clip(height / width, 0.25, 1.5))), DPI)
    figure.set_layout_engine("compressed", h_pad=0.08)  # axes of equal scales leave room for title and key
    sheets = []
    if good is not None and good in safety.states:
        sheet = new_sheet(_scene(safety.states[good]), figure, (1, 2, 1))
        caption = draw_state(sheet) or draw_zone_yielding(sheet) or "no joints"
        sheets.append((sheet, f"last stable, {with_unit(good, safety.unit)}: {caption}"))
    if bad is not None and bad in safety.states:
        fails = np.zeros(0, dtype=np.int32) if safety.mechanism is None else safety.mechanism.blocks
        sheet, factor = _draw_failure(_scene(safety.states[bad]), fails, figure)
        shown = f", drawn {factor:.2g} times as far" if not 0.95 < factor < 1.05 else ""
        sheets.append((sheet, f"first unstable, {with_unit(bad, safety.unit)}: displacement{shown}"))
    for sheet, caption in sheets:
        width = int(LETTERS * figure.get_figwidth() / len(sheets))
        sheet.axes.set_title(
            "\n".join(wrap(caption, width)), loc="left", fontsize=10, color=TEXT, parse_math=False, va="bottom"
        )
    add_key(figure, [line for sheet, _ in sheets for line in sheet.key])
    entitle(figure, title)
    save(figure, path)


def _scene(results: Results) -> Scene:
    return Scene(results=results, number=len(results.stages) - 1, title="")


def _draw_failure(scene: Scene, fails: IntArray, figure: Figure) -> tuple[Sheet, float]:
    """Draw the blocks at the end, those that fail marked; return the factor of their movement.

    Blocks with zones have displacements of a search without end: all of them are drawn by the same factor.
    """
    stage, blocks = scene.stage, scene.results.blocks
    size = np.sqrt(blocks.moments.area)
    chosen = np.zeros(blocks.count, dtype=bool)
    chosen[fails] = True
    moved = stage.stage_displacement.copy()
    far = np.hypot(*moved[:, :2].T)
    shown, greatest = SHOWN * float(size[chosen].max(initial=0.0)), float(far[chosen].max(initial=0.0))
    factor = max(1.0 if stage.zones is None else 0.0, shown / greatest) if greatest > 0 else 1.0
    most = np.inf if stage.zones is not None else shown
    moved *= (factor * np.minimum(1.0, most / np.maximum(factor * far, 1e-300)))[:, None]
    outlines = _outlines(scene.results, stage, moved)
    x0, y0, x1, y1 = scene.view
    corners = np.concatenate([[(x0, y0), (x1, y1)], *outlines])
    window = (*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist())
    sheet = new_sheet(replace(scene, window=window), figure, (1, 2, 2))
    if stage.zones is not None and stage.zones.yielded.any():
        draw_moved_zones(sheet, factor)
    else:
        colours = [FALLS if each else ROCKS[0] for each in chosen[scene.here]]
        sheet.polygons(outlines, facecolors=colours, edgecolors=LINE, linewidths=0.5)
        sheet.explain_patch("fails", facecolor=FALLS, edgecolor=LINE)
    start = blocks.moments.centroid + (stage.displacement - stage.stage_displacement)[:, :2]
    rows = scene.here[chosen[scene.here] & (far[scene.here] > 0)]
    arrows(sheet, start[rows], moved[rows, :2], TEXT, width=0.004)
    rows = np.flatnonzero(chosen & stage.present)
    add_rings(sheet, rows, start[rows] + moved[rows, :2])
    return sheet, factor


def _outlines(results: Results, stage: StageResult, moved: FloatArray) -> list[FloatArray]:
    """Return the corners of the blocks that are there, moved (n, 3) from where the stage found them."""
    blocks, owner = results.blocks, results.blocks.owner
    there = stage.displacement - stage.stage_displacement + moved
    corners = blocks.vertices + displacement_of(blocks, there, owner, blocks.vertices)
    sizes = np.diff(blocks.offsets)[stage.present]
    return np.split(corners[stage.present[owner]], np.cumsum(sizes)[:-1])
