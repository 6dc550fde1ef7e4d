"""Water pressure on faces: linear heads integrated exactly, over wet parts and bends of the table (Wang ch. 6)."""

from __future__ import annotations

import numba as nb
import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.model.water import Water


@nb.njit(cache=True)
def end_forces(
    start: FloatArray,
    end: FloatArray,
    given: FloatArray,
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
    given : (k,) float64 [Pa]
        Pressure all along the face; nan: that of the table.
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
        if not np.isnan(given[k]):
            forces[k, 0] = forces[k, 1] = length * given[k] / 2
            continue
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


@nb.njit(cache=True)
def add_water_forces(
    vertices: FloatArray, offsets: FloatArray, centroid: FloatArray, ends: FloatArray, total: FloatArray
) -> None:  # pragma: no cover - compiled
    """Add force and moment of the water on all edges, from `end_forces`, to `total` (n, 3) (Wang Eqs. 6.6, 6.7)."""
    for b in range(offsets.size - 1):
        for e in range(offsets[b], offsets[b + 1]):
            f = e + 1 if e + 1 < offsets[b + 1] else offsets[b]
            dx, dy = vertices[f, 0] - vertices[e, 0], vertices[f, 1] - vertices[e, 1]
            length = np.hypot(dx, dy)
            for corner, size in ((e, ends[e, 0]), (f, ends[e, 1])):
                fx, fy = -size * dy / length, size * dx / length  # inwards
                total[b, 0] += fx
                total[b, 1] += fy
                total[b, 2] += (vertices[corner, 0] - centroid[b, 0]) * fy - (vertices[corner, 1] - centroid[b, 1]) * fx


class WaterLoad:
    """The water's forces on the blocks of a model, wherever they stand.

    Parameters
    ----------
    model : Model
        What is given; its ``water`` may be None: all forces are zero.
    """

    def __init__(self, model: Model) -> None:
        self.water = model.water or Water()
        self.blocks = model.blocks
        self.surface = self.water.surface()
        self.joint_names = [joint.name for joint in model.joints]
        self.given = _given_pressures(model, self.water)
        self.acts = bool(np.isfinite(self.surface.level).any() or not np.isnan(self.given).all())

    def on_faces(self, start: FloatArray, end: FloatArray, given: FloatArray | None = None) -> FloatArray:
        """Return the pressure forces at both ends of faces, (k, 2) [N/m]; `given` as in `end_forces`."""
        s = self.surface
        given = np.full(len(start), np.nan) if given is None else given
        forces: FloatArray = end_forces(start, end, given, s.breaks, s.level, s.slope, s.factor, self.water.unit_weight)
        return forces

    def on_edges(self, vertices: FloatArray) -> FloatArray:
        """Return the pressure forces at both ends of every edge, the corners being at `vertices`, (n_vertices, 2)."""
        return self.on_faces(vertices, vertices[self.blocks.following], self.given)

    def on_blocks(self, vertices: FloatArray, centroid: FloatArray) -> FloatArray:
        """Return force and moment about the centroid on every block, (n, 3)."""
        total = np.zeros((self.blocks.count, 3))
        if self.acts:
            add_water_forces(vertices, self.blocks.offsets, centroid, self.on_edges(vertices), total)
        return total

    def point_forces(self, vertices: FloatArray) -> tuple[tuple[IntArray, FloatArray, FloatArray], ...]:
        """Return block, point and force at both ends of every edge, as average stresses need them; none if dry."""
        if not self.acts:
            return ()
        along = vertices[self.blocks.following] - vertices
        inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        force = self.on_edges(vertices)[:, :, None] * inward[:, None, :]
        ends = np.stack([vertices, vertices[self.blocks.following]], axis=1)
        return ((np.repeat(self.blocks.owner, 2), ends.reshape(-1, 2), force.reshape(-1, 2)),)

    def pressure(self, points: FloatArray, joint: IntArray) -> FloatArray:
        """Return the pressure at points (k, 2) [m] of faces with a joint (k,), (k,) [Pa]."""
        piece = np.searchsorted(self.surface.breaks, points[:, 0])
        head = self.surface.at(points[:, 0]) - points[:, 1]
        found: FloatArray = self.water.unit_weight * self.surface.factor[piece] * np.maximum(head, 0.0)
        for name, pressure in self.water.joint_pressure.items():
            found[joint == self.joint_names.index(name)] = pressure
        return found


def _given_pressures(model: Model, water: Water) -> FloatArray:
    """Return the pressure given for every edge's joint, nan where none is, (n_vertices,) [Pa]."""
    given = np.full(len(model.blocks.vertices), np.nan)
    if not water.joint_pressure:
        return given
    names = joint_of_edges(model)
    for name, pressure in water.joint_pressure.items():
        given[names == [joint.name for joint in model.joints].index(name)] = pressure
    return given


def joint_of_edges(model: Model) -> IntArray:
    """Return the joint's number of every edge between two blocks, -1 for rock and outer edges, (n_vertices,)."""
    from bsm_mesh.model.face_stiffness import face_joints
    from bsm_mesh.model.faces import find_faces

    faces = find_faces(model.blocks)
    joint = face_joints(model, faces)
    of_edge = np.full(len(model.blocks.vertices), -1)
    for edges in (faces.edge_a, faces.edge_b):
        of_edge[edges] = np.maximum(of_edge[edges], joint)
    return of_edge
