"""A tunnel through joint sets: circular, horseshoe or box, or none, in a rectangle of rock.

The centre of the tunnel is the origin, that of the rectangle too.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from bsm_mesh.geometries.parameters import ParameterChecks

SHAPES = ("circle", "horseshoe", "box", "none")
ENGINES = ("auto", "gmsh", "shapely")


def build(
    path: str | os.PathLike[str],
    *,
    shape: Literal["circle", "horseshoe", "box", "none"] = "circle",
    span: float = 6.0,
    width: float = 30.0,
    height: float = 30.0,
    dips: Sequence[float] = (30.0, 110.0),
    spacings: Sequence[float] = (2.0, 2.5),
    scatter: float = 0.0,
    seed: int = 1,
    engine: Literal["auto", "gmsh", "shapely"] = "auto",
    size: float | None = None,
    rock: str = "rock",
    **unknown: object,
) -> Path:
    """Write the mesh of a tunnel in jointed rock and return its path.

    Surface ``rock:rock``; curves ``joint:J1``, ``joint:J2``, ..., ``boundary:left``, ``right``, ``bottom``, ``top`` and
    ``tunnel``. To be read with ``blocks = "regions"``.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    shape : {"circle", "horseshoe", "box", "none"}
        Cross-section of the tunnel.
    span : float
        Its width and height [m].
    width : float
        Width of the rectangle [m].
    height : float
        Height of the rectangle [m].
    dips : sequence of float
        Angle of each joint set from the x axis, counter-clockwise [degrees].
    spacings : sequence of float
        Spacing of each set [m].
    scatter : float
        Standard deviation of the dips from joint to joint [degrees].
    seed : int
        Of the random numbers: same seed, same blocks.
    engine : {"auto", "gmsh", "shapely"}
        What cuts the rock, to the same blocks: Gmsh or our own cutter; ``auto`` takes the cutter for very many joints.
    size : float, optional
        Size of the elements [m]; where not given, few elements a block.
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
    checks.positive(span=span, width=width, height=height)
    checks.positive_or_none(size=size)
    checks.one_of(SHAPES, shape=shape)
    checks.one_of(ENGINES, engine=engine)
    checks.group_part(rock=rock)
    if len(dips) != len(spacings):
        checks.add(f"{len(dips)} dips and {len(spacings)} spacings; give one spacing for each dip")
    checks.raise_faults()
    from bsm_mesh.geometries.block_files import mesh_blocks, write_blocks
    from bsm_mesh.geometries.cutting.cut import cut_blocks
    from bsm_mesh.geometries.joint_sets import JointSet
    from bsm_mesh.geometries.rock_mass import Excavation, Opening, Region, RockMass
    from bsm_mesh.geometries.shapes import circle, horseshoe, rectangle

    half = span / 2
    outlines = {
        "circle": circle(half),
        "horseshoe": horseshoe(span, span, (0.0, -half)),
        "box": rectangle(-half, -half, half, half),
    }
    frame = rectangle(-width / 2, -height / 2, width / 2, height / 2)
    regions: list[Region | Opening | Excavation] = [Region(outline=frame, rock=rock)]
    if shape != "none":
        regions.append(Opening(outline=outlines[shape], boundary="tunnel"))
    sets = [
        JointSet(name=f"J{number}", dip=dip, spacing=spacing, scatter=scatter)
        for number, (dip, spacing) in enumerate(zip(dips, spacings, strict=True), start=1)
    ]
    cut = cut_blocks(RockMass(regions=regions, joints=sets, seed=seed), engine)
    return write_blocks(cut, path) if size is None else mesh_blocks(cut, path, size=size)
