"""The common part of the pictures of a stage: blocks, faces, unstable blocks, positions and the visible part."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.faces import find_faces
from bsm_mesh.movements import distances
from bsm_mesh.results.joint_faces import JointFaces, joint_faces
from bsm_mesh.results.movement import FAR, displacement_of, moved_far
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.stress import stress_is_known
from bsm_mesh.text.exaggeration import exaggeration, opening_of

MARGIN = 0.04  # of the model's size, around it
BEYOND = 0.3  # of the model's extent: how far beside it what moves is followed
MOST_EDGES = 40_000  # blocks; more and their outlines hide the colours
LEAST_PART = 1e-6  # of an edge: less is rounding

Window = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """A stage of results, and the part of it that is seen.

    Attributes
    ----------
    results : Results
        The result.
    number : int
        Of the stage.
    title : str
        Title of the model, stage and verdict.
    window : (x0, y0, x1, y1), optional [m]
        The visible part; by default the whole model.
    """

    results: Results
    number: int
    title: str
    window: Window | None = None

    @property
    def stage(self) -> StageResult:
        """The stage."""
        return self.results.stages[self.number]

    @cached_property
    def here(self) -> IntArray:
        """The blocks that are there, (k,)."""
        return np.flatnonzero(self.stage.present)

    @cached_property
    def down(self) -> BoolArray:
        """Which blocks fall, (n,)."""
        down: BoolArray = np.zeros(self.results.blocks.count, dtype=np.bool_)
        down[self.stage.unstable_blocks] = True
        return down

    @cached_property
    def apart(self) -> BoolArray:
        """Which blocks have gone: they fall, or reached rest far off. They are in no scale of colours, (n,)."""
        apart = self.down | self.strays
        apart[moved_far(self.results.blocks, self.stage)] = True
        return apart

    @cached_property
    def strays(self) -> BoolArray:
        """Which blocks too small to count (``falls.ignore_below``) lie far from where they were given, (n,)."""
        blocks, stage = self.results.blocks, self.stage
        far: BoolArray = distances(stage.displacement) > FAR * blocks.moments.size
        return far & stage.present & ~stage.counts

    @cached_property
    def stressed(self) -> BoolArray:
        """Which blocks have a mean stress that is known (`stress_is_known`), and have not gone, (n,)."""
        known = stress_is_known(self.results.blocks, self.stage)
        chosen: BoolArray = (known if known.any() else self.stage.present) & ~self.apart
        return chosen

    @cached_property
    def shown(self) -> IntArray:
        """The blocks that are there and at least partly seen, (k,)."""
        blocks, (x0, y0, x1, y1) = self.results.blocks, self.view
        corner = blocks.offsets[:-1]
        low = np.minimum.reduceat(blocks.vertices, corner)[self.here]
        high = np.maximum.reduceat(blocks.vertices, corner)[self.here]
        seen: IntArray = self.here[((high > (x0, y0)) & (low < (x1, y1))).all(axis=1)]
        return seen

    @cached_property
    def box(self) -> FloatArray:
        """Lower left and upper right corner of the blocks as given, (2, 2) [m]."""
        corners = self.results.blocks.vertices
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @cached_property
    def view(self) -> Window:
        """The visible part, [m]."""
        if self.window is not None:
            return self.window
        room = MARGIN * float(np.hypot(*(self.box[1] - self.box[0])))
        (x0, y0), (x1, y1) = self.box[0] - room, self.box[1] + room
        return float(x0), float(y0), float(x1), float(y1)

    @cached_property
    def following(self) -> Window:
        """The visible part where blocks are followed to where they have come, as far as `BEYOND` [m]."""
        x0, y0, x1, y1 = self.view
        beyond = BEYOND * float((self.box[1] - self.box[0]).max())
        there = self.stage.present[self.results.blocks.owner]
        moved = (self.results.blocks.vertices + self.corner_movement)[there]
        low = np.maximum(moved.min(axis=0), self.box[0] - beyond) - (self.box[0] - (x0, y0))
        high = np.minimum(moved.max(axis=0), self.box[1] + beyond) + ((x1, y1) - self.box[1])
        return min(x0, float(low[0])), min(y0, float(low[1])), max(x1, float(high[0])), max(y1, float(high[1]))

    @property
    def is_plane(self) -> bool:
        """Whether the blocks are polygons: joints are lines between them."""
        return True

    def flat(self, points: FloatArray) -> FloatArray:
        """Return where points or vectors (k, 2) are seen in the picture, (k, 2): as they are."""
        return points

    @property
    def size(self) -> float:
        """Diagonal of the visible part [m]."""
        x0, y0, x1, y1 = self.view
        return float(np.hypot(x1 - x0, y1 - y0))

    @cached_property
    def corner_movement(self) -> FloatArray:
        """Displacement of every corner, (n_vertices, 2) [m]."""
        blocks = self.results.blocks
        return displacement_of(blocks, self.stage.displacement, blocks.owner, blocks.vertices)

    @cached_property
    def faces(self) -> JointFaces:
        """The faces between the blocks."""
        return joint_faces(self.results, self.stage)

    @property
    def face_pairs(self) -> IntArray:
        """The two blocks of every face, (k, 2)."""
        return np.column_stack([self.faces.block_a, self.faces.block_b])

    @property
    def outlines_seen(self) -> bool:
        """Whether the outlines of the blocks are drawn."""
        return len(self.shown) <= MOST_EDGES

    def polygons(self, blocks: IntArray, factor: float = 0.0) -> list[FloatArray]:
        """Return the corners of blocks (k,), moved by so many times their displacement."""
        given = self.results.blocks
        corners = given.vertices if factor == 0 else given.vertices + factor * self.corner_movement
        return [corners[given.offsets[b] : given.offsets[b + 1]] for b in blocks.tolist()]

    @cached_property
    def bare(self) -> tuple[IntArray, FloatArray]:
        """Parts of edges of blocks that are there to which no other of them lies, as given: edge, and both ends on it.

        The ends are parts of the edge's length, (k, 2).
        """
        given, there = self.results.blocks, self.stage.present[self.results.blocks.owner]
        faces = find_faces(given)
        shared = there[faces.edge_a] & there[faces.edge_b]
        edge = np.concatenate([faces.edge_a[shared], faces.edge_b[shared]])
        ends = np.stack([np.tile(faces.start[shared], (2, 1)), np.tile(faces.end[shared], (2, 1))], axis=1)
        start = given.vertices[edge]
        along = given.vertices[given.following[edge]] - start
        parts = np.sort(
            ((ends - start[:, None]) * along[:, None]).sum(axis=2) / (along**2).sum(axis=1)[:, None], axis=1
        )
        whole = np.flatnonzero(there)
        edge = np.concatenate([whole, edge, whole])  # between the two ends of every edge lie its faces
        parts = np.concatenate([np.zeros((len(whole), 2)), parts, np.ones((len(whole), 2))])
        order = np.lexsort((parts[:, 1], parts[:, 0], edge))
        edge, parts = edge[order], parts[order]
        bare = (edge[1:] == edge[:-1]) & (parts[1:, 0] - parts[:-1, 1] > LEAST_PART)
        return edge[:-1][bare], np.stack([parts[:-1, 1], parts[1:, 0]], axis=1)[bare]

    def outline(self, factor: float = 0.0) -> FloatArray:
        """Return the outline of the body, its blocks moved by so many times their displacement, (k, 2, 2) [m]."""
        given = self.results.blocks
        corners = given.vertices if factor == 0 else given.vertices + factor * self.corner_movement
        edge, parts = self.bare
        start = corners[edge]
        along = corners[given.following[edge]] - start
        ends: FloatArray = start[:, None] + parts[:, :, None] * along[:, None]
        return ends

    def face_lines(self, factor: float = 1.0) -> FloatArray:
        """Return both ends of every face, moved by so many times their displacement, (k, 2, 2) [m]."""
        faces = self.faces
        return np.stack(
            [faces.start + factor * faces.start_displacement, faces.end + factor * faces.end_displacement], axis=1
        )

    @property
    def opening(self) -> float:
        """Size of the room that the blocks leave in their box (`opening_of`) [m]."""
        return opening_of(self.results.blocks, self.here)

    @cached_property
    def exaggeration(self) -> float:
        """How many times displacements are drawn: a round number, at least 1."""
        return exaggeration(self.greatest_movement, self.results.blocks, self.here)

    @property
    def greatest_movement(self) -> float:
        """Greatest displacement of a corner of the blocks that stay [m]."""
        stays = self.stage.present & ~self.apart
        return float(np.hypot(*self.corner_movement[stays[self.results.blocks.owner]].T).max(initial=0.0))

    def spread(self, points: FloatArray, most: int) -> IntArray:
        """Return at most about so many of the points (k, 2) within the view, evenly spread, (m,)."""
        x0, y0, x1, y1 = self.view
        inside = np.flatnonzero(((points >= (x0, y0)) & (points <= (x1, y1))).all(axis=1))
        if len(inside) <= most:
            return inside
        square = np.floor((points[inside] - (x0, y0)) / self.spacing(most)).astype(np.int64)
        _, chosen = np.unique(square, axis=0, return_index=True)
        return inside[chosen]

    def spacing(self, count: int) -> float:
        """Return the mean distance of so many points in the visible part of the model [m]."""
        x0, y0, x1, y1 = self.view
        (left, low), (right, high) = self.box
        seen = max(min(x1, right) - max(x0, left), 0) * max(min(y1, high) - max(y0, low), 0)
        return float(np.sqrt((seen or (x1 - x0) * (y1 - y0)) / max(count, 1)))
