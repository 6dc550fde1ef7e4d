"""Run a model file: read, solved as it says, written to its folder. The command and `bsm.run` both come here."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bsm_mesh.app.build import LoadedModel, load_model_file
from bsm_mesh.app.snapshots import SnapshotWriter, no_snapshots
from bsm_mesh.app.storage import refuse_folder, save_results
from bsm_mesh.errors import ModelError, placed
from bsm_mesh.reading import refuse_special
from bsm_mesh.results.records import Results, StepRecord
from bsm_mesh.run import Observer, Output, Snapshot, run
from bsm_mesh.solve.options import Options

if TYPE_CHECKING:
    from bsm_mesh.solve.stages import Reporter

AS_RUN = "# The model as run by bsm-mesh: every default, SI units. A further run into this folder replaces it.\n"


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class FileRun:
    """What came of a model file.

    Attributes
    ----------
    results : Results
        What came out.
    notes : tuple of str
        What was mended or left out of the mesh, a line each.
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
    snapshot: Snapshot = no_snapshots,
    *,
    output: Output = None,
    scripts: bool = True,
    noted: Callable[[str], None] = lambda text: None,
) -> FileRun:
    """Solve a model file and write its results.

    Parameters
    ----------
    path : Path
        The model file.
    options : Options, optional
        How to solve it; by default as its ``[solver]`` says.
    observer, report, snapshot : callable, optional
        As `bsm_mesh.run` takes them.
    output : path or False, optional
        Folder for the results; by default that of its ``[output]``, beside the file. False: nothing is written.
    scripts : bool
        Whether the file may run a geometry script and name any path.
    noted : callable, optional
        Told each note on the mesh before anything is solved.

    Raises
    ------
    ModelError
        For faults of the file, its mesh or the model, and for a folder that cannot be written to.
    """
    loaded = load_model_file(path, report, scripts=scripts)
    for note in loaded.notes:
        noted(note)
    options = options or loaded.options
    folder = _folder(loaded, output)
    if folder is None:
        with placed(path.name):
            return FileRun(
                results=run(loaded.model, options, observer, report, snapshot), notes=loaded.notes, folder=None
            )
    model_file = model_file_for(loaded, folder, options)
    writer = SnapshotWriter(folder) if loaded.file.output.snapshots == "steps" else no_snapshots

    def watch(record: StepRecord, results: Callable[[], Results]) -> None:
        writer(record, results)
        snapshot(record, results)

    with placed(path.name):
        results = run(loaded.model, options, observer, report, watch)
    report(f"writing {folder}")
    save_results(results, folder, model_file, writer.instants if isinstance(writer, SnapshotWriter) else None)
    return FileRun(results=results, notes=loaded.notes, folder=folder)


def _folder(loaded: LoadedModel, output: Output) -> Path | None:
    if output is False:
        return None
    if output is None:
        return loaded.output_folder
    if isinstance(output, str | os.PathLike):
        return Path(output)
    raise ModelError(f"output = {output!r} must be a folder, or False to write nothing")


def model_file_for(loaded: LoadedModel, folder: Path, options: Options) -> str | None:
    """Return what ``model.toml`` in a results folder is to hold; None where the model itself is that file, and stays.

    Raises
    ------
    ModelError
        If the folder cannot be written to, or that is another file which did not come from a run.
    """
    refuse_folder(folder)
    there = folder / "model.toml"
    refuse_special(there)
    if there.exists():
        if there.samefile(loaded.path):
            return None
        if not there.read_bytes().startswith(AS_RUN.encode()):
            raise ModelError(f"{there} is not from a run and would be replaced; choose another output folder")
    return model_as_run(loaded, folder, options)


def model_as_run(loaded: LoadedModel, folder: Path, options: Options) -> str:
    """Return the model file with every default and all numbers in SI, its mesh relative to `folder`."""
    import tomli_w

    content = loaded.file.model_dump(mode="json", exclude_none=True)
    for key in ("file", "geometry"):
        name = content["mesh"].get(key)
        if name is not None and (key == "file" or name.endswith(".py")):
            content["mesh"][key] = Path(os.path.relpath(loaded.path.parent / name, folder)).as_posix()
    for bolt in content["bolt"]:
        if "table" in bolt:
            bolt["table"] = Path(os.path.relpath(loaded.path.parent / bolt["table"], folder)).as_posix()
    content["solver"] = {key: value for key, value in dataclasses.asdict(options).items() if value is not None}
    content["output"]["folder"] = "."
    return AS_RUN + tomli_w.dumps({key: value for key, value in content.items() if value not in ({}, [])})
