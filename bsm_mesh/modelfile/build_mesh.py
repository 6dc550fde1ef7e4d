"""From the model file's mesh to blocks: a mesh file read, or a geometry built and read."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.errors import ModelError, placed
from bsm_mesh.files import scratch_folder, unnamed_file
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.quantities import UNIT_OF_LENGTH
from bsm_mesh.model.quantity import convert
from bsm_mesh.modelfile.build_marks import geometry_faults, marks_of
from bsm_mesh.modelfile.mesh_tables import MeshTable
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_tables import RockBoxTable
from bsm_mesh.text.interruption import heed_again
from bsm_mesh.text.terminal import is_quiet, say

if TYPE_CHECKING:
    from bsm_mesh.converters import MeshReport
    from bsm_mesh.converters.meshes.marks import Marks


def read_blocks(file: ModelFile, path: Path, reach: Reach) -> tuple[Blocks, MeshReport]:
    """Return the blocks of the mesh file, or of the geometry, which is built in a temporary folder."""
    mesh = file.mesh
    if (mesh.file is None) == (mesh.geometry is None):
        given = "neither is" if mesh.file is None else "both are"
        raise ModelError(f"{path.name}: [mesh] needs one of the keys 'file' and 'geometry'; {given} given")
    with mesh_source(mesh, path, reach) as source:
        with placed(path.name):
            marks = marks_of(file, reach)
        return _read(source, mesh, file.groups, marks, path.name)


@contextmanager
def mesh_source(mesh: MeshTable | RockBoxTable, path: Path, reach: Reach) -> Iterator[Path]:
    """Yield the mesh file that a model file's `path` names, or that of its geometry, built in a temporary folder.

    Raises
    ------
    ModelError
        If there is no such mesh or geometry, or it may not be read.
    """
    if mesh.file is not None:
        if mesh.file.endswith(".py"):
            raise ModelError(f'{path.name}: [mesh] file is a script; write geometry = "{mesh.file}"')
        if mesh.parameters:
            raise ModelError(f"{path.name}: [mesh.parameters] belong to a geometry; [mesh] has a file")
        with placed(path.name):
            source = reach.mesh(mesh.file)
        yield source
        return
    name = str(mesh.geometry)
    with placed(path.name):
        geometry = reach.geometry(name)
    with scratch_folder() as folder:
        target = folder / "mesh.msh"
        try:
            build_geometry(geometry, target, mesh.parameters)
            yield target
        except ModelError as error:  # the name of the temporary file says nothing to the user
            raise ModelError([fault.replace(str(target), f"mesh.msh of {name}") for fault in error.faults]) from error


def unit_scale(unit: str) -> float:
    """Return the length [m] of a mesh's unit."""
    try:
        return convert(f"1 {unit}", UNIT_OF_LENGTH)
    except ValueError as error:
        raise ModelError(f'[mesh] unit = "{unit}": {error}') from None


def _read(
    path: Path, mesh: MeshTable, groups: dict[str, str], marks: Marks | None, model_file: str
) -> tuple[Blocks, MeshReport]:
    from bsm_mesh.converters import read_mesh

    with placed(model_file):
        scale = unit_scale(mesh.unit)
    with placed(model_file) if marks is not None else nullcontext():
        return read_mesh(
            path,
            groups=groups,
            merge_tolerance=mesh.merge_tolerance,
            unit_scale=scale,
            blocks=mesh.blocks,
            marks=marks,
        )


def build_geometry(case: str | os.PathLike[str], path: Path, parameters: Mapping[str, object]) -> None:
    """Write the mesh of a geometry; its output goes to stderr, since stdout is the results'.

    Raises
    ------
    ModelError
        For an unknown geometry or parameter, and for whatever a user's script raises.
    """
    from bsm_mesh.geometries.cases import find_case
    from bsm_mesh.geometries.session import gmsh_as_found

    with geometry_faults(), stdout_to_stderr(), gmsh_as_found(str(case)):
        found = find_case(case)
        if "path" in parameters:
            raise ModelError(f"{found.name}: there is no parameter 'path': the mesh is written where it is needed")
        try:
            found.build(path, **parameters)
        finally:
            heed_again()


@contextmanager
def stdout_to_stderr() -> Iterator[None]:
    """Redirect stdout to stderr, also Gmsh's own output without its Info lines; quiet commands and Python drop it."""
    if sys.stdout is not None:
        sys.stdout.flush()
    with unnamed_file() as printed:
        try:
            kept = os.dup(1)
        except OSError:  # no such thing as stdout
            kept = None
        if kept is not None:
            os.dup2(printed.fileno(), 1)
        try:
            with redirect_stdout(io.StringIO() if is_quiet() else sys.stderr):
                yield
        finally:
            if kept is not None:
                os.dup2(kept, 1)
                os.close(kept)
            printed.seek(0)
            lines = printed.read().decode(errors="replace").splitlines()
            for line in lines:
                if not (line.startswith("Info ") or is_quiet()):
                    say(line, err=True)
