"""A concrete dam keyed into jointed rock under water: Example 5 of Wang (section 6.4).

Block 0 is the dam, which is in the uppermost bed, on the bedding joint below it; the blocks of the rock follow in
beds from below, each from upstream (left) to downstream. The heel of the dam is at x = 0, the rock's surface y = 0. All
sizes are in Fig. 6.8 only; those here are a reconstruction.
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
    toe: float = 3.0,
    toe_dip: float = 45.0,
    **unknown: object,
) -> Path:
    """Write the mesh of a dam keyed into jointed rock and return its path.

    Surfaces ``rock:concrete`` and ``rock:rock``; curves ``joint:contact`` round the dam, ``joint:bedding`` and
    ``joint:cross`` in the rock, ``boundary:bottom``, ``boundary:left``, ``boundary:right``.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    height : float
        Height of the dam above the rock [m]; its upstream face is vertical.
    base : float
        Width of the dam at the rock's surface [m]; its faces continue as deep as the uppermost bed.
    crest : float
        Width of the dam above [m].
    upstream : int
        Blocks in a bed upstream of the dam.
    downstream : int
        Blocks in a bed downstream of the dam.
    under : int
        Blocks in a bed under the dam: their length is ``base / under``.
    beds : int
        Number of beds, with the one that the dam is in.
    thickness : float
        Thickness of a bed [m].
    dip : float
        Dip of the cross joints to the right, downstream [degrees].
    toe : float
        Length of the block at the toe along its base [m].
    toe_dip : float
        Dip to the left, upstream, of the cross joints in the uppermost bed beyond the toe [degrees]; above 90 they dip
        downstream. Below 90 the block at the toe is a wedge that the dam may push up.
    **unknown
        Refused, with the nearest parameter that there is.

    Raises
    ------
    GeometryError
        With all faults of the parameters.
    """
    checks = ParameterChecks(build, unknown)
    checks.positive(height=height, base=base, crest=crest, thickness=thickness, toe=toe)
    checks.count(upstream=upstream, downstream=downstream, under=under)
    checks.count(2, beds=beds)
    checks.within(30.0, 90.0, "degrees", dip=dip)
    checks.within(30.0, 150.0, "degrees", toe_dip=toe_dip)
    checks.raise_faults()
    width = base / under
    batter = (base - crest) / height
    lean = -thickness / math.tan(math.radians(dip))  # of a cross joint through a bed, from below
    left, right = -upstream * width, base + downstream * width - beds * lean
    foot = base + batter * thickness  # the dam's downstream face meets the bedding joint
    rise = thickness / math.tan(math.radians(toe_dip))
    blocks: list[Quadrilateral] = [((0.0, -thickness), (foot, -thickness), (crest, height), (0.0, height))]
    for bed in range(beds - 1):
        blocks += _bed(bed - beds, width, thickness, lean, (-upstream, under + downstream), (left, right))
    in_bed = upstream + under + downstream
    below = range(1, len(blocks))
    joints = [k * width for k in range(1 - upstream, 0)]
    blocks += _strip(-thickness, 0.0, [left, *(x - lean for x in joints), 0.0], [left, *joints, 0.0])
    toe_block = len(blocks)
    joints = [foot + toe + k * width for k in range(downstream - 1)]
    blocks += _strip(-thickness, 0.0, [foot, *joints, right], [base, *(x + rise for x in joints), right])
    top = range(below.stop, len(blocks))
    ends = [*below[in_bed - 1 :: in_bed], len(blocks) - 1]
    return write_quadrilaterals(
        path, blocks, ["concrete"] + ["rock"] * (len(blocks) - 1),
        joints={
            "contact": [(0, 0), (toe_block - 1, 1), (toe_block, 3)],
            "bedding": sides_of(below, (2,)),
            "cross": [(b, 1) for b in (*below, *top) if b not in (*ends, toe_block - 1)],
        },
        boundaries={
            "bottom": sides_of(below[:in_bed], (0,)),
            "left": sides_of((*below[::in_bed], top[0]), (3,)),
            "right": sides_of(ends, (1,)),
        },
        name="dam_foundation",
    )  # fmt: skip


def _strip(low: float, high: float, below: list[float], above: list[float]) -> list[Quadrilateral]:
    """Return the blocks between joints from `below` at height `low` to `above` at `high`."""
    return [
        ((below[i], low), (below[i + 1], low), (above[i + 1], high), (above[i], high)) for i in range(len(below) - 1)
    ]


def _bed(
    level: int, width: float, thickness: float, lean: float, ends: tuple[int, int], sides: tuple[float, float]
) -> list[Quadrilateral]:
    """Return the blocks of a bed; its joints are continued from bed to bed, the outer blocks end upright."""
    low, high = level * thickness, (level + 1) * thickness
    below = [k * width + level * lean for k in range(ends[0] + 1, ends[1])]
    above = [x + lean for x in below]
    below, above = [sides[0], *below, sides[1]], [sides[0], *above, sides[1]]
    return _strip(low, high, below, above)
