"""Meshes of given hexahedral blocks in space: domes, vaults.

The corners of a block are those of its lower face, counter-clockwise seen from above, then those over them. Sides 0 and
1 are the lower and the upper face; side 2 + k lies over the edge from corner k to the next one.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries import physical_groups
from bsm_mesh.geometries.session import gmsh_session, name_groups, write_mesh

LOWER, UPPER = 0, 1
SIDES = np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
QUADRANGLE, HEXAHEDRON = 3, 5  # Gmsh's numbers of element types
ROUNDING = 9  # decimals of a metre: corners that agree in them are one node
MOST_BLOCKS = 500_000


def write_hexahedra(
    path: str | os.PathLike[str],
    corners: npt.ArrayLike,
    *,
    rock: str,
    joint: str,
    boundaries: Mapping[str, tuple[Sequence[int] | npt.NDArray[np.intp], int]],
    name: str,
) -> Path:
    """Write one hexahedron a block, in the order given, and quadrangles for the joint and boundaries.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    corners : (n, 8, 3) array_like [m]
        Corners of the blocks.
    rock, joint : str
        Name of the rock of all blocks, and of the joint of all faces between them.
    boundaries : mapping of str to (blocks, side)
        Blocks whose side is in the boundary.
    name : str
        Name of the mesh in messages.

    Raises
    ------
    GeometryError
        Where Gmsh cannot write the mesh.
    """
    points = np.asarray(corners, dtype=np.float64).reshape(-1, 3)
    _, kept, number = np.unique(np.round(points, ROUNDING) + 0.0, axis=0, return_index=True, return_inverse=True)
    nodes = number.reshape(-1, 8)
    faces = nodes[:, SIDES].reshape(-1, 4)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    groups = {physical_groups.joint(joint): faces[np.sort(first[count == 2])]}
    groups |= {
        physical_groups.boundary(key): nodes[np.asarray(blocks)][:, SIDES[side]]
        for key, (blocks, side) in boundaries.items()
    }
    with gmsh_session(name) as gmsh:
        volume = gmsh.model.addDiscreteEntity(3)
        gmsh.model.mesh.addNodes(3, volume, range(1, len(kept) + 1), points[kept].ravel())
        gmsh.model.mesh.addElementsByType(volume, HEXAHEDRON, [], (nodes + 1).ravel())
        surfaces = {key: [_add_faces(gmsh, rows)] for key, rows in groups.items()}
        gmsh.model.mesh.reclassifyNodes()
        name_groups({physical_groups.rock(rock): [volume]} | surfaces, of_volumes=True)
        return write_mesh(path)


def _add_faces(gmsh: Any, faces: npt.NDArray[np.intp]) -> int:
    surface: int = gmsh.model.addDiscreteEntity(2)
    gmsh.model.mesh.addElementsByType(surface, QUADRANGLE, [], (faces + 1).ravel())
    return surface
