"""The common part of the pictures of a stage in space: the view, and outer faces that are cut away."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.movements import lengths
from bsm_mesh.pictures.look import Look
from bsm_mesh.pictures.painter import Layer, Painter
from bsm_mesh.pictures.scene import MARGIN, Scene, Window
from bsm_mesh.pictures.surfaces import LEVEL, Sides
from bsm_mesh.three_d.joint_polygons import joint_polygons

BELOW = 0.08  # of the view's height: room for the scale and the directions
AROUND = 0.1  # of the size of what excavations have bared, around it
COARSE = 300  # pixels of the view in which it is found out what hides what
HIDDEN = 0.5  # of what excavations have bared: where the outer faces hide more they are cut away


@dataclass(frozen=True, eq=False, kw_only=True)
class SpaceScene(Scene):
    """A stage of results in space.

    Attributes
    ----------
    look : Look, optional
        From where it is seen; by default from where the blocks that fall are seen.
    """

    look: Look | None = None

    @cached_property
    def sides(self) -> Sides:
        """The sides of the blocks as given."""
        blocks = self.results.blocks
        assert in_space(blocks)
        return Sides(blocks)

    @cached_property
    def eye(self) -> Look:
        """From where the run is seen, the same in all its stages."""
        return self.look or _view_of(self)

    @cached_property
    def ever_down(self) -> BoolArray:
        """Which blocks fall in some stage, (n,)."""
        down: BoolArray = np.zeros(self.results.blocks.count, dtype=np.bool_)
        for stage in self.results.stages:
            down[stage.unstable_blocks] = True
            down[[fall.block for fall in stage.falls]] = True
        return down

    @cached_property
    def bared(self) -> BoolArray:
        """Sides that are bare because a stage has taken their neighbours away, (n,)."""
        last = self.results.stages[-1].present
        bared: BoolArray = self.sides.bare(last | self.ever_down) & (self.sides.other >= 0)
        return bared

    @cached_property
    def cut(self) -> bool:
        """Whether outer faces are cut away: they hide more than `HIDDEN` of what excavations have bared."""
        to_the_eye = self.sides.outward @ self.eye.axes[2] < 0
        bared = np.flatnonzero(self.bared & to_the_eye)
        if not len(bared):
            return False
        outer = np.flatnonzero((self.sides.other < 0) & to_the_eye & self.results.stages[-1].present[self.sides.block])
        alone, among = (self._points_seen(bared, others) for others in (outer[:0], outer))
        return among < (1 - HIDDEN) * alone

    def _points_seen(self, sides: IntArray, others: IntArray) -> int:
        """Return in how many points of a coarse picture sides are seen, and not others."""
        corners, offsets = self.sides.polygons(np.concatenate([sides, others]))
        count = len(offsets) - 1
        layer = Layer(corners=corners, offsets=offsets, part=np.arange(count), colours=np.zeros((count, 3)), edge=None)
        seen = Painter(look=self.eye, view=self._whole, width=COARSE, layers=[layer]).seen()
        assert seen is not None
        return int(((seen.face >= 0) & (seen.face < len(sides))).sum())

    @cached_property
    def shown(self) -> IntArray:
        """The blocks that are there, (k,)."""
        return self.here

    @cached_property
    def box(self) -> FloatArray:
        """Lower left and upper right corner of the blocks as given, as they are seen, (2, 2) [m]."""
        flat = self.flat(self.results.blocks.vertices)
        return np.stack([flat.min(axis=0), flat.max(axis=0)])

    @cached_property
    def view(self) -> Window:
        """The visible part of the picture's plane: all, or what excavations have bared where it is cut [m]."""
        if self.window is not None:
            return self.window
        if not self.cut:
            return self._whole
        corners, _ = self.sides.polygons(np.flatnonzero(self.bared | self.ever_down[self.sides.block]))
        return frame(self.flat(corners), AROUND)

    @property
    def _whole(self) -> Window:
        """The part of the picture's plane with all blocks as given."""
        return frame(self.box, MARGIN)

    @cached_property
    def following(self) -> Window:
        """The visible part: blocks are not followed out of it."""
        return self.view

    @property
    def is_plane(self) -> bool:
        """Whether the blocks are polygons: they are not."""
        return False

    def flat(self, points: FloatArray) -> FloatArray:
        """Return where points or vectors (k, 3) are seen in the picture, (k, 2) [m]."""
        return self.eye.flat(points)

    @cached_property
    def faces(self) -> Any:
        """The contact polygons between the blocks that are there, `JointPolygons`."""
        return joint_polygons(self.results, self.stage)

    @property
    def face_pairs(self) -> IntArray:
        """The two blocks of every contact polygon, (k, 2)."""
        return np.column_stack([self.faces.block_a, self.faces.block_b])

    @property
    def greatest_movement(self) -> float:
        """Greatest displacement of a corner of the blocks that stay [m]."""
        stays = np.flatnonzero((self.stage.present & ~self.apart)[self.sides.block])
        given, _ = self.sides.polygons(stays)
        moved, _ = self.sides.polygons(stays, self.stage.displacement)
        return float(lengths(moved - given).max(initial=0.0))

    @cached_property
    def body(self) -> FloatArray:
        """The edges at which the blocks as given bend or end, as they are seen, (k, 2, 2) [m]."""
        return self.edges(np.flatnonzero(self.sides.bare(self.stage.present)))

    def edges(self, sides: IntArray) -> FloatArray:
        """Return the edges at which a surface of sides (k,) bends or ends, as they are seen, (m, 2, 2) [m]."""
        ends: FloatArray = self.flat(self.results.blocks.vertices[self.sides.bent_edges(sides).reshape(-1)])
        return ends.reshape(-1, 2, 2)

    def sides_of(self, blocks: IntArray, factor: float) -> IntArray:
        """Return the sides of blocks (k,) that are painted: of those that have gone all, of others the bare ones.

        Where others are drawn moved, there are cracks between them: then all, unless outer faces are cut away.
        """
        chosen: BoolArray = np.zeros(self.results.blocks.count, dtype=np.bool_)
        chosen[blocks] = True
        whole = chosen & self.apart
        rest = chosen & ~whole
        of_rest = rest[self.sides.block] if factor and not self.cut else self.sides.bare(rest)
        if self.cut:
            of_rest = of_rest & (self.sides.other >= 0)
        return np.flatnonzero(whole[self.sides.block] | of_rest)


def frame(points: FloatArray, room: float) -> Window:
    """Return the rectangle round points (k, 2) with room, a part of its size, and room below for the scale [m]."""
    low, high = points.min(axis=0), points.max(axis=0)
    (x0, y0), (x1, y1) = low - room * np.hypot(*(high - low)), high + room * np.hypot(*(high - low))
    return float(x0), float(y0 - BELOW * (y1 - y0)), float(x1), float(y1)


def _view_of(scene: SpaceScene) -> Look:
    """Return from where the blocks that fall are seen, else the roof of an opening, else a standard view."""
    sides, stages = scene.sides, scene.results.stages
    there = stages[-1].present | scene.ever_down
    bare = sides.bare(there)
    of_falls = bare & scene.ever_down[sides.block]
    down = sides.outward[:, 2] < -LEVEL * np.linalg.norm(sides.outward, axis=1)
    for chosen in (of_falls, scene.bared & down, scene.bared):
        vector: Any = -sides.outward[chosen].sum(axis=0)
        if np.linalg.norm(vector) > LEVEL * np.linalg.norm(sides.outward[chosen], axis=1).sum() > 0:
            return Look.along(vector)
    return Look()
