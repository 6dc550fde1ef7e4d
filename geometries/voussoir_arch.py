"""A semicircular arch of equal voussoirs with straight sides, between two springing blocks.

Blocks 0 and 1 are the left and the right springing; the voussoirs follow from left to right.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import Point, Quadrilateral, rectangle, sides_of, write_quadrilaterals


def build(
    path: str | os.PathLike[str],
    *,
    count: int = 16,
    radius: float = 1.0,
    thickness: float = 0.15,
    springing: float | None = None,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of an arch and return its path.

    Surface ``rock:rock``; curves ``joint:joint`` on every side and ``boundary:base`` under the springings. The
    centre of the arch is the origin.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    count : int
        Number of voussoirs; an even one gives a joint at the crown.
    radius : float
        Radius of the centre line: a voussoir's corners lie half the thickness inside and outside [m].
    thickness : float
        Thickness of the arch [m].
    springing : float, optional
        Height of the springing blocks [m]; as `thickness` where not given.
    rock : str
        Name of the rock.
    **unknown
        Refused, with the nearest parameter that there is.

    Raises
    ------
    GeometryError
        With all faults of the parameters.
    """
    checks = ParameterChecks(build, unknown)
    checks.count(2, count=count)
    checks.positive_or_none(springing=springing)
    if checks.positive(radius=radius, thickness=thickness) and thickness >= 2.0 * radius:
        checks.add(f"thickness = {thickness} m is not less than twice radius = {radius} m; give less")
    checks.group_part(rock=rock)
    checks.raise_faults()
    inner, outer = radius - thickness / 2.0, radius + thickness / 2.0
    depth = thickness if springing is None else springing
    blocks = [rectangle(-outer, -depth, -inner, 0.0), rectangle(inner, -depth, outer, 0.0)]
    blocks += [_voussoir(k, count, inner, outer) for k in range(count)]
    return write_quadrilaterals(
        path, blocks, [rock], joints={"joint": sides_of(range(len(blocks)))},
        boundaries={"base": [(0, 0), (1, 0)]}, name="voussoir_arch",
    )  # fmt: skip


def _voussoir(number: int, count: int, inner: float, outer: float) -> Quadrilateral:
    """Return a voussoir; its sides are the intrados, the right joint, the extrados and the left joint."""
    left, right = (math.pi * (1.0 - k / count) for k in (number, number + 1))

    def corner(r: float, angle: float) -> Point:
        return r * math.cos(angle), r * math.sin(angle)

    return corner(inner, left), corner(inner, right), corner(outer, right), corner(outer, left)
