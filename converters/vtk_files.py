"""VTU and PVD files through VTK's own writer and reader: written whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file
from bsm_mesh.reading import refuse_special
from bsm_mesh.signals import signals_held

VERTEX, LINE, POLYGON = 1, 3, 7  # VTK cell types


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """An unstructured grid in the plane, as it is written and read.

    Attributes
    ----------
    points : (n_points, 2) float64 [m]
        Coordinates; z is 0.
    offsets : (n_cells + 1,) int
        Cell c has the points ``connectivity[offsets[c]:offsets[c + 1]]``.
    connectivity : (k,) int
        Point numbers, cell after cell.
    cell_type : int or (n_cells,) int
        VTK's number of the type of all cells, or of each.
    point_data, cell_data : mapping of str to array
        Arrays with one row a point, one row a cell; of texts where they hold objects. Texts are not read back.
    field_data : mapping of str to sequence of str
        Lists of names that integer arrays refer to; the stage and units.
    """

    points: FloatArray
    offsets: IntArray
    connectivity: IntArray
    cell_type: int | IntArray
    point_data: Mapping[str, Any] = field(default_factory=dict)
    cell_data: Mapping[str, Any] = field(default_factory=dict)
    field_data: Mapping[str, Sequence[str]] = field(default_factory=dict)


@cache
def load_vtk() -> None:
    """Import VTK, whole: its C code dies where an interruption is raised while one module imports the next."""
    with signals_held():
        import vtkmodules.util.numpy_support
        import vtkmodules.vtkCommonMisc
        import vtkmodules.vtkIOLegacy
        import vtkmodules.vtkIOXML  # noqa: F401


@contextmanager
def _silent() -> Iterator[None]:
    """Keep VTK from writing to stderr, past Python."""
    from vtkmodules.vtkCommonCore import vtkLogger

    level = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(level)


def write_vtu(path: Path, grid: Grid, *, parents: bool = False) -> None:
    """Write a grid as compressed binary VTU; its folder too, where `parents` says so.

    Raises
    ------
    OSError
        If the file cannot be written; nothing is left behind.
    """
    load_vtk()
    from vtkmodules.vtkCommonMisc import vtkErrorCode
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    data = _to_vtk(grid)
    with whole_file(path, parents=parents) as draft:
        writer = vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(draft))
        writer.SetInputData(data)
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOff()
        writer.SetCompressorTypeToLZ4()
        writer.SetCompressionLevel(9)  # a fifth of the time of zlib at its quickest, a fifth larger
        writer.AddObserver("ErrorEvent", lambda *_: None)  # what is raised below says it
        with _silent():
            written = writer.Write() == 1 and draft.exists()
        if writer.GetErrorCode() == vtkErrorCode.OutOfDiskSpaceError:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        if not written:
            raise OSError(f"cannot write {path}: is the folder writable, the disk full?")


def read_vtu(path: Path, *, needs: Sequence[str] = ()) -> Grid:
    """Return the grid of a VTU file whose cells are all of one type; parameters and errors as for `grid_of`."""
    if not path.is_file():
        raise ModelError(f"{path}: there is no such file")
    return grid_of(path.read_bytes(), path, needs=needs)


def grid_of(content: bytes, path: Path, *, needs: Sequence[str] = ()) -> Grid:
    """Return the grid of a VTU file that was read.

    Parameters
    ----------
    content : bytes
        What the file holds. VTK opens a file twice, and dies if it is replaced in between.
    path : Path
        The file, for messages.
    needs : sequence of str
        Cell arrays that must be in it.

    Raises
    ------
    ModelError
        If it is damaged, of mixed cell types or without an array that is needed.
    """
    data = vtk_grid_of(content, path, needs=needs)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    types = vtk_to_numpy(data.GetDistinctCellTypesArray()) if data.GetNumberOfCells() else np.array([VERTEX])
    if len(types) > 1:
        raise ModelError(f"{path}: has cells of the types {types.tolist()}; one type is needed")
    arrays = [_arrays(attributes) for attributes in (data.GetPointData(), data.GetCellData())]
    names = data.GetFieldData()
    return Grid(
        points=vtk_to_numpy(data.GetPoints().GetData())[:, :2].astype(np.float64),
        offsets=vtk_to_numpy(data.GetCells().GetOffsetsArray()),
        connectivity=vtk_to_numpy(data.GetCells().GetConnectivityArray()),
        cell_type=int(types[0]),
        point_data=arrays[0],
        cell_data=arrays[1],
        field_data={
            array.GetName(): tuple(array.GetValue(i) for i in range(array.GetNumberOfValues()))
            for array in (names.GetAbstractArray(k) for k in range(names.GetNumberOfArrays()))
            if array.GetClassName() == "vtkStringArray"
        },
    )


def vtk_grid_of(content: bytes, path: Path, *, needs: Sequence[str] = ()) -> Any:
    """Return VTK's own grid of a VTU file that was read; parameters and errors as for `grid_of`."""
    load_vtk()
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader: Any = vtkXMLUnstructuredGridReader()
    reader.ReadFromInputStringOn()
    reader.SetInputString(content)
    reader.AddObserver("ErrorEvent", lambda *_: None)  # the message below says it
    with _silent():
        reader.Update()
    data = reader.GetOutput()
    missing = [name for name in needs if not data.GetCellData().HasArray(name)]
    if reader.GetErrorCode() or data.GetPoints() is None or missing:
        raise ModelError(f"{path}: not a complete VTU file of a run; run the model again")
    return data


