"""The folder of key blocks: the answer as a record and as a table, the model file, the blocks as VTU."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bsm_mesh.errors import ModelError
from bsm_mesh.files import write_text
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.own_files import read_json
from bsm_mesh.folder.result_tables import write_table
from bsm_mesh.folder.run_file import given_files
from bsm_mesh.modelfile.model_text import Given
from bsm_mesh.modelfile.space_file import LoadedSpace
from bsm_mesh.table_rows import read_rows
from bsm_mesh.three_d.key_blocks.record import KeyBlocks

RECORD, TABLE = "key_blocks.json", "key_blocks.csv"
PICTURE, NET = "key_blocks.png", "stereonet.png"  # drawn by the command
TEXTS, TRUTHS, WHOLE = ("mode", "joint_1", "joint_2"), ("removable", "held", "sliver"), ("block", "round")  # columns


def write_key_blocks(loaded: LoadedSpace, found: KeyBlocks, told: dict[str, Any], added: AddedFiles) -> list[str]:
    """Write the answer on a model, its record in JSON as `told`, into a folder; return the names of the files.

    Raises
    ------
    ModelError
        If the folder cannot be written to, or holds what bsm-mesh did not write.
    """
    from bsm_mesh.converters.three_d import write_blocks, write_contacts

    writers: Given = {
        RECORD: lambda draft: write_text(draft, json.dumps(told, indent=1) + "\n"),
        TABLE: lambda draft: write_table(found.table(), draft),
        **given_files(loaded.file, loaded.path, added.folder.path, None),
        "blocks.vtu": lambda draft: write_blocks(draft, loaded.blocks, key_blocks=found),
        "contacts.vtu": lambda draft: write_contacts(draft, loaded.blocks),
    }
    for name, write in writers.items():
        with added.file(name) as draft:
            write(draft)
    return list(writers)


def read_key_blocks(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the record and the columns of the table in a folder, as `write_key_blocks` has written them.

    Raises
    ------
    ModelError
        If one of the files is missing or damaged.
    """
    told = read_json(folder / RECORD)
    try:
        table = read_rows(folder / TABLE, "a row a block")
        cells = dict(zip(table.names, zip(*table.cells, strict=True), strict=True))
        columns = {name: _values(name, values) for name, values in cells.items()}
        if len(columns["block"]) != told["at_free_faces"]:
            raise ValueError(f"{TABLE} has another number of rows than {RECORD}")
    except (LookupError, TypeError, ValueError, OSError) as error:
        raise ModelError(
            f"{folder}: {RECORD} or {TABLE} is missing or damaged; run bsm-mesh key-blocks again"
        ) from error
    return told, columns


def _values(name: str, cells: Sequence[str]) -> npt.NDArray[Any]:
    """Return a column as it was written: texts, truths, whole numbers, else numbers, NaN where there is none."""
    if name in TEXTS:
        return np.array(cells, dtype=object)
    if name in WHOLE:
        return np.array(cells, dtype=np.int32)
    numbers = np.array([cell or "nan" for cell in cells], dtype=np.float64)
    return numbers > 0 if name in TRUTHS else numbers
