"""A column of equal blocks on a base, level or inclined; of one block: a block on an incline.

Block 0 is the base; the others follow from the lowest up.
"""

from __future__ import annotations

import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import rectangle, sides_of, turn, write_quadrilaterals


def build(
    path: str | os.PathLike[str],
    *,
    count: int = 4,
    width: float = 1.0,
    height: float = 2.0,
    dip: float = 0.0,
    margin: float | None = None,
    thickness: float | None = None,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of a column and return its path.

    Surface ``rock:rock``; curves ``joint:joint`` on every side and ``boundary:base`` under block 0. The
    column's lower right corner, about which it topples, is the origin.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    count : int
        Number of blocks in the column.
    width : float
        Width of a block, along the base [m].
    height : float
        Height of a block, across the base [m].
    dip : float
        Dip of the base to the right [degrees].
    margin : float, optional
        Length of the base on either side of the column [m]; the column's height where not given.
    thickness : float, optional
        Thickness of the base [m]; as `width` where not given.
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
    checks.positive(width=width, height=height)
    checks.positive_or_none(margin=margin, thickness=thickness)
    checks.count(count=count)
    checks.within(0.0, 90.0, "degrees", dip=dip)
    checks.group_part(rock=rock)
    checks.raise_faults()
    beside = count * height if margin is None else margin
    below = width if thickness is None else thickness
    blocks = [rectangle(-width - beside, -below, beside, 0.0)]
    blocks += [rectangle(-width, k * height, 0.0, (k + 1) * height) for k in range(count)]
    return write_quadrilaterals(
        path, turn(blocks, dip), [rock], joints={"joint": sides_of(range(count + 1))}, boundaries={"base": [(0, 0)]},
        name="column",
    )  # fmt: skip
