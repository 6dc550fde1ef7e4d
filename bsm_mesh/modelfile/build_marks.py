"""From the model file's joints and boundaries by place to what marks them on a mesh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError, gathered, raise_faults
from bsm_mesh.modelfile.mesh_tables import LineFile
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.reach import Reach

if TYPE_CHECKING:
    from bsm_mesh.converters.meshes.marks import Marks

LIMITS = ("below", "above", "left_of", "right_of")


def places_in(file: ModelFile) -> dict[str, Any]:
    """Return all that a model file says of joints and boundaries by place; nothing where it says nothing."""
    joints = {name: (table.along, table.between) for name, table in file.joint.items()}
    given = {name: both for name, both in joints.items() if both != (None, None)}
    return {"joint": given, "boundary": dict(file.boundary)} if given or file.boundary else {}


def marks_of(file: ModelFile, reach: Reach) -> Marks | None:
    """Return what marks joints and boundaries by place; None where the file says nothing of that.

    Raises
    ------
    ModelError
        For a file of lines that cannot be read, and a boundary without a place.
    """
    if not places_in(file):
        return None
    from bsm_mesh.converters.meshes.marks import Marks, Place

    faults: list[str] = []
    lines: dict[str, list[FloatArray]] = {}
    for name, table in file.joint.items():
        if table.along is not None:
            with gathered(faults, f"[joint.{name}] along"):
                lines[name] = _lines(table.along, reach)
    places = {}
    for name, boundary in file.boundary.items():
        given: Mapping[str, float | None] = {limit: getattr(boundary, limit) for limit in LIMITS}
        along = None if boundary.along is None else np.array(boundary.along)
        if along is None and all(value is None for value in given.values()):
            faults.append(f"[boundary.{name}] needs one or more of {', '.join(LIMITS)}, along")
        elif along is not None and len(along) < 2:
            faults.append(f"[boundary.{name}] along: a line has two points or more")
        places[name] = Place(**given, along=along)
    raise_faults(faults)
    borders = {name: table.between for name, table in file.joint.items() if table.between is not None}
    return Marks(lines=lines, borders=borders, boundaries=places)


def _lines(along: Any, reach: Reach) -> list[FloatArray]:
    if not isinstance(along, LineFile):
        short = [line for line in along if len(line) < 2]
        if short or not along:
            raise ModelError("a line has two points or more")
        return [np.array(line) for line in along]
    from bsm_mesh.geometries.traces import chosen_traces

    names = None if along.set is None else {along.set: along.set}
    with geometry_faults():
        faults, _ = chosen_traces(reach.path(along.file, "along"), names=names, scale=along.scale)
    return [np.asarray(line) for fault in faults for line in fault.lines]


@contextmanager
def geometry_faults() -> Iterator[None]:
    """Raise the faults with a geometry as a `ModelError`, as all bad input is."""
    from bsm_mesh.geometries.errors import GeometryError

    try:
        yield
    except GeometryError as error:
        raise ModelError(error.faults) from error
