"""Files that Gmsh reads: I-deas universal files (.unv), which meshio does not know, CGNS, and MSH 4.0."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from bsm_mesh.converters.meshes.cells import PHYSICAL, MeshCells
from bsm_mesh.converters.meshes.content import UNV, recognised
from bsm_mesh.converters.meshes.from_msh import read_msh41
from bsm_mesh.converters.meshes.known_forms import unv_groups
from bsm_mesh.errors import ModelError
from bsm_mesh.files import given_alone, whole_file

SUFFIXES = (".unv", ".cgns")
LIBRARY = ("gmsh",)


def read_by_gmsh(path: Path) -> MeshCells:
    """Return the elements and groups of a file that Gmsh reads; groups of elements keep their names.

    Gmsh runs unknown content as a script, and a file of options next to the mesh (``mesh.unv.opt``) too. So it
    gets the mesh alone in a folder of ours, by the ending of the format that the content has.

    Raises
    ------
    ModelError
        If the content is no mesh, Gmsh is not there, or it cannot read the file.
    """
    content = recognised(path)
    given = f"given{content.ending}"
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise ModelError(
            f"{path}: {content.name} is read by Gmsh, which cannot start ({error}); save the mesh as MSH 4.1 or VTU"
        ) from None
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.AbortOnError", 2)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.option.setNumber("Mesh.Binary", 1)
        gmsh.option.setNumber("Mesh.SaveAll", 1)
        with given_alone({} if content is UNV else {given: path}) as folder:
            if content is UNV:
                with whole_file(folder / given) as draft:
                    draft.write_bytes(unv_groups(path.read_bytes()))
            gmsh.merge(str(folder / given))
            with whole_file(folder / "mesh.msh") as draft:
                gmsh.write(str(draft))
            cells = read_msh41(folder / "mesh.msh")
    except ModelError:
        raise ModelError(
            f"{path}: Gmsh finds no plane mesh in it; it is damaged, or not what its ending says"
        ) from None
    except Exception as error:  # Gmsh raises nothing more special
        raise ModelError(f"{path}: Gmsh cannot read it ({error}); it is damaged, or holds no mesh") from None
    finally:
        gmsh.finalize()
    groups = [group for group in cells.groups if content is not UNV or not group.name.startswith(f"{PHYSICAL}=")]
    return dataclasses.replace(cells, source=str(path), groups=tuple(groups))  # of UNV they are numbers of properties
