"""The command ``study``: a study file run, resumed, and summed up."""

from __future__ import annotations

import json
import os
import shlex
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from bsm_mesh.commands.study_file import Study, load_study
from bsm_mesh.commands.study_work import failed, work_of
from bsm_mesh.errors import ModelError, counted, raise_faults
from bsm_mesh.files import write_text
from bsm_mesh.folder.study_folder import SHEET, SUMMARY, TABLE, StudyFolder
from bsm_mesh.folder.summary import code_digest
from bsm_mesh.model.model import Model
from bsm_mesh.model.quantities import PROCESSES
from bsm_mesh.model.values import Rules
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.pictures.study_pictures import draw_study
from bsm_mesh.studies.scatter import scatter_joint
from bsm_mesh.studies.scheduler import Processes, Scheduler
from bsm_mesh.studies.statistics import MOVEMENT_LIMIT, summary_of
from bsm_mesh.studies.table import UNITS, StudyTable, make_table
from bsm_mesh.text.csv_tables import csv_file
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.study_tables import print_study, sheet_rows, study_rows
from bsm_mesh.text.terminal import say, say_json
from bsm_mesh.version import __version__

OFTEN = 2.0  # s between two lines of progress


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class StudyResults:
    """The outcome of a study.

    Attributes
    ----------
    table : StudyTable
        A row a run.
    summary : mapping
        Probability of failure, spread of the answers, effects of the keys, as ``summary.json`` has them.
    folder : Path
        Where it was written.
    pictures : tuple of Path
        The pictures.
    """

    table: StudyTable
    summary: Mapping[str, Any]
    folder: Path
    pictures: tuple[Path, ...]

    def __repr__(self) -> str:
        title, _, rows = study_rows(self.summary)[0]
        return f"{title}: {'; '.join(' '.join(row) for row in rows)}; in {self.folder}"


def run_study(
    path: Path,
    output: Path | None = None,
    *,
    processes: int | None = None,
    scheduler: str | None = None,
    scripts: bool = True,
    report: Callable[[str], None] = lambda text: None,
) -> StudyResults:
    """Have the runs of a study done that are not done yet, and sum all of them up.

    Parameters
    ----------
    path : Path
        The study file.
    output : Path, optional
        Folder for the table, the summary and the pictures; by default ``out/NAME`` next to NAME.toml. Runs that
        are finished there are not done again.
    processes : int, optional
        How many runs at a time on this machine; by default as many as there are cores.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers do the runs instead.
    scripts : bool
        Whether the model may run a geometry script and name any path.
    report : callable, optional
        Called with the progress.

    Raises
    ------
    ModelError
        For faults of the study file and its model, and for a folder that holds another study.
    """
    at_work = _scheduler(processes, scheduler)
    study = load_study(path, scripts=scripts)
    model = study.variation.model({}).model  # as in its file, built here so that its faults come first
    identity = _identity(study, model)
    reach = Reach(folder=path.parent, scripts=scripts)
    folder = StudyFolder(output or reach.output(f"out/{path.stem}", "the study's folder"), identity)
    with folder.held(study.text):
        rows = folder.journal.rows()
        try:
            _run_missing(study, at_work, folder, rows, "-".join(identity.values()), report)
        except KeyboardInterrupt as error:
            error.add_note(
                f"{len(folder.journal.rows())} of {counted(study.plan.count, 'run')} are finished in {folder.path}; "
                f"continue with: {_again(path, output, processes, scheduler, scripts=scripts)}"
            )
            raise
        report("table and pictures")
        metadata = {**identity, "study_file": study.text, "title": study.title, UNITS: json.dumps(study.units)}
        if study.file.movement_limit is not None:
            metadata[MOVEMENT_LIMIT] = repr(study.file.movement_limit)
        has_factor = "factor_of_safety" in study.file.answers
        bulk = model.blocks.bulk_name
        table = make_table(study.plan, rows, factor=has_factor, bulk=bulk, metadata=metadata)
        summary = {"title": study.title, **identity, **summary_of(table, drawn=study.is_drawn)}
        table.write(folder.path / TABLE)
        with csv_file(folder.path / SHEET) as sheet:
            sheet.writerows(sheet_rows(table))
        write_text(folder.path / SUMMARY, f"{json.dumps(summary, indent=2)}\n")
        pictures = draw_study(table, model, study.title, folder.path, drawn=study.is_drawn)
    return StudyResults(table=table, summary=summary, folder=folder.path, pictures=tuple(pictures))