def sample(grid: Grid, points: FloatArray) -> tuple[BoolArray, dict[str, FloatArray]]:
    """Return which points (k, 2) [m] lie in a grid, and its point and cell arrays there.

    Point arrays are interpolated within their cell, cell arrays constant.
    """
    load_vtk()
    with signals_held():
        from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator
        from vtkmodules.vtkFiltersCore import vtkProbeFilter

    where = vtkPoints()
    where.SetData(numpy_to_vtk(spatial(points), deep=True))
    asked = vtkPolyData()
    asked.SetPoints(where)
    probe: Any = vtkProbeFilter()
    probe.SetInputData(asked)
    probe.SetSourceData(_to_vtk(grid))
    try:
        probe.SetCellLocator(vtkStaticCellLocator())
    except AttributeError:  # before VTK 9.6
        probe.SetCellLocatorPrototype(vtkStaticCellLocator())
    probe.Update()
    found = probe.GetOutput().GetPointData()
    inside = vtk_to_numpy(found.GetArray(probe.GetValidPointMaskArrayName())) > 0
    names = (*grid.point_data, *grid.cell_data)
    return inside, {name: np.array(vtk_to_numpy(found.GetArray(name)), dtype=np.float64) for name in names}


def write_pvd(path: Path, files: Sequence[tuple[float, str]]) -> None:
    """Write a ParaView collection of (time, file name) pairs."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for time, name in files:
        ElementTree.SubElement(collection, "DataSet", timestep=f"{time:g}", group="", part="0", file=name)
    ElementTree.indent(root)
    with whole_file(path) as draft:
        ElementTree.ElementTree(root).write(draft, encoding="utf-8", xml_declaration=True)


def read_pvd(path: Path) -> list[tuple[float, Path]]:
    """Return the (time, file) pairs of a ParaView collection.

    Raises
    ------
    ModelError
        If the file is missing or no collection.
    """
    refuse_special(path)
    try:
        return files_of(path.read_bytes(), path)
    except FileNotFoundError:
        raise ModelError(f"{path}: there is no such file; is this the folder of a run?") from None


def files_of(content: bytes, path: Path) -> list[tuple[float, Path]]:
    """Return the (time, file) pairs of a ParaView collection that was read."""
    try:
        root = ElementTree.fromstring(content)
        found = [(float(e.get("timestep", "0")), path.parent / e.get("file", "")) for e in root.iter("DataSet")]
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # no such encoding, no number
        raise ModelError(f"{path}: not a PVD file ({error})") from None
    if not found:
        raise ModelError(f"{path}: lists no files")
    return found


def spatial(vectors: FloatArray) -> FloatArray:
    """Return plane vectors (k, 2) with a third component 0, (k, 3)."""
    return np.column_stack([vectors, np.zeros(len(vectors))])


def _to_vtk(grid: Grid) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid

    points = vtkPoints()
    points.SetData(numpy_to_vtk(spatial(grid.points), deep=True))
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtk(np.ascontiguousarray(grid.offsets, dtype=np.int64), deep=True, array_type=_id_type()),
        numpy_to_vtk(np.ascontiguousarray(grid.connectivity, dtype=np.int64), deep=True, array_type=_id_type()),
    )
    data = vtkUnstructuredGrid()
    data.SetPoints(points)
    types = grid.cell_type
    if not isinstance(types, int):
        types = numpy_to_vtk(np.ascontiguousarray(types, dtype=np.uint8), deep=True)
    data.SetCells(types, cells)
    for attributes, arrays in ((data.GetPointData(), grid.point_data), (data.GetCellData(), grid.cell_data)):
        for name, values in arrays.items():
            is_text = np.asarray(values).dtype == object
            array = _strings(values) if is_text else numpy_to_vtk(np.ascontiguousarray(values), deep=True)
            array.SetName(name)
            attributes.AddArray(array)
    for name, texts in grid.field_data.items():
        array = _strings(texts)
        array.SetName(name)
        data.GetFieldData().AddArray(array)
    return data


def _strings(texts: Sequence[str]) -> Any:
    from vtkmodules.vtkCommonCore import vtkStringArray

    strings = vtkStringArray()
    strings.SetNumberOfValues(len(texts))
    for number, text in enumerate(texts):
        strings.SetValue(number, text)
    return strings


def _id_type() -> int:
    from vtkmodules.vtkCommonCore import VTK_ID_TYPE

    return int(VTK_ID_TYPE)


def _arrays(attributes: Any) -> dict[str, Any]:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    found = (attributes.GetArray(k) for k in range(attributes.GetNumberOfArrays()))
    return {array.GetName(): vtk_to_numpy(array) for array in found if array is not None}
