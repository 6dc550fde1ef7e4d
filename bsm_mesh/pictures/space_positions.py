"""Positions of polyhedra at the snapshots of a run, painted as in the pictures of its stages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.folder.frames import Frame
from bsm_mesh.folder.saved_results import SavedResults
from bsm_mesh.folder.storage import load_results
from bsm_mesh.movements import lengths
from bsm_mesh.pictures.canvas import FALLS, GIVEN, MOVED, OUTLINE, ROCKS
from bsm_mesh.pictures.space_scene import SpaceScene
from bsm_mesh.pictures.space_sheet import SpaceSheet
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import StageResults


class SpacePositions:
    """Positions of polyhedra; all frames are seen from where the end is.

    Parameters
    ----------
    saved : SavedResults
        The results folder.
    """

    def __init__(self, saved: SavedResults) -> None:
        self._saved = saved
        self._end = SpaceScene(results=load_results(saved.folder), number=-1, title="")
        self._last: tuple[Frame, SpaceScene] | None = None

    def _scene(self, frame: Frame) -> SpaceScene:
        if self._last is None or self._last[0] != frame:
            results = self._end.results
            stages = StageResults((self._stage(frame), *results.stages))
            scene = replace(self._end, results=replace(results, stages=stages), number=0, look=self._end.eye)
            self._last = frame, scene
        return self._last[1]

    def _stage(self, frame: Frame) -> StageResult:
        """Return the stage of a frame with the blocks where they are in it."""
        cells = self._saved.grid(frame.file("blocks"), needs=("displacement", "block_id", "unstable")).cell_data
        here, count = cells["block_id"], self._end.results.blocks.count
        movement, present = np.zeros((count, 6)), np.zeros(count, dtype=bool)
        movement[here], present[here] = np.hstack([cells["displacement"], cells["rotation"]]), True
        down = here[cells["unstable"] > 0].astype(np.int32)
        stages = self._end.results.stages
        last = stages[min(frame.stage, len(stages) - 1)]
        return replace(last, displacement=movement, present=present, unstable_blocks=down, falls=())

    def extent(self, frame: Frame) -> tuple[FloatArray, FloatArray]:
        """Return the visible part as given, and the box of the blocks where they are in a frame, (2, 2) each [m].

        Where outer faces are cut away it is the box of the blocks that fall in the run.
        """
        scene = self._scene(frame)
        low, high = np.array(self._end.view).reshape(2, 2)
        there = scene.stage.present & (self._end.ever_down if self._end.cut else True)
        corners, _ = scene.sides.polygons(np.flatnonzero(there[scene.sides.block]), scene.stage.displacement)
        flat = scene.flat(corners) if len(corners) else np.stack([low, high])
        return np.stack([low, high]), np.stack([flat.min(axis=0), flat.max(axis=0)])

    def greatest(self, frame: Frame) -> float:
        """Return the greatest displacement of a corner [m]."""
        scene = self._scene(frame)
        there = np.flatnonzero(scene.stage.present[scene.sides.block])
        given, _ = scene.sides.polygons(there)
        moved, _ = scene.sides.polygons(there, scene.stage.displacement)
        return float(lengths(moved - given).max(initial=0.0))

    def add_start(self, axes: Any) -> None:
        """Draw the edges of the body as given."""
        from matplotlib.collections import LineCollection

        edges = LineCollection(list(self._end.body), colors=GIVEN, linewidths=0.8, zorder=1)
        axes.add_collection(edges, autolim=False)

    def add_blocks(self, axes: Any, frame: Frame, factor: float, down: IntArray | None) -> Sequence[Any]:
        """Draw the blocks of a frame; return its artists."""
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        scene = replace(self._scene(frame), window=(x0, y0, x1, y1))
        before = set(axes.get_children())
        sheet = SpaceSheet(figure=axes.figure, axes=axes, scene=scene)
        stays = self._end.results.stages[-1].present | self._end.ever_down
        falls = np.isin(scene.here, scene.stage.unstable_blocks if down is None else down)
        core = ~stays[scene.here] & ~falls if scene.cut else np.zeros_like(falls)  # what excavations will take away
        for chosen, colour in ((core, ROCKS[0]), (~core & ~falls, MOVED), (falls, FALLS)):
            sheet.blocks(scene.here[chosen], factor, facecolors=colour, edgecolors=OUTLINE)
        sheet.complete()
        return [artist for artist in axes.get_children() if artist not in before]
