"""Meshes in a form that their reader does not know, written anew in one that it does, element for element.

Gmsh reads most of meshio's unknown forms, but it takes groups from whole surfaces and curves: where elements of one
surface are in different groups, as other programs write them, all would be in all.
"""

from __future__ import annotations

import itertools
import re
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bsm_mesh.errors import ModelError
from bsm_mesh.files import scratch_folder, whole_file

NASTRAN = (".bdf", ".nas", ".fem")
BEGIN = re.compile(rb"^\s*BEGIN\s+BULK", re.IGNORECASE | re.MULTILINE)
MSH_1 = re.compile(rb"\s*\$NOD\s")
HEADER = re.compile(rb"\s*\$MeshFormat\s+2(?:\.\d+)?\s+([01])\s+8[ \t]*\r?\n(.{4})?", re.DOTALL)
PARAMETRIC = re.compile(rb"\$ParametricNodes[ \t\r]*\n[ \t]*(\d+)[ \t\r]*\n")
END_PARAMETRIC = b"$EndParametricNodes"
GROUPS = re.compile(
    rb"(^[ \t]*-1[ \t]*\r?\n[ \t]*)(2435|2452|2467|2477)([ \t]*\r?\n)(.*?)(^[ \t]*-1[ \t]*\r?$)",
    re.DOTALL | re.MULTILINE,
)
FIRST_GROUP = 1_000_000
OF_ENTITY = {0: 0, 1: 1, 2: 2, 3: 0}  # parameters of a node on an entity of a dimension


@contextmanager
def in_known_form(path: Path) -> Iterator[Path]:
    """Give a file that meshio knows: the file itself, or one of a moment in its place.

    Raises
    ------
    ModelError
        If the file is of another form, and damaged.
    """
    content = None
    if path.suffix.lower() in NASTRAN:
        content = _with_begin_bulk(path.read_bytes())
    elif path.suffix.lower() == ".msh":
        data = path.read_bytes()
        content = _msh_22(path, data) if MSH_1.match(data) else _without_parameters(path, data)
    if content is None:
        yield path
        return
    with scratch_folder() as folder:
        with whole_file(folder / f"given{path.suffix.lower()}") as draft:
            draft.write_bytes(content)
        yield folder / f"given{path.suffix.lower()}"


def unv_groups(data: bytes) -> bytes:
    """Return a universal file whose groups Gmsh reads: those of the data set 2477, by numbers of their own.

    Salome writes them as data set 2467, other programs as 2435 or 2452, of the same form. Gmsh mixes up the numbers of
    groups of curves, groups of surfaces and properties.
    """
    numbers = itertools.count(FIRST_GROUP)
    return GROUPS.sub(lambda found: found[1] + b"2477" + found[3] + _renumbered(found[4], numbers) + found[5], data)


def _renumbered(groups: bytes, new: Iterator[int]) -> bytes:
    """Return records of groups with other numbers: eight numbers, the name, two members a line."""
    lines, k = groups.split(b"\n"), 0
    while k < len(lines):
        numbers = lines[k].split()
        if len(numbers) != 8 or not all(number.isdigit() for number in numbers):
            break
        lines[k] = b"".join(b"%10d" % n for n in (next(new), *map(int, numbers[1:])))
        k += 2 + (int(numbers[7]) + 1) // 2
    return b"\n".join(lines)


def _with_begin_bulk(data: bytes) -> bytes | None:
    """Return Nastran's bulk data with the line before it that Gmsh leaves out; None for a file that has it."""
    return None if BEGIN.search(data) else b"BEGIN BULK\n" + data


def _msh_22(path: Path, data: bytes) -> bytes:
    """Return MSH 1 as MSH 2.2: an element's two numbers are its physical and its elementary one."""
    text = data.decode("ascii", "replace")
    nodes, elements = (_section(path, text, name) for name in ("NOD", "ELM"))
    rows = []
    for line in elements[1:]:
        number, kind, physical, elementary, count, *corners = line.split() if len(line.split()) > 4 else [""] * 5
        if count != str(len(corners)):
            raise ModelError(
                f"{path}: section $ELM: '{line.strip():.40}' is no element; the file is cut off or damaged"
            )
        rows.append(" ".join([number, kind, "2", physical, elementary, *corners]))
    told = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", *nodes, "$EndNodes"]
    return "\n".join([*told, "$Elements", str(len(rows)), *rows, "$EndElements", ""]).encode()


def _section(path: Path, text: str, name: str) -> list[str]:
    """Return the lines of a section of MSH 1: their number, then so many."""
    found = re.search(rf"\${name}\s+(.*?)\n\s*\$END{name}\b", text, re.DOTALL | re.IGNORECASE)
    lines = [line for line in found[1].split("\n") if line.strip()] if found else []
    if not lines or lines[0].strip() != str(len(lines) - 1):
        raise ModelError(f"{path}: section ${name} is cut off or damaged: the file was not written to its end")
    return lines


def _without_parameters(path: Path, data: bytes) -> bytes | None:
    """Return MSH 2 without the places of nodes on curves and surfaces (``Mesh.SaveParametric``); None without any."""
    header, section = HEADER.match(data), PARAMETRIC.search(data)
    if header is None or section is None:
        return None
    count = int(section[1])
    try:
        if header[1] == b"0":
            end = data.index(END_PARAMETRIC, section.end())
            lines = [line.split() for line in data[section.end() : end].split(b"\n") if line.strip()]
            if len(lines) != count or not all(len(line) >= 6 for line in lines):
                raise ValueError
            nodes = b"".join(b" ".join(line[:4]) + b"\n" for line in lines)
        else:
            nodes, end = _binary_nodes(data, section.end(), count, "<" if header[2] == b"\x01\0\0\0" else ">")
            end = data.index(END_PARAMETRIC, end)
    except (ValueError, struct.error, KeyError):
        raise ModelError(
            f"{path}: section $ParametricNodes is cut off or damaged: the file was not written to its end"
        ) from None
    middle = b"$Nodes\n%d\n" % count + nodes + (b"" if header[1] == b"0" else b"\n") + b"$EndNodes"
    return data[: section.start()] + middle + data[end + len(END_PARAMETRIC) :]


def _binary_nodes(data: bytes, start: int, count: int, order: str) -> tuple[bytes, int]:
    """Return numbers and coordinates of nodes, and where the section's numbers end."""
    kept = []
    for _ in range(count):  # of different lengths, one after the other
        (dimension,) = struct.unpack_from(f"{order}i", data, start + 28)
        kept.append(data[start : start + 28])
        start += 36 + 8 * OF_ENTITY[dimension]
    if start > len(data):
        raise ValueError
    return b"".join(kept), start
