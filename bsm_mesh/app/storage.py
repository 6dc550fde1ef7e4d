"""Results to a folder and back: VTU and PVD, history.csv, summary.json."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Sequence
from dataclasses import asdict, fields
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.files import make_folder, remove, whole_file, write_text
from bsm_mesh.reading import refuse_special
from bsm_mesh.results.bolts import BoltForces, BoltStatus
from bsm_mesh.results.records import Results, StageResult, Status, StepRecord
from bsm_mesh.results.stress import principal_stresses

if TYPE_CHECKING:
    from bsm_mesh.converters.result_files import Instant

SCHEMA_VERSION = 1
VERSIONED = ("numpy", "scipy", "numba", "vtk")


def refuse_folder(folder: Path) -> None:
    """Raise `ModelError` where a folder cannot be made or written to: better before a long run than after it.

    Nothing is made; a disk that fills up later is found out later.
    """
    there = next((place for place in (folder, *folder.absolute().parents) if os.path.lexists(place)), folder)
    if not there.is_dir():
        raise ModelError(f"cannot write results to {folder}: {there} is not a folder; choose another folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise ModelError(f"cannot write results to {folder}: {there} is not writable; choose another folder")


def save_results(
    results: Results, folder: Path, model_file: str | None = None, instants: Sequence[Instant] | None = None
) -> Path:
    """Write all files of a run into `folder`, made if need be; ``summary.json`` last, as the mark of a complete run.

    Parameters
    ----------
    results : Results
        What came out.
    folder : Path
        Where to.
    model_file : str, optional
        Content of ``model.toml``, the model as run.
    instants : sequence of Instant, optional
        Snapshots that are in the folder already.

    Raises
    ------
    ModelError
        If the folder cannot be made or written to.
    """
    from bsm_mesh.converters.result_files import write_series

    try:
        make_folder(folder)
        remove(folder / "summary.json")  # while the files change the run is not complete
        write_series(results, folder, instants)
        _write_history(results, folder / "history.csv")
        if model_file is not None:
            write_text(folder / "model.toml", model_file)
        write_text(folder / "summary.json", json.dumps(summary(results), indent=2) + "\n")
    except OSError as error:
        raise ModelError(
            f"cannot write results to {folder}: {error.strerror or error}; choose another folder"
        ) from error
    return folder


def summary(results: Results) -> dict[str, Any]:
    """Return what ``summary.json`` holds: versions, verdict, and the numbers of every stage."""
    return {
        "schema_version": SCHEMA_VERSION,
        "versions": {name: metadata.version(name) for name in VERSIONED},
        "title": results.title,
        "model_hash": results.model_digest,
        "scheme": results.scheme,
        "linear_solver": results.linear_solver,
        "tolerance": results.tolerance,
        "status": results.status.value,
        "unstable_blocks": results.unstable_blocks.tolist(),
        "blocks": results.blocks.count,
        "joint_names": list(results.joint_names),
        "stages": [_stage_summary(stage) for stage in results.stages],
    }


def _stage_summary(stage: StageResult) -> dict[str, Any]:
    sigma_1, sigma_3 = principal_stresses(stage.stress)
    return {
        "name": stage.name,
        "status": stage.status.value,
        "reason": stage.reason,
        "steps": len(stage.steps),
        "newton_iterations": sum(step.newton_iterations for step in stage.steps),
        "factorizations": sum(step.factorizations for step in stage.steps),
        "start_residual": stage.start_residual,
        "residual": stage.residual,
        "reference_weight": stage.reference_weight,
        "blocks": int(stage.present.sum()),
        "max_displacement": stage.max_displacement,
        "max_stage_displacement": stage.max_stage_displacement,
        "most_compressive_stress": float(sigma_1.min()),
        "most_tensile_stress": float(sigma_3.max()),
        "unstable_blocks": stage.unstable_blocks.tolist(),
        "contacts": len(stage.contacts.length),
        **({"bolts": _bolt_summary(stage)} if stage.bolts.count else {}),
        "total_load": stage.total_load.tolist(),
        "total_water": stage.water[:, :2].sum(axis=0).tolist(),
        "uplifted_blocks": stage.uplifted_blocks.tolist(),
        "total_reaction": stage.total_reaction.tolist(),
        "notes": list(stage.notes),
        "seconds": stage.seconds,
    }


def _bolt_summary(stage: StageResult) -> list[dict[str, Any]]:
    bolts = stage.bolts
    used = np.zeros(bolts.count)
    np.maximum.at(used, bolts.bolt, bolts.utilisation)
    greatest, head, pressure = bolts.greatest_force, bolts.head_force, bolts.support_pressure
    return [
        {
            "name": name,
            "status": BoltStatus(int(bolts.status[k])).name.lower(),
            "greatest_force": float(greatest[k]),
            "utilisation": float(used[k]),
            "head_force": float(head[k]),
            "support_pressure": None if np.isnan(pressure[k]) else float(pressure[k]),
        }
        for k, name in enumerate(bolts.names)
    ]


def _write_history(results: Results, path: Path) -> None:
    with whole_file(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(StepRecord)])
        writer.writeheader()
        writer.writerows(asdict(step) for stage in results.stages for step in stage.steps)


def _read_history(path: Path, count: int) -> list[StepRecord]:
    kinds: dict[str, Any] = {field.name: int if field.type == "int" else float for field in fields(StepRecord)}
    refuse_special(path)
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        steps = [StepRecord(**{name: kind(row[name]) for name, kind in kinds.items()}) for row in rows]
    except FileNotFoundError:
        raise ModelError(f"{path}: there is no such file; run the model again") from None
    except (KeyError, TypeError, ValueError):
        steps = []
    if len(steps) != count:
        raise ModelError(f"{path} is damaged; run the model again")
    return steps


def load_results(folder: Path) -> Results:
    """Return the results that `save_results` wrote."""
    from bsm_mesh.converters.result_files import blocks_of_grid, read_stage_grids

    told = read_summary(folder)
    steps = _read_history(folder / "history.csv", sum(stage["steps"] for stage in told["stages"]))
    blocks = blocks_of_grid(read_stage_grids(folder, 0)[0])
    stages = [_load_stage(folder, k, stage, steps, blocks.count) for k, stage in enumerate(told["stages"])]
    return Results(
        blocks=blocks,
        joint_names=tuple(told["joint_names"]),
        stages=tuple(stages),
        scheme=told["scheme"],
        linear_solver=told["linear_solver"],
        tolerance=told["tolerance"],
        model_digest=told["model_hash"],
        title=told["title"],
    )


def read_summary(folder: Path) -> dict[str, Any]:
    """Return the content of ``summary.json``.

    Raises
    ------
    ModelError
        If the folder holds no complete results of this version.
    """
    path = folder / "summary.json"
    refuse_special(path)
    try:
        told: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        raise ModelError(f"{folder} holds no results (no summary.json); give the output folder of a run") from None
    except (json.JSONDecodeError, UnicodeDecodeError):
        raise ModelError(f"{path} is damaged; run the model again") from None
    if not isinstance(told, dict) or "schema_version" not in told:
        raise ModelError(f"{path} is not from a run of bsm-mesh; give the output folder of a run")
    if told["schema_version"] != SCHEMA_VERSION:
        raise ModelError(f"{path} has schema version {told['schema_version']}; this is {SCHEMA_VERSION}: run again")
    if not {"title", "stages", "joint_names", "scheme", "tolerance"} <= set(told) or not told["stages"]:
        raise ModelError(f"{path} is not complete; run the model again")
    return told


def _load_stage(folder: Path, number: int, told: dict[str, Any], steps: list[StepRecord], count: int) -> StageResult:
    from bsm_mesh.converters.result_files import (
        contacts_of_grid,
        read_bolts,
        read_stage_grids,
        read_water_table,
        supports_of_grid,
    )

    blocks, contacts, supports = read_stage_grids(folder, number)
    cells, here = blocks.cell_data, blocks.cell_data["block_id"]

    def whole(rows: Any) -> Any:
        """Return rows of the blocks that are there among zeros for those that are not."""
        values = np.zeros((count, *rows.shape[1:]), dtype=rows.dtype)
        values[here] = rows
        return values

    return StageResult(
        name=told["name"],
        status=Status(told["status"]),
        reason=told["reason"],
        present=whole(np.ones(len(here), dtype=bool)),
        displacement=whole(np.column_stack([cells["displacement"][:, :2], cells["rotation"]])),
        stage_displacement=whole(np.column_stack([cells["stage_displacement"][:, :2], cells["stage_rotation"]])),
        origin=whole(cells["origin"]),
        stress=whole(_tensors(cells["stress"])),
        stress_effective=whole(_tensors(cells["stress_effective"])),
        loads=whole(cells["load"]),
        reactions=whole(cells["reaction"]),
        water=whole(cells["water"]),
        water_table=read_water_table(folder, number),
        contacts=contacts_of_grid(contacts),
        supports=supports_of_grid(supports),
        bolts=read_bolts(folder, number) if "bolts" in told else BoltForces.none(),
        unstable_blocks=np.array(told["unstable_blocks"], dtype=np.int32),
        start_residual=told["start_residual"],
        residual=told["residual"],
        reference_weight=told["reference_weight"],
        steps=tuple(step for step in steps if step.stage == number),
        notes=tuple(told["notes"]),
    )


def _tensors(six: FloatArray) -> FloatArray:
    """Return the tensors (k, 2, 2) of six components XX YY ZZ XY YZ XZ (k, 6)."""
    xx, yy, _, xy, _, _ = six.T
    return np.stack([np.stack([xx, xy], axis=1), np.stack([xy, yy], axis=1)], axis=1)
