"""A barrel vault, or an arch, of blocks with plane faces, in three dimensions, on two springings.

Blocks are numbered from the right springing over the crown to the left one, ring after ring from south to north.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from bsm_mesh.geometries.hexahedra import MOST_BLOCKS, write_hexahedra
from bsm_mesh.geometries.parameters import ParameterChecks

START, END = 2, 4  # sides of a block towards the right springing and towards the left one


def build(
    path: str | os.PathLike[str],
    *,
    radius: float = 5.0,
    thickness: float = 0.8,
    stones: int = 15,
    opening: float = 180.0,
    length: float = 6.0,
    rings: int = 6,
    rock: str = "stone",
    **unknown: object,
) -> Path:
    """Write the mesh of a barrel vault and return its path.

    Volumes ``rock:rock``; surfaces ``joint:joint`` between all blocks, ``boundary:right`` and ``boundary:left`` at the
    springings. The axis is y, from 0 to `length`; the centre of the arch is at x = z = 0.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    radius : float
        Radius of the middle line, at the corners of stones [m].
    thickness : float
        Thickness of the vault [m].
    stones : int
        Number of stones of a ring, with one more at each springing.
    opening : float
        Angle of the arch between its springings [degrees].
    length : float
        Length along the axis [m].
    rings : int
        Number of rings along the axis; an arch has one.
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
    if checks.count(2, stones=stones) & checks.count(1, rings=rings) and rings * (stones + 2) > MOST_BLOCKS:
        checks.add(f"stones = {stones} and rings = {rings} make more than {MOST_BLOCKS} blocks; give fewer")
    if checks.within(1.0, 270.0, "degrees", opening=opening) and checks.count(2, stones=stones):
        whole = opening * (stones + 2) / stones
        if whole >= 350 or opening / stones >= 90:
            checks.add(f"opening = {opening} degrees of {stones} stones leaves no room; give less, or more stones")
    checks.positive(length=length)
    if checks.positive(radius=radius, thickness=thickness) and thickness >= 2.0 * radius:
        checks.add(f"thickness = {thickness} m is not less than twice radius = {radius} m; give less")
    checks.group_part(rock=rock)
    checks.raise_faults()
    angle = np.radians(90 - opening / 2 + opening * np.arange(-1, stones + 2) / stones)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner, outer = (radius - thickness / 2) * ray, (radius + thickness / 2) * ray
    across = np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1)  # (stones + 2, 4, 2) in x and z
    along = length * np.arange(rings + 1) / rings
    corners = np.empty((rings, stones + 2, 8, 3))
    for half, y in ((slice(0, 4), along[1:]), (slice(4, 8), along[:-1])):  # the lower face looks north: y falls upwards
        corners[:, :, half, 0], corners[:, :, half, 2] = across[None, ..., 0], across[None, ..., 1]
        corners[:, :, half, 1] = y[:, None, None]
    number = np.arange(rings * (stones + 2)).reshape(rings, -1)
    boundaries = {"right": (number[:, 0], START), "left": (number[:, -1], END)}
    return write_hexahedra(
        path, corners.reshape(-1, 8, 3), rock=rock, joint="joint", boundaries=boundaries, name="barrel_vault"
    )
