"""Running a model, and the record of the result: verdict, counts and processor seconds."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.scene import FloatArray, Scene, turn
from bsm_mesh.results import Results
from bsm_mesh.results.records import StepRecord

Record = dict[str, Any]
OPTIONS = bsm.Options(scheme="continuation", threads=1)
ERROR, TIMEOUT = "error", "timeout"
DECIDED = ("stable", "unstable")
SHORT = 12  # characters of a digest


def run(scene: Scene, observer: Callable[[StepRecord], None] | None = None) -> tuple[Results, float]:
    """Return the results of a scene, and the processor seconds of the run with the model in memory."""
    model = scene.model()
    began = time.process_time()
    results = bsm.run(model, OPTIONS, observer)
    return results, time.process_time() - began


def record_of(scene: Scene, results: Results, seconds: float) -> Record:
    """Return the kept part of a run."""
    stage = results.stages[-1]
    steps = [step for stage in results.stages for step in stage.steps]
    methods = Counter(step.method for step in steps if getattr(step, "method", None))
    record: Record = {
        "blocks": scene.count,
        "digest": scene.digest[:SHORT],
        "status": str(results.status),
        "stage": f"{len(results.stages) - 1}/{len(scene.digs)}",
        "fallen": len(results.unstable_blocks),
        "fell": rounded(fell(results)),
        "steps": len(steps),
        "newton": sum(step.newton_iterations for step in steps),
        "factorizations": sum(step.factorizations for step in steps),
        "moved": rounded(moved(results, scene.size)),
        "closure": rounded(closure(results) / scene.size),
        "residual": rounded(stage.residual),
        "seconds": round(seconds, 4),
    }
    if results.status == "not_converged":
        record["reason"] = stage.reason
    return record | ({"methods": dict(methods)} if methods else {})


def moved(results: Results, size: float) -> float:
    """Return how far a block moved, or turned over half a block's size, at most, over the size of a block."""
    greatest = 0.0
    for stage in results.stages:
        u, v, theta = (stage.origin + stage.displacement).T
        greatest = max(greatest, float(np.hypot(u, v).max()), size / 2 * float(np.abs(theta).max()))
    return greatest / size


def fell(results: Results) -> float:
    """Return how far an unstable block moved at most, over the square root of its own area."""
    stage, blocks = results.stages[-1], results.unstable_blocks
    u, v, theta = (stage.origin + stage.displacement)[blocks].T
    own = np.sqrt(results.blocks.moments.area[blocks])
    return float(np.maximum(np.hypot(u, v) / own, np.abs(theta) / 2).max(initial=0.0))


def closure(results: Results) -> float:
    """Return how far the joints that carry have closed at the end, at most [m]."""
    contacts = results.stages[-1].contacts
    return float(np.maximum(-contacts.opening[contacts.normal_force < 0], 0.0).max(initial=0.0))


def noticeable(record: Record) -> float:
    """Return what counts as movement, over the size of a block: more than the springs' settlement."""
    return float(2e-3 + 10 * record["closure"])


def final_polygons(results: Results) -> list[FloatArray]:
    """Return the blocks where they are at the end, those taken away too."""
    blocks, stage = results.blocks, results.stages[-1]
    place = stage.origin + stage.displacement
    centre = blocks.moments.centroid
    return [
        turn(blocks.polygon(b) - centre[b], float(np.degrees(place[b, 2]))) + centre[b] + place[b, :2]
        for b in range(blocks.count)
    ]


def rounded(value: float) -> float:
    """Return a number with four digits."""
    return float(f"{value:.4g}")
