"""Results of other programs: VTU, VTP and VTK by VTK, tables of nodes, all else by meshio.

VTK and meshio run in a process apart.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.converters.meshes import from_table
from bsm_mesh.converters.meshes.files import refuse_unreadable
from bsm_mesh.converters.meshes.foreign_result import ForeignResult, numbers_only
from bsm_mesh.converters.meshes.from_meshio import read_mesh
from bsm_mesh.converters.meshes.from_vtk import SUFFIXES, cell_arrays, numpy_of, read_data
from bsm_mesh.errors import ModelError
from bsm_mesh.reading import as_path

LIBRARY = ("meshio", "vtkmodules.util.numpy_support", "vtkmodules.vtkIOLegacy", "vtkmodules.vtkIOXML")
SURFACES = {  # meshio's name of a type: VTK's number and how many nodes
    "triangle": (5, 3),
    "quad": (9, 4),
    "triangle6": (22, 6),
    "quad8": (23, 8),
    "quad9": (28, 9),
    "triangle7": (34, 7),
}
POLYGON, PIXEL, STRIP = 7, 8, 6
PLANE_TYPES = (POLYGON, PIXEL, STRIP, *(number for number, _ in SURFACES.values()))
SOLID = (10, 11, 12, 13, 14, 24, 25, 26, 27, 29)


def read_foreign(path: str | os.PathLike[str]) -> ForeignResult:
    """Return the mesh and fields of a file of another program.

    Raises
    ------
    ModelError
        If the file is missing, unreadable, damaged or of no known format, or holds no surface elements.
    """
    from bsm_mesh.converters.meshes.apart import read_apart

    file = as_path("result", path)
    refuse_unreadable(file)
    if file.suffix.lower() == from_table.SUFFIX:
        return from_table.read_table(file)
    return read_apart(by_vtk if file.suffix.lower() in SUFFIXES else by_meshio, file)


def by_vtk(path: Path) -> ForeignResult:
    """Return what VTK reads."""
    data = read_data(path)
    kind, offsets, connectivity = cell_arrays(data)
    points = numpy_of(data.GetPoints().GetData()) if data.GetPoints() else np.zeros((0, 3))
    fields = (_fields(data.GetPointData()), _fields(data.GetCellData()))
    return _surfaces(str(path), points, kind, offsets, connectivity, *fields)


def by_meshio(path: Path) -> ForeignResult:
    """Return what meshio reads."""
    mesh, _ = read_mesh(path)
    plane = [(k, block) for k, block in enumerate(mesh.cells) if block.type in SURFACES or block.type == "polygon"]
    solid = [block.type for block in mesh.cells if block.dim == 3]
    if not plane:
        raise ModelError(_no_surfaces(str(path), bool(solid)))
    nodes = [np.asarray(block.data, dtype=np.int64) for _, block in plane]
    kind = [SURFACES.get(block.type, (POLYGON, 0))[0] for _, block in plane]
    sizes = np.concatenate([np.full(len(rows), rows.shape[1]) for rows in nodes])
    cells = {
        name: np.concatenate([np.asarray(values[k]) for k, _ in plane])
        for name, values in mesh.cell_data.items()
        if len(values) == len(mesh.cells) and len({np.asarray(values[k]).shape[1:] for k, _ in plane}) == 1
    }
    points = np.asarray(mesh.points, dtype=np.float64)
    return ForeignResult(
        source=str(path),
        points=np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))]),
        cell_type=np.repeat(kind, [len(rows) for rows in nodes]),
        offsets=np.concatenate([[0], np.cumsum(sizes)]),
        connectivity=np.concatenate([rows.ravel() for rows in nodes]),
        at_points=numbers_only({name: np.asarray(values) for name, values in mesh.point_data.items()}),
        at_cells=numbers_only(cells),
    )


def _surfaces(
    source: str,
    points: npt.NDArray[Any],
    kind: npt.NDArray[Any],
    offsets: npt.NDArray[Any],
    connectivity: npt.NDArray[Any],
    at_points: dict[str, npt.NDArray[Any]],
    at_cells: dict[str, npt.NDArray[Any]],
) -> ForeignResult:
    """Return the surface elements among all."""
    kept = np.flatnonzero(np.isin(kind, PLANE_TYPES))
    if not kept.size:
        raise ModelError(_no_surfaces(source, bool(np.isin(kind, SOLID).any())))
    sizes = np.diff(offsets)[kept]
    row = np.repeat(offsets[:-1][kept], sizes) + np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return ForeignResult(
        source=source,
        points=points.astype(np.float64),
        cell_type=kind[kept],
        offsets=np.concatenate([[0], np.cumsum(sizes)]),
        connectivity=connectivity[row],
        at_points=numbers_only({name: values for name, values in at_points.items() if len(values) == len(points)}),
        at_cells=numbers_only({name: values[kept] for name, values in at_cells.items() if len(values) == len(kind)}),
    )


def _no_surfaces(source: str, solid: bool) -> str:
    if solid:
        return f"{source}: holds solid elements; give a plane section of it (in ParaView: Slice, then save as VTU)"
    return f"{source}: holds no triangles, quads or polygons that could carry a field; give a plane mesh with results"


def _fields(attributes: Any) -> dict[str, npt.NDArray[Any]]:
    found = {}
    for k in range(attributes.GetNumberOfArrays()):
        array = attributes.GetArray(k)  # None for strings
        if array is not None and array.GetName():
            found[array.GetName()] = numpy_of(array)
    return found
