"""Mechanisms and their proof by virtual work."""

from __future__ import annotations

from typing import Any

import numpy as np

from .complete import corner_gaps, missing_faults
from .geometry import AGREES, Arrays, cross, scaled, turned_left
from .strength import is_curved, strength_of
from .water import water_on

ENORMOUS = 1e6  # times all loads together: forces that no rock carries


def proved(stage: dict[str, Any], a: Arrays, *, linear: bool) -> tuple[str, list[str]]:
    """Return the virtual work of the mechanism in the initial geometry in words, and whether the proof fails."""
    p = {name.removeprefix("proof_"): values for name, values in a.items() if name.startswith("proof_")}
    v, centroid, gyration = p["velocity"], a["centroid"], a["gyration"]

    def at(block: Any, point: Any) -> Any:
        return v[block, :2] + v[block, 2:] * turned_left(point - centroid[block])

    power = float((p["loads"] * v).sum())
    past = at(p["block_a"], p["point"]) - at(p["block_b"], p["point"])
    taken, loose = dissipation((past * p["normal"]).sum(axis=1), np.abs(cross(p["normal"], past)), p)
    held = (at(p["bar_block"], p["bar_point"]) * p["bar_direction"]).sum(axis=1)
    loose += float(np.abs(np.where(p["bar_turns"], v[p["bar_block"], 2] * gyration[p["bar_block"]], held)).sum())
    first, nodes = p["element_node"], at(p["node_block"], p["node_point"])
    along = p["node_point"][first + 1] - p["node_point"][first]
    along = along / np.hypot(*along.T)[:, None]
    longer = ((nodes[first + 1] - nodes[first]) * along).sum(axis=1) - p["node_slip"][first] + p["node_slip"][first + 1]
    across = (at(p["dowel_block"][:, 0], p["dowel_point"]) - at(p["dowel_block"][:, 1], p["dowel_point"])) * p[
        "dowel_across"
    ]
    for speed, most in (
        (np.maximum(longer, 0.0), p["element_yield"]),
        (np.abs(p["node_slip"]), p["node_capacity"]),
        (np.abs(across.sum(axis=1)), p["dowel_strength"]),
    ):
        taken += float((speed * np.where(np.isfinite(most), most, 0.0)).sum())
        loose += float(speed[np.isinf(most)].sum())
    loose += corner_gaps(a, p, steepest([*stage["laws"], *stage["proof"]["laws"]]))
    every = float(np.hypot(*p["loads"][:, :2].T).sum())
    left = (power - taken) / every
    least = left / loose if loose > 0 else np.copysign(np.inf, left)
    faults = witness_faults(stage, a, p, linear=linear) + missing_faults(a, p)
    if not (power > 0 and least >= ENORMOUS):
        faults.append("the mechanism proves nothing: forces within strength can take up the power of the loads")
    text = (
        f"in the mechanism the loads do {power:.6g} W/m and all that strength allows takes up {taken:.6g}: forces that "
        f"balance would have to be {least:.1e} times all loads together"
    )
    return text, faults


