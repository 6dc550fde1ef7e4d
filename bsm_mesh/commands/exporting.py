"""``bsm-mesh export``: a model file written for another program."""

from __future__ import annotations

from pathlib import Path

from bsm_mesh.errors import counted
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.text.terminal import say, say_json

ENDINGS = {"3dgrid": ".3dgrid", "abaqus": ".inp", "compas_dem": ".py", "lmgc90": ".py", "udec": ".dat"}


def export_model(path: Path, program: str, output: Path | None, *, as_json: bool, scripts: bool = True) -> None:
    """Write the model of a model file for another program, and say the features that it does not support.

    Parameters
    ----------
    path : Path
        The model file.
    program : str
        One of `ENDINGS`.
    output : Path or None
        The file to write; by default NAME_PROGRAM in the current folder.
    as_json : bool
        Print one JSON document instead of lines.
    scripts : bool
        Whether the model file may run a geometry script and name any path.
    """
    from bsm_mesh.converters.exports import export

    target = output or Path(f"{path.stem}_{program}{ENDINGS[program]}")
    loaded = load_model_file(path, scripts=scripts)
    left_out = export(loaded.model, program, target)
    if as_json:
        say_json({"file": str(target), "blocks": loaded.model.blocks.count, "left_out": list(left_out)})
        return
    for note in loaded.notes:
        say(f"mesh: {note}", err=True)
    say(f"written to {target}: {counted(loaded.model.blocks.count, 'block')} for {program}")
    for text in left_out:
        say(f"left out: {text}")
