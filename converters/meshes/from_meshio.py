"""Every other format, read by meshio, with its errors corrected."""

from __future__ import annotations

import contextlib
import io
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.converters.meshes.cells import PHYSICAL, MeshCells, gather_cells
from bsm_mesh.converters.meshes.from_msh import names_in
from bsm_mesh.converters.meshes.known_forms import NASTRAN, in_known_form
from bsm_mesh.converters.meshes.report import Note, NoteKind
from bsm_mesh.converters.meshio_library import NAMES, load_meshio
from bsm_mesh.errors import ModelError, as_given, counted

LIBRARY = NAMES  # what `read_apart` imports before its limits hold
PLANE = {".node": (b"2",), ".ele": (b"3", b"6")}  # coordinates, and nodes of elements, in Triangle's files
Sets = dict[str, list[npt.NDArray[Any] | None]]


def read_by_meshio(path: Path) -> MeshCells:
    """Return the elements and groups of a file in any format that meshio knows.

    Raises
    ------
    ModelError
        If meshio cannot read the file.
    """
    mesh, remarks = read_mesh(path)
    _refuse_other_axes(path, mesh)
    return cells_of_meshio(mesh, str(path), remarks=remarks, physical_names=_physical_names(path))


def read_mesh(path: Path) -> tuple[Any, list[str]]:
    """Return the ``meshio.Mesh`` of a file, and what meshio printed.

    Raises
    ------
    ModelError
        If meshio cannot read the file.
    """
    meshio = load_meshio()
    said = io.StringIO()
    try:
        # meshio prints its errors and then leaves the program.
        with (
            in_known_form(path) as known,
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            np.errstate(all="ignore"),
        ):
            mesh = meshio.read(known, file_format=_format(known))
    except ModelError:
        raise
    except ImportError as problem:
        raise ModelError(
            f"{path}: this format needs the Python package '{problem.name}'; install it (pip install {problem.name}), "
            "or save the mesh as MSH 4.1 or VTU"
        ) from None
    except (Exception, SystemExit) as problem:  # readers raise whatever a damaged file makes them raise
        raise ModelError(f"{path}: {_reason(path, said.getvalue(), problem)}") from None
    remarks = [line.strip() for line in said.getvalue().splitlines() if line.strip()]
    if any("not closed by" in line for line in remarks):
        raise ModelError(f"{path}: cut off or damaged: {remarks[-1]}; write the file again")
    return mesh, remarks


def cells_of_meshio(
    mesh: Any,
    source: str = "mesh",
    *,
    remarks: Sequence[str] = (),
    physical_names: Mapping[tuple[int, int], str] | None = None,
) -> MeshCells:
    """Return the elements and groups of a ``meshio.Mesh``.

    Parameters
    ----------
    mesh : meshio.Mesh
        What meshio read, or the user made.
    source : str
        Named in messages.
    remarks : sequence of str
        What meshio printed.
    physical_names : mapping of (int, int) to str, optional
        Names of Gmsh's physical groups by dimension and number. meshio keeps one number a name.

    Raises
    ------
    ModelError
        If it is no mesh, or one that `gather_cells` refuses.
    """
    if not hasattr(mesh, "points") or not hasattr(mesh, "cells"):
        raise ModelError(f"{source} = {as_given(mesh)} must be a meshio.Mesh; of a file read_mesh returns the blocks")
    return gather_cells(
        source,
        mesh.points,
        [(block.type, block.data if len(block.data) else np.empty((0, 2))) for block in mesh.cells],
        sets={**_sets(mesh), **_physical_sets(mesh, physical_names or {})},
        arrays=mesh.cell_data,
        node_sets={str(name): np.asarray(nodes, np.int64) for name, nodes in (mesh.point_sets or {}).items()},
        notes=[
            *(Note(kind=NoteKind.READER, count=1, text=f"meshio says: {line}") for line in dict.fromkeys(remarks)),
            *_lost_groups(mesh, physical_names or {}),
        ],
    )


def _format(path: Path) -> str | None:
    """Return meshio's name of the format where the suffix represents two, else None."""
    if path.suffix.lower() != ".msh":
        return None
    with path.open("rb") as file:
        return "gmsh" if file.read(1) == b"$" else "ansys"


def _reason(path: Path, said: str, problem: BaseException) -> str:
    if path.suffix == ".geo":
        return "a script of Gmsh, no mesh; make one: gmsh -2 -format msh41 " + path.name
    if "Could not deduce file format" in str(problem):
        known = ", ".join(sorted({*load_meshio().extension_to_filetypes, ".vtp", ".unv"}))
        return f"no mesh format has the ending '{path.suffix}' (known: {known}); save the mesh as .msh or .vtu"
    if isinstance(problem, UnicodeDecodeError):
        problem = ValueError("it holds bytes that are no text")
    lines = [line.strip() for line in said.splitlines() if line.strip() and "Couldn't read file" not in line]
    why = str(problem) if isinstance(problem, Exception) and str(problem) else (lines or ["no reason given"])[-1]
    if _is_of_triangle(path):
        return (
            "a plane mesh of Triangle: of this ending meshio reads TetGen's meshes in space alone; save it as MSH 4.1 "
            "or VTU, or give nodes and triangles to bsm_mesh.converters.convert_mesh"
        )
    return (
        f"meshio cannot read it ({why}); it is damaged, cut off, or of another kind than meshio knows of this ending; "
        "save it as MSH 4.1 or VTU"
    )


