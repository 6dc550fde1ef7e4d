"""A concrete dam on jointed rock under water: Example 5 of Wang (section 6.4).

Block 0 is the dam; the blocks of the rock follow in beds from below, each from upstream (left) to downstream. The heel
of the dam is the origin, the rock's surface y = 0. All sizes stand in Fig. 6.8 only; those here are a reconstruction.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import Quadrilateral, sides_of, write_quadrilaterals


def build(
    path: str | os.PathLike[str],
    *,
    height: float = 40.0,
    base: float = 32.0,
    crest: float = 6.0,
    upstream: int = 5,
    downstream: int = 6,
    under: int = 3,
    beds: int = 3,
    thickness: float = 8.0,
    dip: float = 45.0,
    **unknown: object,
) -> Path:
    """Write the mesh of a dam on jointed rock and return its path.

    Surfaces ``rock:concrete`` and ``rock:rock``; curves ``joint:contact`` under the dam, ``joint:bedding`` and
    ``joint:cross`` in the rock, ``boundary:bottom``, ``boundary:left``, ``boundary:right``.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    height : float
        Height of the dam [m]; its upstream face is vertical.
    base : float
        Width of the dam on the rock [m].
    crest : float
        Width of the dam above [m].
    upstream : int
        Blocks in a bed upstream of the dam.
    downstream : int
        Blocks in a bed downstream of the dam.
    under : int
        Blocks in a bed under the dam.
    beds : int
        Number of beds.
    thickness : float
        Thickness of a bed [m].
    dip : float
        Dip of the cross joints to the right, downstream [degrees]: a block pushed that way may ride up.
    **unknown
        Refused, with the nearest parameter that there is.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    GeometryError
        With all faults of the parameters.
    """
    checks = ParameterChecks(build, unknown)
    checks.positive(height=height, base=base, crest=crest, thickness=thickness)
    checks.count(upstream=upstream, downstream=downstream, under=under, beds=beds)
    checks.within(30.0, 90.0, "degrees", dip=dip)
    checks.raise_faults()
    width = base / under
    blocks: list[Quadrilateral] = [((0.0, 0.0), (base, 0.0), (crest, height), (0.0, height))]
    lean = -thickness / math.tan(math.radians(dip))  # of a cross joint through a bed, from below
    left, right = -upstream * width, base + downstream * width - beds * lean
    for bed in range(beds):
        blocks += _bed(bed - beds, width, thickness, lean, (-upstream, under + downstream), (left, right))
    in_bed = (len(blocks) - 1) // beds
    rock = range(1, len(blocks))
    return write_quadrilaterals(
        path, blocks, ["concrete"] + ["rock"] * len(rock),
        joints={
            "contact": [(0, 0)],
            "bedding": sides_of(rock[:-in_bed], (2,)) + sides_of(rock[in_bed:], (0,)),
            "cross": [(b, 1) for b in rock if b % in_bed],
        },
        boundaries={
            "bottom": sides_of(rock[:in_bed], (0,)),
            "left": sides_of(rock[::in_bed], (3,)),
            "right": sides_of(rock[in_bed - 1 :: in_bed], (1,)),
        },
        name="dam_foundation",
    )  # fmt: skip


def _bed(
    level: int, width: float, thickness: float, lean: float, ends: tuple[int, int], sides: tuple[float, float]
) -> list[Quadrilateral]:
    """Return the blocks of a bed; its joints are continued from bed to bed, the outer blocks end upright."""
    low, high = level * thickness, (level + 1) * thickness
    below = [k * width + level * lean for k in range(ends[0] + 1, ends[1])]
    above = [x + lean for x in below]
    below, above = [sides[0], *below, sides[1]], [sides[0], *above, sides[1]]
    return [
        ((below[i], low), (below[i + 1], low), (above[i + 1], high), (above[i], high)) for i in range(len(below) - 1)
    ]
