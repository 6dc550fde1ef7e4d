"""summary.json: the outcome of a run, and the checksum of every file that it wrote."""

from __future__ import annotations

import hashlib
import json
import os
from collections import Counter
from dataclasses import asdict
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.folder.older_results import NEXT, brought_up
from bsm_mesh.folder.own_files import SUMMARY, is_inside
from bsm_mesh.folder.shaking_files import shaking_summary
from bsm_mesh.model.kinds import in_space
from bsm_mesh.movements import translations
from bsm_mesh.reading import as_typed
from bsm_mesh.results.bolts import BoltStatus
from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.movement import greatest_displacement, verdict_in_words
from bsm_mesh.results.records import StageResult, Status
from bsm_mesh.results.results import Results
from bsm_mesh.results.spread import is_near_limit
from bsm_mesh.results.stress import extreme_stresses
from bsm_mesh.version import __version__

SCHEMA_VERSION = 4
VERSIONED = ("numpy", "scipy", "numba", "vtk")
PROGRAM = "bsm-mesh"
NUMBER = (int, float)
NEEDED: dict[str, tuple[type, ...]] = {
    "title": (str,),
    "stages": (list,),
    "joint_names": (list,),
    "default_joint": (str, type(None)),
    "scheme": (str,),
    "linear_solver": (str,),
    "tolerance": NUMBER,
    "model_hash": (str,),
    "status": (str,),
    "files": (dict,),
}
OF_A_STAGE: dict[str, tuple[type, ...]] = {
    "name": (str,),
    "status": (str,),
    "reason": (str,),
    "steps": (int,),
    "start_residual": NUMBER,
    "residual": NUMBER,
    "reference_weight": NUMBER,
    "unstable_blocks": (list,),
    "notes": (list,),
}


def summary(results: Results) -> dict[str, Any]:
    """Return what ``summary.json`` holds: versions, verdict, and the numbers of every stage."""
    return {
        "schema_version": SCHEMA_VERSION,
        "versions": versions(),
        "title": results.title,
        "model_hash": results.model_digest,
        "scheme": results.scheme,
        "linear_solver": results.linear_solver,
        "tolerance": results.tolerance,
        "status": results.status.value,
        "unstable_blocks": results.unstable_blocks.tolist(),
        **({"dimensions": 3} if in_space(results.blocks) else {}),
        "blocks": results.blocks.count,
        "joint_names": list(results.joint_names),
        "default_joint": results.default_joint,
        "stages": [_stage_summary(results, stage) for stage in results.stages],
        **({"histories": [asdict(one) for one in results.recorded]} if results.recorded else {}),
        **_spread_summary(results),
    }


def _spread_summary(results: Results) -> dict[str, Any]:
    if not results.spread:
        return {}
    return {"spread": [asdict(end) for end in results.spread], "near_limit": is_near_limit(results.spread)}


def versions() -> dict[str, str]:
    """Return the versions of the libraries that change the digits of results, and of the writer of files."""
    return {PROGRAM: __version__, **dict(_versions())}


@cache
def code_digest() -> str:
    """Return a SHA-256 of the program's own source, and of the versions of libraries that change digits of results.

    A checkout may be changed under one version: earlier results are then of another program.
    """
    state = hashlib.sha256(repr(versions()).encode())
    root = Path(__file__).parents[1]
    folders = os.walk(root, followlinks=True)  # in a checkout some folders are links
    for path in sorted(os.path.join(folder, name) for folder, _, names in folders for name in names):
        if path.endswith(".py"):
            state.update(f"{os.path.relpath(path, root)}\n".encode())
            state.update(Path(path).read_bytes())
    return state.hexdigest()


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    return tuple((name, metadata.version(name)) for name in VERSIONED)


