"""The command ``newmark``: yield acceleration of a model file, and a record integrated twice over it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bsm_mesh.commands.safety import EXIT_DONE, EXIT_UNDECIDED, folder_beside
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.newmark_files import write_newmark
from bsm_mesh.model.shaking import MotionQuantity, Shaking
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.modelfile.build_mesh import stdout_to_stderr
from bsm_mesh.modelfile.record_files import read_record
from bsm_mesh.pictures.newmark_pictures import draw_newmark
from bsm_mesh.safety.criterion import Failure
from bsm_mesh.safety.earthquake import newmark
from bsm_mesh.text.newmark_text import HEADER, remarks, side_rows, told_of
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.tables import print_table
from bsm_mesh.text.terminal import say, say_json


def ask_newmark(
    path: Path,
    output: Path | None,
    told: Progress,
    *,
    record: Path | None,
    quantity: MotionQuantity,
    scale: float,
    movement: float,
    as_json: bool,
    scripts: bool,
    **asked: Any,
) -> int:
    """Find Newmark's displacement of a model file, write and print it, and return the exit code."""
    failure = Failure(movement=movement)
    with told as progress, stdout_to_stderr():
        given = None
        if record is not None:
            given = Shaking(record=read_record(record, quantity), quantity=quantity, scale=scale)
        loaded = load_model_file(path, progress.report, scripts=scripts)
        folder = output or folder_beside(loaded, loaded.reach, "newmark")
        added = AddedFiles(folder)  # refused before anything is solved
        answer = newmark(loaded.model, given, options=loaded.options, failure=failure, report=progress.report, **asked)
        title = f"{loaded.model.title or loaded.path.stem}: displacement by Newmark's method"
        files = write_newmark(answer, title, added)
        with added.file("newmark.png") as draft:
            draw_newmark(answer, title, draft)
    if as_json:
        say_json({**told_of(answer), "notes": list(loaded.notes), "folder": str(folder)})
    else:
        for note in loaded.notes:
            say(f"mesh: {note}", err=True)
        print_table(title, HEADER, side_rows(answer))
        for remark in remarks(answer):
            say(remark)
        say(f"written to {folder}: {', '.join([*files, 'newmark.png'])}")
    return EXIT_DONE if answer.is_decided else EXIT_UNDECIDED
