"""What joint laws cost, over the first random model of every family: ``python -m benchmarks.joint_laws``.

Models of up to 400 blocks, 8 processor seconds each. The table takes the place of that of `PAGE`; with names of laws
only their rows do, and that of Mohr-Coulomb.
"""

from __future__ import annotations

import dataclasses
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.scene import Scene
from benchmarks.campaign.trial import trial_of
from examples.numbers.pages import table_in, with_table

PAGE = Path(__file__).parents[1] / "docs/experiments/joint_laws.md"
MOST_BLOCKS, SECONDS = 400, 8.0
Keys = Mapping[str, Any]


class TimeUpError(BaseException):
    """A model has had its processor seconds; laws of the user's own may fail by an `Exception`."""


def plastic(scene: Scene, size: float) -> Keys:
    """Return what the joints of a scene of blocks of a size [m] are given: Mohr-Coulomb."""
    return {"law": bsm.MohrCoulomb(friction=scene.friction, cohesion=scene.cohesion)}


def softening(scene: Scene, size: float) -> Keys:
    """Return a law that softens over a thousandth of a block's size."""
    residual = {"residual_friction": 0.8 * scene.friction, "softening_slip": max(1e-6, 1e-3 * size)}
    return {"law": bsm.MohrCoulomb(friction=scene.friction, cohesion=scene.cohesion, **residual)}


def tension(scene: Scene, size: float) -> Keys:
    """Return a brittle law, of whose tensile strength of 10 kPa slip leaves a half."""
    law = bsm.MohrCoulomb(friction=scene.friction, cohesion=scene.cohesion, residual_friction=0.8 * scene.friction)
    return {"law": law, "tensile_strength": 10e3, "residual_tensile_strength": 5e3}


def dilating(scene: Scene, size: float) -> Keys:
    """Return Mohr-Coulomb's law that dilates by a quarter of the friction angle over a thousandth of a block."""
    return {
        **plastic(scene, size),
        "dilation_angle": scene.friction / 4,
        "dilation_slip": max(1e-6, 1e-3 * size),
    }


def both(scene: Scene, size: float) -> Keys:
    """Return the law that softens, with that dilation."""
    return {**dilating(scene, size), **softening(scene, size)}


def closing(scene: Scene, size: float) -> Keys:
    """Return Mohr-Coulomb's law of joints that close by three times what a block's height of rock closes at first."""
    return {**plastic(scene, size), "max_closure": max(1e-6, 3 * scene.unit_weight * size / scene.kn)}


def stiffening(scene: Scene, size: float) -> Keys:
    """Return Mohr-Coulomb's law with a shear stiffness by the root of the stress, given under ten blocks' height."""
    return {**plastic(scene, size), "shear_stiffness_exponent": 0.5, "reference_stress": _stress(scene, size)}


def _stress(scene: Scene, size: float) -> float:
    """Return the stress under ten blocks' height [Pa], in the range of reference stresses."""
    return float(np.clip(10 * scene.unit_weight * size, 1e2, 1e10))


def barton(scene: Scene, size: float) -> Keys:
    """Return Barton-Bandis's law, as stiff in shear as its peak over the displacement there."""
    length = max(0.1, size)
    law = bsm.BartonBandis(jrc=6, jcs=60e6, residual_friction=0.8 * scene.friction, joint_length=length)
    return {"law": law, "shear_stiffness": None, "reference_stress": _stress(scene, size)}


LAWS: dict[str, Callable[[Scene, float], Keys]] = {
    "Mohr-Coulomb": plastic,
    "residual tensile strength, brittle": tension,
    "softening": softening,
    "dilation": dilating,
    "dilation and softening": both,
    "shear stiffness by the root of stress": stiffening,
    "Barton-Bandis, stiffness by its peak": barton,
    "closure limit": closing,
}


def verdicts(keys_of: Callable[[Scene, float], Keys], seconds: float = SECONDS) -> tuple[dict[str, str], float]:
    """Return the verdicts by family, "no answer" where time was up, and the processor seconds of all."""
    found, spent = {}, 0.0
    for family in FAMILIES:
        scene = trial_of(FAMILIES[family], 0).scene
        if scene.count > MOST_BLOCKS:
            continue
        model = scene.model()
        keys = keys_of(scene, float(np.sqrt(model.blocks.moments.area.mean())))
        model = model.replace(joints=[dataclasses.replace(joint, **keys) for joint in model.joints])
        began = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, seconds)
        try:
            found[family] = str(bsm.run(model).status.value)
        except TimeUpError:
            found[family] = "no answer"
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        spent += time.process_time() - began
    return found, spent


def _up(*_: object) -> None:
    raise TimeUpError


def main(names: Sequence[str] = ()) -> None:
    """Run all laws, or Mohr-Coulomb and those named, and write their rows of the table."""
    if unknown := [name for name in names if name not in LAWS]:
        raise SystemExit(f"no law is called {', '.join(unknown)}; there are: {', '.join(LAWS)}")
    signal.signal(signal.SIGPROF, _up)
    verdicts(plastic, 60.0)  # compiles, which must not be interrupted
    page = PAGE.read_text(encoding="utf-8")
    stated = table_in(page, "law-answers").splitlines()
    rows = {name: line for name in LAWS for line in stated if line.startswith(f"| {name} |")}
    usual = 0.0
    for name, keys_of in LAWS.items():
        if usual and names and name not in names:
            continue
        found, spent = verdicts(keys_of)
        usual = usual or spent
        count = Counter(found.values())
        answers = len(found) - count["no answer"] - count["not_converged"]
        stable = count["stable"] + count["stable_after_falls"]
        row = (name, len(found), answers, stable, count["unstable"], f"{spent:.0f}", f"{spent / usual:.1f}")
        rows[name] = f"| {' | '.join(map(str, row))} |"
        print(name, {family: value for family, value in found.items() if value in ("no answer", "not_converged")}, row)
    heading = ["| law | models | answers | stable | unstable | s | times |", "|---|---|---|---|---|---|---|"]
    lines = [*heading, *(rows[name] for name in LAWS if name in rows)]
    PAGE.write_text(with_table(page, "law-answers", "\n".join(lines)), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
