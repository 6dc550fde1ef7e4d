"""What the end of a window by wear is worth in explicit motion: ``python -m benchmarks.law_windows``.

The first dry model of every random family of up to 250 blocks, with a law that softens over a thousandth of a block's
size. The table takes the place of that of `PAGE`.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.scene import Scene
from benchmarks.campaign.trial import trial_of
from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.joint_laws import JointLaw
from bsm_mesh.solve.motion import cycles
from examples.numbers.pages import markdown, with_table

PAGE = Path(__file__).parents[1] / "docs/experiments/joint_laws.md"
WINDOWS = {"1/16": 0.5, "1/8, as it is": 1.0, "1/4": 2.0, "1/2": 4.0, "not by wear": 1e9}  # times as long
MOST_BLOCKS, MAX_STEPS = 250, 60
WHOLE = cycles.wear_room


def softening(scene: Scene, size: float) -> JointLaw:
    """Return the law for a scene of blocks of a size [m]."""
    return bsm.MohrCoulomb(
        friction=scene.friction,
        cohesion=scene.cohesion,
        residual_friction=0.8 * scene.friction,
        softening_slip=max(1e-6, 1e-3 * size),
    )


def longer(times: float) -> Callable[[float, float, FloatArray], FloatArray]:
    """Return how far contacts slide in a window that is so many times as long."""
    return lambda window, wear_length, slip_path: times * WHOLE(window, wear_length, slip_path)


def verdicts() -> dict[str, str]:
    """Return the verdicts on the models, by family."""
    found = {}
    for family in FAMILIES:
        scene = trial_of(FAMILIES[family], 0).scene
        if "+water" in family or scene.count > MOST_BLOCKS:
            continue
        model = scene.model()
        law = softening(scene, float(np.sqrt(model.blocks.moments.area.mean())))
        model = model.replace(joints=[dataclasses.replace(model.joints[0], law=law)])
        found[family] = str(bsm.run(model, bsm.Options(max_steps=MAX_STEPS)).status.value)
    return found


def main() -> None:
    """Run all and write the table."""
    rows = []
    first: dict[str, str] = {}
    for window, times in WINDOWS.items():
        cycles.wear_room = longer(times)
        began = time.process_time()
        found = verdicts()
        first = first or found
        other = [f"{key}: {value}, not {first[key]}" for key, value in found.items() if value != first[key]]
        stable, spent = list(found.values()).count("stable"), time.process_time() - began
        rows.append((window, str(len(found)), str(stable), "; ".join(other) or "none", f"{spent:.0f}"))
    table = markdown(("window ends by", "models", "stable", "others than in the shortest", "s"), rows)
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), "law-windows", table), encoding="utf-8")


if __name__ == "__main__":
    main()
