"""The check of a stage: its verdict, its ground, and what speaks against it."""

from __future__ import annotations

from typing import Any

import numpy as np

from .balance import reaction_faults, residuals
from .geometry import AGREES, Arrays, moments, shapes
from .given import given_faults, given_text
from .mechanism import proved
from .model_file import GivenFiles
from .overlap import overlap
from .places import place_faults, shape_faults, support_faults
from .space import forces_in_space, is_in_space, with_moments
from .stability import falling
from .strength import own_laws, strength_faults
from .water import stiffness_faults

GROUNDS = {
    "stable": ("equilibrium",),
    "stable_after_falls": ("equilibrium",),
    "unstable": ("proved", "followed"),
    "not_converged": ("best state",),
    "no_verdict": ("equilibrium",),
}
LINEAR = 1e-9  # tolerance of the linear scheme: rounding


def check_stage(
    told: dict[str, Any], stage: dict[str, Any], arrays: Arrays, files: GivenFiles | None = None
) -> tuple[str, list[str]]:
    """Return the grounds for the verdict of a stage, in words, and against it; `files`: for the comparison."""
    try:
        text, faults = _checked(told, stage, arrays)
        if files is None:
            return text, faults
        there = measured(arrays)
        return f"{text}; {given_text(there)}, {files.text}", faults + files.faults(stage, there)
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        return "", [f"the numbers do not fit together ({type(error).__name__}: {error})"]


def measured(arrays: Arrays) -> Arrays:
    """Return the arrays with the moments of the blocks, and where these are."""
    if is_in_space(arrays):
        return with_moments(arrays)
    a = {**arrays, **moments(arrays["vertices"], arrays["offsets"])}
    a["at"] = a["centroid"] + a["position"][:, :2]
    a["shape"] = shapes(a)
    return a


def _checked(told: dict[str, Any], stage: dict[str, Any], a: Arrays) -> tuple[str, list[str]]:
    a = measured(a)
    if stage["ground"] not in GROUNDS.get(stage["verdict"], ()):
        return "", [f"the ground '{stage['ground']}' is none for '{stage['verdict']}'"]
    linear = told["scheme"] == "linear"
    small = linear or told["scheme"] == "zones"  # displacements: forces act where blocks were given
    if stage["ground"] == "equilibrium" and linear != (stage["verdict"] == "no_verdict"):
        return "", [f"an equilibrium of scheme '{told['scheme']}' is none for '{stage['verdict']}'"]
    if is_in_space(a):
        text, faults, unbalanced = forces_in_space(told, stage, a)
        if stage["verdict"] != "unstable":
            return text, faults
        text, found = movement(stage, a, unbalanced)
        return text, faults + found
    residual, rounding = residuals(a, stage["reference_weight"])
    reference = stage["reference_weight"]
    faults = reaction_faults(a, reference) + given_faults(a, reference) + support_faults(a, reference)
    faults += shape_faults(a) + place_faults(a) if stage["ground"] == "equilibrium" else []
    faults += [] if linear else strength_faults(stage, a)
    faults += [] if small else stiffness_faults(a)
    if stage["ground"] == "best state":
        worst = int(residual.argmax())
        text = f"block {worst} is out of balance by {residual[worst]:.1e} of the reference weight"
        text += f" ({told['tolerance']:.0e} is allowed)"
        return f"{text}; {stage['reason']}", faults
    if stage["verdict"] == "unstable":
        text, found = movement(stage, a, residual - rounding > told["tolerance"])
        if stage["ground"] == "proved":
            proof, more = proved(stage, a, linear=linear)
            return f"{proof}; {text}", faults + found + more
        return text, faults + found
    allowed = min(told["tolerance"], LINEAR) if linear else told["tolerance"]
    worst = int((residual - rounding).argmax())
    if not residual[worst] - rounding[worst] <= allowed:
        faults.append(f"block {worst} is out of balance by {residual[worst]:.1e} of the reference weight")
    text = f"every block is in balance to {residual.max():.1e} of the reference weight ({allowed:.0e} is allowed)"
    for told_more, found in ("", []) if small else overlap(a), falling(a, linear=small):
        text, faults = f"{text}{'; ' if told_more else ''}{told_more}", faults + found
    return text + own_laws(stage, a), faults


def movement(stage: dict[str, Any], a: Arrays, unbalanced: Any) -> tuple[str, list[str]]:
    """Return how the unstable blocks were followed, and what of it is not so; `unbalanced` (n,): what moves."""
    blocks, moved = stage["unstable_blocks"], np.linalg.norm(a["displacement"][:, : a["at"].shape[1]], axis=1)
    if not blocks or [one["block"] for one in stage["movement"]] != blocks or not a["present"][blocks].all():
        return "", ["the unstable blocks are not named"]
    faults = []
    if any(abs(one["moved"] - moved[one["block"]]) > AGREES * moved[one["block"]] for one in stage["movement"]):
        faults.append("blocks have not moved as far as is said")
    if not unbalanced[blocks].any():
        faults.append("every block that is to fall is in balance")
    farthest = max(stage["movement"], key=lambda one: one["moved"])
    speed = "" if farthest["speed"] is None else f", at {farthest['speed']:.2g} m/s"
    methods = ", ".join(
        f"{one['name']} ended {one['ended']} and failed in {one['in_vain']}" for one in stage["methods"]
    )
    text = f"block {farthest['block']} was followed over {farthest['moved']:.3g} m{speed} ({len(blocks)} fall); "
    why = f"; {stage['proof']['text']}" if "proof" in stage and stage["ground"] == "followed" else ""
    return f"{text}{stage['reason']}; of {stage['steps']} steps {methods}{why}", faults
