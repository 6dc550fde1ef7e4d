"""Slips of the pen in a model file: one key is changed."""

from __future__ import annotations

import copy
import math
from random import Random
from typing import Any

from .values import FACTORS, NUMBERS, text

Tree = dict[str, Any]
UNITS = (
    "Pa",
    "kPa",
    "MPa",
    "GPa",
    "Pa/m",
    "kPa/m",
    "MPa/m",
    "GPa/m",
    "N/m^3",
    "kN/m^3",
    "MN/m^3",
    "mm",
    "cm",
    "m",
    "km",
    "N/m",
    "kN/m",
    "N",
    "kN",
    "deg",
    "rad",
)
EXTREMES = [value for value in NUMBERS if isinstance(value, float) and math.isfinite(value)] + [
    math.inf,
    -math.inf,
    math.nan,
]
ADDED: dict[str, list[tuple[str, Any]]] = {  # keys that a user might add to a table, or mistake for another
    "": [
        ("in_situ", {"surface": 30.0}),
        ("in_situ", {"stress": {"xx": -1e6, "yy": -1e6}}),
        ("in_situ", {"surface": 30.0, "k0": 5.0}),
        ("in_situ", {"method": "gravity"}),
        ("gravity", {"direction": 90}),
        ("gravity", {"direction": 0}),
        ("titel", "x"),
        ("tolerance", 0.9),
    ],
    "mesh": [
        ("unit", "mm"),
        ("unit", "km"),
        ("merge_tolerance", 0.5),
        ("contact_points", "gauss"),
        ("blocks", "regions"),
        ("default_joint", "joint"),
    ],
    "parameters": [("dip", 0.0), ("count", 1), ("margin", 1e6)],
    "rock": [
        ("young", "1 kPa"),
        ("cohesion", "1 GPa"),
        ("friction", 89.0),
        ("tensile_strength", "1 GPa"),
        ("stiffness", "rigid"),
        ("density", 2000),
    ],
    "joint": [
        ("cohesion", "10 MPa"),
        ("cohesion", 1e29),
        ("residual_friction", 85.0),
        ("residual_friction", 5.0),
        ("dilation", 45.0),
        ("tensile_strength", "10 MPa"),
        ("law", "patton"),
        ("filling", {"thickness": "1 mm", "young": "1 Pa", "poisson": 0.3}),
    ],
    "support": [("displacement", "1 m"), ("direction", 90), ("point", [0, 0])],
    "bolt": [("bond_strength", "1 MN/m"), ("plate", "1 MN"), ("pretension", "40 kN")],
    "water": [("head", "parallel"), ("joint_pressure", {"bedding": "-1 MPa"})],
    "solver": [
        ("tolerance", 0.05),
        ("tolerance", 0.3),
        ("tolerance", 0.9),
        ("tolerance", 1e-3),
        ("max_steps", 1),
        ("max_steps", 3),
        ("scheme", "linear"),
        ("scheme", "wang"),
        ("displacement_limit", "1 mm"),
        ("displacement_limit", "1e20 m"),
        ("sliding_stiffness", 1e-9),
        ("linear_solver", "superlu"),
        ("threads", 1),
    ],
    "output": [("snapshots", "steps"), ("folder", "here")],
    "gravity": [("direction", 90), ("direction", -90 + 360)],
}


def slip(random: Random, tree: Tree) -> tuple[Tree, str, str]:
    """Return a tree with one key changed, the path of the key, and what was done to it."""
    changed = copy.deepcopy(tree)
    holder, key, path = random.choice(
        [found for found in _named_places(changed) if found[2] not in ("title", "output")]
    )
    kind = random.random()
    if kind < 0.15 and isinstance(holder, dict):
        del holder[key]
        return changed, path, "dropped"
    if kind < 0.4:
        done = _added(random, changed)
        if done is not None:
            return changed, *done
    if kind < 0.5 and isinstance(holder, dict):
        other = random.choice(list(holder))
        holder[key], holder[other] = holder[other], holder[key]
        return changed, path, f"exchanged with {other}"
    if kind < 0.55 and isinstance(holder, dict):
        name = str(text(random, key))
        holder[name] = holder.pop(key)
        return changed, path, f"written as {name!r}"
    if kind < 0.62 and isinstance(holder, dict):
        table, _, where = random.choice([found for found in _named_places(changed) if isinstance(found[0], dict)])
        table[key] = copy.deepcopy(holder[key]) if random.random() < 0.5 else holder.pop(key)
        there = where.rpartition(".")[0] or "the file itself"
        return changed, path, f"put into {there}"
    given = holder[key]
    holder[key] = _other(random, given)
    return changed, path, f"{given!r} became {holder[key]!r}"


def _named_places(tree: Tree, prefix: str = "") -> list[tuple[Any, Any, str]]:
    found: list[tuple[Any, Any, str]] = []
    keys = tree.keys() if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else ()
    for key in keys:
        path = f"{prefix}.{key}" if prefix else str(key)
        found.append((tree, key, path))
        found.extend(_named_places(tree[key], path))
    return found


def _added(random: Random, tree: Tree) -> tuple[str, str] | None:
    """Add a key to a table that is there; return its path and what was done."""
    name = random.choice(list(ADDED))
    holder: Any = (
        tree if not name else tree.get(name) if name != "parameters" else tree.get("mesh", {}).get("parameters")
    )
    path = name
    if name in ("rock", "joint") and holder:
        part = random.choice(list(holder))
        holder, path = holder[part], f"{name}.{part}"
    if isinstance(holder, list) and holder:
        holder, path = holder[0], f"{name}.0"
    if not isinstance(holder, dict):
        return None
    key, value = random.choice(ADDED[name])
    before = holder.get(key)
    holder[key] = copy.deepcopy(value)
    return f"{path}.{key}" if path else key, f"{before!r} became {value!r}"


def _other(random: Random, given: Any) -> Any:
    if isinstance(given, bool):
        return not given
    if isinstance(given, int | float):
        changed = random.choice([given * random.choice(FACTORS), random.choice(EXTREMES), -given])
        return int(changed) if isinstance(given, int) and math.isfinite(changed) and random.random() < 0.9 else changed
    if isinstance(given, str):
        number, space, unit = given.partition(" ")
        if space and random.random() < 0.9:
            value = float(number)
            return random.choice(
                [
                    f"{number} {random.choice(UNITS)}",
                    f"{value * random.choice(FACTORS):g} {unit}",
                    f"{random.choice(EXTREMES):g} {unit}",
                    f"{-value:g} {unit}",
                    value,
                ]
            )
        return text(random, given)
    if isinstance(given, list):
        return random.choice([[], given[:1], given + given[-1:], given[::-1], [0], [[]]])
    if isinstance(given, dict):
        return {key: given[key] for key in list(given)[1:]} if random.random() < 0.7 else {}
    return 0
