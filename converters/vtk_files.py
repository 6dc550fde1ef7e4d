"""VTU and PVD files through VTK's own writer and reader: written whole or not at all."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.grid_reader import read_arrays
from bsm_mesh.converters.vtk_library import KINDS, POLYHEDRON, load_vtk, names_of, silent
from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file
from bsm_mesh.reading import refuse_special
from bsm_mesh.signals import signals_held

Compression = Literal["zlib", "lz4"]
NO_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
IN_ATTRIBUTES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\t": "&#9;", "\n": "&#10;", "\r": "&#13;"}
)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Faces:
    """Faces of polyhedra.

    Attributes
    ----------
    cell_offsets : (n_cells + 1,) int
        Cell c has the faces from ``cell_offsets[c]`` to below ``cell_offsets[c + 1]``.
    offsets : (n_faces + 1,) int
        Face f has the points ``connectivity[offsets[f]:offsets[f + 1]]``.
    connectivity : (k,) int
        Point numbers, face after face.
    """

    cell_offsets: IntArray
    offsets: IntArray
    connectivity: IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """An unstructured grid, as it is written; one in the plane is read too.

    Attributes
    ----------
    points : (n_points, 2) or (n_points, 3) float64 [m]
        Coordinates; of two z is 0.
    offsets : (n_cells + 1,) int
        Cell c has the points ``connectivity[offsets[c]:offsets[c + 1]]``.
    connectivity : (k,) int
        Point numbers, cell after cell.
    cell_type : int or (n_cells,) int
        VTK's number of the type of all cells, or of each.
    point_data, cell_data : mapping of str to array
        Arrays of numbers with one row a point, one row a cell.
    names : mapping of str to int
        Meanings of the numbers of an array: ``"joint:J1": 3`` where 3 in the array ``joint`` is J1. In the file each is
        a field array of one number, as meshio keeps names of groups: meshio, VisIt and others read no file with a text
        array in it.
    units : mapping of str to str
        Unit of each array that has one, in the file VTK's ``UNITS_LABEL``. Not read back.
    faces : Faces or None
        Those of polyhedra. Not read back.
    field_data : mapping of str to array
        Arrays of the whole. Not read back.
    """

    points: FloatArray
    offsets: IntArray
    connectivity: IntArray
    cell_type: int | IntArray
    point_data: Mapping[str, Any] = field(default_factory=dict)
    cell_data: Mapping[str, Any] = field(default_factory=dict)
    names: Mapping[str, int] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    faces: Faces | None = None
    field_data: Mapping[str, Any] = field(default_factory=dict)

    def names_of(self, array: str) -> tuple[str, ...]:
        """Return the names of an array's numbers, from 0."""
        return names_of(array, self.names)


def write_vtu(path: Path, grid: Grid, *, compression: Compression = "zlib", parents: bool = False) -> None:
    """Write a grid as compressed binary VTU; its folder too, where `parents` says so.

    zlib is read by everything; LZ4 by VTK, ParaView and PyVista only.

    Raises
    ------
    OSError
        If the file cannot be written; nothing is left behind.
    """
    load_vtk()
    from vtkmodules.vtkCommonMisc import vtkErrorCode
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    data = vtk_of_grid(grid, in_xml) if grid.faces is None else _with_faces_as_fields(grid, grid.faces)
    with whole_file(path, parents=parents) as draft:
        writer = vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(draft))
        writer.SetInputData(data)
        writer.SetDataModeToBinary()  # inline, in base64: ParaView 5.11 with a patched expat reads no appended data
        if compression == "lz4":
            writer.SetCompressorTypeToLZ4()
            writer.SetCompressionLevel(9)  # a tenth of the time of zlib at its quickest, a fifth larger
        else:
            writer.SetCompressorTypeToZLib()
            writer.SetCompressionLevel(1)
        writer.AddObserver("ErrorEvent", lambda *_: None)  # what is raised below says it
        with silent():
            written = writer.Write() == 1 and draft.exists()
        if writer.GetErrorCode() == vtkErrorCode.OutOfDiskSpaceError:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        if not written:
            raise OSError(f"cannot write {path}: is the folder writable, the disk full?")
        if grid.faces is not None:
            draft.write_bytes(_faces_among_cells(draft.read_bytes()))


