"""A slope of layers parallel to its face that may slide to its toe: Example 3 of Wang (section 4.6).

Block 0 is the rock under the layers, those after it are the toe, one a layer from the lowest up; then come
the blocks of the layers, from the lowest layer up, each from the crest down. The sizes stand in Figs. 4.20
to 4.22 only; those here are a reconstruction.
"""

from __future__ import annotations

import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import rectangle, sides_of, turn, write_quadrilaterals


def build(
    path: str | os.PathLike[str],
    *,
    dip: float = 40.0,
    layers: int = 2,
    blocks: int = 6,
    length: float = 2.0,
    thickness: float = 1.0,
    gap: float = 2.0,
    step: float = 1.0,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of a stratified slope and return its path.

    Surface ``rock:rock``; curves ``joint:set1`` along the layers, ``joint:set2`` across them, ``boundary:base``
    under block 0 and the ends of the base and the toe, ``boundary:left`` and ``boundary:right``. The lower end of
    the lowest layer is the origin.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    dip : float
        Dip of face and layers to the right [degrees].
    layers : int
        Number of layers that may slide.
    blocks : int
        Blocks in a layer.
    length : float
        Length of a block along the layer [m].
    thickness : float
        Thickness of a layer [m].
    gap : float
        From the lowest layer to the toe [m].
    step : float
        By how much farther the toe lies for each further layer [m].
    rock : str
        Name of the rock.
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
    checks.positive(length=length, thickness=thickness, gap=gap)
    checks.count(layers=layers, blocks=blocks)
    checks.within(0.0, 90.0, "degrees", dip=dip)
    checks.within(0.0, float("inf"), "m", step=step)
    checks.group_part(rock=rock)
    checks.raise_faults()
    crest, end = -blocks * length, gap + (layers - 1) * step + length
    drawn = [rectangle(crest - length, -length, end, 0.0)]
    for k in range(layers):
        drawn.append(rectangle(gap + k * step, k * thickness, end, (k + 1) * thickness))
    for k in range(layers):
        low, high = k * thickness, (k + 1) * thickness
        drawn += [rectangle(crest + i * length, low, crest + (i + 1) * length, high) for i in range(blocks)]
    fixed, every = range(layers + 1), range(len(drawn))
    return write_quadrilaterals(
        path, turn(drawn, dip), [rock],
        joints={"set1": sides_of(every, (0, 2)), "set2": sides_of(every, (1, 3))},
        boundaries={"base": [(0, 0)], "left": [(0, 3)], "right": sides_of(fixed, (1,))},
        name="stratified_slope",
    )  # fmt: skip
