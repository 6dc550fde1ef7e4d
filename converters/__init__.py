"""From meshes to blocks and joints, from results to VTU, and the continuum solution for comparison.

The names below are loaded when they are first used, so that ``from bsm_mesh import converters`` is quick.
"""

from __future__ import annotations

if __name__ == "converters":  # imported by the folder's own name
    from bsm_mesh.checkout import hand_over

    hand_over(__name__)

from typing import TYPE_CHECKING

from bsm_mesh.lazy import names_from

if TYPE_CHECKING:
    from bsm_mesh.converters.continuum import Comparison, ContinuumSolution, compare, solve_continuum
    from bsm_mesh.converters.meshes.convert import convert_mesh, convert_meshio, read_blocks, read_mesh
    from bsm_mesh.converters.meshes.report import MeshReport, Note, NoteKind

__all__ = [
    "Comparison",
    "ContinuumSolution",
    "MeshReport",
    "Note",
    "NoteKind",
    "compare",
    "convert_mesh",
    "convert_meshio",
    "read_blocks",
    "read_mesh",
    "solve_continuum",
]

_HOME = {
    "Comparison": "bsm_mesh.converters.continuum",
    "ContinuumSolution": "bsm_mesh.converters.continuum",
    "compare": "bsm_mesh.converters.continuum",
    "solve_continuum": "bsm_mesh.converters.continuum",
    "convert_mesh": "bsm_mesh.converters.meshes.convert",
    "convert_meshio": "bsm_mesh.converters.meshes.convert",
    "read_blocks": "bsm_mesh.converters.meshes.convert",
    "read_mesh": "bsm_mesh.converters.meshes.convert",
    "MeshReport": "bsm_mesh.converters.meshes.report",
    "Note": "bsm_mesh.converters.meshes.report",
    "NoteKind": "bsm_mesh.converters.meshes.report",
}


if not TYPE_CHECKING:
    __getattr__ = names_from(_HOME, __name__)


def __dir__() -> list[str]:
    return __all__
