"""Balance of every block, and reactions."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import AGREES, ROUNDING, Arrays, cross, turned_left


def residuals(a: Arrays, reference: float) -> tuple[Any, Any]:
    """Return the unbalanced force of every block, (n,), and its part by rounding, over the reference weight."""
    total = a["applied"] + a["water"] + a["reactions"]
    total[:, :2] += a["weight"]
    force = a["contact_normal_force"][:, None] * a["contact_normal"]
    force = force + a["contact_shear_force"][:, None] * turned_left(a["contact_normal"])
    borne = np.zeros(len(total))
    for block, point, push in (
        (a["contact_block_b"], a["contact_point"], force),
        (a["contact_block_a"], a["contact_point"], -force),
        (a["bolt_block"], a["bolt_point"], a["bolt_force"]),
    ):
        moment = cross(point - a["at"][block], push)
        np.add.at(total, block, np.column_stack([push, moment]))
        np.add.at(borne, block, np.hypot(*push.T))
    total[:, 2] /= a["gyration"]
    far = float(np.abs(a["at"][a["present"]]).max())
    size = np.where(a["present"], np.abs(total).max(axis=1), 0.0)
    return np.nan_to_num(size, nan=np.inf) / reference, ROUNDING * far * borne / a["gyration"] / reference


def reaction_faults(a: Arrays, reference: float) -> list[str]:
    """Return where the reactions are not the sum of the supports' forces."""
    total, block = np.zeros_like(a["reactions"]), a["support_block"]
    moment = a["support_moment"] + cross(a["support_point"] - a["at"][block], a["support_reaction"])
    np.add.at(total, block, np.column_stack([a["support_reaction"], moment]))
    off = np.abs(total - a["reactions"]) / np.column_stack([np.ones((len(total), 2)), a["gyration"]])
    allowed = AGREES * (reference + np.abs(a["reactions"]).max(initial=0.0))
    return [] if off.max(initial=0.0) <= allowed else ["reactions are not the sum of the supports' forces"]