def _stage_summary(results: Results, stage: StageResult) -> dict[str, Any]:
    blocks, own = results.blocks, stage.joint_water
    joint_water = {name: float(p) for name, p in zip(results.joint_names, own, strict=True) if not np.isnan(p)}
    most_compressive, most_tensile, unknown = extreme_stresses(blocks, stage)
    return {
        "name": stage.name,
        "status": stage.status.value,
        "verdict": verdict_in_words(blocks, stage),
        "reason": stage.reason,
        "steps": len(stage.steps),
        "methods": dict(Counter(step.method for step in stage.steps)),
        "newton_iterations": sum(step.newton_iterations for step in stage.steps),
        "factorizations": sum(step.factorizations for step in stage.steps),
        "start_residual": stage.start_residual,
        "residual": stage.residual,
        "reference_weight": stage.reference_weight,
        "blocks": int(stage.present.sum()),
        "max_displacement": stage.max_displacement,
        "max_stage_displacement": stage.max_stage_displacement,
        **({} if stage.zones is None else {"max_zone_displacement": greatest_displacement(stage)}),
        "most_compressive_stress": most_compressive,
        "most_tensile_stress": most_tensile,
        "blocks_of_unknown_stress": unknown,
        "unstable_blocks": stage.unstable_blocks.tolist(),
        **({"small_blocks": stage.small_blocks.tolist()} if stage.small_blocks.size else {}),
        **({"falls": [asdict(fall) for fall in stage.falls]} if stage.falls else {}),
        "contacts": len(stage.contacts.length),
        **({"bolts": _bolt_summary(stage)} if stage.bolts.count else {}),
        "total_load": stage.total_load.tolist(),
        "total_water": translations(stage.water).sum(axis=0).tolist(),
        **({"joint_water": joint_water} if joint_water else {}),
        **({"flow": flow_summary(stage.flow)} if stage.flow is not None else {}),
        **({"shaking": shaking_summary(stage.shaking)} if stage.shaking is not None else {}),
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


def flow_summary(flow: FlowResult) -> dict[str, Any]:
    """Return the entries of the summary for a flow."""
    return {
        "through": flow.through,
        "leaving": dict(zip(flow.places, flow.leaving.tolist(), strict=True)),
        "places": list(flow.places),
        "nodes": len(flow.point),
        "imbalance": flow.imbalance,
        "rounds": flow.rounds,
        "change": flow.change,
    }


def fingerprint(path: Path) -> dict[str, Any]:
    """Return size and checksum of a file, as the summary lists them."""
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        return {"bytes": file.tell(), "sha256": digest}


def summary_text(results: Results, run: int, files: dict[str, dict[str, Any]]) -> str:
    """Return the content of ``summary.json``.

    Parameters
    ----------
    results : Results
        The result, so far where the run is not finished.
    run : int
        The how-manieth run into its folder it is.
    files : mapping of str to fingerprint
        All files that the run wrote but this one. Of an unfinished run those that do not change any more, and
        growing tables as at the end of the last stage.
    """
    told = {**summary(results), "run": run, "files": dict(sorted(files.items()))}
    return json.dumps({**told, "checksum": _checksum(told)}, indent=2) + "\n"


def _of_another_version(path: Path, told: dict[str, Any]) -> str:
    """Return what to do with results whose files this program does not know."""
    version, written = told["schema_version"], told.get("versions")
    by = f" by bsm-mesh {written[PROGRAM]!s:.20}" if isinstance(written, dict) and PROGRAM in written else ""
    is_newer = isinstance(version, int) and version > SCHEMA_VERSION
    cure = "update bsm-mesh" if is_newer else "run its model.toml again"
    here = f"bsm-mesh {__version__} reads {' and '.join(map(str, (*NEXT, SCHEMA_VERSION)))}"
    return f"{path} was written{by} with schema version {version!s:.20}; {here}: {cure}"


def _checksum(told: dict[str, Any]) -> str:
    """Return the SHA-256 of a summary's content, however it is laid out."""
    return hashlib.sha256(json.dumps(told, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def finished_stages(folder: Path) -> list[str]:
    """Return the names of the finished stages of a run that is not at its end; none where there is no such run."""
    try:
        told = read_summary(folder)
    except ModelError:
        return []
    return [stage["name"] for stage in told["stages"]] if told["status"] == Status.UNFINISHED else []


def read_summary(folder: Path) -> dict[str, Any]:
    """Return the content of ``summary.json``; that of an older schema version as the present one would tell it.

    Raises
    ------
    ModelError
        If the folder holds no results of a version that is known, or they were changed.
    """
    path = folder / SUMMARY
    if not path.is_file():
        raise ModelError(f"{folder} holds no results (no {SUMMARY}); give the output folder of a run")
    try:
        told: Any = json.loads(path.read_text(encoding="utf-8"))
        json.dumps(told, ensure_ascii=False).encode()  # half a character can be written to no page
    except OSError as error:
        raise ModelError(f"{path} cannot be read: {error.strerror or error}") from None
    except (ValueError, RecursionError):  # no JSON, no UTF-8, a number of thousands of digits
        raise ModelError(f"{path} is damaged; run the model again") from None
    if isinstance(told, dict) and "study" in told:
        raise ModelError(
            f"{path} is of a study; give the output folder of a run, or type `{as_typed('report', folder)}`"
        )
    if not isinstance(told, dict) or "schema_version" not in told:
        raise ModelError(f"{path} is not from a run of bsm-mesh; give the output folder of a run")
    version = told["schema_version"]
    if not isinstance(version, int) or version not in (*NEXT, SCHEMA_VERSION):
        raise ModelError(_of_another_version(path, told))
    if not set(told) >= {*NEEDED} or not told["stages"]:
        raise ModelError(f"{path} is not complete; run the model again")
    if told.pop("checksum", None) != _checksum(told):
        raise ModelError(f"{path} was changed after the run; run the model again")
    if not _is_of_a_run(told):
        raise ModelError(f"{path} is damaged; run the model again")
    return brought_up(told)


def _is_of_a_run(told: dict[str, Any]) -> bool:
    """Return whether every entry is of its kind: a right checksum proves nothing else."""
    known = {status.value for status in Status}
    if not _are(told, NEEDED) or told["status"] not in known or not _texts(told["joint_names"]):
        return False
    for stage in told["stages"]:
        if not isinstance(stage, dict) or not _are(stage, OF_A_STAGE) or stage["status"] not in known:
            return False
        if not isinstance(stage.get("verdict", ""), str):  # older results do not have it
            return False
        if stage["steps"] < 0 or not _texts(stage["notes"]) or not _numbers_of_blocks(stage["unstable_blocks"]):
            return False
    return all(is_inside(name) and _is_fingerprint(told) for name, told in told["files"].items())


def _are(told: dict[str, Any], kinds: dict[str, tuple[type, ...]]) -> bool:
    return all(isinstance(told.get(name), kind) and not isinstance(told[name], bool) for name, kind in kinds.items())


def _texts(values: list[Any]) -> bool:
    return all(isinstance(value, str) for value in values)


def _numbers_of_blocks(values: list[Any]) -> bool:
    return all(isinstance(value, int) and value >= 0 for value in values)


def _is_fingerprint(told: Any) -> bool:
    listed = isinstance(told, dict) and isinstance(told.get("bytes"), int) and isinstance(told.get("sha256"), str)
    return listed and told["bytes"] >= 0
