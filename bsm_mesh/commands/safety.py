"""The command ``safety``: the factor of safety of a model file, or the limit of one of its numbers."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError, placed
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.safety_files import LIMIT, SAFETY, write_safety
from bsm_mesh.model.quantity import typed
from bsm_mesh.modelfile.build import LoadedModel, load_model_file
from bsm_mesh.modelfile.build_mesh import stdout_to_stderr
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_file import LoadedSpace
from bsm_mesh.modelfile.variation import Variation
from bsm_mesh.pictures.safety_pictures import draw_safety
from bsm_mesh.safety.answer import Safety
from bsm_mesh.safety.criterion import Failure
from bsm_mesh.safety.factor import factor_of_safety
from bsm_mesh.safety.limits import limit_value
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.safety_text import answer_rows, spread_rows, told_of
from bsm_mesh.text.tables import print_table
from bsm_mesh.text.terminal import say, say_json

EXIT_DONE, EXIT_UNDECIDED = 0, 3


def folder_beside(loaded: LoadedModel | LoadedSpace, reach: Reach, word: str) -> Path:
    """Return the default folder of an answer: next to the results of the run."""
    results = Path(loaded.file.output.folder or f"out/{loaded.path.stem}")
    return reach.output(str(results.with_name(f"{results.name}-{word}")) if results.name else word)


def answer_word(key: str | None, stage: str | None) -> str:
    """Return the end of the name of an answer's folder: each varied key and each stage asked for has its own.

    Examples
    --------
    >>> answer_word("joint.bedding/2.friction", None), answer_word(None, "heavy rain")
    ('limit-joint.bedding_2.friction', 'safety-heavy_rain')
    """
    word = SAFETY if key is None else LIMIT + key
    return re.sub(r"[^\w.+-]", "_", word if stage is None else f"{word}-{stage}")


def ask_safety(
    path: Path,
    output: Path | None,
    told: Progress,
    *,
    vary: tuple[str, str, str] | None,
    movement: float,
    as_json: bool,
    scripts: bool,
    **asked: Any,
) -> int:
    """Find the factor of safety of a model file, or the limit of one of its numbers; write and print the result.

    Returns the exit code.
    """
    failure = Failure(movement=movement)
    common = {name: asked.pop(name) for name in ("stage", "tolerance", "trials", "processes")}
    with told as progress, stdout_to_stderr():
        if vary is None:
            loaded = load_model_file(path, progress.report, scripts=scripts, space=True)
        else:
            _refuse_reductions(asked)
            variation, name = Variation(path, scripts=scripts), vary[0]
            good, bad = variation.ends(name, [typed(word) for word in vary[1:]])
            loaded = variation.model({})
        word = answer_word(None if vary is None else vary[0], common["stage"])
        folder = output or folder_beside(loaded, Reach(folder=path.parent, scripts=scripts), word)  # as it was given
        added = AddedFiles(folder)  # refused before anything is solved
        common |= {"options": loaded.options, "failure": failure, "report": progress.report}
        if vary is None:
            with placed(path.name):
                answer = factor_of_safety(loaded.model, **common, **asked)
        else:
            at, unit = partial(variation.with_value, name), variation.unit(name)
            answer = limit_value(at, good, bad, quantity=name, unit=unit, **common)
            answer = replace(answer, notes=(*answer.notes, *variation.overriding(name, answer.stage)))
        progress.report(f"writing {folder}")
        files = write_safety(answer, loaded, added)
        title = f"{loaded.model.title or loaded.path.stem}: {answer}"
        files += draw_safety(answer, failure.movement, title, added)  # last: whatever fails here, the answer is there
    if as_json:
        say_json({**told_of(answer), "notes": [*loaded.notes, *answer.notes], "folder": str(folder)})
    else:
        _print(answer, loaded, folder, files)
    return EXIT_DONE if answer.is_decided else EXIT_UNDECIDED


def _refuse_reductions(asked: dict[str, Any]) -> None:
    """Raise where an option of strength reduction is given with another number to vary."""
    usual = {"joints": None, "rocks": None, "bolts": False, "start": "stage", "spread": False}
    for name, value in asked.items():
        if value != usual[name]:
            raise ModelError(
                f"safety: --{name} belongs to strength reduction, and --vary varies another number; leave one out"
            )


def _print(answer: Safety, loaded: LoadedModel, folder: Path, files: list[str]) -> None:
    for note in loaded.notes:
        say(f"mesh: {note}", err=True)
    print_table(loaded.model.title or str(loaded.path), ("", ""), answer_rows(answer))
    if answer.spread:
        print_table("Other starts, and stiffer joints", ("", "stable", "unstable"), spread_rows(answer))
    for note in answer.notes:
        say(f"note: {note}")
    say(f"{answer}.")
    say(f"written to {folder}: {', '.join(files)}")
