"""certificate.json with certificate_0000.npz ...: the ground of every verdict, to be checked without this package."""

from __future__ import annotations

import io
import json
from collections import Counter
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.certificate.verify_certificate import read_arrays
from bsm_mesh.files import whole_file, write_text
from bsm_mesh.model.kinds import in_space
from bsm_mesh.movements import distances
from bsm_mesh.results.evidence import Evidence, Proof, Witness
from bsm_mesh.results.records import StageResult, Status, SupportForces
from bsm_mesh.results.results import Results

CERTIFICATE = "certificate.json"
SCHEMA_VERSION = 2
GRAVITY = 9.81  # m/s2: speeds are kept as heights of fall
OF_PROOF = "proof_"
POLYGONS = ("vertices", "offsets")
POLYHEDRA = ("vertices", "face_vertices", "face_offsets", "face_cells", "face_joint", "cell_block", "rock")
OF_SPACE = ("stage_displacement", "origin", "stress", "stress_effective", "loads")


def arrays_file(number: int) -> str:
    """Return the name of the file with the arrays of a stage."""
    return f"certificate_{number:04d}.npz"


def write_arrays(results: Results, number: int, folder: Path) -> list[str]:
    """Write the arrays of a stage's certificate, if it has evidence; return the names of the files."""
    stage = results.stages[number]
    if stage.evidence is None:
        return []
    arrays = certificate_arrays(results, stage)
    with whole_file(folder / arrays_file(number)) as draft:
        np.savez(draft, **arrays)
    return [arrays_file(number)]


def solved_stages(folder: Path) -> list[str]:
    """Return the names of the files with arrays of stages in a folder: they are the first of a stage to be written."""
    return sorted(path.name for path in folder.glob("certificate_*.npz"))


def write_certificate(results: Results, folder: Path) -> list[str]:
    """Write the certificate of all stages, their arrays apart; return the names of the files."""
    if any(stage.evidence is None for stage in results.stages):
        return []
    write_text(folder / CERTIFICATE, json.dumps(certificate(results), indent=1, allow_nan=False) + "\n")
    return [CERTIFICATE]


def certificate(results: Results) -> dict[str, Any]:
    """Return the content of ``certificate.json``."""
    return {
        "schema_version": SCHEMA_VERSION,
        "title": results.title,
        "model_hash": results.model_digest,
        "scheme": results.scheme,
        "tolerance": results.tolerance,
        "joint_names": list(results.joint_names),
        "stages": [_stage(stage, number) for number, stage in enumerate(results.stages)],
    }


def ground_of(stage: StageResult) -> str:
    """Return the ground of the verdict of a stage."""
    if stage.status.is_at_rest:
        return "equilibrium"
    if stage.status is not Status.UNSTABLE:
        return "best state"
    return "proved" if stage.proof is not None and stage.proof.witness is not None else "followed"


def _stage(stage: StageResult, number: int) -> dict[str, Any]:
    assert stage.evidence is not None
    told: dict[str, Any] = {
        "name": stage.name,
        "verdict": stage.status.value,
        "ground": ground_of(stage),
        "reason": stage.reason,
        "arrays": arrays_file(number),
        "reference_weight": stage.reference_weight,
        "residual": stage.residual,
        "steps": len(stage.steps),
        "methods": methods_of(stage),
        "unstable_blocks": stage.unstable_blocks.tolist(),
    }
    if stage.status is Status.UNSTABLE:
        told["movement"] = movement_of(stage)
    return told | words_of(stage)


def words_of(stage: StageResult) -> dict[str, Any]:
    """Return the parts of a stage's evidence that are no arrays: the laws, and the words and laws of the proof."""
    assert stage.evidence is not None
    told: dict[str, Any] = {"laws": list(stage.evidence.laws)}
    if stage.proof is not None:
        witness = stage.proof.witness
        told["proof"] = {"text": stage.proof.text, **({} if witness is None else {"laws": list(witness.laws)})}
    return told


