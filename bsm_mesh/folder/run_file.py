"""Run a model file: read, solved as it says, written to its folder. The command and `bsm.run` both come here."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from bsm_mesh.errors import ModelError, placed
from bsm_mesh.files import write_text
from bsm_mesh.folder.result_tables import OutputForm, TableForm
from bsm_mesh.folder.resume import identity_of, take_up
from bsm_mesh.folder.run_writer import RunWriter
from bsm_mesh.model.options import Options
from bsm_mesh.modelfile.build import build_file, inputs_of, output_folder, read_file
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.model_text import MODEL, Given, as_run, tables_of
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.results.records import StepRecord
from bsm_mesh.results.results import Results
from bsm_mesh.solve.stages.checkpoint import Resumption
from bsm_mesh.solving import Finished, Observer, Output, Snapshot, refuse_one_route, solve
from bsm_mesh.solving import spread as with_spread

if TYPE_CHECKING:
    from bsm_mesh.solve.stages.scheme import Reporter


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class FileRun:
    """The outcome of a model file.

    Attributes
    ----------
    results : Results
        The result.
    notes : tuple of str
        Repairs and omissions of the mesh, a line each.
    folder : Path or None
        Where the results were written; None: nowhere.
    """

    results: Results
    notes: tuple[str, ...]
    folder: Path | None


def run_file(
    path: Path,
    options: Options | None = None,
    observer: Observer | None = None,
    report: Reporter = lambda text: None,
    snapshot: Snapshot = lambda record, results: None,
    finished: Finished = lambda results: None,
    *,
    output: Output = None,
    scripts: bool = True,
    noted: Callable[[str], None] = lambda text: None,
    resume: bool = False,
    spread: bool = False,
    tables: TableForm | Literal[False] = False,
) -> FileRun:
    """Solve a model file and write its results.

    Parameters
    ----------
    path : Path
        The model file.
    options : Options, optional
        How to solve it; by default as its ``[solver]`` says.
    observer, report, snapshot, finished : callable, optional
        As `bsm_mesh.run` takes them.
    output : path or False, optional
        Folder for the results; by default that of its ``[output]``, next to the file. False: nothing is written.
    scripts : bool
        Whether the file may run a geometry script and name any path.
    noted : callable, optional
        Called with each note on the mesh before anything is solved.
    resume : bool
        Go on where an interrupted run was; where there was none, begin at the start.
    spread : bool
        Whether the model is solved by other routes too, and how far they lead apart is reported.
    tables : {"csv", "parquet"} or False
        As what tables are written, also where its ``[output]`` does not say so.

    Raises
    ------
    ModelError
        For faults of the file, its mesh or the model, and for a folder that cannot be written to; with `resume` where
        an interrupted run cannot be taken up, or was finished.
    """
    file = read_file(path)
    if tables:
        file = file.model_copy(update={"output": file.output.model_copy(update={"tables": tables})})
    reach = Reach(folder=path.parent, scripts=scripts)
    folder = _folder(file, path, reach, output)
    if file.output.tables and isinstance(file, SpaceFile):
        raise ModelError(f"{path.name}: tables of results are for the plane; leave tables out")
    if resume and folder is None:
        raise ModelError("resume belongs to a results folder, and output = False leaves nothing to continue with")
    with ExitStack() as held:
        writer = None
        if folder is not None:
            given, steps = given_files(file, path, folder, options), file.output.snapshots == "steps"
            writer = held.enter_context(
                RunWriter(
                    folder,
                    given,
                    inputs=inputs_of(file, path),
                    steps=steps,
                    form=OutputForm(tables=file.output.tables, compression=file.output.compression),
                    again=_command(path, output, scripts=scripts, tables=tables),
                    resumes=resume,
                )
            )
        loaded = build_file(file, path, reach, report)
        model, notes = loaded.model, loaded.notes
        for note in notes:
            noted(note)

        def watch(record: StepRecord, results: Callable[[], Results]) -> None:
            if writer is not None:
                writer.step(record, results)
            snapshot(record, results)

        def end(results: Results) -> None:
            if writer is not None:
                writer.stage(results)
            finished(results)

        solver = options or model.options or Options()
        resumption = None
        if writer is not None:
            writer.checkpoints.identity = identity_of(model, solver, file.output.snapshots)
            resumption = _resumption(writer, report, resume=resume)
        with placed(path.name):
            if spread:
                refuse_one_route(solver, model)  # before anything is solved
            results = solve(model, solver, observer, report, watch, end, resumption)
            if spread:
                results = with_spread(results, report)
        if writer is not None:
            report(f"writing {folder}")
            writer.finish(results)
    return FileRun(results=results, notes=notes, folder=folder)


def _resumption(writer: RunWriter, report: Reporter, *, resume: bool) -> Resumption:
    """Return where the run continues, or that it begins at the start, `writer` keeping its checkpoints."""
    left = take_up(writer.folder, writer.checkpoints.identity) if resume else None
    if left is not None:
        writer.go_on(left)
        stages = () if left.results is None else left.results.stages
        return Resumption(begun=left.checkpoint, stages=stages, keep=writer.keep)
    if resume:
        writer.start_over()
        report("no interrupted run to continue with: it begins at the start")
    return Resumption(keep=writer.keep)


def _command(path: Path, output: Output, *, scripts: bool, tables: TableForm | Literal[False]) -> str:
    """Return the command that continues with a run."""
    words = ["bsm-mesh", "run", str(path), "--resume"]
    words += ["--tables", str(tables)] if tables else []
    words += [] if output is None else ["-o", str(output)]
    return shlex.join(words if scripts else [*words, "--no-scripts"])


def _folder(file: ModelFile | SpaceFile, path: Path, reach: Reach, output: Output) -> Path | None:
    if output is False:
        return None
    if output is None:
        return output_folder(file, path, reach)
    if isinstance(output, str | os.PathLike):
        return Path(output)
    raise ModelError(f"output = {output!r} must be a folder, or False to write nothing")


def given_files(file: ModelFile | SpaceFile, path: Path, folder: Path, options: Options | None) -> Given:
    """Return the model file to be written: nothing where it is the folder's own ``model.toml``, which stays."""
    there = folder / MODEL
    if there.exists() and there.samefile(path):
        return {}
    text = _as_run(file, path, folder, options)
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ModelError(
            f"{path}: {MODEL} in {folder} could not name the files of this model: a folder's name is no text in UTF-8 "
            "(Latin-1, perhaps?); rename it"
        ) from None
    return {MODEL: lambda target: write_text(target, text)}


