"""Loads on the blocks follow from the input: weights from areas and unit weights, loads from their forces."""

from __future__ import annotations

import numpy as np

from .geometry import AGREES, Arrays, add_forces, scaled
from .water import water_faults

GIVEN = ("unit_weight", "gravity", "load_block", "load_point", "load_force")


def given_faults(a: Arrays, reference: float) -> list[str]:
    """Return what acts on the blocks otherwise than it follows from the input."""
    missing = [name for name in GIVEN if name not in a]
    if missing:
        return [f"the certificate has no {', '.join(missing)}: weights and loads cannot be followed"]
    faults = []
    weight = (a["unit_weight"] * a["area"])[:, None] * a["gravity"]
    off = np.abs(weight - a["weight"])
    if not off.max(initial=0.0) <= AGREES * np.abs(a["weight"]).max(initial=0.0):
        faults.append(f"block {int(off.max(axis=1).argmax())} weighs otherwise than its area and its unit weight say")
    loads = add_forces(np.zeros_like(a["applied"]), a, a["load_block"], a["load_point"], a["load_force"])
    off = np.abs(scaled(a, loads - a["applied"]))
    if not off.max(initial=0.0) <= AGREES * (reference + np.abs(a["load_force"]).max(initial=0.0)):
        faults.append(f"block {int(off.max(axis=1).argmax())} is loaded otherwise than by the loads")
    return faults + water_faults(a, reference)


def given_text(a: Arrays) -> str:
    """State the weight of the blocks and how many are held, for a reader who knows the model."""
    if any(name not in a for name in GIVEN):
        return "no weights are given"
    there = np.unique(a["unit_weight"][a["present"]])
    weights = f"{there[0]:g}" if len(there) == 1 else f"{there[0]:g} to {there[-1]:g}"
    return f"unit weight {weights} N/m3, {len(np.unique(a['bar_block']))} blocks held, {len(a['load_block'])} forces"
