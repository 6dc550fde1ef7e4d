"""What the closed forms read of a model file, by Pint and not by the program, and how they compare."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from functools import cache
from typing import Any

Tree = dict[str, Any]
NEAR = 0.005  # of the limit: nearer to it no form judges


@cache
def _pint() -> Any:
    import pint

    units = pint.UnitRegistry()
    units.define("deg = degree")
    return units


def si(value: Any, unit: str) -> float:
    """Return a number of the file in SI; nan where it is none."""
    if isinstance(value, bool) or value is None:
        return math.nan
    if isinstance(value, int | float):
        return float(value)
    try:
        return float(_pint().Quantity(str(value)).to(unit).magnitude)
    except Exception:  # whatever Pint thinks of it, it is no number
        return math.nan


def gravity(tree: Tree) -> float:
    """Return the direction in which weight acts [radians], anticlockwise from the x axis."""
    return math.radians(si(tree.get("gravity", {}).get("direction", -90), "deg"))


def scaled(tree: Tree, scale: float) -> Tree:
    """Return a model of the given size that stands or falls as the model of `scale` times that size does.

    Weights grow with the square of the size, strengths of faces with the size, forces and bolts not at all: so unit
    weights are multiplied, and forces divided, by the scale.
    """
    tree = copy.deepcopy(tree)
    for rock in tree.get("rock", {}).values():
        rock["unit_weight"] = si(rock["unit_weight"], "N/m^3") * scale
    if "water" in tree:
        tree["water"]["unit_weight"] = si(tree["water"].get("unit_weight", 9810), "N/m^3") * scale
    for load in tree.get("load", []):
        load["force"] = [si(part, "N/m") / scale for part in load["force"]]
    for bolt in tree.get("bolt", []):
        bolt["spacing"] = si(bolt["spacing"], "m") * scale
    return tree


def beyond(drive: float, resistance: float) -> bool | None:
    """Return whether something stays: what drives it is below what resists, or above, or too near to tell."""
    if math.isnan(drive) or math.isnan(resistance):
        return None
    if abs(drive - resistance) <= NEAR * max(abs(drive), abs(resistance)):
        return None
    return drive < resistance


def both(*answers: bool | None) -> bool | None:
    """Return whether all stay: one that does not decides."""
    return False if False in answers else None if None in answers else True


@dataclass(frozen=True)
class Strength:
    """A joint's friction coefficient and cohesion; nan where the form does not know."""

    friction: float
    cohesion: float


def strength(tree: Tree, name: str) -> Strength:
    """Return the strength of a joint before it slips."""
    joint = tree.get("joint", {}).get(name, {})
    angle = si(joint.get("friction"), "deg") + si(joint.get("dilation", 0), "deg")
    cohesion = si(joint.get("cohesion", 0), "Pa") if joint.get("law") == "mohr_coulomb" else 0.0
    if si(joint.get("tensile_strength", 0), "Pa") > 0 and cohesion:
        cohesion = math.nan
    return Strength(math.tan(math.radians(angle)) if 0 <= angle < 90 else math.nan, cohesion)


def weakens(tree: Tree, name: str) -> bool:
    """Return whether a joint has a residual strength: it may fail beyond its peak."""
    return bool({"residual_friction", "residual_cohesion"} & set(tree.get("joint", {}).get(name, {})))
