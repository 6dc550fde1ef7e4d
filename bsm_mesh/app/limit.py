"""The command ``limit``: the linear program on a model file, its answer in words, the mechanism as VTU."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from bsm_mesh.app.added_files import AddedFiles
from bsm_mesh.app.build import load_model_file
from bsm_mesh.app.build_mesh import stdout_to_stderr
from bsm_mesh.app.tables import print_table
from bsm_mesh.app.terminal import say, say_json
from bsm_mesh.errors import ModelError
from bsm_mesh.model.model import Model
from bsm_mesh.model.notes import notes_of
from bsm_mesh.solve.limit.analysis import LimitAnalysis, limit_analysis, limit_tilt


def analyse_limit(
    path: Path,
    numbers: tuple[int, ...],
    tilt: str | None,
    output: Path | None,
    *,
    as_json: bool,
    scripts: bool = True,
) -> None:
    """Run the linear program on a model file, print what it says and proves, and write the mechanism."""
    if numbers and tilt:
        raise ModelError("limit: give --load or --tilt, not both")
    loaded = load_model_file(path, scripts=scripts)
    added = AddedFiles(output or loaded.output_folder)
    model = loaded.model
    with stdout_to_stderr():  # HiGHS complains there
        found = _with_live_loads(model, numbers) if numbers else limit_analysis(model)
        told: dict[str, Any] = {"admissible": found.admissible, "factor": _finite(found.factor)}
        if tilt:
            told["tilt"] = limit_tilt(model, clockwise=tilt == "left")
    file = None
    if found.mechanism.any():
        from bsm_mesh.converters.result_files import write_mechanism

        with added.file("limit.vtu") as draft:
            write_mechanism(model.blocks, found.mechanism, draft)
        file = added.folder.path / "limit.vtu"
    if as_json:
        notes = [*loaded.notes, *notes_of(model), str(found)]
        say_json({**told, "file": None if file is None else str(file), "notes": notes})
        return
    for note in loaded.notes:
        say(f"mesh: {note}", err=True)
    for note in notes_of(model):
        say(f"note: {note}", err=True)
    print_table(model.title or str(path), ("", ""), _rows(found, numbers, told.get("tilt"), tilt))
    say(f"{found}.")
    if numbers and found.admissible and found.factor < 1:
        say("A factor below 1: with the loads as given the blocks must move.")
    if file is not None:
        say(f"collapse mechanism written to {file}")


def _with_live_loads(model: Model, numbers: tuple[int, ...]) -> LimitAnalysis:
    """Return the analysis with the factor on the loads of these numbers, from 1, the others staying."""
    outside = [k for k in numbers if not 1 <= k <= len(model.loads)]
    if outside:
        raise ModelError(f"limit: there is no [[load]] number {outside[0]}; the model has {len(model.loads)}")
    live = [model.loads[k - 1] for k in numbers]
    dead = tuple(load for k, load in enumerate(model.loads) if k + 1 not in numbers)
    return limit_analysis(model.replace(loads=dead), live)


def _finite(factor: float) -> float | None:
    return factor if math.isfinite(factor) else None


def _rows(
    found: LimitAnalysis, numbers: tuple[int, ...], angle: float | None, side: str | None
) -> list[tuple[str, str]]:
    which = f"load {', '.join(map(str, numbers))}" if numbers else "weights and loads together"
    without = f", without load {', '.join(map(str, numbers))}" if numbers else ""
    factor = f"{found.factor:.6g}" if math.isfinite(found.factor) else "no limit"
    rows = [
        (f"statically{without}", "admissible" if found.admissible else "inadmissible"),
        ("contacts", str(found.contacts.count)),
        ("of them without a limit of strength", str(found.unlimited)),
        (f"greatest factor on {which}", factor),
    ]
    if angle is not None:
        rows.append((f"greatest further tilt to the {side}", f"{angle:.4f} degrees"))
    return rows
