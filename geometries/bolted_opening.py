"""Twenty-four blocks round an opening: Example 4 of Wang (section 5.6, Figs. 5.12-5.16).

Block 15 is the wedge in the roof, block 10 the wedge in the left wall and block 6 the one at the lower left corner of
the opening. The thesis shows the blocks in figures only: all sizes are a reconstruction.
"""

from __future__ import annotations

import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import Point, Quadrilateral, Side, sides_of, write_quadrilaterals

WIDTH = HEIGHT = 10.0
LEFT, RIGHT, FLOOR, ROOF = 3.5, 6.5, 2.0, 6.0  # of the opening
BACK = 2.75  # of the wedge in the left wall
BED = (ROOF - 4.3) / LEFT  # slope of the joint from the left side over the wall wedge into the roof
ROUNDING = 1e-9


def build(path: str | os.PathLike[str], *, rock: str = "rock", **unknown: object) -> Path:
    """Write the mesh of 24 blocks round an opening, and return its path.

    Surface ``rock:rock``; curves ``joint:filling`` on every side of a block, and ``boundary:`` bottom, left, right and
    top of the square of 10 m.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
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
    checks.group_part(rock=rock)
    checks.raise_faults()
    blocks = _blocks()
    return write_quadrilaterals(
        path,
        blocks,
        [rock],
        joints={"filling": sides_of(range(len(blocks)))},
        boundaries={
            "bottom": _outer(blocks, 1, 0.0),
            "left": _outer(blocks, 0, 0.0),
            "right": _outer(blocks, 0, WIDTH),
            "top": _outer(blocks, 1, HEIGHT),
        },
        name="bolted_opening",
    )


def _blocks() -> list[Quadrilateral]:
    """Return the blocks, row by row from below, from left to right."""
    heel, step = (BACK, 4.28), (2.2, 3.85)  # lower back corner of the wall wedge; that of the corner block
    eave, ridge = (RIGHT + 1.8, _bed(4.0) - 2.3 * BED), (4.7, 7.3)
    hip = (WIDTH - ridge[0], ridge[1])
    split = (6.7, ridge[1] + (6.7 - hip[0]) * (7.8 - ridge[1]) / (8.1 - hip[0]))
    roof = ((4.0, _bed(4.0)), (6.0, _bed(4.0)))
    shelf, ledge = (BACK, _bed(BACK)), (1.2, _bed(1.2))
    return [
        ((0.0, 0.0), (2.0, 0.0), step, (0.0, 2.2)),
        ((2.0, 0.0), (3.6, 0.0), (LEFT, FLOOR), step),
        ((3.6, 0.0), (6.4, 0.0), (RIGHT, FLOOR), (LEFT, FLOOR)),
        ((6.4, 0.0), (8.2, 0.0), (8.3, 2.1), (RIGHT, FLOOR)),
        ((8.2, 0.0), (WIDTH, 0.0), (WIDTH, 2.0), (8.3, 2.1)),
        ((0.0, 2.2), step, heel, (0.0, 3.5)),
        (step, (LEFT, FLOOR), (LEFT, 3.5), heel),
        ((RIGHT, FLOOR), (8.3, 2.1), (8.2, 4.2), (RIGHT, 4.0)),
        ((8.3, 2.1), (WIDTH, 2.0), (WIDTH, 4.1), (8.2, 4.2)),
        ((0.0, 3.5), heel, shelf, (0.0, _bed(0.0))),
        (heel, (LEFT, 3.5), (LEFT, ROOF), shelf),
        ((RIGHT, 4.0), (8.2, 4.2), eave, (RIGHT, ROOF)),
        ((8.2, 4.2), (WIDTH, 4.1), (WIDTH, 5.4), eave),
        ((0.0, _bed(0.0)), ledge, (1.5, 7.9), (0.0, 8.0)),
        (ledge, roof[0], ridge, (1.5, 7.9)),
        (roof[0], roof[1], hip, ridge),
        (roof[1], eave, (8.1, 7.8), hip),
        (eave, (WIDTH, 5.4), (WIDTH, 8.0), (8.1, 7.8)),
        ((0.0, 8.0), (1.5, 7.9), (1.7, HEIGHT), (0.0, HEIGHT)),
        ((1.5, 7.9), ridge, (4.4, HEIGHT), (1.7, HEIGHT)),
        (ridge, hip, (5.6, HEIGHT), (4.4, HEIGHT)),
        (hip, split, (6.8, HEIGHT), (5.6, HEIGHT)),
        (split, (8.1, 7.8), (8.0, HEIGHT), (6.8, HEIGHT)),
        ((8.1, 7.8), (WIDTH, 8.0), (WIDTH, HEIGHT), (8.0, HEIGHT)),
    ]


def _bed(x: float) -> float:
    """Return the height of the joint over the wall wedge."""
    return ROOF + (x - LEFT) * BED


def _outer(blocks: list[Quadrilateral], axis: int, value: float) -> list[Side]:
    """Return the sides on a side of the square."""

    def there(point: Point) -> bool:
        return abs(point[axis] - value) < ROUNDING

    return [
        (number, side)
        for number, block in enumerate(blocks)
        for side in range(4)
        if there(block[side]) and there(block[(side + 1) % 4])
    ]
