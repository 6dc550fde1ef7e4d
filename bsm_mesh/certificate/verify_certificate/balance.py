"""Balance of every block, and reactions."""

from __future__ import annotations

from typing import Any

import numpy as np

from .geometry import AGREES, ROUNDING, Arrays, add_forces, scaled, turned_left


def residuals(a: Arrays, reference: float) -> tuple[Any, Any]:
    """Return the unbalanced force of every block, (n,), and its part by rounding, over the reference weight."""
    axes, normal = a["at"].shape[1], a["contact_normal"]
    total = a["applied"] + a["water"] + a["reactions"]
    total[:, :axes] += a["weight"]
    along = a["contact_shear"] if axes == 3 else a["contact_shear_force"][:, None] * turned_left(normal)
    force = a["contact_normal_force"][:, None] * normal + along
    borne = np.zeros(len(total))
    for block, point, push in (
        (a["contact_block_b"], a["contact_point"], force),
        (a["contact_block_a"], a["contact_point"], -force),
        (a["bolt_block"], a["bolt_point"], a["bolt_force"]),
    ):
        if len(block):
            add_forces(total, a, block, point, push)
            np.add.at(borne, block, np.linalg.norm(push, axis=1) if axes == 3 else np.hypot(*push.T))
    far = float(np.abs(a["at"][a["present"]]).max())
    size = np.where(a["present"], np.abs(scaled(a, total)).max(axis=1), 0.0)
    return np.nan_to_num(size, nan=np.inf) / reference, ROUNDING * far * borne / a["gyration"] / reference


def reaction_faults(a: Arrays, reference: float) -> list[str]:
    """Return where the reactions are not the sum of the supports' forces."""
    of_supports = a["support_block"], a["support_point"], a["support_reaction"], a["support_moment"]
    off = np.abs(scaled(a, add_forces(np.zeros_like(a["reactions"]), a, *of_supports) - a["reactions"]))
    allowed = AGREES * (reference + np.abs(a["reactions"]).max(initial=0.0))
    return [] if off.max(initial=0.0) <= allowed else ["reactions are not the sum of the supports' forces"]