OF_FACES = ("faces", "faceoffsets")
OF_FACES_IN_VTK = ("face_connectivity", "face_offsets", "polyhedron_to_faces", "polyhedron_offsets")


def _with_faces_as_fields(grid: Grid, faces: Faces) -> Any:
    """Return polyhedra with their faces in two field arrays, as ParaView before 6.0 reads them.

    ``faces`` has the number of faces of each cell, and the number of points and the points of each face;
    ``faceoffsets`` the end of each cell in it. VTK 9.4 and later write four other arrays, which ParaView 5 does not
    read: it shows nothing.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk

    cells, count = np.arange(len(grid.offsets) - 1), np.diff(faces.cell_offsets)
    start = faces.offsets[faces.cell_offsets] + faces.cell_offsets + np.arange(len(faces.cell_offsets))
    of_face = faces.offsets[:-1] + np.arange(len(faces.offsets) - 1) + np.repeat(cells, count) + 1
    told = np.zeros(start[-1], dtype=np.int64)
    points = np.ones(len(told), dtype=bool)
    told[start[:-1]], told[of_face] = count, np.diff(faces.offsets)
    points[start[:-1]] = points[of_face] = False
    told[points] = faces.connectivity
    data = vtk_of_grid(grid, in_xml)
    for name, values in zip(OF_FACES, (told, start[1:]), strict=True):
        array = numpy_to_vtk(np.ascontiguousarray(values, dtype=np.int64), deep=True)
        array.SetName(name)
        data.GetFieldData().AddArray(array)
    return data


def _faces_among_cells(content: bytes) -> bytes:
    """Return a VTU file whose field arrays `OF_FACES` take the place of VTK's own arrays of the cells."""
    found = []
    for name in (*OF_FACES, *OF_FACES_IN_VTK):
        array = re.search(
            rb'\s*<DataArray type="Int\d+"[^>]* Name="%b".*?</DataArray>' % name.encode(), content, re.DOTALL
        )
        assert array is not None
        found.append(re.sub(rb' NumberOfTuples="\d+"', b"", array[0], count=1))
        content = content[: array.start()] + content[array.end() :]
    found = found[: len(OF_FACES)]
    content = re.sub(rb' version="[\d.]+" byte', b' version="1.0" byte', content, count=1)  # of files with these arrays
    place = content.index(b"</Cells>")
    return b"".join([content[:place].rstrip(), *found, b"\n      ", content[place:]])


def read_vtu(path: Path, *, needs: Sequence[str] = ()) -> Grid:
    """Return the grid of a VTU file whose cells are all of one type; parameters and errors as for `grid_of`."""
    if not path.is_file():
        raise ModelError(f"{path}: there is no such file")
    return grid_of(path.read_bytes(), path, needs=needs)


def grid_of(content: bytes, path: Path, *, needs: Sequence[str] = (), coordinates: int = 2) -> Grid:
    """Return the grid of a VTU file that was read.

    Parameters
    ----------
    content : bytes
        Content of the file.
    path : Path
        The file, for messages.
    needs : sequence of str
        Cell arrays that must be in it.
    coordinates : int
        Of points: in the plane z is left out.

    Raises
    ------
    ModelError
        If it is damaged, of mixed cell types or without an array that is needed.
    """
    told, arrays = read_arrays(content, path)
    types = told["types"]
    if len(types) > 1:
        raise ModelError(f"{path}: has cells of the types {types}; one type is needed")
    data = [
        {name.removeprefix(kind): values for name, values in arrays.items() if name.startswith(kind)}
        for kind in KINDS[:2]
    ]
    if any(name not in data[1] for name in needs):
        raise ModelError(f"{path}: not a complete VTU file of a run; run the model again")
    return Grid(
        points=arrays["points"][:, :coordinates],
        offsets=arrays["offsets"],
        connectivity=arrays["connectivity"],
        cell_type=types[0],
        point_data=data[0],
        cell_data=data[1],
        names=told["names"],
    )


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
    probe.SetSourceData(vtk_of_grid(grid))
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
    if b"<!DOCTYPE" in content.replace(b"\0", b""):  # a document type, whose entities may grow without end
        raise ModelError(f"{path}: not a PVD file (a document type is in it)")
    try:
        root = ElementTree.fromstring(content)
        found = [(float(e.get("timestep", "0")), path.parent / e.get("file", "")) for e in root.iter("DataSet")]
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # no such encoding, no number
        raise ModelError(f"{path}: not a PVD file ({error})") from None
    if not found:
        raise ModelError(f"{path}: lists no files")
    return found