def study_command(
    path: Path,
    output: Path | None,
    *,
    processes: int | None,
    scheduler: str | None,
    scripts: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run a study and print its answers."""
    with Progress(quiet=quiet or as_json) as progress:
        done = run_study(
            path, output, processes=processes, scheduler=scheduler, scripts=scripts, report=progress.report
        )
    if as_json:
        say_json({**done.summary, "folder": str(done.folder), "pictures": [str(path) for path in done.pictures]})
        return
    print_study(done.table, done.summary)
    say(f"written to {done.folder}: {TABLE}, {SHEET}, {SUMMARY}")
    for picture in done.pictures:
        say(picture)


def _scheduler(processes: int | None, address: str | None) -> Scheduler:
    if processes is not None and address is not None:
        raise ModelError("study: give processes or a scheduler, not both: a scheduler has workers of its own")
    if address is not None:
        from bsm_mesh.studies.dask_scheduler import Dask

        return Dask(address)
    rules = Rules("study")
    rules.number("processes", processes, PROCESSES, optional=True)
    raise_faults(rules.faults)
    return Processes(processes or _cores())


def _cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _identity(study: Study, model: Model) -> dict[str, str]:
    """Return the digests that identify the runs of a study."""
    for scatter in study.scatters:
        scatter_joint(model, scatter, (study.file.seed,))
    return {
        "study": study.digest,
        "model_file": study.variation.digest,
        "model": model.digest,
        "version": __version__,
        "code": code_digest(),
    }


def _run_missing(
    study: Study,
    scheduler: Scheduler,
    folder: StudyFolder,
    rows: dict[int, dict[str, Any]],
    key: str,
    report: Callable[[str], None],
) -> None:
    """Have the runs done that are in no row yet; each is on the disk itself before the next is looked at."""
    tasks = {run: study.plan.of(run) for run in range(study.plan.count) if run not in rows}
    if not tasks:
        return
    told = _Told(report=partial(report), total=study.plan.count, rows=rows)
    told.tell()
    for done in scheduler.run(work_of(study, key), tasks):
        answers = failed(done.error) if done.answers is None else dict(done.answers)
        folder.journal.add(done.run, answers)
        rows[done.run] = answers
        told.tell()


@dataclass(kw_only=True)
class _Told:
    """The progress of a study, reported now and then."""

    report: Callable[[str], None]
    total: int
    rows: Mapping[int, Mapping[str, Any]]
    _began: float = field(default_factory=time.monotonic)
    _last: float = 0.0
    _before: int = 0

    def __post_init__(self) -> None:
        self._before = len(self.rows)

    def tell(self) -> None:
        """Tell it, if it is time to."""
        now, done = time.monotonic(), len(self.rows)
        if now - self._last < OFTEN and done < self.total:
            return
        self._last = now
        counts = Counter(row["status"] for row in self.rows.values())
        parts = [f"{number} {status.replace('_', ' ')}" for status, number in sorted(counts.items())]
        new = done - self._before
        if new and done < self.total:
            parts.append(f"{_duration((now - self._began) / new * (self.total - done))} left")
        self.report(f"{done} of {counted(self.total, 'run')}" + (f": {', '.join(parts)}" if parts else ""))


def _duration(seconds: float) -> str:
    """Return a time as a person says it.

    Examples
    --------
    >>> _duration(12.3), _duration(600), _duration(9000)
    ('12 s', '10 min', '2.5 h')
    """
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def _again(path: Path, output: Path | None, processes: int | None, scheduler: str | None, *, scripts: bool) -> str:
    """Return the command that resumes a study."""
    words = ["bsm-mesh", "study", str(path)]
    for option, value in (("-o", output), ("--processes", processes), ("--scheduler", scheduler)):
        words += [] if value is None else [option, str(value)]
    return shlex.join(words if scripts else [*words, "--no-scripts"])
