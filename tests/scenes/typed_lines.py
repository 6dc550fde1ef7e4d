"""What a reader does who types a line of a page into a shell."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from tests.scenes.small_case import Case


def type_line(case: Case, line: str, place: str, otherwise: Callable[[str, str], None] | None = None) -> None:
    """Run the commands of a line in the folder of a case: bsm-mesh, Python files and code, Gmsh on a script, cat.

    Any other command, of which `otherwise` makes what it can, is a fault where there is none.
    """
    for part in line.split(" && "):
        program, *arguments = shlex.split(part)
        if program == "bsm-mesh":
            outcome = case.run(*arguments)
            assert outcome.code == 0, f"{place}: {part}: {outcome.err}"
        elif program == "python" and arguments[0] != "-m":
            command = [sys.executable, *arguments]
            done = subprocess.run(command, cwd=case.folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{place}: {part}: {done.stderr}"
        elif program == "cat":
            *parts, _, target = arguments
            case.write(target, "".join((case.folder / name).read_text(encoding="utf-8") for name in parts))
        elif program == "gmsh":
            _, geo, _, _, _, target = arguments
            mesh_by_gmsh(case.folder, geo, target)
        else:
            assert otherwise is not None, f"{place}: {part}"
            otherwise(part, place)


def mesh_by_gmsh(folder: Path, geo: str, target: str) -> None:
    """Do what ``gmsh -2 GEO -format msh41 -o TARGET`` does."""
    from bsm_mesh.geometries import gmsh_session

    with gmsh_session("geo") as gmsh:
        gmsh.merge(str(folder / geo))
        gmsh.model.mesh.generate(2)
        gmsh.write(str(folder / target))
