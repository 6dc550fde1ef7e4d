"""Which reader takes which file, and the description of a path that no reader can take."""

from __future__ import annotations

import os
from pathlib import Path

from bsm_mesh.converters.meshes.cells import MeshCells
from bsm_mesh.errors import ModelError
from bsm_mesh.reading import as_path, refuse_special

SELF_CONTAINED = {
    *(".msh", ".vtu", ".vtp", ".vtk", ".bdf", ".fem", ".nas", ".tec", ".dat", ".ply", ".su2", ".avs", ".off", ".mdpa"),
    *(".unv", ".ugrid", ".f3grid", ".stl", ".mesh", ".meshb", ".obj", ".wkt", ".vol", ".post", ".dato"),
}


def read_cells(path: str | os.PathLike[str]) -> MeshCells:
    """Return the elements and groups of a mesh file.

    MSH 4.1 and Abaqus input are read here, VTU, VTP and VTK by VTK, UNV, CGNS and MSH 4.0 by Gmsh, everything else by
    meshio; these three in a process of their own.

    Parameters
    ----------
    path : path
        The file; its ending gives the format.

    Raises
    ------
    ModelError
        If the file is missing, empty, unreadable, damaged or of no known format, or holds no plane mesh.
    """
    file = as_path("mesh", path)
    refuse_unreadable(file)
    from bsm_mesh.converters.meshes.from_msh import is_msh40, is_msh41, read_msh41
    from bsm_mesh.converters.meshes.from_vtk import SUFFIXES, read_vtk

    by_gmsh = file.suffix.lower() == ".msh" and is_msh40(file)
    if file.suffix.lower() == ".msh" and is_msh41(file) and not by_gmsh:
        return read_msh41(file)
    from bsm_mesh.converters.meshes.apart import read_apart

    if file.suffix.lower() in SUFFIXES:
        return read_apart(read_vtk, file)
    if file.suffix.lower() == ".inp":
        from bsm_mesh.converters.meshes.from_inp import read_inp

        return read_inp(file)
    from bsm_mesh.converters.meshes import from_gmsh

    if by_gmsh or file.suffix.lower() in from_gmsh.SUFFIXES:
        return read_apart(from_gmsh.read_by_gmsh, file)
    from bsm_mesh.converters.meshes.from_meshio import read_by_meshio

    return read_apart(read_by_meshio, file)


def may_name_others(file: Path) -> bool:
    """Return whether a mesh file may make its reader open further files, which may lie anywhere.

    So do XDMF (its HDF5 files), HDF5 files themselves (external links), TetGen and DOLFIN (the files next to it), and
    Abaqus by ``*INCLUDE``.
    """
    if file.suffix.lower() != ".inp":
        return file.suffix.lower() not in SELF_CONTAINED
    try:
        refuse_special(file)
        with file.open("rb") as opened:
            return any(b"INCLUDE" in line.upper() for line in opened)
    except (OSError, ModelError):
        return False  # reading says the fault


def refuse_unreadable(file: Path, what: str = "mesh") -> None:
    """Raise a `ModelError` for a path that is no file with something in it; `what` should be in it, for messages."""
    refuse_special(file)
    if os.path.isdir(file):  # False for a name that is none
        raise ModelError(f"{file}: is a folder; give the {what} file in it")
    try:
        with file.open("rb") as opened:
            empty = not opened.read(1)
    except FileNotFoundError:
        alike = sorted(p.name for p in file.parent.glob(f"*{file.suffix}")) if file.suffix else []
        there = f" ({file.parent} holds: {', '.join(alike[:8])})" if alike else ""
        raise ModelError(f"{file}: there is no such file{there}; correct the path or make the {what} first") from None
    except OSError as problem:
        raise ModelError(f"{file}: cannot be opened ({problem.strerror}); see to its permissions") from None
    except ValueError:  # a NUL in it
        raise ModelError(f"{file!s:.60}: is no path; correct it") from None
    if empty:
        raise ModelError(f"{file}: is empty; write the {what} again")
