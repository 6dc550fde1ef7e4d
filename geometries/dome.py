"""A hemispherical dome of blocks with plane faces, in three dimensions, on a fixed ring.

Blocks are numbered course by course from the crown; the last ring is the base.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from bsm_mesh.geometries.hexahedra import LOWER, MOST_BLOCKS, write_hexahedra
from bsm_mesh.geometries.parameters import ParameterChecks


def build(
    path: str | os.PathLike[str],
    *,
    radius: float = 5.0,
    thickness: float = 0.5,
    sectors: int = 16,
    courses: int = 10,
    eye: float = 6.0,
    rock: str = "stone",
    **unknown: object,
) -> Path:
    """Write the mesh of a dome and return its path.

    Volumes ``rock:rock``; surfaces ``joint:joint`` between all blocks and ``boundary:base`` under the ring. The centre
    of the sphere is the origin, z is up. Joints across meridians are level chords of the sphere.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    radius : float
        Radius of the middle surface, at the corners of blocks [m].
    thickness : float
        Thickness of the dome [m].
    sectors : int
        Number of blocks in a ring.
    courses : int
        Number of rings between the eye and the base.
    eye : float
        Angle at the centre from the crown to the rim of the open eye [degrees].
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
    if checks.count(3, sectors=sectors) & checks.count(1, courses=courses) and sectors * (courses + 1) > MOST_BLOCKS:
        checks.add(f"sectors = {sectors} and courses = {courses} make more than {MOST_BLOCKS} blocks; give fewer")
    checks.within(0.01, 85.0, "degrees", eye=eye)
    if checks.positive(radius=radius, thickness=thickness) and thickness >= 2.0 * radius:
        checks.add(f"thickness = {thickness} m is not less than twice radius = {radius} m; give less")
    checks.group_part(rock=rock)
    checks.raise_faults()
    fall = np.append(np.linspace(np.radians(eye), np.pi / 2, courses + 1), np.pi / 2)
    drop = np.append(np.zeros(courses + 1), thickness)  # the base: a ring straight down
    turn = 2 * np.pi * np.arange(sectors) / sectors
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)

    def shell(r: float) -> np.ndarray:
        """Return the corners (courses + 2, sectors, 3) of one side of the dome."""
        level = np.einsum("i,jk->ijk", r * np.sin(fall), out)
        height = np.repeat((r * np.cos(fall) - drop)[:, None], sectors, axis=1)
        return np.concatenate([level, height[:, :, None]], axis=2)

    inner, outer = shell(radius - thickness / 2), shell(radius + thickness / 2)
    # Of a level face, counter-clockwise seen from above: the ring of shell and sector at every corner.
    level = np.stack([inner, outer, np.roll(outer, -1, axis=1), np.roll(inner, -1, axis=1)], axis=2)
    blocks = np.concatenate([level[1:], level[:-1]], axis=2).reshape(-1, 8, 3)
    base = np.arange(len(blocks) - sectors, len(blocks))
    return write_hexahedra(path, blocks, rock=rock, joint="joint", boundaries={"base": (base, LOWER)}, name="dome")
