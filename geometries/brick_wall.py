"""A wall of bricks in running bond on a base, with half bricks at the ends of every other course.

Block 0 is the base; the bricks follow course by course from the lowest up, each from the left.
"""

from __future__ import annotations

import itertools
import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import rectangle, sides_of, write_quadrilaterals


def build(
    path: str | os.PathLike[str],
    *,
    courses: int = 10,
    bricks: int = 10,
    length: float = 1.0,
    height: float = 0.5,
    margin: float | None = None,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of a brick wall and return its path.

    Surface ``rock:rock``; curves ``joint:bed`` on the lower and upper sides of the blocks, ``joint:head`` on
    the others, ``boundary:base`` under block 0. The wall's lower left corner is the origin.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    courses : int
        Number of courses.
    bricks : int
        Whole bricks in a course.
    length : float
        Length of a brick [m].
    height : float
        Height of a brick [m].
    margin : float, optional
        Length of the base on either side of the wall [m]; as `length` where not given.
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
    checks.positive(length=length, height=height)
    checks.positive_or_none(margin=margin)
    checks.count(courses=courses, bricks=bricks)
    checks.group_part(rock=rock)
    checks.raise_faults()
    beside = length if margin is None else margin
    blocks = [rectangle(-beside, -height, bricks * length + beside, 0.0)]
    for course in range(courses):
        heads = [float(k) for k in range(bricks + 1)]
        if course % 2:
            heads = [0.0, *(k + 0.5 for k in range(bricks)), float(bricks)]
        low, high = course * height, (course + 1) * height
        blocks += [rectangle(a * length, low, b * length, high) for a, b in itertools.pairwise(heads)]
    every = range(len(blocks))
    return write_quadrilaterals(
        path, blocks, [rock], joints={"bed": sides_of(every, (0, 2)), "head": sides_of(every, (1, 3))},
        boundaries={"base": [(0, 0)]}, name="brick_wall",
    )  # fmt: skip
