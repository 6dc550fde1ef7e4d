"""Joint networks to cut, and the outcome of them in a form that does not depend on the numbers of blocks."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries import BlockCut, Fault, Region, RockMass
from bsm_mesh.geometries.cutting.faces import Faces

FloatArray = npt.NDArray[np.float64]


def box(left: float, bottom: float, right: float, top: float) -> list[tuple[float, float]]:
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


def circle(radius: float, sides: int = 24, centre: tuple[float, float] = (0.0, 0.0)) -> FloatArray:
    angle = np.arange(sides) * 2 * np.pi / sides
    return np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def rock(*lines: Any, **others: Any) -> RockMass:
    """Return a square of 10 m with some lines in it."""
    joints = [Fault(name=f"J{number}", lines=[line]) for number, line in enumerate(lines)]
    return RockMass(regions=[Region(outline=box(0, 0, 10, 10), rock="gneiss")], joints=joints, **others)


def areas(cut: BlockCut) -> FloatArray:
    return Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces).areas(cut.points)


def areas_within(cut: BlockCut, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Return the areas, greatest first, and how far each is open where a block's sides may lie a tolerance away."""
    faces = Faces(corners=cut.corners, rings=cut.rings, faces=cut.faces)
    area, open_by = faces.areas(cut.points), tolerance * faces.perimeters(cut.points)
    order = np.argsort(-area)
    return area[order], open_by[order]


def lengths(cut: BlockCut, groups: dict[str, Any]) -> dict[str, float]:
    return {
        name: float(np.hypot(*(cut.points[edges[:, 1]] - cut.points[edges[:, 0]]).T).sum())
        for name, edges in groups.items()
    }


def accounted(cut: BlockCut, tolerance: float) -> bool:
    """Return whether the parts of every joint's length add up to the whole."""
    return all(
        abs(a.in_rock + a.extended - (a.bounding + a.coincident + a.on_outline + a.dead + a.outside)) <= tolerance
        for a in cut.accounts
    )