def _is_of_triangle(path: Path) -> bool:
    """Return whether a file holds plane nodes, or triangles: the second number says so."""
    if path.suffix.lower() not in PLANE:
        return False
    with path.open("rb") as file:
        words = re.sub(rb"#.*", b"", file.read(4096)).split()
    return len(words) > 1 and words[1] in PLANE[path.suffix.lower()]


def _sets(mesh: Any) -> Sets:
    """Return the named groups: meshio's cell sets, Gmsh's physical names, MED's families."""
    n_blocks = len(mesh.cells)
    found: Sets = {}
    for name, members in mesh.cell_sets.items():
        if name != "gmsh:bounding_entities" and len(members) == n_blocks:
            found[name] = [None if inside is None else np.asarray(inside) for inside in members]
    physical = mesh.cell_data.get(PHYSICAL)
    if physical is not None:
        for name, value in mesh.field_data.items():
            if np.size(value) == 2 and not _any_members(found.get(name, [])):
                tag, dimension = (int(v) for v in value)
                found[name] = [
                    np.flatnonzero(np.abs(tags) == tag) if block.dim == dimension else None
                    for block, tags in zip(mesh.cells, physical, strict=True)
                ]
    families: dict[int, list[str]] = getattr(mesh, "cell_tags", None) or {}
    tags = mesh.cell_data.get("cell_tags")
    if tags is not None and len(tags) == n_blocks:
        for name in dict.fromkeys(name for names in families.values() for name in names):
            inside = [family for family, names in families.items() if name in names]
            found[name] = [np.flatnonzero(np.isin(values, inside)) for values in tags]
    return found


def _physical_names(path: Path) -> dict[tuple[int, int], str]:
    """Return the names of the physical groups of a MSH file; none of other files."""
    if _format(path) != "gmsh":
        return {}
    section = re.search(rb"\$PhysicalNames[ \t\r]*\n(.*?)\$EndPhysicalNames", path.read_bytes(), re.DOTALL)
    return {} if section is None else names_in(section[1].decode("utf-8", "replace"))


def _physical_sets(mesh: Any, names: Mapping[tuple[int, int], str]) -> Sets:
    """Return Gmsh's groups that meshio does not distinguish: of names that several numbers have, and curves of no name.

    `names` are those in the file, by dimension and number; without them meshio's own are taken.
    """
    numbers = mesh.cell_data.get(PHYSICAL)
    if numbers is None:
        return {}
    known = names or {(int(v[1]), int(v[0])): name for name, v in mesh.field_data.items() if np.size(v) == 2}
    several = {name for name, count in Counter(names.values()).items() if count > 1}
    tags_of: dict[str, list[tuple[int, int]]] = {name: [] for name in several}
    for key, name in known.items():
        if name in several:
            tags_of[name].append(key)
    curves = {int(tag) for block, tags in zip(mesh.cells, numbers, strict=True) if block.dim == 1 for tag in tags}
    tags_of |= {f"{PHYSICAL}={tag}": [(1, tag)] for tag in sorted(curves) if tag > 0 and (1, tag) not in known}
    return {
        name: [
            np.flatnonzero(np.isin(np.abs(tags), [tag for dimension, tag in keys if dimension == block.dim]))
            for block, tags in zip(mesh.cells, numbers, strict=True)
        ]
        for name, keys in tags_of.items()
    }


def _lost_groups(mesh: Any, names: Mapping[tuple[int, int], str]) -> list[Note]:
    """Return a note where a file has names of groups, and no element is in any: so Gmsh saves all in MSH 2."""
    numbers = mesh.cell_data.get(PHYSICAL)
    if not names or numbers is None or any(np.any(tags) for tags in numbers):
        return []
    listed = ", ".join(f"'{name}'" for name in dict.fromkeys(names.values()))
    text = (
        f"no element is in one of the groups of the file ({listed}): MSH 2 saved with Mesh.SaveAll = 1 does not say "
        "which elements they have; save it without Mesh.SaveAll, or as MSH 4.1"
    )
    return [Note(kind=NoteKind.EMPTY_GROUP, count=len(names), text=text)]


def _refuse_other_axes(path: Path, mesh: Any) -> None:
    """Refuse nodes of Nastran that are given in a coordinate system of their own, which meshio leaves out."""
    systems = np.asarray(mesh.point_data.get("nastran:ref", ()))
    if path.suffix.lower() in NASTRAN and (count := int(np.count_nonzero(systems))):
        raise ModelError(
            f"{path}: {counted(count, 'node')} in a coordinate system other than the basic one (field CP of GRID), "
            f"such as {systems[systems != 0][0]}, which is not read; write all nodes in the basic system"
        )


def _any_members(members: list[npt.NDArray[Any] | None]) -> bool:
    return any(inside is not None and inside.size > 0 for inside in members)
