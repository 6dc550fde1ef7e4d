"""Results from a folder and to one."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.certificate.certificate import arrays_file, read_evidence
from bsm_mesh.errors import ModelError, ResultsWarning
from bsm_mesh.folder.histories import with_histories
from bsm_mesh.folder.history import HISTORY, read_history
from bsm_mesh.folder.result_tables import USUAL, OutputForm
from bsm_mesh.folder.run_writer import RunWriter
from bsm_mesh.folder.saved_results import SavedResults, damage_told, find_results
from bsm_mesh.folder.shaking_files import read_shaking, with_times
from bsm_mesh.folder.space_stages import columns_in_space
from bsm_mesh.folder.summary import read_summary
from bsm_mesh.model.beside import Beside
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.modelfile.model_text import MODEL, Given, files_of_model
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.histories import Recorded
from bsm_mesh.results.records import StageResult, Status, StepRecord
from bsm_mesh.results.results import Results, StageResults
from bsm_mesh.results.spread import RouteEnd

SEVERAL_TIMES = 5


def save_results(results: Results, folder: Path, *, form: OutputForm = USUAL) -> Path:
    """Write all files of a run into `folder`, made if need be, in place of the former results.

    The model is written as ``model.toml`` with its blocks as ``mesh.vtu``.

    Parameters
    ----------
    results : Results
        The result.
    folder : Path
        Where to.
    form : OutputForm
        Which tables are written too, and how VTU files are compressed.

    Warns
    -----
    ResultsWarning
        Where the model cannot be written; it names the missing parts.

    Raises
    ------
    ModelError
        If the folder cannot be written to, or holds what bsm-mesh did not write.
    """
    with RunWriter(folder, _what_was_run(results), form=form) as writer:
        return writer.finish(results)


def _what_was_run(results: Results) -> Given:
    """Return the files of the model; warn where there are none."""
    if results.model is None or results.options is None:
        faults: tuple[str, ...] = ("these results were read from a folder, and do not hold their model",)
    else:
        try:
            return files_of_model(results.model, results.options)
        except ModelError as error:
            faults = error.faults
    warnings.warn(f"{MODEL} is not written: {'; '.join(faults)}", ResultsWarning, stacklevel=4)
    return {}


def load_results(folder: Path) -> Results:
    """Return the results in a folder: those of one run, also while another run replaces them.

    Raises
    ------
    ModelError
        If the folder holds no results, or they are damaged.
    """
    for _ in range(SEVERAL_TIMES):
        try:
            saved = SavedResults(folder)
        except OSError as error:
            raise ModelError(f"{folder} cannot be read: {error.strerror or error}") from error
        try:
            saved.check()
            with damage_told(folder):
                results = _load(saved)
                _refuse_strange_numbers(results, saved.folder)
            return results
        except ModelError:
            if read_summary(find_results(folder)) == saved.told:
                raise  # else another run has replaced them meanwhile
        except OSError as error:
            raise ModelError(f"{folder} cannot be read: {error.strerror or error}") from error
    raise ModelError(f"{folder}: its results are replaced again and again while they are read; read them later")


def _load(saved: SavedResults) -> Results:
    told = saved.told
    count = sum(stage["steps"] for stage in told["stages"])
    steps = read_history(saved.content(HISTORY), count, saved.folder / HISTORY)
    recorded = tuple(_recorded(one) for one in told.get("histories", ()))
    steps = with_histories(steps, recorded, saved.content, saved.folder)
    blocks = saved.blocks()
    stages = [_load_stage(saved, k, stage, steps, blocks) for k, stage in enumerate(told["stages"])]
    return Results(
        blocks=blocks,
        joint_names=tuple(told["joint_names"]),
        stages=StageResults(stages),
        scheme=told["scheme"],
        linear_solver=told["linear_solver"],
        tolerance=told["tolerance"],
        model_digest=told["model_hash"],
        title=told["title"],
        default_joint=told["default_joint"],
        recorded=recorded,
        finished=saved.finished,
        spread=tuple(_route_end(end) for end in told.get("spread", ())),
    )


def _refuse_strange_numbers(results: Results, folder: Path) -> None:
    """Raise where a stage refers to blocks or joints that are not there."""
    blocks, joints = results.blocks.count, len(results.joint_names)
    for stage in results.stages:
        contacts, supports = stage.contacts, stage.supports
        of_blocks = (contacts.block_a, contacts.block_b, supports.block, stage.unstable_blocks, stage.small_blocks)
        falls = np.array([fall.block for fall in stage.falls], dtype=np.int64)
        numbers = [(values, 0, blocks) for values in (*of_blocks, falls)] + [(contacts.joint, -1, joints)]
        if any(values.size and (values.min() < least or values.max() >= most) for values, least, most in numbers):
            raise ModelError(
                f"{folder} is damaged (stage '{stage.name}' refers to entries that are missing); run the model again"
            )


def _recorded(told: dict[str, Any]) -> Recorded:
    lists = {key: tuple(told.get(key, ())) for key in ("quantities", "units", "distances")}
    points = tuple(map(tuple, told.get("points", ())))
    measured = tuple(Beside(**one) for one in told.get("measured", ()))
    return Recorded(**{**told, **lists, "points": points, "measured": measured})


def _route_end(told: dict[str, Any]) -> RouteEnd:
    return RouteEnd(**{**told, "status": Status(told["status"]), "unstable_blocks": tuple(told["unstable_blocks"])})


def _load_stage(
    saved: SavedResults, number: int, told: dict[str, Any], steps: list[StepRecord], given: Blocks
) -> StageResult:
    shaking = read_shaking(told["shaking"], number, saved.content, saved.folder) if "shaking" in told else None
    if in_space(given):
        columns = columns_in_space(saved, number, given, bolts="bolts" in told)
    else:
        columns = _columns(saved, number, told, given)
    return StageResult(
        name=told["name"],
        status=Status(told["status"]),
        reason=told["reason"],
        **columns,
        **_water_of(saved, number, told),
        unstable_blocks=np.array(told["unstable_blocks"], dtype=np.int32),
        small_blocks=np.array(told.get("small_blocks", ()), dtype=np.int32),
        start_residual=told["start_residual"],
        residual=told["residual"],
        reference_weight=told["reference_weight"],
        steps=with_times(tuple(step for step in steps if step.stage == number), shaking),
        shaking=shaking,
        notes=tuple(told["notes"]),
        falls=tuple(_fall(fall, given) for fall in told.get("falls", ())),
        **_evidence(saved, number),
    )


def _columns(saved: SavedResults, number: int, told: dict[str, Any], given: Blocks) -> dict[str, Any]:
    """Return the fields of a stage in the plane that are arrays, from its grids."""
    from bsm_mesh.converters.bolt_files import bolts_of_grid
    from bsm_mesh.converters.contact_files import contacts_of_grid, supports_of_grid
    from bsm_mesh.converters.flow_files import flow_of_grid
    from bsm_mesh.converters.result_files import BOLTS, FLOW, ZONES, stage_file
    from bsm_mesh.converters.stress_components import tensors
    from bsm_mesh.converters.zone_files import zones_of_grid

    saved.content(stage_file("joints", number))  # follows from the others; whoever opens it elsewhere trusts it
    blocks, contacts, supports = (saved.grid(stage_file(kind, number)) for kind in ("blocks", "contacts", "supports"))
    cells, here, zones = blocks.cell_data, blocks.cell_data["block_id"], stage_file(ZONES, number)

    def whole(rows: Any) -> Any:
        """Return rows of the blocks that are there among zeros for those that are not."""
        values = np.zeros((given.count, *rows.shape[1:]), dtype=rows.dtype)
        values[here] = rows
        return values

    return {
        "present": whole(np.ones(len(here), dtype=bool)),
        "displacement": whole(np.column_stack([cells["displacement"][:, :2], cells["rotation"]])),
        "stage_displacement": whole(np.column_stack([cells["stage_displacement"][:, :2], cells["stage_rotation"]])),
        "origin": whole(cells["origin"]),
        "stress": whole(tensors(cells["stress"])),
        "stress_effective": whole(tensors(cells["stress_effective"])),
        "loads": whole(cells["load"]),
        "reactions": whole(cells["reaction"]),
        "water": whole(cells["water"]),
        "contacts": contacts_of_grid(contacts),
        "supports": supports_of_grid(supports),
        "bolts": bolts_of_grid(saved.grid(stage_file(BOLTS, number))) if "bolts" in told else BoltForces.none(),
        "flow": flow_of_grid(saved.grid(stage_file(FLOW, number)), told["flow"]) if "flow" in told else None,
        "zones": zones_of_grid(saved.grid(zones)) if zones in saved else None,
    }


def _fall(told: dict[str, Any], given: Blocks) -> Fall:
    origin = told.get("origin", given.moments.centroid[told["block"]].tolist())  # older results do not have it
    return Fall(**{**told, "origin": tuple(origin), "place": tuple(told["place"])})


def _water_of(saved: SavedResults, number: int, told: dict[str, Any]) -> dict[str, Any]:
    """Return the water table of a stage, the pressure under it, and that of joints with one of their own."""
    from bsm_mesh.converters.result_files import WATER, stage_file

    name, table = stage_file(WATER, number), saved.water_table(number)
    unknown = np.full(len(table), np.nan)  # schema version 3 did not write it
    gradient = saved.grid(name).cell_data.get("pressure_gradient", unknown) if name in saved else unknown
    own = told.get("joint_water", {})
    joints = [own.get(joint, np.nan) for joint in saved.told["joint_names"]]
    return {
        "water_table": table,
        "water_gradient": gradient,
        "joint_water": np.array(joints, dtype=np.float64),
    }


def _evidence(saved: SavedResults, number: int) -> dict[str, Any]:
    """Return evidence and proof of a stage; nothing where results without any were saved."""
    if arrays_file(number) not in saved:
        return {}
    return dict(zip(("evidence", "proof"), read_evidence(saved.content(arrays_file(number))), strict=True))
