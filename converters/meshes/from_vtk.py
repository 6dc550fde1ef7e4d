"""VTK's own files (VTU, VTP, legacy VTK), read by VTK.

meshio 5.3.5 keeps only the last piece of a VTU file in several pieces, knows neither its newer versions nor
string data, and orders polygons by their number of corners; VTK reads its own files.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.converters.meshes.cells import MeshCells, gather_cells
from bsm_mesh.converters.vtk_library import load_vtk, names_in
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries.physical_groups import GroupKind
from bsm_mesh.model.edges import LongArray
from bsm_mesh.signals import signals_held

SUFFIXES = (".vtu", ".vtp", ".vtk")
LIBRARY = ("vtkmodules.util.numpy_support", "vtkmodules.vtkIOLegacy", "vtkmodules.vtkIOXML")
POLY_LINE = 4
TYPES = {  # VTK's cell type: meshio's name for it
    0: "empty", 1: "vertex", 2: "vertex", 3: "line", 5: "triangle", 6: "strip", 7: "polygon", 8: "pixel", 9: "quad",
    10: "tetra", 11: "hexahedron", 12: "hexahedron", 13: "wedge", 14: "pyramid", 15: "penta_prism", 16: "hexa_prism",
    21: "line3", 22: "triangle6", 23: "quad8", 24: "tetra10", 25: "hexahedron20", 26: "wedge15", 27: "pyramid13",
    28: "quad9", 29: "hexahedron27", 30: "quad6", 31: "wedge12", 32: "wedge18", 33: "hexahedron24", 34: "triangle7",
    35: "line4", 36: "quadratic_polygon", 37: "pyramid19", 42: "polyhedron",
    68: "VTK_LAGRANGE_CURVE", 69: "VTK_LAGRANGE_TRIANGLE", 70: "VTK_LAGRANGE_QUADRILATERAL",
    71: "VTK_LAGRANGE_TETRAHEDRON", 72: "VTK_LAGRANGE_HEXAHEDRON", 73: "VTK_LAGRANGE_WEDGE", 74: "VTK_LAGRANGE_PYRAMID",
    75: "VTK_BEZIER_CURVE", 76: "VTK_BEZIER_TRIANGLE", 77: "VTK_BEZIER_QUADRILATERAL", 78: "VTK_BEZIER_TETRAHEDRON",
    79: "VTK_BEZIER_HEXAHEDRON", 80: "VTK_BEZIER_WEDGE", 81: "VTK_BEZIER_PYRAMID",
}  # fmt: skip


def read_vtk(path: Path) -> MeshCells:
    """Return the cells of a VTU, VTP or legacy VTK file, in the file's order.

    Cell arrays of whole numbers can be named as groups (``"MaterialIDs=3"``). A field array ``rock:gneiss`` of one
    number names that value of the cell array ``rock``; so with the other kinds, and ``boundary:top`` that of
    ``boundary_top`` where it is there, for an edge may be in several.

    Raises
    ------
    ModelError
        If VTK cannot read the file.
    """
    data = read_data(path)
    types, offsets, connectivity = cell_arrays(data)
    arrays = {name: values for name, values in _cell_data(data).items() if len(values) == len(types)}
    cells: list[tuple[str, LongArray]] = []
    numbers: list[LongArray] = []
    sizes = np.diff(offsets)
    if len(sizes) != len(types) or np.any(sizes < 0) or offsets[-1] > len(connectivity):
        raise ModelError(f"{path}: its list of cells is damaged; write the file again")
    shape = types * (int(sizes.max(initial=0)) + 1) + sizes
    for k in np.unique(shape, return_index=True)[1]:  # a block of cells of one type and size
        kind, size = int(types[k]), int(sizes[k])
        which = np.flatnonzero(shape == shape[k])
        nodes = connectivity[offsets[which][:, None] + np.arange(size)]
        if kind == POLY_LINE and size > 1:
            nodes, which = np.stack([nodes[:, :-1], nodes[:, 1:]], axis=2).reshape(-1, 2), np.repeat(which, size - 1)
        cells.append(("line" if kind == POLY_LINE else TYPES.get(kind, f"VTK type {kind}"), nodes))
        numbers.append(which)
    return gather_cells(
        str(path),
        numpy_of(data.GetPoints().GetData()) if data.GetPoints() else np.empty((0, 3)),
        cells,
        sets=_named_sets(data, arrays, numbers),
        arrays={name: [values[which] for which in numbers] for name, values in arrays.items()},
        numbers=numbers,
    )


def read_data(path: Path) -> Any:
    """Return VTK's own data set of a VTU, VTP or legacy VTK file.

    Raises
    ------
    ModelError
        If VTK cannot read the file, or it holds neither an unstructured grid nor polygons.
    """
    load_vtk()
    with signals_held():
        from vtkmodules.vtkIOLegacy import vtkDataSetReader
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

    readers: dict[str, Any] = {
        ".vtu": vtkXMLUnstructuredGridReader,
        ".vtp": vtkXMLPolyDataReader,
        ".vtk": vtkDataSetReader,
    }
    reader = readers[path.suffix.lower()]()
    reader.SetFileName(str(path))
    if path.suffix.lower() == ".vtk":
        reader.ReadAllScalarsOn()
        reader.ReadAllFieldsOn()
    window, said = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkOutputWindow.SetInstance(said)  # VTK writes its complaints there and to its log, and continues
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        reader.Update()
        data = reader.GetOutput()
    finally:
        vtkOutputWindow.SetInstance(window)
        vtkLogger.SetStderrVerbosity(verbosity)
    output = said.GetOutput()
    output = output.decode(errors="replace") if isinstance(output, bytes) else output  # where it quotes the file
    complaints = [line.strip() for line in output.splitlines() if line.strip()]
    if data is None or complaints:
        # Of VTK's lines the telling ones have the form "ERR| Reader (0x...): the fault".
        told = [found[1] for found in (re.search(r"Reader \(0x\w+\): (.+)", line) for line in complaints) if found]
        reason = f" ({told[0]})" if told else ""
        raise ModelError(f"{path}: VTK cannot read it{reason}; it is damaged, cut off, or not what its ending says")
    if not data.IsA("vtkUnstructuredGrid") and not data.IsA("vtkPolyData"):
        raise ModelError(
            f"{path}: holds a {data.GetClassName()[3:]}; an unstructured grid or polygons are needed "
            "(in ParaView: Append Datasets turns any data set into an unstructured grid)"
        )
    return data


def cell_arrays(data: Any) -> tuple[LongArray, LongArray, LongArray]:
    """Return type, offsets and nodes of all cells."""
    if data.IsA("vtkUnstructuredGrid"):
        if data.GetNumberOfCells() == 0:
            return np.empty(0, np.int64), np.zeros(1, np.int64), np.empty(0, np.int64)
        try:
            kinds = data.GetCellTypes()
        except TypeError:  # before VTK 9.6
            kinds = data.GetCellTypesArray()
        return (
            numpy_of(kinds),
            numpy_of(data.GetCells().GetOffsetsArray()),
            numpy_of(data.GetCells().GetConnectivityArray()),
        )
    types: list[LongArray] = [np.empty(0, np.int64)]
    offsets: list[LongArray] = [np.zeros(1, np.int64)]
    nodes: list[LongArray] = [np.empty(0, np.int64)]
    parts = ((data.GetVerts(), 1), (data.GetLines(), POLY_LINE), (data.GetPolys(), 7), (data.GetStrips(), 6))
    for part, kind in parts:  # in this order VTK numbers the cells of polygonal data
        if part.GetNumberOfCells():
            types.append(np.full(part.GetNumberOfCells(), kind))
            offsets.append(numpy_of(part.GetOffsetsArray())[1:] + offsets[-1][-1])
            nodes.append(numpy_of(part.GetConnectivityArray()))
    return np.concatenate(types), np.concatenate(offsets), np.concatenate(nodes)


def _cell_data(data: Any) -> dict[str, npt.NDArray[Any]]:
    found = {}
    for k in range(data.GetCellData().GetNumberOfArrays()):
        array = data.GetCellData().GetArray(k)  # None for strings
        if array is not None and array.GetNumberOfComponents() == 1 and array.GetName():
            found[array.GetName()] = numpy_of(array)
    return found


def _named_sets(
    data: Any, arrays: dict[str, npt.NDArray[Any]], numbers: list[LongArray]
) -> dict[str, list[npt.NDArray[Any]]]:
    """Return the groups ``kind:name`` that field arrays name as values of whole-number arrays."""
    found: dict[str, list[npt.NDArray[Any]]] = {}
    for group, number in names_in(data).items():
        kind, _, name = group.partition(":")
        values = arrays.get(f"{kind}_{name}", arrays.get(kind))
        if values is not None and kind in {known.value for known in GroupKind}:
            found[group] = [np.flatnonzero(values[which] == number) for which in numbers]
    return found


def numpy_of(array: Any) -> npt.NDArray[Any]:
    """Return a copy of a VTK array; whole numbers as int64."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    values: npt.NDArray[Any] = np.array(vtk_to_numpy(array))  # VTK frees its own with the reader
    return values.astype(np.int64) if values.dtype.kind in "iu" else values
