"""A run on its way to disk: stage by stage next to its results folder, which it replaces when it is finished."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from bsm_mesh.certificate.certificate import solved_stages, write_arrays, write_certificate
from bsm_mesh.errors import ModelError, counted
from bsm_mesh.files import copy_mode, keep, make_folder, move, remove, remove_abandoned, settle, write_text
from bsm_mesh.folder.checkpoint_file import named_by_checkpoint
from bsm_mesh.folder.checkpoints import Checkpoints
from bsm_mesh.folder.histories import write_histories
from bsm_mesh.folder.history import HISTORY, write_history
from bsm_mesh.folder.own_files import (
    CHECKPOINT,
    HEADER,
    MARKER,
    SUMMARY,
    clear,
    is_lasting,
    own_files,
    place_in,
    run_number,
    tidy,
)
from bsm_mesh.folder.result_tables import USUAL, OutputForm, write_tables
from bsm_mesh.folder.results_folder import ResultsFolder, State, told_fault
from bsm_mesh.folder.shaking_files import write_shaking
from bsm_mesh.folder.snapshots import Snapshots
from bsm_mesh.folder.summary import fingerprint, finished_stages, summary_text
from bsm_mesh.modelfile.model_text import Given
from bsm_mesh.results.records import StageResult, StepRecord
from bsm_mesh.results.results import Results

if TYPE_CHECKING:
    from bsm_mesh.converters.result_files import Instant
    from bsm_mesh.folder.resume import TakenUp
    from bsm_mesh.solve.stages.checkpoint import Checkpoint


class RunWriter:
    """Writes a run into ``NAME.running`` and lets it take the place of ``NAME`` when it is finished.

    It is a context: inside it no other run can write there. At the end of every stage the finished ones are a results
    folder of their own, on the disk itself, whose status is ``unfinished``. If the run does not reach its end that
    becomes ``NAME.interrupted``, and the former results stay as they were; the exception carries a note that says so.
    The PVD files list what there is at any time: ParaView can follow a run whose steps are written.

    Parameters
    ----------
    folder : Path
        The results folder.
    given : mapping of str to callable
        Files that define the run: names, and a writer for each.
    inputs : iterable of Path
        Files that the run reads; in the folder itself they stay.
    steps : bool
        Write snapshots of the steps as well.
    form : OutputForm
        Which tables, and how VTU files are compressed.
    again : str
        The command that continues with the run if it is interrupted.
    resumes : bool
        Whether the files of an interrupted run stay until `go_on` or `start_over` is called.

    Raises
    ------
    ModelError
        If another run writes there, or the folder holds what bsm-mesh did not write, or cannot be written to.
    """

    def __init__(
        self,
        folder: Path,
        given: Given | None = None,
        *,
        inputs: Iterable[Path] = (),
        steps: bool = False,
        form: OutputForm = USUAL,
        again: str = "",
        resumes: bool = False,
    ) -> None:
        self.folder = ResultsFolder(folder)
        self._given, self._inputs, self._steps = dict(given or {}), tuple(inputs), steps
        self._form, self._again, self._resumes = form, again, resumes
        self.checkpoints = Checkpoints()
        self._snapshots = Snapshots()
        self._stages: tuple[StageResult, ...] = ()
        self._files: dict[str, dict[str, Any]] = {}
        self._loose: set[str] = set()  # written, but perhaps not on the disk itself
        self._state: State | None = None  # of what it has written; None: nothing yet
        self._held = ExitStack()

    def __enter__(self) -> Self:
        with self._told_faults():
            self.folder.refuse(self._inputs)
            self._held.enter_context(self.folder.locked())
            try:
                if not self._resumes:
                    self.start_over()
            except BaseException:
                self._held.close()
                raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._state is State.FINISHED and error is not None:
                with suppress(OSError, ModelError):  # told already
                    self.folder.recover()
                    error.add_note(f"the run was at its end: its results are in {self.folder.path}")
            elif self._state is State.RUNNING or (self._state is None and isinstance(error, KeyboardInterrupt)):
                self._end_early(error)
        finally:
            self._held.close()

    def start_over(self) -> None:
        """Keep the files of a killed run for a run that resumes it, and remove the rest."""
        place = self._place
        if finished_stages(place) or (place / CHECKPOINT).is_file() or solved_stages(place):
            tidy(place, {*named_by_checkpoint(place), *solved_stages(place)})
            self.folder.set_aside()
        else:
            clear(place)

    def go_on(self, left: TakenUp) -> None:
        """Go on writing where an interrupted run was at its last checkpoint; what came after it is removed."""
        with self._told_faults():
            if left.place != self._place:
                clear(self._place)
                move(left.place, self._place)
            self._state, self._files = State.RUNNING, dict(left.told["files"])
            self._snapshots.recall(left.told["snapshots"])
            if left.results is None:
                remove(self._place / SUMMARY)
            else:
                self._stages = left.results.stages
                self._write_summary(left.results)
            for name in sorted(own_files(self._place) - set(self._files)):
                if is_lasting(name):
                    remove(self._place / name)
            remove_abandoned(self._place)
            self._put_given()

    def keep(self, make: Callable[[], Checkpoint], ended: bool) -> None:
        """Have a checkpoint on the disk itself at the end of a stage, and in time between steps; `solve` calls this."""
        if not self.checkpoints.is_due(ended=ended):
            return
        with self._told_faults():
            self._begin()
            self._settle()  # what it names is there before it is
            self.checkpoints.write(self._place, make(), {"files": self._files, "snapshots": self._snapshots.told})

    def step(self, record: StepRecord, results: Callable[[], Results]) -> None:
        """Write the results of a step if it is its turn; `bsm_mesh.run` calls this."""
        instant = self._snapshots.instant(record) if self._steps else None
        if instant is None:
            return
        from bsm_mesh.converters.result_files import write_lists, write_snapshot

        with self._told_faults():
            self._begin()
            self._note(write_snapshot(results(), self._place, instant, self._form.compression))
            gone = self._snapshots.add(instant)
            write_lists(self._stages, self._place, self._snapshots.instants, self._snapshots.zero)
            self._remove_snapshots(gone)

    def stage(self, results: Results) -> None:
        """Have everything up to the last stage on disk; `bsm_mesh.run` calls this at its end."""
        with self._told_faults():
            self._begin()
            self._write_stages(results)
            self._write_lists(results)
            self._settle()
            self._write_summary(results)
            self._stages = results.stages

    def finish(self, results: Results) -> Path:
        """Complete the results, let them take the place of the former ones, and return the folder."""
        with self._told_faults():
            self._begin()
            self._write_stages(results)
            taken = {sum(len(stage.steps) for stage in results.stages[: k + 1]) for k in range(len(results.stages))}
            at_an_end = [instant for instant in self._snapshots.instants if instant.time in taken]
            self._snapshots.drop(at_an_end)
            self._note(self._write_lists(results))
            self._note(write_certificate(results, self._place))  # not before: it tells of all stages
            self._remove_snapshots(at_an_end)
            self._settle()
            self._write_summary(results)
            self._state = State.FINISHED
        try:
            self.folder.put_in_place()
        except OSError as error:
            raise ModelError(
                f"the results are complete, but {self.folder.told(self.folder.running)} cannot take the place of "
                f"{self.folder.path}: {error.strerror or error}; close the program that has a file of "
                "it open; the next run into it completes this"
            ) from error
        return self.folder.path

    @property
    def _place(self) -> Path:
        return self.folder.running

    @contextmanager
    def _told_faults(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise ModelError(f"cannot write results to {self.folder.path}: {told_fault(error)}") from error

    def _begin(self) -> None:
        if self._state is not None:
            return
        self._state = State.RUNNING
        place = self.folder.place
        make_folder(self._place)
        if place.is_dir():
            copy_mode(place, self._place)
        write_text(self._place / MARKER, HEADER + "".join(f"{name}\n" for name in self._given))
        self._loose.add(MARKER)
        self._put_given()

    def _put_given(self) -> None:
        """Write the files that define the run into the folder, with those of the present results that the run reads."""
        place = self.folder.place
        own = own_files(place)
        for name in self.folder.inside(self._inputs):
            kept = place_in(self._place, name)
            make_folder(kept.parent)
            remove(kept)
            keep(place / name, kept)
            if name in own:
                self._note([name])
        for name, write in self._given.items():
            write(self._place / name)
            self._note([name])

    def _note(self, names: Iterable[str]) -> None:
        for name in names:
            self._files[name] = fingerprint(self._place / name)
            self._loose.add(name)

    def _write_stages(self, results: Results) -> None:
        from bsm_mesh.converters.result_files import write_stage

        for number in range(len(self._stages), len(results.stages)):
            self._note(write_arrays(results, number, self._place))  # first: whatever fails after it, these are there
            self._note(write_stage(results, number, self._place, self._form.compression))

    def _write_lists(self, results: Results) -> list[str]:
        """Write what tells of all stages: tables that grow, and the PVD files, whose names are returned."""
        from bsm_mesh.converters.result_files import write_lists

        write_history(results, self._place)
        self._note([HISTORY, *write_histories(results, self._place), *write_shaking(results, self._place)])
        self._note(write_tables(results, self._place, self._form))
        instants = self._snapshots.instants if self._steps else None
        return write_lists(results.stages, self._place, instants, self._snapshots.zero)

    def _write_summary(self, results: Results) -> None:
        number = 1 + (run_number(self.folder.place) or 0)
        text = summary_text(results, number, self._files)
        write_text(self._place / SUMMARY, text, settled=True)
        settle(self._place)

    def _settle(self) -> None:
        for name in sorted(self._loose):
            settle(self._place / name)
        self._loose.clear()

    def _remove_snapshots(self, gone: Iterable[Instant]) -> None:
        from bsm_mesh.converters.result_files import OF_STEPS

        names = [instant.file(kind) for instant in gone for kind in OF_STEPS]
        for name in [name for name in names if name in self._files]:
            self.checkpoints.superseded.append(name)
            self._files.pop(name, None)
            self._loose.discard(name)

    def _end_early(self, error: BaseException | None) -> None:
        """Keep the finished stages of a run that did not reach its end, and report the place."""
        stages, goes_on = finished_stages(self._place), (self._place / CHECKPOINT).is_file()
        solved = solved_stages(self._place)
        moved = bool(self._snapshots.instants) and isinstance(error, KeyboardInterrupt)
        where = self.folder.told(self.folder.interrupted)
        try:
            if stages or moved or goes_on or solved:
                tidy(self._place, {*named_by_checkpoint(self._place), *solved})
                self.folder.set_aside()
            else:
                clear(self._place)
        except OSError:  # a full disk, for one
            where = self.folder.told(self._place)
        told = "no stage was finished"
        if stages:
            told = f"finished and in {where}: {counted(len(stages), 'stage')} ({', '.join(stages)})"
        elif moved:
            told += f"; the movement up to step {self._snapshots.instants[-1].time} is in {where}"
        if unwritten := solved[len(stages) :]:
            told += f"; solved, and in {where} as arrays alone: {', '.join(unwritten)}"
        if error is not None:
            former = run_number(self.folder.place) is not None
            told += f"; {self.folder.path} holds the former results" if former else ""
            error.add_note(told + (f"; continue with: {self._again}" if self._again and goes_on else ""))
