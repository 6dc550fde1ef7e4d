"""Water pressure on faces: linear heads integrated exactly, over wet parts and bends of the table (Wang ch. 6)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.model.face_water import FaceWater
from bsm_mesh.model.model import Model
from bsm_mesh.model.water import Water


@njit()
def end_forces(
    start: FloatArray,
    end: FloatArray,
    breaks: FloatArray,
    level: FloatArray,
    slope: FloatArray,
    factor: FloatArray,
    unit_weight: float,
) -> FloatArray:  # pragma: no cover - compiled
    """Return the two forces at the ends of every face with resultant and moment of its water pressure, (k, 2) [N/m].

    With t running from 0 to 1 along a face of length l, they are ``l * integral of q (1 - t)`` and ``l * integral of
    q t``. For q linear from q1 to q2 these are Wang's Eq. 6.2; where one end is dry, his Eqs. 6.3-6.5.

    Parameters
    ----------
    start, end : (k, 2) float64 [m]
        Ends of the faces.
    breaks, level, slope, factor : float64
        As in `WaterSurface`.
    unit_weight : float [N/m3]
        Of the water.
    """
    forces = np.zeros((start.shape[0], 2))
    for k in range(start.shape[0]):
        x0, y0 = start[k, 0], start[k, 1]
        dx, dy = end[k, 0] - x0, end[k, 1] - y0
        length = np.hypot(dx, dy)
        low, high = min(x0, x0 + dx), max(x0, x0 + dx)
        first = np.searchsorted(breaks, low, side="right")
        last = max(first, np.searchsorted(breaks, high, side="left"))
        for piece in range(first, last + 1):
            if level[piece] == -np.inf:
                continue
            t0, t1 = 0.0, 1.0
            if first < last:
                if piece > first:
                    t = (breaks[piece - 1] - x0) / dx
                    t0, t1 = (t, t1) if dx > 0 else (t0, t)
                if piece < last:
                    t = (breaks[piece] - x0) / dx
                    t0, t1 = (t0, t) if dx > 0 else (t, t1)
            head = level[piece] + slope[piece] * x0 - y0  # head at t: head + rise * t
            rise = slope[piece] * dx - dy
            h0, h1 = head + rise * t0, head + rise * t1
            if h0 <= 0.0 and h1 <= 0.0:
                continue
            if h0 < 0.0 or h1 < 0.0:  # one end is dry: only the wet length counts (Wang Eq. 6.5)
                t = t0 + (t1 - t0) * h0 / (h0 - h1)
                t0, t1, h0, h1 = (t, t1, 0.0, h1) if h0 < 0.0 else (t0, t, h0, 0.0)
            scale = unit_weight * factor[piece] * length * (t1 - t0)
            total = scale * (h0 + h1) / 2
            moment = t0 * total + scale * (t1 - t0) * (h0 + 2 * h1) / 6
            forces[k, 0] += total - moment
            forces[k, 1] += moment
    return forces


@njit()
def add_face_forces(
    block: IntArray, start: FloatArray, end: FloatArray, centroid: FloatArray, ends: FloatArray, total: FloatArray
) -> None:  # pragma: no cover - compiled
    """Add force and moment of pressures on faces of blocks, from their `end_forces`, to `total` (n, 3).

    The block lies to the left of each face; the pressure acts into it (Wang Eqs. 6.6, 6.7).
    """
    for k in range(block.size):
        b = block[k]
        dx, dy = end[k, 0] - start[k, 0], end[k, 1] - start[k, 1]
        length = np.hypot(dx, dy)
        for side in range(2):
            x, y = (end[k, 0], end[k, 1]) if side else (start[k, 0], start[k, 1])
            fx, fy = -ends[k, side] * dy / length, ends[k, side] * dx / length
            total[b, 0] += fx
            total[b, 1] += fy
            total[b, 2] += (x - centroid[b, 0]) * fy - (y - centroid[b, 1]) * fx


class WaterLoad:
    """The water's forces on the blocks of a model, wherever they stand.

    Parameters
    ----------
    model : Model
        What is given: its ``water`` and ``face_water`` may be None; with neither all forces are zero.
    """

    def __init__(self, model: Model) -> None:
        self.on_parts = model.face_water
        self.water = model.water or Water()
        self.blocks = model.blocks
        self.surface = self.water.surface()
        names = [joint.name for joint in model.joints]
        self.of_joint = np.full(len(names) + 1, np.nan)  # the last: rock
        for name, pressure in self.water.joint_pressure.items():
            self.of_joint[names.index(name)] = pressure
        self.patches = _patches(model, self.of_joint) if self.water.joint_pressure else self.on_parts
        self.acts = bool(np.isfinite(self.surface.level).any() or self.patches is not None)

    def on_faces(self, start: FloatArray, end: FloatArray, joint: IntArray | None = None) -> FloatArray:
        """Return the pressure forces at both ends of faces, (k, 2) [N/m].

        Without `joint` (k,), the number of each face's joint (-1: rock), all have the table's pressure.
        """
        if self.on_parts is not None:
            return self.on_parts.on_lines(self._parts(), start, end)
        return self._under_table(start, end, joint)

    def _under_table(self, start: FloatArray, end: FloatArray, joint: IntArray | None = None) -> FloatArray:
        s = self.surface
        forces: FloatArray = end_forces(start, end, s.breaks, s.level, s.slope, s.factor, self.water.unit_weight)
        if joint is None:
            return forces
        given = self.of_joint[joint][:, None] * np.hypot(*(end - start).T)[:, None] / 2
        return np.where(np.isnan(given), forces, given)

    def on_blocks(self, vertices: FloatArray, centroid: FloatArray) -> FloatArray:
        """Return force and moment about the centroid on every block, (n, 3), the corners being at `vertices`."""
        total = np.zeros((self.blocks.count, 3))
        if self.acts:
            for block, start, end, ends in self._pressed(vertices):
                add_face_forces(block, start, end, centroid, ends, total)
        return total

    def recorded(self) -> dict[str, Any]:
        """Return what is kept of the water with a stage's result: fields of `StageResult` by their names."""
        table, factor = self.surface.between(*self.blocks.extent)
        return {
            "water_table": table,
            "water_gradient": self.water.unit_weight * factor,
            "joint_water": self.of_joint[:-1].copy(),
        }

    def point_forces(self, vertices: FloatArray) -> tuple[tuple[IntArray, FloatArray, FloatArray], ...]:
        """Return block, point and force at the ends of all faces, as average stresses need them; none if dry."""
        if not self.acts:
            return ()
        found = []
        for block, start, end, ends in self._pressed(vertices):
            along = end - start
            inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
            points = np.stack([start, end], axis=1).reshape(-1, 2)
            found.append((np.repeat(block, 2), points, (ends[:, :, None] * inward[:, None, :]).reshape(-1, 2)))
        return tuple(found)

    def pressure(self, points: FloatArray, joint: IntArray) -> FloatArray:
        """Return the pressure at points (k, 2) [m] of faces with a joint (k,), (k,) [Pa].

        Where it comes from flow it is that of the nearest face as the blocks were given.
        """
        if self.on_parts is not None:
            return self.on_parts.at(self._parts(), points)
        piece = np.searchsorted(self.surface.breaks, points[:, 0])
        head = np.maximum(self.surface.at(points[:, 0]) - points[:, 1], 0.0)
        given: FloatArray = self.of_joint[joint]
        return np.where(np.isnan(given), self.water.unit_weight * self.surface.factor[piece] * head, given)

    def _pressed(self, vertices: FloatArray) -> Iterator[tuple[IntArray, FloatArray, FloatArray, FloatArray]]:
        """Return block, start, end and end forces of all edges under the table, then of what joints make different."""
        following = vertices[self.blocks.following]
        yield self.blocks.owner, vertices, following, self._under_table(vertices, following)
        if self.patches is not None:
            start, end = self.patches.points(vertices, self.blocks.following)
            instead = self.patches.forces(np.hypot(*(end - start).T)) - self._under_table(start, end)
            yield self.blocks.owner[self.patches.edge], start, end, instead

    def _parts(self) -> tuple[FloatArray, FloatArray]:
        """Return both ends of the parts of edges on which flow presses, as the blocks were given."""
        assert self.on_parts is not None
        return self.on_parts.points(self.blocks.vertices, self.blocks.following)


def _patches(model: Model, of_joint: FloatArray) -> FaceWater:
    """Return the pressure on both sides of the faces of joints with one given."""
    from bsm_mesh.model.face_stiffness import face_joints
    from bsm_mesh.model.faces import find_faces

    faces, blocks = find_faces(model.blocks), model.blocks
    pressure = of_joint[face_joints(model, faces)]
    chosen = np.flatnonzero(~np.isnan(pressure))
    edge = np.concatenate([faces.edge_b[chosen], faces.edge_a[chosen]])
    start = np.concatenate([faces.start[chosen], faces.end[chosen]])
    end = np.concatenate([faces.end[chosen], faces.start[chosen]])
    along = blocks.edge_vectors[edge]
    square = (along**2).sum(axis=1)
    part = np.stack([((at - blocks.vertices[edge]) * along).sum(axis=1) / square for at in (start, end)], axis=1)
    given = np.tile(pressure[chosen], 2)
    return FaceWater(edge=edge.astype(np.int32), ends=part, pressure=np.stack([given, given], axis=1))
