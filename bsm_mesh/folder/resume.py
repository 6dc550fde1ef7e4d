"""An interrupted run taken up again: its files are checked, one by one, before anything is changed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bsm_mesh.arrays import content_hash
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.checkpoint_file import CURE, read_checkpoint
from bsm_mesh.folder.own_files import CHECKPOINT, SUMMARY, is_lasting, read_json, run_number
from bsm_mesh.folder.results_folder import ResultsFolder
from bsm_mesh.folder.storage import load_results
from bsm_mesh.folder.summary import code_digest, fingerprint, versions
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.results.results import Results, StageResults
from bsm_mesh.solve.stages.checkpoint import Checkpoint

CHANGED = {  # entries of an identity, and what it means that they differ
    "versions": "was made by other versions ({then}; here {now}), which end in other digits",
    "code": "was made by another state of bsm-mesh's source, which may end in other digits",
    "model": "is of another model: the model file, its mesh or its script was changed since",
    "options": "is of another way to solve: [solver] or [falls] was changed since",
    "histories": "recorded other histories: [[history]] was changed since",
    "snapshots": "is of a run with snapshots = {then!r} in [output], and now it is {now!r}",
}


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class TakenUp:
    """Remains of an interrupted run.

    Attributes
    ----------
    place : Path
        The folder that it is in.
    checkpoint : Checkpoint
        State from which the run resumes.
    results : Results or None
        Of the stages that are at their end; None where there is none.
    told : dict
        The writer's own record: its files, and which snapshots there are.
    """

    place: Path
    checkpoint: Checkpoint
    results: Results | None
    told: dict[str, Any]


def identity_of(model: Model, options: Options, snapshots: str) -> dict[str, Any]:
    """Return the identity of a run: if it is the same, a resumed run has the same digits as one without a break."""
    return {
        "versions": ", ".join(f"{name} {number}" for name, number in versions().items()),
        "code": code_digest(),
        "model": model.digest,
        "options": content_hash(options),
        "histories": content_hash(model.histories),
        "snapshots": snapshots,
    }


def take_up(folder: ResultsFolder, identity: dict[str, Any]) -> TakenUp | None:
    """Return the remains of an interrupted run into a folder; None if there are none, and the run begins at the start.

    Raises
    ------
    ModelError
        If its files are truncated, changed, or of another model or program; and where the folder holds finished
        results of this model, so that there is nothing to continue with.
    """
    places = [place for place in (folder.running, folder.interrupted) if (place / CHECKPOINT).is_file()]
    if not places:
        _refuse_finished(folder, identity["model"])
        return None
    place, told_place = places[0], folder.told(places[0])
    told, checkpoint = read_checkpoint(place / CHECKPOINT)
    for entry, meaning in CHANGED.items():
        then, now = told["identity"].get(entry), identity[entry]
        if then != now:
            raise ModelError(f"an interrupted run, in {told_place}, {meaning.format(then=then, now=now)}; {CURE}")
    for name, listed in told["files"].items():
        path = place / name
        if is_lasting(name) and not (path.is_file() and fingerprint(path) == listed):
            raise ModelError(f"{told_place / name} is missing, or was changed after it was written; {CURE}")
    return TakenUp(place=place, checkpoint=checkpoint, results=_finished(place, checkpoint.finished), told=told)


def _finished(place: Path, count: int) -> Results | None:
    """Return the results of the first stages."""
    if not count:
        return None
    try:
        results = load_results(place)
    except ModelError as error:
        raise ModelError(f"the finished stages of an interrupted run: {error}; {CURE}") from error
    if len(results.stages) < count:
        raise ModelError(f"{place / SUMMARY} has no record of a finished stage; {CURE}")
    return replace(results, stages=StageResults(results.stages[:count]), finished=False)


def _refuse_finished(folder: ResultsFolder, digest: str) -> None:
    if run_number(folder.place) is not None and read_json(folder.place / SUMMARY).get("model_hash") == digest:
        raise ModelError(
            f"{folder.path} holds the finished results of this model, and no run of it was interrupted: there is "
            f"nothing to continue with; to run it again, {CURE}"
        )
