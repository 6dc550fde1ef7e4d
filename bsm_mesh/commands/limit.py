"""The command ``limit``: the linear program on a model file, its answer in words, the mechanism as VTU."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from bsm_mesh.errors import ModelError
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import Load
from bsm_mesh.model.model import Model
from bsm_mesh.model.notes import notes_of
from bsm_mesh.model.residual import residual_note
from bsm_mesh.modelfile.build import LoadedModel, load_model_file
from bsm_mesh.solve.limit_analysis import LimitAnalysis, StrengthLimit, limit_analysis, limit_tilt, strength_limit
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.tables import print_table
from bsm_mesh.text.terminal import say, say_json
from bsm_mesh.three_d.limit.of_model import SpaceLimit


def analyse_limit(
    path: Path,
    output: Path | None,
    progress: Progress,
    *,
    stage: str | None,
    numbers: tuple[int, ...],
    tilt: str | None,
    strength: bool,
    joints: tuple[str, ...],
    rocks: bool | None,
    bolts: bool,
    as_json: bool,
    scripts: bool = True,
) -> None:
    """Run linear programs on a model file, print their answers and proofs, and write the mechanism."""
    if bool(numbers) + bool(tilt) + strength > 1:
        raise ModelError("limit: give one of --load, --tilt and --strength")
    if not strength and (joints or bolts or rocks is not None):
        raise ModelError("limit: --joints, --rocks and --bolts say what --strength divides: give --strength too")
    found: LimitAnalysis | StrengthLimit | SpaceLimit
    with progress:
        loaded = load_model_file(path, progress.report, scripts=scripts, space=True)
        added = AddedFiles(output or loaded.output_folder)
        model = loaded.model
        if tilt and in_space(model.blocks):
            raise ModelError("limit: --tilt is for the plane; in space give [gravity] with its trend")
        progress.report("limit analysis")
        if strength:
            rocks = not joints if rocks is None else rocks
            found = strength_limit(model, joints or None, rocks=rocks, bolts=bolts, stage=stage)
        else:
            dead, live = _split(model, numbers) if numbers else (model, None)
            found = limit_analysis(dead, live, stage=stage)
        angle = limit_tilt(model, stage=stage, clockwise=tilt == "left") if tilt else None
    if isinstance(found, SpaceLimit):
        _tell(loaded, added, found, _space_told(found), _space_rows(found, numbers, strength), as_json)
        return
    if isinstance(found, StrengthLimit):
        _tell(loaded, added, found, _strength_told(found), _strength_rows(found), as_json)
        return
    told: dict[str, Any] = {"stage": found.stage, "admissible": found.admissible, "factor": _finite(found.factor)}
    if angle is not None:
        told["tilt"] = angle
    _tell(loaded, added, found, told, _rows(found, numbers, angle, tilt), as_json)
    if found.admissible and not as_json:
        say(_meaning(found.factor, f"load {', '.join(map(str, numbers))}" if numbers else "weights and loads"))
    if numbers and found.admissible and found.factor < 1 and not as_json:
        say("A factor below 1: with the loads as given the blocks must move.")


def _tell(
    loaded: LoadedModel,
    added: AddedFiles,
    found: LimitAnalysis | StrengthLimit | SpaceLimit,
    told: dict[str, Any],
    rows: list[tuple[str, str]],
    as_json: bool,
) -> None:
    """Print an answer, as JSON or as a table and in words, and write its mechanism where there is one."""
    model, file = loaded.model, None
    if found.mechanism.any():
        from bsm_mesh.converters.result_files import write_mechanism
        from bsm_mesh.converters.three_d import write_mechanism as write_in_space

        with added.file("limit.vtu") as draft:
            if in_space(model.blocks):
                write_in_space(model.blocks, found.mechanism, found.present, draft)
            else:
                write_mechanism(model.blocks, found.mechanism, found.present, draft)
        file = added.folder.path / "limit.vtu"
    notes = [*notes_of(model), *([residual] if (residual := residual_note(model)) else [])]
    if as_json:
        notes = [*loaded.notes, *notes, str(found)]
        say_json({**told, "file": None if file is None else str(file), "notes": notes})
        return
    for note in loaded.notes:
        say(f"mesh: {note}", err=True)
    for note in notes:
        say(f"note: {note}", err=True)
    print_table(model.title or str(loaded.path), ("", ""), rows)
    say(f"{found}.")
    if file is not None:
        say(f"collapse mechanism written to {file}")


def _space_told(found: SpaceLimit) -> dict[str, Any]:
    """Return the JSON record of an answer for polyhedra."""
    return {
        "stage": found.stage,
        "admissible": found.admissible,
        "factor": _finite(found.factor),
        "beyond": _finite(found.beyond),
    }


def _space_rows(found: SpaceLimit, numbers: tuple[int, ...], strength: bool) -> list[tuple[str, str]]:
    """Return the table of an answer for polyhedra."""
    which = f"load {', '.join(map(str, numbers))}" if numbers else "weights and loads together"
    return [
        ("stage", found.stage),
        ("contact points", str(found.points)),
        ("of them without a limit of strength", str(found.unlimited)),
        _factor_row("the strength" if strength else which, found.factor),
    ]


def _split(model: Model, numbers: tuple[int, ...]) -> tuple[Model, list[Load]]:
    """Return the model without its loads of these numbers, from 1, and those loads."""
    outside = [k for k in numbers if not 1 <= k <= len(model.loads)]
    if outside:
        raise ModelError(f"limit: there is no [[load]] number {outside[0]}; the model has {len(model.loads)}")
    live = [model.loads[k - 1] for k in numbers]
    dead = tuple(load for k, load in enumerate(model.loads) if k + 1 not in numbers)
    return model.replace(loads=dead), live


def _finite(factor: float) -> float | None:
    """Return a factor; None where it is infinite."""
    return factor if math.isfinite(factor) else None


def _strength_told(found: StrengthLimit) -> dict[str, Any]:
    """Return the JSON record of a factor of strength."""
    return {
        "stage": found.stage,
        "factor": _finite(found.factor),
        "beyond": _finite(found.beyond),
        "proved": found.proof.witness is not None,
        "programs": found.programs,
        "seconds": round(found.seconds, 3),
    }


def _strength_rows(found: StrengthLimit) -> list[tuple[str, str]]:
    """Return the table of a factor of strength."""
    return [
        ("stage", found.stage),
        _factor_row("the strength", found.factor),
        ("contacts", str(found.contacts.count)),
        ("of them without a limit of strength", str(found.unlimited)),
        ("linear programs", f"{found.programs} in {found.seconds:.2g} s"),
    ]


def _factor_row(which: str, factor: float) -> tuple[str, str]:
    return f"greatest factor on {which}", f"{factor:.6g}" if math.isfinite(factor) else "no limit"


def _meaning(factor: float, which: str) -> str:
    """Return the meaning of a factor of limit analysis, in one sentence."""
    if not math.isfinite(factor):
        return (
            f"No limit: for every factor on {which}, statics alone does not prove that blocks move; friction grows "
            "with it. That is no factor of safety (bsm-mesh safety)."
        )
    return (
        f"Beyond {factor:.4g} times {which} the blocks must move, whatever their stiffness; they may well move before: "
        "an upper bound, no factor of safety (bsm-mesh safety)."
    )


def _rows(
    found: LimitAnalysis, numbers: tuple[int, ...], angle: float | None, side: str | None
) -> list[tuple[str, str]]:
    which = f"load {', '.join(map(str, numbers))}" if numbers else "weights and loads together"
    without = f", without load {', '.join(map(str, numbers))}" if numbers else ""
    admitted = "yes (statically admissible)" if found.admissible else "no (statically inadmissible)"
    rows = [
        ("stage", found.stage),
        (f"can forces within strength balance the loads{without}?", admitted),
        ("contacts", str(found.contacts.count)),
        ("of them without a limit of strength", str(found.unlimited)),
        _factor_row(which, found.factor),
    ]
    if angle is not None:
        rows.append((f"greatest further tilt to the {side}", f"{angle:.4f} degrees"))
    return rows