def methods_of(stage: StageResult) -> list[dict[str, Any]]:
    """Return the methods of a stage, in their order: how many steps each ended, or tried without success."""
    ended = Counter(step.method for step in stage.steps)
    in_vain = Counter(name for step in stage.steps for name in step.tried)
    order = dict.fromkeys(name for step in stage.steps for name in (*step.tried, step.method))
    return [{"name": name, "ended": ended[name], "in_vain": in_vain[name]} for name in order]


def movement_of(stage: StageResult) -> list[dict[str, Any]]:
    """Return how far every unstable block moved [m], and how fast it is [m/s] where that is known."""
    evidence = stage.evidence
    speed: FloatArray | None = None
    if evidence is not None and evidence.velocity is not None:
        speed = np.sqrt(GRAVITY) * distances(evidence.velocity)
    moved = distances(stage.displacement)
    return [
        {"block": block, "moved": float(moved[block]), "speed": None if speed is None else float(speed[block])}
        for block in stage.unstable_blocks.tolist()
    ]


def certificate_arrays(results: Results, stage: StageResult) -> dict[str, Any]:
    """Return the arrays of a stage: where its blocks are, all forces on them, and those in contacts and supports.

    Where displacements are small forces act where blocks were given.
    """
    evidence, blocks = stage.evidence, results.blocks
    assert evidence is not None
    applied = stage.loads - stage.water
    applied[:, : evidence.weight.shape[1]] -= evidence.weight
    position = (stage.origin + stage.displacement) * (not results.has_small_displacements)
    arrays = {
        **{name: getattr(blocks, name) for name in (POLYHEDRA if in_space(blocks) else POLYGONS)},
        "present": stage.present,
        "position": position,
        "displacement": stage.displacement,
        "water": stage.water,
        "applied": applied,
        "reactions": stage.reactions,
        **_columns("contact_", stage.contacts, type(stage.contacts)),
        **_columns("support_", stage.supports, SupportForces),
        **dict(zip(("bolt_block", "bolt_point", "bolt_force"), stage.bolts.on_blocks(), strict=True)),
        **_columns("", evidence, Evidence),
    }
    words = words_of(stage)
    if in_space(blocks):  # they are read from here, as polygons are from their grids
        arrays |= {name: getattr(stage, name) for name in OF_SPACE}
        words["blocks"] = {"rock_names": list(blocks.rock_names), "joint_names": list(blocks.joint_names)}
    arrays["told"] = np.array(json.dumps(words))  # so that a finished stage of an unfinished run is whole
    if stage.proof is not None and stage.proof.witness is not None:
        arrays |= _columns(OF_PROOF, stage.proof.witness, Witness)
    return arrays


def _columns(prefix: str, table: Any, kind: type) -> dict[str, Any]:
    """Return the arrays of a record by their names."""
    columns = {f"{prefix}{field.name}": getattr(table, field.name) for field in fields(kind)}
    return {name: values for name, values in columns.items() if isinstance(values, np.ndarray)}


def read_evidence(content: bytes) -> tuple[Evidence, Proof | None]:
    """Return evidence and proof of a stage from the content of its arrays."""
    arrays = read_arrays(io.BytesIO(content))
    told = json.loads(str(arrays["told"]))
    names = [field.name for field in fields(Evidence) if field.name in arrays]
    slid = {"slip_path": np.zeros(len(arrays["law"]))}  # schema version 3: no law asked for it
    evidence = Evidence(laws=tuple(told["laws"]), **{**slid, **{name: arrays[name] for name in names}})
    if "proof" not in told:
        return evidence, None
    if "laws" not in told["proof"]:
        return evidence, Proof(text=told["proof"]["text"])
    columns = {field.name: arrays[OF_PROOF + field.name] for field in fields(Witness) if field.name != "laws"}
    witness = Witness(laws=tuple(told["proof"]["laws"]), **columns)
    return evidence, Proof(text=told["proof"]["text"], witness=witness)
