"""A checkpoint as a file: arrays and JSON in an .npz without pickle, a version, and a checksum over the whole.

Only dataclasses that are listed here can be in it, and of them only fields that they have. The last line of the file is
the SHA-256 of all before it: truncation, changes, or another program are noticed before anything is read.
"""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.certificate.verify_certificate import read_arrays
from bsm_mesh.errors import ModelError
from bsm_mesh.files import whole_file
from bsm_mesh.folder.own_files import CHECKPOINT
from bsm_mesh.reading import refuse_special

if TYPE_CHECKING:
    from bsm_mesh.solve.stages.checkpoint import Checkpoint

FORMAT = 1
TOLD = ("identity", "files", "snapshots")  # the record of a checkpoint: see `Checkpoints` and `RunWriter.keep`
CURE = "run without --resume"
KINDS = {  # the dataclasses that may be in a checkpoint, and the modules that have them
    "ActiveContacts": "contact.search",
    "BoltMemory": "solve.bolts.memory",
    "Checkpoint": "solve.stages.checkpoint",
    "CollapseMemory": "solve.continuation.state",
    "ContinuationState": "solve.continuation.state",
    "CycleMemory": "solve.continuation.state",
    "FaceWater": "model.face_water",
    "Fall": "results.falls",
    "Fill": "solve.zones.fills",
    "FlowState": "flow.coupling",
    "History": "contact.history",
    "JointHistory": "solve.zones.joint_history",
    "LinearState": "solve.linear.state",
    "LoopState": "solve.continuation.state",
    "Met": "solve.zones.moving_points",
    "Pace": "solve.continuation.pace",
    "Places": "solve.zones.moving_points",
    "PointForces": "model.loads",
    "PointHistory": "three_d.contacts.history",
    "PolygonPoints": "three_d.contacts.history",
    "QuietEnds": "solve.motion.quiet_ends",
    "ShakingMemory": "solve.motion.shaking_memory",
    "StageProgress": "solve.stages.checkpoint",
    "StepRecord": "results.records",
    "ZonesMemory": "solve.zones.zones_state",
}
_TEXT = "content"  # the member that holds the JSON
_SEAL = 65  # bytes of the last line: SHA-256 and a line feed


def write_checkpoint(path: Path, told: dict[str, Any], checkpoint: Checkpoint) -> None:
    """Write a checkpoint, whole and on the disk itself.

    Parameters
    ----------
    path : Path
        The file, ending in ``.npz``.
    told : dict
        What else is to be known of it, as JSON can say it.
    checkpoint : Checkpoint
        The state of the run.
    """
    arrays: list[np.ndarray] = []
    content = {**told, "format": FORMAT, "checkpoint": _encoded(checkpoint, arrays)}
    text = np.frombuffer(json.dumps(content).encode(), np.uint8)
    members = {_TEXT: text, **{f"a{number}": array for number, array in enumerate(arrays)}}
    with whole_file(path, settled=True) as draft:
        np.savez(draft, **members)  # type: ignore[arg-type]
        with draft.open("rb") as file:
            seal = hashlib.file_digest(file, "sha256").hexdigest()
        with draft.open("ab") as file:
            file.write(f"{seal}\n".encode())


def read_told(path: Path) -> dict[str, Any]:
    """Return the record of a checkpoint, but for the state of the run.

    Raises
    ------
    ModelError
        If it is no checkpoint of this format, or not as it was written.
    """
    return _read(path, whole=False)[0]


def read_checkpoint(path: Path) -> tuple[dict[str, Any], Checkpoint]:
    """Return the record of a checkpoint, and the state of the run.

    Raises
    ------
    ModelError
        If it is no checkpoint of this format, or not as it was written.
    """
    told, arrays = _read(path, whole=True)
    try:
        checkpoint = _decoded(told.pop("checkpoint"), arrays)
        told = {name: told[name] for name in TOLD}
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise ModelError(f"{path} is no checkpoint of this program ({error}); {CURE}") from error
    if type(checkpoint).__name__ != "Checkpoint":
        raise ModelError(f"{path} holds no state of a run; {CURE}")
    return told, checkpoint


def named_by_checkpoint(place: Path) -> set[str]:
    """Return the files that the checkpoint in a folder needs; none where there is none that can be read."""
    try:
        return set(read_told(place / CHECKPOINT)["files"]) if (place / CHECKPOINT).is_file() else set()
    except (ModelError, KeyError):
        return set()


def _read(path: Path, *, whole: bool) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return the JSON of a checkpoint, and its arrays if it is wanted `whole`."""
    refuse_special(path)
    try:
        if not _is_sealed(path):
            raise ModelError(f"{path} is truncated, was changed, or is no checkpoint of bsm-mesh; {CURE}")
        members = read_arrays(path, None if whole else (_TEXT,))
        told: Any = json.loads(members.pop(_TEXT).tobytes())
        if told["format"] != FORMAT:
            raise ModelError(f"{path} has format {told['format']!s:.20}, and this bsm-mesh reads {FORMAT}; {CURE}")
        arrays = [members[f"a{number}"] for number in range(len(members))]
    except OSError as error:
        raise ModelError(f"{path} cannot be read: {error.strerror or error}; {CURE}") from error
    except ModelError:
        raise
    except (KeyError, RecursionError, TypeError, ValueError) as error:
        raise ModelError(f"{path} is no checkpoint of bsm-mesh ({error}); {CURE}") from error
    return told, arrays


def _is_sealed(path: Path) -> bool:
    """Return whether the last line is the checksum of all before it."""
    state = hashlib.sha256()
    with path.open("rb") as file:
        left = os.fstat(file.fileno()).st_size - _SEAL
        while left > 0 and (piece := file.read(min(left, 2**20))):
            state.update(piece)
            left -= len(piece)
        return left == 0 and file.read() == f"{state.hexdigest()}\n".encode()


def _encoded(value: Any, arrays: list[np.ndarray]) -> Any:
    """Return a value as JSON; its arrays are added to a list, and reported by their numbers."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biuf":
            raise TypeError(f"an array of {value.dtype} cannot be kept")
        arrays.append(value)
        return {"array": len(arrays) - 1}
    if is_dataclass(value):
        name = type(value).__name__
        if f"bsm_mesh.{KINDS.get(name)}" != type(value).__module__:
            raise TypeError(f"a {name} cannot be kept")
        return {"kind": name, **{field.name: _encoded(getattr(value, field.name), arrays) for field in fields(value)}}
    if isinstance(value, tuple):
        return [_encoded(part, arrays) for part in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a {type(value).__name__} cannot be kept")


def _decoded(value: Any, arrays: list[np.ndarray]) -> Any:
    """Return what `_encoded` was given."""
    if isinstance(value, list):
        return tuple(_decoded(part, arrays) for part in value)
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    kind = getattr(import_module(f"bsm_mesh.{KINDS[value['kind']]}"), value["kind"])
    return kind(**{name: _decoded(part, arrays) for name, part in value.items() if name != "kind"})
