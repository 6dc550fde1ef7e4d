"""Water on polyhedra: pressure below a plane of head, or that of a joint, over the faces where the blocks are."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import AGREES, Arrays


def water_faults(a: Arrays, reference: float) -> list[str]:
    """Return whether the forces of the water follow from the plane and the pressures in joints."""
    found = np.zeros_like(a["water"]) if "water_plane" not in a else forces(a)
    off = np.abs(found - a["water"])
    off[:, 3:] /= a["gyration"][:, None]
    allowed = AGREES * (reference + np.abs(found[:, :3]).max(initial=0.0))
    if off.max(initial=0.0) <= allowed:
        return []
    return [f"the water presses on block {int(off.max(axis=1).argmax())} otherwise than its plane and pressures say"]


def forces(a: Arrays) -> Any:
    """Return forces and moments of the water on all blocks, (n, 6)."""
    slope_x, slope_y, level, weight = a["water_plane"]
    own = np.full(len(a["face_area"]), np.nan)
    own[a["water_face"]] = a["water_face_pressure"]
    total = np.zeros_like(a["water"])
    there = np.where(a["face_blocks"] >= 0, a["present"][a["face_blocks"]], False)
    blocks = np.where(there, a["face_blocks"], -1)
    for side, other in ((0, 1), (1, 0)):
        for face in np.flatnonzero(there[:, side] & (blocks[:, side] != blocks[:, other])):
            block = blocks[face, side]
            corners = a["vertices"][a["face_vertices"][a["face_offsets"][face] : a["face_offsets"][face + 1]]]
            arm = (corners - a["centroid"][block]) @ matrix(a["position"][block, 3:]).T
            arm = arm if side == 0 else arm[::-1]  # counter-clockwise seen from outside the block
            depth = weight * (level - (a["at"][block] + arm) @ (slope_x, slope_y, 1.0))
            if not np.isnan(own[face]):
                depth = np.full(len(arm), own[face])
            total[block] += pressed(*wet_part(arm, depth))
    return total + on_parts(a) if "water_part_block" in a else total


def on_parts(a: Arrays) -> Any:
    """Return the same of parts of faces with a pressure of their own, less that of the plane there, (n, 6)."""
    slope_x, slope_y, level, weight = a["water_plane"]
    total, offsets = np.zeros_like(a["water"]), a["water_part_offsets"]
    for part, pair in enumerate(a["water_part_block"]):
        for block, turned_over in zip(pair, (True, False), strict=True):  # counter-clockwise seen from outside b
            corners = a["water_part_corner"][offsets[part] : offsets[part + 1]]
            arm = (corners - a["centroid"][block]) @ matrix(a["position"][block, 3:]).T
            arm = arm[::-1] if turned_over else arm
            depth = weight * (level - (a["at"][block] + arm) @ (slope_x, slope_y, 1.0))
            total[block] += pressed(arm, np.full(len(arm), a["water_part_pressure"][part]))
            total[block] -= pressed(*wet_part(arm, depth))
    return total


def wet_part(arm: Any, depth: Any) -> tuple[Any, Any]:
    """Return the corners of the part of a convex polygon that is wet, and the pressures there."""
    if (depth >= 0).all():
        return arm, depth
    kept = []
    for k in range(len(arm)):
        after = (k + 1) % len(arm)
        if depth[k] >= 0:
            kept.append((arm[k], depth[k]))
        if depth[k] * depth[after] < 0:
            part = depth[k] / (depth[k] - depth[after])
            kept.append((arm[k] + part * (arm[after] - arm[k]), 0.0))
    return np.array([point for point, _ in kept]), np.array([pressure for _, pressure in kept])


def pressed(arm: Any, pressure: Any) -> Any:
    """Return force and moment (6,) of a pressure, linear over a convex polygon, by the midpoints of its triangles."""
    total = np.zeros(6)
    for k in range(1, len(arm) - 1):
        corners = [0, k, k + 1]
        inward = -np.cross(arm[k] - arm[0], arm[k + 1] - arm[0]) / 2
        for one, other in ((0, 1), (1, 2), (2, 0)):
            i, j = corners[one], corners[other]
            force = (pressure[i] + pressure[j]) / 6 * inward
            total += np.concatenate([force, np.cross((arm[i] + arm[j]) / 2, force)])
    return total


def matrix(turn: Any) -> Any:
    """Return the matrix of a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sinc(angle / np.pi) * K + np.sinc(angle / (2 * np.pi)) ** 2 / 2 * K @ K
