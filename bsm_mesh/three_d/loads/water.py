"""Water on polyhedra: pressure below a plane of head on all faces, or a pressure where blocks meet in a joint."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.model import Model
from bsm_mesh.model.water import Water
from bsm_mesh.movements import cross, turned
from bsm_mesh.three_d.blocks.contact_polygons import ContactPolygons
from bsm_mesh.three_d.blocks.moments import fan_triangles
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.contacts.part_polygons import part_polygons

DRY = 1e9  # m: a plane so far below is none


class WaterOnPolyhedra:
    """The water of a model of polyhedra.

    The pressure of a plane acts normal to every face, outer ones too, at the present position of the blocks. Triangles
    are cut where they leave the water, so that forces and moments are exact. On faces that blocks share, the pressure
    of the joint replaces that of the plane. So it does on parts of faces on which blocks touch as given.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    water : Water or None
        The water.
    default_joint : str, optional
        Joint of the faces between blocks that carry none.
    """

    block: IntArray  # (t,) of every triangle of the surfaces of all blocks
    arm: FloatArray  # (t, 3 corners, 3) from the centroid, as given
    inward: FloatArray  # (t, 3) area times the normal into the block
    own: FloatArray  # (t,) pressure of a joint [Pa]; nan: the plane's

    def __init__(self, blocks: Polyhedra, water: Water | None, default_joint: str | None = None) -> None:
        self.centroid: FloatArray = blocks.moments.centroid
        self.acts: bool = water is not None and (water.plane is not None or bool(water.joint_pressure))
        self.up, self.level, self.unit_weight = np.array([0.0, 0.0, 1.0]), -DRY, 0.0
        if water is None or not self.acts:
            return
        self.unit_weight = water.unit_weight
        if water.plane is not None:
            self.up = water.plane.up
            self.level = float(self.up @ water.plane.point)
        names = [*blocks.joint_names, default_joint or ""]
        by_joint = np.array([water.joint_pressure.get(name, np.nan) for name in names])
        self._of_parts = np.zeros(0)
        self._of_faces = np.where(blocks.face_cells[:, 1] >= 0, by_joint[blocks.face_joint], np.nan)
        self._set_triangles(blocks, self._of_faces)
        if water.joint_pressure:
            parts = part_polygons(blocks)
            own = by_joint[parts.joint]
            self._parts, self._of_parts = parts.some(np.flatnonzero(~np.isnan(own))), own[~np.isnan(own)]
            self._add_parts(self._parts, self._of_parts)

    def _set_triangles(self, blocks: Polyhedra, own: FloatArray) -> None:
        """Set the triangles of the surfaces, with the pressures of joints on faces (n_faces,)."""
        corner, face = fan_triangles(blocks.face_offsets)
        points = blocks.vertices[blocks.face_vertices[corner]]
        outward = cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]) / 2  # of the first side
        first, second = blocks.face_blocks[face].T
        one, other = np.flatnonzero(first != second), np.flatnonzero((first != second) & (second >= 0))
        row = np.concatenate([one, other])
        self.block = np.concatenate([first[one], second[other]])
        self.arm = points[row] - self.centroid[self.block][:, None, :]
        self.inward = np.concatenate([-outward[one], outward[other]])
        self.own = own[face[row]]

    def _add_parts(self, parts: ContactPolygons, own: FloatArray) -> None:
        """Add the pressures (q,) on parts of faces, and subtract that of the plane there."""
        corner, polygon = fan_triangles(parts.offsets)
        points = parts.corners[corner]
        into_a = cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]) / 2
        given, none = own[polygon], np.full(len(polygon), np.nan)
        for block, inward in ((parts.block_a[polygon], into_a), (parts.block_b[polygon], -into_a)):
            arm = points - self.centroid[block][:, None, :]
            self.block = np.concatenate([self.block, block, block])
            self.arm = np.concatenate([self.arm, arm, arm])
            self.inward = np.concatenate([self.inward, inward, -inward])
            self.own = np.concatenate([self.own, given, none])

    def pressure_at(self, point: FloatArray, own: FloatArray) -> FloatArray:
        """Return the water pressure at points (k, 3) as given, with those of their joints (k,), (k,) [Pa]."""
        if not self.acts:
            return np.zeros(len(point))
        below = np.maximum(self.unit_weight * (self.level - point @ self.up), 0.0)
        return np.where(np.isnan(own), below, own)

    def recorded(self) -> dict[str, Any]:
        """Return the fields of `Evidence` that tell of the water."""
        if not self.acts:
            return {}
        face = np.flatnonzero(~np.isnan(self._of_faces)).astype(np.int32)
        found = {
            "water_plane": np.array([*self.up[:2], self.level, self.unit_weight]),
            "water_face": face,
            "water_face_pressure": self._of_faces[face],
        }
        if not len(self._of_parts):
            return found
        return {
            **found,
            "water_part_block": np.column_stack([self._parts.block_a, self._parts.block_b]),
            "water_part_corner": self._parts.corners,
            "water_part_offsets": self._parts.offsets,
            "water_part_pressure": self._of_parts,
        }

    def on_blocks(self, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return forces and moments on all blocks (n, 6) at a position (n, 6), and forces times arms (n, 3, 3)."""
        total, dyad = np.zeros_like(position), np.zeros((len(position), 3, 3))
        if not self.acts:
            return total, dyad
        turn = position[self.block, 3:]
        arm: FloatArray = np.stack([turned(self.arm[:, k], turn) for k in range(3)], axis=1)
        inward = turned(self.inward, turn)
        place = (self.centroid + position[:, :3])[self.block]
        depth = self.unit_weight * (self.level - (place[:, None, :] + arm) @ self.up)
        depth = np.where(np.isnan(self.own)[:, None], depth, self.own[:, None])
        for block, parts, areas, pressures in _wet(self.block, arm, inward, depth):
            mean = pressures.mean(axis=1)[:, None]
            each = (pressures[:, :, None] * parts).sum(axis=1)
            both = pressures.sum(axis=1)[:, None] * parts.sum(axis=1) + each
            lever = both / 12  # of the arm times the pressure, over the triangle, per area vector
            np.add.at(total, block, np.hstack([mean * areas, cross(lever, areas)]))
            np.add.at(dyad, block, lever[:, :, None] * areas[:, None, :])
        return total, dyad


