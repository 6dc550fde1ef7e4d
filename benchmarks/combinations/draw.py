"""What the combinations in the plane and in space draw alike: features, laws, bolts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

import bsm_mesh as bsm

LAWS = (
    bsm.MohrCoulomb(friction=35),
    bsm.MohrCoulomb(friction=30, cohesion=5e4, residual_cohesion=0),
    bsm.MohrCoulomb(friction=35, residual_friction=25, softening_slip=1e-3),
    bsm.Patton(friction=30, dilation=5, cohesion=5e4),
    bsm.BartonBandis(jrc=8, jcs=5e7, residual_friction=28),
)
OF_JOINTS: tuple[dict[str, Any], ...] = (
    {"tensile_strength": 2e4},
    {"max_closure": 1e-3},
    {"dilation_angle": 5.0, "dilation_slip": 0.01},
    {"shear_stiffness_exponent": 0.5, "reference_stress": 1e6},
)
BOLTS: dict[str, dict[str, Any]] = {
    "grouted": {"bond_strength": 2e5},
    "end-anchored": {"kind": "end_anchored", "anchor_capacity": 2e5},
    "resists shear": {"bond_strength": 2e5, "bearing_stiffness": 1e9},
    "pretensioned": {"pretension": 2e4, "yield_strength": 5e8},
}


class Draw:
    """Draws the combination of a seed; `tags` are the features that it has."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self.tags: list[str] = []

    def one(self, *choices: Any) -> Any:
        """Return one of some choices."""
        return choices[self._random.integers(len(choices))]

    def often(self, share: float, tag: str = "") -> bool:
        """Return whether a feature is drawn, with a share of all seeds."""
        drawn = bool(self._random.random() < share)
        self.tags += [tag] if drawn and tag else []
        return drawn


def in_time(draw: Draw, stages: list[dict[str, Any]], ends: dict[str, Any], *places: dict[str, Any]) -> dict[str, Any]:
    """Return stages, a bolt between its ends and histories at places, as parts of a model.

    A stage that fills puts back what the one before took away.
    """
    parts: dict[str, Any] = {}
    for former, stage in pairwise(stages):
        stage |= {"fill": former.get("excavate", [])} if "fill" in stage else {}
    if draw.often(0.35):
        kind = draw.one(*BOLTS)
        draw.tags.append(f"bolt: {kind}")
        late = {"stage": "stage 1"} if stages and draw.often(0.5, "late bolt") else {}
        parts["bolts"] = [bsm.Bolt(**ends, diameter=0.025, name="B", **BOLTS[kind], **late)]
    if draw.often(0.4, "histories"):
        recorded = [*places, {"joint": "bed"}, *[{"bolt": "B"}] * ("bolts" in parts)]
        parts["histories"] = [bsm.History(f"h{number}", **place) for number, place in enumerate(recorded)]
    return parts | {"stages": [bsm.Stage(**stage) for stage in stages]}


def options_of(draw: Draw) -> bsm.Options:
    """Return the options of a run of one thread."""
    options = bsm.Options(threads=1, max_steps=60)
    return replace(options, falls=bsm.Falls(on_fall="remove")) if draw.often(0.1, "falls removed") else options
