"""A block pushed along another towards a third: Example 2 of Wang (section 4.6, Figs. 4.16-4.19).

Block 0 is the base, block 1 the one to push, block 2 the wall in its way. Of the sizes only the 0.5 m
between blocks 1 and 2 are in the text; the others are a reconstruction.
"""

from __future__ import annotations

import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import rectangle, sides_of, write_quadrilaterals


def build(
    path: str | os.PathLike[str],
    *,
    size: float = 1.0,
    gap: float = 0.5,
    separation: float | None = None,
    behind: float = 1.0,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of a block that is pushed towards another, and return its path.

    Surface ``rock:rock``; curves ``joint:joint`` on every side and ``boundary:base`` under block 0. The
    pushed block is on the x axis, its left side at x = 0.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    size : float
        Width and height of the pushed block and thickness of the base [m].
    gap : float
        From the pushed block to the wall [m].
    separation : float, optional
        From the end of the base to the wall [m]; the wall is on the base where not given.
    behind : float
        Length of the base behind the pushed block [m].
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
    good = checks.positive(size=size, gap=gap, behind=behind)
    if checks.positive_or_none(separation=separation) and good and separation is not None and separation > gap:
        checks.add(
            f"separation = {separation} m exceeds gap = {gap} m: the pushed block would extend beyond the end of "
            "the base; give a separation of at most gap"
        )
    checks.group_part(rock=rock)
    checks.raise_faults()
    face = size + gap
    on_base = separation is None
    end = face + size if separation is None else face - separation
    blocks = [
        rectangle(-behind, -size, end, 0.0),
        rectangle(0.0, 0.0, size, size),
        rectangle(face, 0.0 if on_base else -size, face + size, 2.0 * size),
    ]
    return write_quadrilaterals(
        path, blocks, [rock], joints={"joint": sides_of(range(3))}, boundaries={"base": [(0, 0)]}, name="pushed_block"
    )
