"""Arrays from an .npz file that may come from anywhere: sizes are checked before anything is made of them."""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Container
from pathlib import Path
from typing import IO, Any

import numpy as np

ROOM, ROOM_A_BYTE = 1 << 28, 200  # [bytes] that the arrays of a file may fill; in files of runs ten a byte at most
ENDING = ".npy"
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # NumPy writes no others; each has errors of its own
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def read_arrays(file: Path | IO[bytes], only: Container[str] | None = None) -> dict[str, Any]:
    """Return the arrays of an .npz file by their names; no Python object is made of its content.

    Parameters
    ----------
    file : path or file
        The archive.
    only : container of str, optional
        Names of the arrays that are read; by default all.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is damaged, or says of an array that it is larger than what there is of it.
    """
    try:
        with zipfile.ZipFile(file) as archive:
            members = [entry for entry in archive.infolist() if entry.filename.endswith(ENDING)]
            size = sum(entry.compress_size for entry in members)
            if sum(entry.file_size for entry in members) > ROOM + ROOM_A_BYTE * size:
                raise ValueError("its arrays fill more than such a file can hold")
            names = {entry.filename.removesuffix(ENDING): entry for entry in members}
            return {name: _array(archive, entry) for name, entry in names.items() if only is None or name in only}
    # EOFError: cut off. NotImplementedError, RuntimeError: its flags ask for patches, a password. MemoryError: its size
    except (EOFError, MemoryError, NotImplementedError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"it is cut off or damaged: {error or type(error).__name__}") from error


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> Any:
    if entry.compress_type not in METHODS:
        raise ValueError(f"the array {entry.filename} is compressed by an unknown method")
    with archive.open(entry) as member:
        version = np.lib.format.read_magic(member)
        if version not in HEADERS:
            raise ValueError(f"the array {entry.filename} is of an unknown version")
        shape, in_columns, dtype = HEADERS[version](member)
        count = math.prod(shape)
        if dtype.hasobject or min(shape, default=0) < 0 or member.tell() + count * dtype.itemsize != entry.file_size:
            raise ValueError(f"the array {entry.filename} is not as large as it says")
        content = bytearray(member.read())
    if not count:
        return np.zeros(shape, dtype)
    values = np.frombuffer(content, dtype, count)
    return values.reshape(shape[::-1]).T if in_columns else values.reshape(shape)
