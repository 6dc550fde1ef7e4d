"""The command ``report``: results, a factor of safety, key blocks or a study as one page to be filed or printed."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.files import write_text
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.key_block_files import RECORD
from bsm_mesh.folder.own_files import SUMMARY
from bsm_mesh.folder.safety_files import ANSWER, LIMIT, SAFETY
from bsm_mesh.folder.saved_results import damage_told, find_results
from bsm_mesh.modelfile.model_text import MODEL
from bsm_mesh.pages.report_answers import (
    answers_beside,
    is_study,
    key_blocks_content,
    key_blocks_page,
    safety_content,
    study_content,
)
from bsm_mesh.pages.report_results import content_of, picture_data
from bsm_mesh.pictures.plot import PictureChoice, draw_in_subprocess, in_silence

REPORT, TEMPLATE = "report.html", "report.html.j2"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportFields:
    """The head of a report. Empty fields take the values of ``[report]`` in the model or study file.

    Attributes
    ----------
    project, author, date : str
        As they are to be there.
    picture : Path or None
        An overview of one's own, PNG; by default the picture of the model.
    """

    project: str = ""
    author: str = ""
    date: str = ""
    picture: Path | None = None


def write_report(
    out: Path,
    progress: Callable[[str], None] = in_silence,
    *,
    pictures: bool = True,
    fields: ReportFields | None = None,
    safety: Path | None = None,
    note: Callable[[str], None] = in_silence,
) -> Path:
    """Write the report of a folder into it and return its path.

    Parameters
    ----------
    out : Path
        The folder of a run, of a factor of safety, of key blocks or of a study.
    progress : callable
        Gets a few words before each part of the work.
    pictures : bool
        Whether its pictures are drawn where they are missing.
    fields : ReportFields, optional
        Project, author, date and overview picture.
    safety : Path, optional
        The folder of the factor of safety for the first page of a run's report; by default ``OUT-safety`` and
        ``OUT-safety-STAGE`` that belong to the same model.
    note : callable
        Gets a sentence where a verdict does not hold, and where the page shows another model or input edited later.

    Raises
    ------
    ModelError
        If the folder holds nothing to report, or it is damaged, or the pictures cannot be drawn.
    """
    from jinja2 import Environment

    chosen = fields or ReportFields()
    if not (is_study(out) or (out / RECORD).is_file() or (out / ANSWER).is_file()):
        find_results(out)
    added = AddedFiles(out) if not is_study(out) else None
    with damage_told(out):
        content = _content(out, progress, pictures=pictures, safety=safety)
    for text in (
        *content.get("doubts", ()),
        *content.get("strangers", ()),
        *_edited_fields(out, content["fields"], chosen),
    ):
        note(text)
    content["fields"] = _fields(chosen, content["fields"])
    if chosen.picture is not None:
        content["overview"] = _overview(chosen.picture)
    template = resources.files("bsm_mesh.pages").joinpath(TEMPLATE).read_text(encoding="utf-8")
    page = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(template).render(**content)
    if added is None:
        write_text(out / REPORT, page)
    else:
        with added.file(REPORT) as draft:
            write_text(draft, page)
    return out / REPORT


def _content(out: Path, progress: Callable[[str], None], *, pictures: bool, safety: Path | None) -> dict[str, Any]:
    """Return the content of the page: the answer first, then the results on which it rests."""
    if is_study(out):
        return study_content(out)
    if (out / RECORD).is_file():
        return key_blocks_page(out)
    if (out / ANSWER).is_file():
        answer = safety_content(out)
        state = next((out / name for name in answer["states"] if (out / name / SUMMARY).is_file()), None)
        results = {} if state is None else _results(state, progress, pictures=pictures)
        heading = f"{answer['answer']} ({answer['state_shown']})" if state is not None else answer["answer"]
        return {
            **results,
            "title": answer["title"],
            "heading": heading,
            "fields": answer["fields"],
            "answers": [answer],
        }
    content = _results(out, progress, pictures=pictures)
    digest = content["model_hash"]
    factors, others = answers_beside(out, f"{SAFETY}*", ANSWER, digest) if safety is None else ([safety], [])
    limits, of_limits = answers_beside(out, f"{LIMIT}*", ANSWER, digest)
    blocks, of_blocks = answers_beside(out, "key-blocks", RECORD, digest)
    order = [stage["name"] for stage in content["stages"]]
    content["answers"] = [*_in_order(factors, order), *_in_order(limits, order)]
    content["strangers"] = [
        *_of_other_models(content["answers"], digest),
        *(
            f"{each.parent.name}/{each.name} is of another model than {out}, or of an edited one, and is left out; "
            "run both commands again"
            for each in (*others, *of_limits, *of_blocks)
        ),
    ]
    for each in blocks:
        content["key_blocks"] = key_blocks_content(each)
    return content


def _in_order(folders: Iterable[Path], order: list[str]) -> list[dict[str, Any]]:
    """Return the parts of the page on factors or limits, in the order of their stages; of other stages at the end."""
    found = [safety_content(each) for each in folders]
    return sorted(found, key=lambda one: order.index(one["stage"]) if one["stage"] in order else len(order))


def _of_other_models(answers: list[dict[str, Any]], model_hash: str) -> list[str]:
    """Add a note to each answer that is of another model than the results, and return the notes."""
    found = []
    for answer in answers:
        if answer["model_hash"] != model_hash:
            text = f"'{answer['answer']}' is of another model than these results (SHA-256 {answer['model_hash']})"
            answer["notes"] = [*answer["notes"], text]
            found.append(text)
    return found


def _edited_fields(out: Path, fields: Mapping[str, Any], chosen: ReportFields) -> list[str]:
    """Return a note where the model file has another head than when it was run, or is not where it is looked for.

    ``NAME.toml`` in the folder of ``out`` is the model file of ``out/NAME`` and of ``out/NAME-safety``.
    """
    folder = out.absolute()
    beside = folder.parent.parent.glob("*.toml") if folder.parent.name == "out" else ()
    named = [path for path in beside if f"{folder.name}-".startswith(f"{path.stem}-")]
    cure = "give --project, --author and --date, or run the model again"
    if not named:
        if not (folder / MODEL).is_file() or all((chosen.project, chosen.author, chosen.date)):
            return []
        return [f"the head of the page is [report] of {out / MODEL}, the model as it was run; {cure} for another one"]
    source = max(named, key=lambda path: len(path.stem))
    try:
        now = tomllib.loads(source.read_text(encoding="utf-8")).get("report", {})
    except (OSError, ValueError):
        return []
    if _fields(ReportFields(), now) == _fields(ReportFields(), fields):
        return []
    return [f"[report] in {source} is not that of the run, which the page shows; {cure}"]


def _results(out: Path, progress: Callable[[str], None], *, pictures: bool) -> dict[str, Any]:
    if pictures:
        progress("pictures that are missing")
        draw_in_subprocess(out, PictureChoice(for_report=True), progress)
    progress(f"checking the verdicts of {out}")
    return content_of(out)


def _fields(given: ReportFields, known: Mapping[str, Any]) -> dict[str, str]:
    """Return the fields that are not empty: as given, else as in the file."""
    named = {name: value for name, value in asdict(given).items() if name != "picture"}
    found = {name: str(value or known.get(name, "")) for name, value in named.items()}
    return {name: value for name, value in found.items() if value}


def _overview(picture: Path) -> str:
    if picture.suffix.lower() != ".png" or not picture.is_file():
        raise ModelError(f"report: --picture {picture}: give a PNG file")
    return picture_data(picture)
