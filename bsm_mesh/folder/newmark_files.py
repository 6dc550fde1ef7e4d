"""The folder of Newmark's displacement: the answer, and sliding over time."""

from __future__ import annotations

import json

import numpy as np

from bsm_mesh.files import write_text
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.model.base_motion import BaseMotion
from bsm_mesh.safety.earthquake import Newmark
from bsm_mesh.text.csv_tables import csv_text
from bsm_mesh.text.newmark_text import told_of

ANSWER, OVER_TIME = "newmark.json", "newmark.csv"
TIMES = 2001  # rows of the table


def write_newmark(answer: Newmark, title: str, added: AddedFiles) -> list[str]:
    """Write an answer into a folder and return the names of the files.

    Raises
    ------
    ModelError
        If the folder cannot be written to, or holds files that bsm-mesh did not write.
    """
    with added.file(ANSWER) as draft:
        write_text(draft, json.dumps({"title": title, **told_of(answer)}, indent=1) + "\n")
    with added.file(OVER_TIME) as draft:
        write_text(draft, _table(answer))
    return [ANSWER, OVER_TIME]


def _table(answer: Newmark) -> str:
    """Return the record and sliding over time, a row a time."""
    found = [
        (f"{side.side}{'' if slides is side.sliding else ', turned over'}", slides)
        for side in answer.sides
        for slides in (side.sliding, side.turned)
        if slides is not None
    ]
    length = max([answer.shaking.length, *(float(slides.time[-1]) for _, slides in found)])
    time = np.linspace(0.0, length, TIMES)
    columns = [time, BaseMotion(answer.shaking).velocity_at(time)]
    names = ["time [s]", "base_velocity [m/s]"]
    for name, slides in found:
        columns += [np.interp(time, slides.time, values) for values in (slides.velocity, slides.displacement)]
        names += [f"velocity {name} [m/s]", f"displacement {name} [m]"]
    return csv_text([names, *np.column_stack(columns).tolist()])
