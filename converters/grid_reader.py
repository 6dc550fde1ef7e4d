"""VTU files read by VTK in a process of its own, which stays for the next ones and ends with this one.

A results folder may come from anywhere, and VTK's reader dies of counts that are not true (signals 6 and 11). Its data
come back as plain arrays, whose sizes are checked here.
"""

from __future__ import annotations

import atexit
import json
import math
import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.converters.vtk_library import content_of_vtu, load_vtk
from bsm_mesh.errors import ModelError
from bsm_mesh.processes import limit_process, python_command

SECONDS, SECONDS_A_MEGABYTE = 10.0, 1.0  # of the processor, a hundred times what VTK needs
WAITING = 60.0  # s; more of these may pass on the wall, and four times as many: a slow disk, a busy machine
MEMORY, MEMORY_A_BYTE = 2 << 30, 200  # [bytes]
Content = dict[str, Any]


class _Process:
    """The process that reads; a new one where there is none, it has died, or belongs to a process that forked."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._running: subprocess.Popen[bytes] | None = None
        self._owner = 0

    def ask(self, content: bytes) -> tuple[Content, dict[str, npt.NDArray[Any]]] | str:
        """Return the data of a file's content, or the signal that ended its reader."""
        with self._lock:
            reader = self._started()
            assert reader.stdin is not None
            assert reader.stdout is not None
            late = threading.Timer(WAITING + 4 * _seconds(len(content)), reader.kill)
            late.daemon = True
            late.start()
            try:
                reader.stdin.write(len(content).to_bytes(8, "little"))
                reader.stdin.write(content)
                reader.stdin.flush()
                return _received(reader.stdout)
            except (OSError, EOFError):
                code = self._ended()
                return f"signal {-code}" if code < 0 else f"exit code {code}"
            except BaseException:  # an interruption: what is still to come answers no later question
                self._ended()
                raise
            finally:
                late.cancel()

    def close(self) -> None:
        """End the process."""
        with self._lock:
            if self._running is not None and self._owner == os.getpid():
                self._ended()

    def _started(self) -> subprocess.Popen[bytes]:
        if self._running is None or self._owner != os.getpid() or self._running.poll() is not None:
            self._running = subprocess.Popen(
                python_command(__name__), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
            )
            self._owner = os.getpid()
        return self._running

    def _ended(self) -> int:
        reader, self._running = self._running, None
        assert reader is not None
        for stream in (reader.stdin, reader.stdout):
            with suppress(OSError):
                if stream is not None:
                    stream.close()
        with suppress(subprocess.TimeoutExpired):
            return reader.wait(timeout=1.0)
        reader.kill()
        return reader.wait()


_process = _Process()
atexit.register(_process.close)


def read_arrays(content: bytes, path: Path) -> tuple[Content, dict[str, npt.NDArray[Any]]]:
    """Return the description of a VTU file and its arrays.

    Parameters
    ----------
    content : bytes
        Content of the file.
    path : Path
        The file, for messages.

    Raises
    ------
    ModelError
        If it is damaged: its reader finds so, dies of it, or does not come to an end; or its data fit nowhere.
    """
    found = _process.ask(content)
    if isinstance(found, str):
        raise ModelError(f"{path}: not a complete VTU file of a run (its reader died of {found}); run the model again")
    told, arrays = found
    if "fault" in told or (misfit := _misfit(arrays)):
        more = "" if "fault" in told else f": {misfit}"
        raise ModelError(f"{path}: not a complete VTU file of a run{more}; run the model again")
    return told, arrays


def _misfit(arrays: dict[str, npt.NDArray[Any]]) -> str:
    """Return what of the arrays does not fit together; empty where all does."""
    points, offsets, connectivity = (arrays[name] for name in ("points", "offsets", "connectivity"))
    if not _fit(offsets, connectivity, len(points)):
        return "its cells have points that are not there"
    if "face_offsets" in arrays:
        of_faces, of_cells = arrays["face_offsets"], arrays["cell_face_offsets"]
        known = _fit(of_cells, arrays["cell_faces"], len(of_faces) - 1) and len(of_cells) == len(offsets)
        if not known or not _fit(of_faces, arrays["face_connectivity"], len(points)):
            return "its polyhedra have faces or points that are not there"
    counts = {"point": len(points), "cell": len(offsets) - 1}
    short = [
        name
        for name, values in arrays.items()
        if (kind := name.partition(":")[0]) in counts and ":" in name and len(values) != counts[kind]
    ]
    return f"the array '{short[0].partition(':')[2]}' is too long or too short" if short else ""


def _fit(offsets: npt.NDArray[Any], entries: npt.NDArray[Any], count: int) -> bool:
    """Return whether offsets rise from 0 to the number of entries, and all entries are from 0 to below a count."""
    rising = len(offsets) > 0 and offsets[0] == 0 and offsets[-1] == len(entries) and (np.diff(offsets) >= 0).all()
    return bool(rising) and (not entries.size or bool(entries.min() >= 0 and entries.max() < count))


def _seconds(size: int) -> int:
    return math.ceil(SECONDS + SECONDS_A_MEGABYTE * size / 1e6)


def _received(stream: IO[bytes]) -> tuple[Content, dict[str, npt.NDArray[Any]]]:
    line = stream.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    told = json.loads(line)
    arrays = {}
    for name, dtype, shape in told.pop("arrays", ()):
        array = np.empty(shape, dtype=np.dtype(dtype))
        if array.nbytes and stream.readinto(array.reshape(-1).view(np.uint8).data) != array.nbytes:  # type: ignore[attr-defined]
            raise EOFError
        arrays[name] = array
    return told, arrays


def _sent(stream: IO[bytes], told: Content, arrays: dict[str, npt.NDArray[Any]]) -> None:
    listed = [(name, values.dtype.str, values.shape) for name, values in arrays.items()]
    stream.write(json.dumps({**told, "arrays": listed}).encode() + b"\n")
    for values in arrays.values():
        stream.write(np.ascontiguousarray(values).reshape(-1).view(np.uint8).data)
    stream.flush()


def _main() -> None:
    """Read what stdin brings, file by file, until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal: the process that asked ends this one
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no part of it
    load_vtk()
    while len(head := sys.stdin.buffer.read(8)) == 8:
        size = int.from_bytes(head, "little")
        content = sys.stdin.buffer.read(size)
        limit_process(_seconds(size), MEMORY + MEMORY_A_BYTE * size)
        try:
            told, arrays = content_of_vtu(content)
        except Exception:  # whatever a damaged file makes VTK and NumPy raise
            told, arrays = {"fault": True}, {}
        _sent(answers, told, arrays)


if __name__ == "__main__":
    with suppress(BrokenPipeError):
        _main()
