"""A slope of layers parallel to its face that may slide to its toe: Example 3 of Wang (section 4.6).

Block 0 is the rock under the layers, those after it are the toe, one a layer from the lowest up; then come
the blocks of the layers, from the lowest layer up, each from the crest down. With a floor, block 1 is that and the
layers follow; or all rock is of layers, down to the bottom and under the floor. The sizes are in Figs. 4.20
to 4.22 only; those here are a reconstruction.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks
from bsm_mesh.geometries.quadrilaterals import Quadrilateral, rectangle, sides_of, turn, write_quadrilaterals

SHORTEST = 0.4  # of a block's lesser side: shorter sides are closed where joints meet the outline


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
    floor: float = 0.0,
    layered: bool = False,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of a stratified slope and return its path.

    Surface ``rock:rock``; curves ``joint:set1`` along the layers, ``joint:set2`` across them, ``boundary:base``
    under block 0 and the ends of the base and the toe, ``boundary:left`` and ``boundary:right``; with a
    floor the base is level and under the floor too. The lower end of
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
        By how much further the toe lies for each further layer [m].
    floor : float
        Length of a level floor in the toe's stead [m], `gap` below the lowest layer along the face; 0: none. It takes
        a dip below 90 degrees.
    layered : bool
        With a floor: both joint sets run through all rock, under the layers and under the floor. Where joints leave
        short sides at the outline these are closed. To be read with ``blocks = "regions"``.
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
    checks.positive(length=length, thickness=thickness, gap=gap)
    checks.count(layers=layers, blocks=blocks)
    checks.within(0.0, 90.0, "degrees", dip=dip)
    checks.within(0.0, float("inf"), "m", step=step, floor=floor)
    if floor and dip == 90.0:
        checks.add(f"dip = {dip} with a floor: give a dip below 90 degrees")
    if layered and not floor:
        checks.add("layered = true without a floor: give a length of the floor")
    checks.group_part(rock=rock)
    checks.raise_faults()
    if layered:
        return _all_layers(path, dip, (layers, thickness), (blocks, length), gap, floor, rock)
    crest, end = -blocks * length, gap + (layers - 1) * step + length
    if floor:
        still = _on_a_floor(crest - length, gap, dip, length, floor)
    else:
        toes = [rectangle(gap + k * step, k * thickness, end, (k + 1) * thickness) for k in range(layers)]
        still = turn([rectangle(crest - length, -length, end, 0.0), *toes], dip)
    drawn = []
    for k in range(layers):
        low, high = k * thickness, (k + 1) * thickness
        drawn += [rectangle(crest + i * length, low, crest + (i + 1) * length, high) for i in range(blocks)]
    blocks_of_all = [*still, *turn(drawn, dip)]
    every = range(len(blocks_of_all))
    return write_quadrilaterals(
        path, blocks_of_all, [rock],
        joints={"set1": sides_of(every, (0, 2)), "set2": sides_of(every, (1, 3))},
        boundaries={
            "base": [(0, 0), (1, 0)] if floor else [(0, 0)],
            "left": [(0, 3)],
            "right": [(1, 1)] if floor else sides_of(range(layers + 1), (1,)),
        },
        name="stratified_slope",
    )  # fmt: skip


def _on_a_floor(crest: float, gap: float, dip: float, depth: float, floor: float) -> list[Quadrilateral]:
    """Return the rock under the face, from `crest` along it down to `gap`, and the floor where it ends."""
    c, s = math.cos(math.radians(dip)), math.sin(math.radians(dip))
    left, foot = crest * c, (gap * c, -gap * s)
    bottom, right = foot[1] - 2.0 * depth, foot[0] + floor
    return [
        ((left, bottom), (foot[0], bottom), foot, (left, -crest * s)),
        ((foot[0], bottom), (right, bottom), (right, foot[1]), foot),
    ]


def _all_layers(
    path: str | os.PathLike[str],
    dip: float,
    layers: tuple[int, float],
    blocks: tuple[int, float],
    gap: float,
    floor: float,
    rock: str,
) -> Path:
    """Write a slope of layers throughout: layers and their thickness [m], blocks on the face and their length [m]."""
    import shapely

    from bsm_mesh.geometries.block_files import write_blocks
    from bsm_mesh.geometries.cutting.cut import cut_blocks
    from bsm_mesh.geometries.joint_sets import JointSet
    from bsm_mesh.geometries.rock_mass import Region, RockMass
    from bsm_mesh.geometries.short_sides import close_short_sides

    (count, thickness), (number, length) = layers, blocks
    crest = -number * length
    ((left_foot, right_foot, foot, top), ground) = _on_a_floor(crest - length, gap, dip, length, floor)
    (on_face,) = turn([rectangle(crest, 0.0, 0.0, count * thickness)], dip)
    start, end, above, behind = on_face
    outline = [left_foot, right_foot, *ground[1:3], foot, end, above, behind, start, top]
    mass = RockMass(
        regions=[Region(outline=outline, rock=rock)],
        joints=[
            JointSet(name="set1", dip=-dip, spacing=thickness, start=(0.0, 0.0)),
            JointSet(name="set2", dip=90.0 - dip, spacing=length, start=(0.0, 0.0)),
        ],
        boundaries={
            "base": [left_foot, right_foot, ground[1]],
            "left": [left_foot, top],
            "right": [ground[1], ground[2]],
            "ground": [ground[2], foot, end, above, behind, start, top],
        },
    )
    shortest = SHORTEST * min(thickness, length)
    return write_blocks(close_short_sides(cut_blocks(mass), shortest, shapely.Polygon(outline)), path)
