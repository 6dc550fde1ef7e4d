"""Foreign readers in a process of their own, with limits of time and memory.

VTK's readers die of damaged files (signals 6 and 11), meshio's never end on some. Their data come back as plain
arrays; a reader that fails, dies or does not end is one `ModelError`.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import IO, Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from bsm_mesh.converters.meshes.cells import CellGroup, MeshCells
from bsm_mesh.converters.meshes.foreign_result import ForeignResult
from bsm_mesh.converters.meshes.report import Note, NoteKind
from bsm_mesh.errors import ModelError
from bsm_mesh.files import temporary_place, unnamed_file
from bsm_mesh.processes import limit_process, python_command

Found = TypeVar("Found", MeshCells, ForeignResult)
# Ten times what the slowest reader needs (a megabyte a second), and what small files take at most.
SECONDS, SECONDS_A_MEGABYTE = 5.0, 10.0  # of the processor: other programs on it do not count
WAITING = 60.0  # more of these may pass on the wall, and four times as many: a slow disk, a busy machine
MEMORY, MEMORY_A_BYTE = 4 << 30, 200  # [bytes]; address space, of which little is ever touched
_TIME_IS_UP = 24  # SIGXCPU
_NO_ROOM = 74  # exit code of the process whose answer found no room
ARRAYS = ("points", "corners", "offsets", "numbers", "pieces")


def read_apart(read: Callable[[Path], Found], path: Path) -> Found:
    """Return the contents of a file, read in a process of its own.

    Parameters
    ----------
    read : callable
        The reader, a function of a module; the module's ``LIBRARY`` names the modules it imports when it is called.
    path : Path
        The file.

    Raises
    ------
    ModelError
        As the reader does; and if it dies, or does not end in a time that grows with the file.
    """
    seconds = math.ceil(SECONDS + SECONDS_A_MEGABYTE * path.stat().st_size / 1e6)
    command = python_command(__name__, read.__module__, read.__name__, os.fspath(path), str(seconds))
    with unnamed_file() as found, unnamed_file() as said:
        try:
            code = subprocess.run(
                command, stdin=subprocess.DEVNULL, stdout=found, stderr=said, timeout=WAITING + 4 * seconds, check=False
            ).returncode
        except subprocess.TimeoutExpired:
            code = -_TIME_IS_UP
        found.seek(0)
        if code == 0:
            return cast(Found, _receive(found))
        said.seek(0)
        raise ModelError(f"{path}: {_reason(code, said.read().decode(errors='replace'), seconds)}")


_CURE = "it is damaged or not what its ending says; write it again, or save it as MSH 4.1"


def _reason(code: int, said: str, seconds: int) -> str:
    if code == -_TIME_IS_UP:
        return f"the reader of this format did not end within {seconds} s; {_CURE}"
    if code == _NO_ROOM:
        return f"its contents cannot be kept in {temporary_place()}; make room there, or set TMPDIR"
    if code < 0 or code > 255:  # a signal; on Windows an exception's number
        return f"the reader of this format died of signal {abs(code)}; {_CURE}"
    last = (said.strip().splitlines() or ["no reason given"])[-1]
    return f"the reader of this format failed ({last}); {_CURE}"


def _send(found: MeshCells | ForeignResult | ModelError, stream: IO[bytes]) -> None:
    if isinstance(found, ModelError):
        stream.write(json.dumps({"faults": found.faults}).encode() + b"\n")
        return
    told, arrays = _packed(found) if isinstance(found, MeshCells) else found.packed()
    stream.write(json.dumps({"kind": type(found).__name__, **told}).encode() + b"\n")
    for array in arrays:
        np.lib.format.write_array(stream, np.ascontiguousarray(array), allow_pickle=False)


def _receive(stream: IO[bytes]) -> MeshCells | ForeignResult:
    told = json.loads(stream.readline())
    if "faults" in told:
        raise ModelError(told["faults"])
    kind, arrays = told.pop("kind"), _arrays(stream)
    return _unpacked(told, arrays) if kind == MeshCells.__name__ else ForeignResult.unpacked(told, arrays)


def _packed(cells: MeshCells) -> tuple[dict[str, Any], list[npt.NDArray[Any]]]:
    told = {
        "source": cells.source,
        "groups": [group.name for group in cells.groups],
        "arrays": list(cells.arrays),
        "notes": [[note.kind.value, note.name, note.count, note.text] for note in cells.notes],
    }
    arrays = [
        *(getattr(cells, name) for name in ARRAYS),
        *(part for group in cells.groups for part in (group.elements, group.pieces)),
        *(part for parts in cells.arrays.values() for part in parts),
    ]
    return told, arrays


def _unpacked(told: dict[str, Any], arrays: Iterator[npt.NDArray[Any]]) -> MeshCells:
    return MeshCells(
        source=told["source"],
        **{name: next(arrays) for name in ARRAYS},
        groups=tuple(CellGroup(name=name, elements=next(arrays), pieces=next(arrays)) for name in told["groups"]),
        arrays={name: (next(arrays), next(arrays)) for name in told["arrays"]},
        notes=tuple(Note(kind=NoteKind(kind), name=name, count=n, text=text) for kind, name, n, text in told["notes"]),
    )


def _arrays(stream: IO[bytes]) -> Iterator[npt.NDArray[Any]]:
    while True:
        yield np.lib.format.read_array(stream, allow_pickle=False)


def _main(module: str, function: str, path: str, seconds: str) -> None:
    """Read a file within limits and send the data, or the faults, down stdout."""
    stream = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no part of it
    reader = import_module(module)
    for library in reader.LIBRARY:
        with contextlib.suppress(ImportError):  # the reader says what is missing
            import_module(library)
    limit_process(int(seconds), MEMORY + MEMORY_A_BYTE * os.stat(path).st_size)
    try:
        found = getattr(reader, function)(Path(path))
    except ModelError as error:
        found = error
    try:
        with stream:
            _send(found, stream)
    except OSError:
        sys.exit(_NO_ROOM)


if __name__ == "__main__":
    _main(*sys.argv[1:])
