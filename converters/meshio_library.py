"""meshio, the library: the one place where it is imported.

meshio is not maintained any more; meshlane descends from it, has the same functions and reads meshes where it is
installed.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

from bsm_mesh.converters.vtk_files import Grid, spatial
from bsm_mesh.converters.vtk_library import LINE, POLYGON, QUADRATIC_TRIANGLE, TRIANGLE, VERTEX

MESHIO = "meshio"
NAMES = ("meshlane", MESHIO)  # the first that is there reads meshes
TYPES = {VERTEX: "vertex", LINE: "line", POLYGON: "polygon", TRIANGLE: "triangle", QUADRATIC_TRIANGLE: "triangle6"}


def load_meshio() -> ModuleType:
    """Return the module that reads and writes meshes as meshio does.

    Raises
    ------
    ImportError
        If none is installed.
    """
    for name in NAMES[:-1]:
        try:
            return import_module(name)
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
    return import_module(NAMES[-1])


def mesh_of_grid(grid: Grid) -> Any:
    """Return a grid as ``meshio.Mesh``: blocks of cells of one size that follow each other, names as field data."""
    sizes = np.diff(grid.offsets)
    types = np.broadcast_to(grid.cell_type, sizes.shape)
    at = np.flatnonzero((np.diff(sizes, prepend=-1) != 0) | (np.diff(types, prepend=-1) != 0))
    bounds = list(zip(at, [*at[1:], len(sizes)], strict=True))
    cells = [
        (TYPES[int(types[a])], grid.connectivity[grid.offsets[a] : grid.offsets[b]].reshape(-1, int(sizes[a])))
        for a, b in bounds
    ]
    return import_module(MESHIO).Mesh(
        spatial(grid.points),
        cells,
        point_data=dict(grid.point_data),
        cell_data={name: [values[a:b] for a, b in bounds] for name, values in grid.cell_data.items()},
        field_data={name: np.array([number], dtype=np.int32) for name, number in grid.names.items()},
    )
