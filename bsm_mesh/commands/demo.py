"""The command ``demo``: a cavern whose roof wedge falls without bolts and is stable with them."""

from __future__ import annotations

import tomllib
from pathlib import Path

import tomli_w

from bsm_mesh.commands.commands import run_model
from bsm_mesh.errors import named_stage
from bsm_mesh.files import write_text
from bsm_mesh.folder.summary import read_summary
from bsm_mesh.modelfile.model_file import read_model_file
from bsm_mesh.pictures.plot import PictureChoice, draw_in_subprocess
from bsm_mesh.text.headings import PICTURES_FOLDER
from bsm_mesh.text.progress import Progress, reading
from bsm_mesh.text.terminal import say

CASE, LAST = "cavern", "-1"
MODEL, UNBOLTED = "model.toml", "unbolted.toml"


def run_demo(folder: Path) -> None:
    """Write the starter into a folder, run it without its bolts and with them, and draw both.

    Where the starter is there already it is run as it was changed.
    """
    from bsm_mesh.commands.starters import starter_files, write_starter

    if not all((folder / source.name).is_file() for source in starter_files(CASE)):
        write_starter(CASE, folder)
    read_model_file(folder / MODEL)  # says the fault, and where
    write_text(folder / UNBOLTED, without_bolts((folder / MODEL).read_text(encoding="utf-8")))
    for name in (UNBOLTED, MODEL):
        say(f"{folder / name}:")
        run_model(folder / name, None, Progress(), pictures=False, as_json=False)
        say("")
    for name in (UNBOLTED, MODEL):
        out = folder / "out" / Path(name).stem
        with reading(out) as progress:
            draw_in_subprocess(out, PictureChoice(stage=LAST), progress.often)
        stage = read_summary(out)["stages"][-1]
        say(f"{name}, {named_stage(stage['name'])}: {stage['verdict']}. Pictures: {out / PICTURES_FOLDER}")


def without_bolts(text: str) -> str:
    """Return a model file without its bolts and the record of them."""
    content = tomllib.loads(text)
    content.pop("bolt", None)
    if "history" in content:
        content["history"] = [table for table in content["history"] if "bolt" not in table]
    content["title"] = f"{content.get('title', 'Cavern')}, without bolts"
    return f"# {MODEL} without its bolts, written by: bsm-mesh demo\n\n{tomli_w.dumps(content)}"
