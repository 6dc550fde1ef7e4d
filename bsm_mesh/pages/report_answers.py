"""Parts of a report on a factor of safety and on a study."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.folder.own_files import read_json
from bsm_mesh.folder.safety_files import ANSWER, STATES
from bsm_mesh.folder.study_folder import IDENTITY, STUDY, SUMMARY
from bsm_mesh.pages.report_results import picture_data
from bsm_mesh.text.headings import PICTURES_FOLDER
from bsm_mesh.text.safety_text import rows_of
from bsm_mesh.text.study_tables import study_rows

MECHANISM, MOVEMENT = "mechanism.png", "movement.png"


def safety_beside(out: Path, model_hash: str) -> Path | None:
    """Return the folder ``OUT-safety`` if its answer is of a model with this digest."""
    folder = out.absolute()
    beside = folder.with_name(f"{folder.name}-safety")
    return beside if read_json(beside / ANSWER).get("model_hash") == model_hash else None


def safety_content(folder: Path) -> dict[str, Any]:
    """Return the part of the page on a factor of safety.

    Raises
    ------
    ModelError
        If the folder does not hold one, or it is damaged.
    """
    told = read_json(folder / ANSWER)
    shown = [
        (caption, picture_data(folder / name))
        for name, caption in ((MECHANISM, "mechanism"), (MOVEMENT, "movement"))
        if (folder / name).is_file()
    ]
    try:
        states = [name for name in STATES if told[name] is not None]
        return {
            "title": told["title"],
            "fields": told["report"],
            "answer": told["answer"],
            "rows": rows_of(told),
            "notes": told["remarks"],
            "pictures": shown,
            "states": states,
            "state_shown": f"below: the results of the state {STATES[states[0]]}" if states else "",
        }
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        raise ModelError(f"{folder / ANSWER} is damaged or missing; run bsm-mesh safety again") from error


def is_study(out: Path) -> bool:
    """Return whether a folder is that of a study."""
    return (out / IDENTITY).is_file() and (out / STUDY).is_file()


def study_content(out: Path) -> dict[str, Any]:
    """Return the page of a study: probability of failure, answers, effects, pictures.

    Raises
    ------
    ModelError
        If the study is not finished, or its files are damaged.
    """
    told = read_json(out / SUMMARY)
    shown = [(path.stem, picture_data(path)) for path in sorted((out / PICTURES_FOLDER).glob("*.png"))]
    try:
        text = (out / STUDY).read_text(encoding="utf-8")
        tables = study_rows(told)
        fields = tomllib.loads(text).get("report", {})
    except (AttributeError, LookupError, TypeError, ValueError, OSError) as error:
        raise ModelError(f"{out / SUMMARY} is damaged or missing; run bsm-mesh study again") from error
    return {
        "title": told["title"],
        "heading": "",
        "fields": fields,
        "study": {"tables": tables, "text": text},
        "pictures": [each for each in shown if each[0] != "model"],
        "overview": next((data for name, data in shown if name == "model"), ""),
    }