def dissipation(opens: Any, slips: Any, p: Arrays) -> tuple[float, float]:
    """Return the power that contacts can take up at most (velocities (m,)), and what rounding leaves per force.

    Under the pressure p a contact takes up ``-p * opens + strength(p) * slips``: concave in p, greatest at a corner of
    the strength, and bounded where it opens fast enough.
    """
    slope, intercept = p["lines"][:, :, 0], p["lines"][:, :, 1]
    bounded = np.isfinite(intercept)
    free = ~bounded.any(axis=1) | np.isinf(p["tension"])
    tension = np.where(free & np.isinf(p["tension"]), 0.0, p["tension"])
    intercept = intercept + slope * tension[:, None]  # the convex hull of the strength in tension
    flattest = np.where(bounded, slope, np.inf).min(axis=1, initial=np.inf)
    lacks = np.where(free, np.where(np.isinf(p["tension"]), np.abs(opens), np.maximum(-opens, 0.0)) + slips, 0.0)
    with np.errstate(invalid="ignore"):
        lacks = np.where(free, lacks, np.maximum(slips * flattest - opens, 0.0))
    pressures = [-tension]
    for one in range(slope.shape[1]):
        for other in range(one):
            with np.errstate(divide="ignore", invalid="ignore"):
                meet = (intercept[:, other] - intercept[:, one]) / (slope[:, one] - slope[:, other])
            pressures.append(np.where(np.isfinite(meet), np.maximum(meet, -tension), -tension))
    taken = np.zeros(len(opens))
    for pressure in pressures:
        line = np.where(bounded, intercept + slope * pressure[:, None], np.inf).min(axis=1, initial=np.inf)
        strength = np.where(free, 0.0, line)
        taken = np.maximum(taken, -pressure * (opens + np.where(free, 0.0, lacks)) + slips * strength)
    return float(taken.sum()), float(lacks.sum())


def given_loads(a: Arrays) -> Any:
    """Return weights, loads and the table's water where the blocks were given, (n, 3)."""
    block, turn = a["load_block"], -a["position"][a["load_block"], 2]
    x, y = (a["load_point"] - a["at"][block]).T
    arm = np.column_stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y])
    loads = np.column_stack([a["weight"], np.zeros(len(a["weight"]))])
    np.add.at(loads, block, np.column_stack([a["load_force"], cross(arm, a["load_force"])]))
    return loads + water_on(a, np.zeros_like(a["position"]))[0] if "water_pieces" in a else loads


def steepest(laws: list[dict[str, Any]]) -> float:
    """Return the most shear per pressure that any of the laws allows, from little pressure on."""
    pressure, one, none = np.array([1e3, 1e5]), np.ones(2), np.zeros(2)
    slopes = [strength_of(law, pressure, one, none > 0, none) / pressure for law in laws]
    return float(np.nan_to_num(np.concatenate([*slopes, none]), nan=1e3, posinf=1e3).max())


def witness_faults(stage: dict[str, Any], a: Arrays, p: Arrays, *, linear: bool) -> list[str]:
    """Return where loads and strength of the mechanism are not those of the certificate."""
    faults = []
    moves = p["velocity"].any(axis=1)
    off = scaled(a, given_loads(a) - p["loads"])[moves]
    if "water_pieces" not in a and a["water"].any():  # that of flow and joints presses where the blocks have come to
        off = off[:, :0]
    if not np.abs(off).max(initial=0.0) <= AGREES * np.abs(p["loads"]).max(initial=0.0):
        faults.append("the mechanism is loaded otherwise than the blocks")
    if not np.isin(a["bolt_block"][moves[a["bolt_block"]]], [*p["node_block"], *p["dowel_block"].ravel()]).all():
        faults.append("the mechanism leaves out a bolt")
    used = [stage["proof"]["laws"][number] for number in np.unique(p["law"])]
    if not linear and any(law not in stage["laws"] for law in used):  # that scheme knows no strength
        faults.append("the mechanism has laws that the contacts have not")
    for number, law in enumerate(stage["proof"]["laws"]):
        rows, lines = p["law"] == number, p["lines"][p["law"] == number]
        for pressure in (0.0, 1e3, 1e6, 1e9):
            told = (lines[:, :, 1] + lines[:, :, 0] * pressure).min(axis=1, initial=np.inf)
            length = p["length"][rows]
            none = np.zeros(len(length))
            known = strength_of(law, np.full(len(length), pressure), length, none > 0, none)
            with np.errstate(invalid="ignore"):
                off = np.where(np.isfinite(known), told - known, 0.0)
                off = off if is_curved(law) else -np.abs(off)  # tangents lie above: what holds for more strength
                wrong = (off < -AGREES * np.abs(known)).any()
            if wrong:
                faults.append(f"the lines of law {number} are not its strength")
                break
    return faults
