"""Parts of a report on a factor of safety, on key blocks and on a study."""

from __future__ import annotations

import glob
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.folder.key_block_files import NET, PICTURE, RECORD, read_key_blocks
from bsm_mesh.folder.own_files import read_json
from bsm_mesh.folder.safety_files import ANSWER, MECHANISM, MOVEMENT, STATES
from bsm_mesh.folder.study_folder import IDENTITY, STUDY, SUMMARY, TABLE
from bsm_mesh.modelfile.model_text import MODEL
from bsm_mesh.pages.report_results import SPACE, input_tables, picture_data
from bsm_mesh.safety.answer import FACTOR
from bsm_mesh.studies.table import StudyTable
from bsm_mesh.text.headings import PICTURES_FOLDER
from bsm_mesh.text.key_block_text import key_block_lines, key_block_table, unstable_rows
from bsm_mesh.text.safety_text import rows_of
from bsm_mesh.text.study_tables import run_rows, study_rows

BLOCK_THEORY = (
    "Block theory (Goodman and Shi 1985): blocks are rigid and translate; they do not rotate.",
    "Stress in the rock round a block is not considered.",
    "The support is a uniform pressure on the free faces of a block that brings the required factor of safety.",
)


def answers_beside(out: Path, word: str, record: str, model_hash: str) -> tuple[list[Path], list[Path]]:
    """Return the folders ``OUT-word`` of other answers, by name: of a model with this digest, and of other models.

    A word that ends in ``*`` finds those that begin so.
    """
    folder = out.absolute()
    found = [path for path in sorted(folder.parent.glob(f"{glob.escape(folder.name)}-{word}")) if path.is_dir()]
    digests = {path: read_json(path / record).get("model_hash") for path in found}
    others = [path for path in found if digests[path] not in (None, model_hash)]
    return [path for path in found if digests[path] == model_hash], others


def safety_content(folder: Path) -> dict[str, Any]:
    """Return the part of the page on a factor of safety, or on the limit of a key.

    Raises
    ------
    ModelError
        If the folder does not hold one, or it is damaged.
    """
    told = read_json(folder / ANSWER)
    shown = _pictures(folder, ((MECHANISM, "mechanism"), (MOVEMENT, "movement")))
    try:
        states = [name for name in STATES if told[name] is not None]
        quantity = "Factor of safety" if told["quantity"] == FACTOR else f"Limit of {told['quantity']}"
        return {
            "title": told["title"],
            "heading": f"{quantity} in stage '{told['stage']}'",
            "stage": told["stage"],
            "fields": told["report"],
            "model_hash": told["model_hash"],
            "answer": told["answer"],
            "rows": rows_of(told),
            "notes": told["remarks"],
            "pictures": shown,
            "states": states,
            "state_shown": f"below: the results of the state {STATES[states[0]]}" if states else "",
        }
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        raise ModelError(f"{folder / ANSWER} is damaged or missing; run bsm-mesh safety again") from error


def key_blocks_content(folder: Path) -> dict[str, Any]:
    """Return the part of the page on key blocks: lines, tables and pictures, by the files of `bsm-mesh key-blocks`.

    Raises
    ------
    ModelError
        If the folder does not hold them, or they are damaged.
    """
    told, columns = read_key_blocks(folder)
    shown = _pictures(folder, ((PICTURE, "blocks at free faces"), (NET, "joints")))
    try:
        rows = unstable_rows(columns)
        header, unstable = key_block_table(columns, rows)
        others = np.setdiff1d(np.arange(len(columns["block"])), rows)
        return {
            "title": told["title"],
            "fields": told["report"],
            "lines": key_block_lines(told, columns),
            "header": header,
            "unstable": unstable,
            "others": key_block_table(columns, others)[1],
            "proofs": [(name, proof["text"]) for name, proof in told["limit_analysis"].items()],
            "notes": told["notes"],
            "pictures": shown,
            "versions": told["versions"],
            "model_hash": told["model_hash"],
        }
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        raise ModelError(f"{folder / RECORD} is damaged; run bsm-mesh key-blocks again") from error


def key_blocks_page(folder: Path) -> dict[str, Any]:
    """Return a page on key blocks alone, with the input on which they rest; errors as of `key_blocks_content`."""
    content = key_blocks_content(folder)
    try:
        model = (folder / MODEL).read_text(encoding="utf-8")
        return {
            **{name: content[name] for name in ("title", "fields", "versions", "model_hash")},
            "heading": "",
            "key_blocks": content,
            "input": input_tables(model),
            "assumptions": (SPACE, *BLOCK_THEORY),
            "model": model,
        }
    except (OSError, ValueError) as error:
        raise ModelError(f"{folder / MODEL} is damaged or missing; run bsm-mesh key-blocks again") from error


def _pictures(folder: Path, names: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return captions and pictures of those that are there."""
    return [(caption, picture_data(folder / name)) for name, caption in names if (folder / name).is_file()]


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
    single = run_rows(StudyTable.read(out / TABLE))
    return {
        "title": told["title"],
        "heading": "",
        "fields": fields,
        "study": {"tables": [*tables, *([single] if single[2] else [])], "text": text},
        "pictures": [each for each in shown if each[0] != "model"],
        "overview": next((data for name, data in shown if name == "model"), ""),
    }
