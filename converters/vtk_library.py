"""VTK: its cell types, its loading, and its reading of a VTU file; `grid_reader` calls that in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np

from bsm_mesh.signals import signals_held

VERTEX, LINE, TRIANGLE, POLYGON, QUADRATIC_TRIANGLE, POLYHEDRON = 1, 3, 5, 7, 22, 42  # VTK cell types
KINDS = ("point:", "cell:", "field:")
COMPONENTS = {  # of the arrays of results; those that are not here are numbers
    **dict.fromkeys(("displacement", "stage_displacement", "origin", "load", "reaction", "water", "force"), 3),
    **dict.fromkeys(
        ("normal", "position", "velocity", "mechanism", "centroid_velocity", "shear_point", "shear_direction"), 3
    ),
    **dict.fromkeys(("stress", "stress_effective"), 6),
    **dict.fromkeys(("aperture_at_ends", "wet", "wet_pressure"), 2),
}
COMPONENTS_IN_SPACE = {  # of polyhedra, whose rotations and moments are vectors
    **COMPONENTS,
    **dict.fromkeys(("rotation", "stage_rotation", "load_moment", "reaction_moment", "moment"), 3),
}


def numbered(array: str, names: Sequence[str]) -> dict[str, int]:
    """Return the names of an array's numbers, from 0, as `Grid` takes them."""
    return {f"{array}:{name}": number for number, name in enumerate(names)}


def names_of(array: str, names: Mapping[str, int]) -> tuple[str, ...]:
    """Return the names of an array's numbers, from 0."""
    mine = f"{array}:"
    found = {number: key.removeprefix(mine) for key, number in names.items() if key.startswith(mine)}
    return tuple(found[number] for number in range(max(found, default=-1) + 1))


@cache
def load_vtk() -> None:
    """Import VTK, whole: its C code dies where an interruption is raised while one module imports the next."""
    with signals_held():
        import vtkmodules.util.numpy_support
        import vtkmodules.vtkCommonMisc
        import vtkmodules.vtkIOXML  # noqa: F401


@contextmanager
def silent() -> Iterator[None]:
    """Keep VTK from writing to stderr, past Python."""
    from vtkmodules.vtkCommonCore import vtkLogger

    level = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(level)


def content_of_vtu(content: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what VTK reads of a VTU file: the types of its cells and its names of numbers; its arrays by their names.

    Point arrays are called ``point:NAME``, cell arrays ``cell:NAME``, arrays of the whole ``field:NAME``. Faces of
    polyhedra are in ``face_offsets`` and ``face_connectivity``, those of each cell in ``cell_face_offsets`` and
    ``cell_faces``.

    Raises
    ------
    ValueError
        If VTK finds a fault.
    """
    load_vtk()
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader: Any = vtkXMLUnstructuredGridReader()
    reader.ReadFromInputStringOn()
    reader.SetInputString(content)
    reader.AddObserver("ErrorEvent", lambda *_: None)  # the message says it
    with silent():
        reader.Update()
    data = reader.GetOutput()
    if reader.GetErrorCode() or data.GetPoints() is None:
        raise ValueError
    types = vtk_to_numpy(data.GetDistinctCellTypesArray()) if data.GetNumberOfCells() else np.array([VERTEX])
    arrays = {
        "points": vtk_to_numpy(data.GetPoints().GetData()).astype(np.float64),
        "offsets": vtk_to_numpy(data.GetCells().GetOffsetsArray()),
        "connectivity": vtk_to_numpy(data.GetCells().GetConnectivityArray()),
    }
    if POLYHEDRON in types:
        faces, cells = data.GetPolyhedronFaces(), data.GetPolyhedronFaceLocations()
        arrays |= {
            "face_offsets": vtk_to_numpy(faces.GetOffsetsArray()),
            "face_connectivity": vtk_to_numpy(faces.GetConnectivityArray()),
            "cell_faces": vtk_to_numpy(cells.GetConnectivityArray()),
            "cell_face_offsets": vtk_to_numpy(cells.GetOffsetsArray()),
        }
    attributes_of_kinds = (data.GetPointData(), data.GetCellData(), data.GetFieldData())
    for kind, attributes in zip(KINDS, attributes_of_kinds, strict=True):
        arrays |= {f"{kind}{name}": values for name, values in _arrays(attributes).items()}
    return {"types": types.tolist(), "names": names_in(data)}, arrays


def names_in(data: Any) -> dict[str, int]:
    """Return the names that a grid of VTK's gives numbers: ``"joint:J1": 3``.

    Results of schema version 3 have a list of them instead: texts ``joint_names``.
    """
    fields = data.GetFieldData()
    found = [fields.GetAbstractArray(k) for k in range(fields.GetNumberOfArrays())]
    names: dict[str, int] = {}
    for array in found:
        name, count = array.GetName() or "", array.GetNumberOfValues()
        if not array.IsNumeric() and name.endswith("_names"):
            names |= numbered(name.removesuffix("_names"), [array.GetValue(k) for k in range(count)])
        elif array.IsNumeric() and count == 1 and ":" in name:
            names[name] = int(array.GetValue(0))
    return names


def _arrays(attributes: Any) -> dict[str, Any]:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    found = (attributes.GetArray(k) for k in range(attributes.GetNumberOfArrays()))
    return {array.GetName(): vtk_to_numpy(array) for array in found if array is not None}
