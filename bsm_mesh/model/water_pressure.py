"""Water pressure on faces: linear heads integrated exactly, over wet parts and bends of the table (Wang ch. 6)."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.face_water import FaceWater
from bsm_mesh.model.water import Water
from bsm_mesh.model.water_kernels import add_face_forces, add_field_change, end_forces

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model


class WaterLoad:
    """The water's forces on the blocks of a model, wherever they are stable.

    Parameters
    ----------
    model : Model
        The input: its ``water`` and ``face_water`` may be None; with neither all forces are zero.
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
        self.patches, self._across = self.on_parts, np.zeros(0, np.int32)  # blocks on the other side of joints' patches
        if self.water.joint_pressure:
            self.patches, self._across = _patches(model, self.of_joint)
        self.acts = bool(np.isfinite(self.surface.level).any() or self.patches is not None)

    def of_present(self, present: BoolArray) -> WaterLoad:
        """Return the water where some blocks (n,) alone are there: a joint's own pressure acts between two of them.

        On faces that a removed block has bared the table's pressure acts.
        """
        found = copy(self)
        if self.patches is not None and self.water.joint_pressure:
            found._across, found.patches = self._across[kept := present[self._across]], self.patches.chosen(kept)
        return found

    def on_faces(self, start: FloatArray, end: FloatArray, joint: IntArray | None = None) -> FloatArray:
        """Return the pressure forces at both ends of faces, (k, 2) [N/m].

        Without `joint` (k,), the number of each face's joint (-1: rock), all have the table's pressure.
        """
        if self.on_parts is not None:
            return self.on_parts.on_lines(self._parts(), start, end)
        return self._under_table(start, end, joint)

    def _under_table(self, start: FloatArray, end: FloatArray, joint: IntArray | None = None) -> FloatArray:
        s = self.surface
        start, end = (np.array(points, order="C") for points in (start, end))  # of one type for the kernel
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

    def stiffness(self, vertices: FloatArray, centroid: FloatArray) -> FloatArray:
        """Return the derivatives of minus `on_blocks` by the movement of every block about its centroid, (n, 3, 3).

        Symmetric under tables, whose pressure is a field in space; not where a face takes its pressure with it.
        """
        change = np.zeros((self.blocks.count, 3, 3))
        if not self.acts:
            return change
        s, following = self.surface, vertices[self.blocks.following]
        table = s.breaks, s.level, s.slope, s.factor, self.water.unit_weight
        add_field_change(self.blocks.owner, vertices, following, centroid, *table, 1.0, change)
        if self.patches is not None:
            start, end = self.patches.points(vertices, self.blocks.following)
            add_field_change(self.blocks.owner[self.patches.edge], start, end, centroid, *table, -1.0, change)
        force = self.on_blocks(vertices, centroid)
        change[:, 0, 2] -= force[:, 1]  # all pressures turn with the faces
        change[:, 1, 2] += force[:, 0]
        return -change

    def on_outlines(
        self, owner: IntArray, start: FloatArray, end: FloatArray, centroid: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return `on_blocks` and `stiffness` of blocks with other outlines, under the table alone.

        Parameters
        ----------
        owner : (k,) int32
            Block of every face.
        start, end : (k, 2) float64 [m]
            Ends of the faces.
        centroid : (n, 2) float64 [m]
            Of the blocks.
        """
        force, change = np.zeros((len(centroid), 3)), np.zeros((len(centroid), 3, 3))
        if self.acts:
            s = self.surface
            add_face_forces(owner, start, end, centroid, self._under_table(start, end), force)
            table = s.breaks, s.level, s.slope, s.factor, self.water.unit_weight
            add_field_change(owner, start, end, centroid, *table, 1.0, change)
            change[:, 0, 2] -= force[:, 1]
            change[:, 1, 2] += force[:, 0]
        return force, -change

    def recorded(self) -> dict[str, Any]:
        """Return the kept part of the water with a stage's result: fields of `StageResult` by their names."""
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


def _patches(model: Model, of_joint: FloatArray) -> tuple[FaceWater, IntArray]:
    """Return the pressure on both sides of the faces of joints with one given, and the block across each, (p,)."""
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
    found = FaceWater(edge=edge.astype(np.int32), ends=part, pressure=np.stack([given, given], axis=1))
    return found, np.roll(blocks.owner[edge], len(chosen))