def _as_run(file: ModelFile | SpaceFile, path: Path, folder: Path, options: Options | None) -> str:
    """Return the model file with every default and all numbers in SI, with paths relative to `folder`."""
    content = file.model_dump(mode="json", exclude_none=True, by_alias=True)
    for body in content.get("excavation", ()):
        if "profile" in body:
            body["profile"] = _from_folder(path.parent / body["profile"], folder)
    for key in ("file", "geometry"):
        name = content["mesh"].get(key)
        if name is not None and (key == "file" or name.endswith(".py")):
            content["mesh"][key] = _from_folder(path.parent / name, folder)
    for bolt in content.get("bolt", ()):
        if "table" in bolt:
            bolt["table"] = _from_folder(path.parent / bolt["table"], folder)
    for joint in content["joint"].values():
        if isinstance(joint.get("along"), dict):
            joint["along"]["file"] = _from_folder(path.parent / joint["along"]["file"], folder)
    for history in content.get("history", ()):
        if "measured" in history:
            history["measured"] = [_from_folder(path.parent / name, folder) for name in history["measured"]]
    if options is not None:
        content |= tables_of(options)
    content["output"]["folder"] = "."
    return as_run(content)


def _from_folder(file: Path, folder: Path) -> str:
    real = Path(os.path.realpath(file))
    try:
        return Path(os.path.relpath(real, os.path.realpath(folder))).as_posix()
    except ValueError:  # on another drive
        return real.as_posix()