Parts = tuple[IntArray, FloatArray, FloatArray, FloatArray]


def _wet(block: IntArray, arm: FloatArray, inward: FloatArray, depth: FloatArray) -> list[Parts]:
    """Return the triangles whose pressures add up to those of the wet parts: block, corners, area, pressures there.

    Pressure is linear: of a triangle with one dry corner it is that of the whole less the (negative) one of the dry
    part.
    """
    wet = depth > 0
    count = wet.sum(axis=1)
    whole = count >= 2
    parts: list[Parts] = [(block[whole], arm[whole], inward[whole], depth[whole])]
    for lone, sign in ((1, 1.0), (2, -1.0)):  # the corner that is wet, or dry, alone
        rows = np.flatnonzero(count == lone)
        tip = (wet[rows] if lone == 1 else ~wet[rows]).argmax(axis=1)
        a, b, c = (arm[rows, (tip + k) % 3] for k in range(3))
        at, one, other = (depth[rows, (tip + k) % 3] for k in range(3))
        s, t = (at / (at - far) for far in (one, other))
        corners = np.stack([a, a + s[:, None] * (b - a), a + t[:, None] * (c - a)], axis=1)
        pressures = np.zeros((len(rows), 3))
        pressures[:, 0] = at
        parts.append((block[rows], corners, sign * (s * t)[:, None] * inward[rows], pressures))
    return parts


def joint_water(model: Model) -> FloatArray:
    """Return the pressure given for every joint of a model [Pa]; nan: none is."""
    given = {} if model.water is None else model.water.joint_pressure
    return np.array([given.get(joint.name, np.nan) for joint in model.joints], dtype=np.float64)
