"""The folder of a factor of safety: the answer, the trials, both states of its bracket as results."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ResultsWarning
from bsm_mesh.files import remove, write_text
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.own_files import clear, has_marker, own_files, place_in
from bsm_mesh.folder.storage import save_results
from bsm_mesh.modelfile.build import LoadedModel
from bsm_mesh.safety.answer import Safety
from bsm_mesh.text.csv_tables import csv_text
from bsm_mesh.text.safety_text import told_of

ANSWER = "safety.json"
SAFETY, LIMIT = "safety", "limit-"  # ends of the names of its folders; the varied key follows LIMIT
MECHANISM, MOVEMENT = "mechanism.png", "movement.png"
STATES = {"stable": "last stable", "unstable": "first unstable"}
TRIALS_HEADER = ("value", "verdict", "movement_over_size", "failed_blocks", "status", "seconds", "reason")


def write_safety(answer: Safety, loaded: LoadedModel, added: AddedFiles) -> list[str]:
    """Write an answer on a model into a folder and return the names of the files, relative to it.

    Raises
    ------
    ModelError
        If the folder cannot be written to, or holds what bsm-mesh did not write.
    """
    title = loaded.model.title or loaded.path.stem
    head = {"title": title, "model_hash": loaded.model.digest, "report": loaded.file.report.model_dump()}
    names = [ANSWER, "trials.csv"]
    for name in {MECHANISM, MOVEMENT} & own_files(added.folder.place):
        remove(place_in(added.folder.place, name))  # of the answer before this one
    with added.file(ANSWER) as draft:
        _write_json({**head, **told_of(answer)}, draft)
    with added.file("trials.csv") as draft:
        _write_trials(answer, draft)
    for name in STATES:
        value, place = getattr(answer, name), place_in(added.folder.path, name, itself=True)
        if value in answer.states:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ResultsWarning)  # a law of the user's own is in no file
                save_results(answer.states[value], place)
            names.append(f"{name}/")
        elif has_marker(place):
            clear(place)  # a state of the answer before this one
    return names


def _write_json(told: dict[str, Any], draft: Path) -> None:
    write_text(draft, json.dumps(told, indent=1) + "\n")


def _write_trials(answer: Safety, draft: Path) -> None:
    rows: list[tuple[object, ...]] = [TRIALS_HEADER]
    for trial in answer.trials:
        row = (repr(trial.value), trial.verdict.value, f"{trial.moved:.6g}", len(trial.blocks), trial.status.value)
        rows.append((*row, f"{trial.seconds:.3f}", trial.reason))
    write_text(draft, csv_text(rows))
