"""What the combinations in the plane and in space draw alike: features, laws, bolts."""

from __future__ import annotations

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