def spatial(vectors: FloatArray) -> FloatArray:
    """Return plane vectors (k, 2) with a third component 0, (k, 3); those of three as they are."""
    if vectors.shape[1] == 3:
        return vectors
    return np.column_stack([vectors, np.zeros(len(vectors))])


def texts_of(grid: Grid) -> dict[str, Any]:
    """Return the names of numbers of cell arrays as arrays of texts, ``joint_name`` for ``joint``; "" without one."""
    found = {}
    for array in {key.partition(":")[0] for key in grid.names} & {*grid.cell_data}:
        mine = {number: key.partition(":")[2] for key, number in grid.names.items() if key.startswith(f"{array}:")}
        numbers, where = np.unique(np.asarray(grid.cell_data[array]), return_inverse=True)
        texts = np.array([mine.get(int(number), "") for number in numbers], dtype=str)
        found[f"{array}_name"] = texts[where] if len(texts) else np.zeros(0, dtype=str)
    return found


def vtk_of_grid(grid: Grid, spell: Callable[[str], str] = str) -> Any:
    """Return the grid as VTK's own; `spell` gives the names of arrays."""
    load_vtk()
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkDataArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(spatial(grid.points)), deep=True))
    data = vtkUnstructuredGrid()
    data.SetPoints(points)
    types = grid.cell_type
    if not isinstance(types, int):
        types = numpy_to_vtk(np.ascontiguousarray(types, dtype=np.uint8), deep=True)
    cells = _cell_array(grid.offsets, grid.connectivity)
    if grid.faces is None:
        data.SetCells(types, cells)
    else:
        own = _cell_array(grid.faces.cell_offsets, np.arange(grid.faces.cell_offsets[-1]))
        kinds = numpy_to_vtk(np.full(len(grid.offsets) - 1, POLYHEDRON, np.uint8), deep=True)
        data.SetPolyhedralCells(kinds, cells, own, _cell_array(grid.faces.offsets, grid.faces.connectivity))
    for attributes, arrays in (
        (data.GetPointData(), grid.point_data),
        (data.GetCellData(), grid.cell_data),
        (data.GetFieldData(), grid.field_data),
    ):
        for name, values in arrays.items():
            array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
            array.SetName(spell(name))
            if name in grid.units:
                array.GetInformation().Set(vtkDataArray.UNITS_LABEL(), grid.units[name])
            attributes.AddArray(array)
    for name, number in grid.names.items():
        array = numpy_to_vtk(np.array([number], dtype=np.int32), deep=True)
        array.SetName(spell(name))
        data.GetFieldData().AddArray(array)
    return data


def _cell_array(offsets: IntArray, connectivity: IntArray) -> Any:
    """Return rows of numbers as VTK's own."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    rows = vtkCellArray()
    rows.SetData(
        numpy_to_vtk(np.ascontiguousarray(offsets, dtype=np.int64), deep=True, array_type=_id_type()),
        numpy_to_vtk(np.ascontiguousarray(connectivity, dtype=np.int64), deep=True, array_type=_id_type()),
    )
    return rows


def in_xml(name: str) -> str:
    """Return the name of an array as VTK's writer must be given it, which writes it into an attribute as it is.

    Control characters, which XML cannot hold, become an escape, a backslash with ``x01`` and the like.
    """
    return NO_XML.sub(lambda found: found[0].encode("unicode_escape").decode(), name).translate(IN_ATTRIBUTES)


def _id_type() -> int:
    from vtkmodules.vtkCommonCore import VTK_ID_TYPE

    return int(VTK_ID_TYPE)
