"""The folder of a study: its owner, its writer, and its content."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from bsm_mesh.errors import ModelError
from bsm_mesh.files import is_draft, make_folder, remove_abandoned, settle, write_text
from bsm_mesh.folder.own_files import place_in, read_json
from bsm_mesh.folder.results_folder import refuse_unwritable
from bsm_mesh.locks import free_lock, holder, take_lock
from bsm_mesh.studies.journal import Journal
from bsm_mesh.text.headings import PICTURES_FOLDER

IDENTITY, RUNS, TABLE, SHEET, SUMMARY, STUDY, LOCK = (
    "study.json",
    "runs.jsonl",
    "study.parquet",
    "study.csv",
    "summary.json",
    "study.toml",
    ".lock",
)
CHANGED = {  # what of the identity can differ, in words
    "study": "the study file was changed",
    "model_file": "the model file was changed",
    "model": "the model's mesh, or a file that it names, was changed",
    "version": "they were done by another version of bsm-mesh",
    "code": "they were done by another state of bsm-mesh, or with other versions of NumPy, SciPy, Numba or VTK",
}


@dataclass(frozen=True, slots=True)
class StudyFolder:
    """A folder that holds one study.

    Attributes
    ----------
    path : Path
        Where it is.
    identity : mapping of str to str
        Digests of the study's inputs.
    """

    path: Path
    identity: Mapping[str, str]

    @property
    def journal(self) -> Journal:
        """The runs that are finished."""
        return Journal(self.path / RUNS, json.dumps(dict(self.identity), sort_keys=True))

    def refuse_others(self) -> None:
        """Raise `ModelError` where the folder holds another study, or files of no study, or cannot be written to."""
        refuse_unwritable(self.path, "a study")
        for name in (RUNS, IDENTITY, LOCK, PICTURES_FOLDER):
            place_in(self.path, name, itself=True)
        there = read_json(self.path / IDENTITY)
        if there:
            differs = next((name for name in CHANGED if there.get(name) != self.identity[name]), None)
            if differs is not None:
                raise ModelError(
                    f"{self.path} holds the runs of another study ({CHANGED[differs]}); choose another folder with -o, "
                    "or remove this one"
                )
            return
        foreign = [entry.name for entry in self._entries() if entry.name != LOCK and not is_draft(entry.name)]
        if foreign:
            raise ModelError(
                f"{self.path} holds files that no study wrote ({sorted(foreign)[0]}); choose a new or an empty folder "
                "with -o"
            )

    @contextmanager
    def held(self, text: str) -> Iterator[None]:
        """Keep others from writing to the folder, from now on that of the study of this file's text.

        Raises
        ------
        ModelError
            If another process writes there, and as `refuse_others` says.
        """
        self.refuse_others()
        make_folder(self.path)
        lock = self.path / LOCK
        descriptor = take_lock(lock)
        if descriptor is None:
            raise ModelError(f"{self.path}: {holder(lock)} is at work on this study; wait for it, or end it")
        try:
            remove_abandoned(self.path)
            if not (self.path / IDENTITY).is_file():
                write_text(self.path / STUDY, text)
                write_text(self.path / IDENTITY, f"{json.dumps(dict(self.identity), indent=2)}\n", settled=True)
                settle(self.path)
            yield
        finally:
            free_lock(lock, descriptor)

    def _entries(self) -> list[Path]:
        return list(self.path.iterdir()) if self.path.is_dir() else []
