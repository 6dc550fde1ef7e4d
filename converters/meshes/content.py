"""The format of a mesh by its content: the ending is a word of whoever wrote the file.

Gmsh takes unknown content for a script and runs it, so no file goes there that is not listed here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from bsm_mesh.errors import ModelError

HEAD = 4096  # bytes of a file that tell its format


@dataclass(frozen=True, slots=True)
class MeshFormat:
    """A format that its first bytes identify.

    Attributes
    ----------
    name : str
        As messages call it.
    ending : str
        By which its reader knows it, for Gmsh in lower case.
    head : re.Pattern
        First bytes of such a file.
    """

    name: str
    ending: str
    head: re.Pattern[bytes]


UNV = MeshFormat("UNV (I-deas universal file)", ".unv", re.compile(rb"\s*-1[ \t]*\r?\n[ \t]*\d+[ \t]*\r?\n"))
MSH = MeshFormat("MSH (Gmsh)", ".msh", re.compile(rb"\s*\$(MeshFormat|NOD|PhysicalNames|Comments)[ \t]*\r?\n"))
CGNS = MeshFormat("CGNS", ".cgns", re.compile(rb"\x89HDF\r\n\x1a\n"))
FORMATS = (UNV, MSH, CGNS)


def format_of(path: Path) -> MeshFormat | None:
    """Return the format that a file's content has, whatever it is called; None for all that is not known."""
    with path.open("rb") as file:
        head = file.read(HEAD)
    return next((known for known in FORMATS if known.head.match(head)), None)


def recognised(path: Path) -> MeshFormat:
    """Return the format that a file's content has.

    Raises
    ------
    ModelError
        If it has none of those in `FORMATS`.
    """
    if (found := format_of(path)) is None:
        known = ", ".join(known.name for known in FORMATS)
        raise ModelError(
            f"{path}: its content is no mesh in a format that Gmsh is given ({known}); "
            "it is damaged, or not what its ending says: write the mesh again"
        )
    return found
