"""Reasons why a shaken stage has no answer, in words: of rigid blocks and of zones."""

from __future__ import annotations

from bsm_mesh.model.shaking import Shaking
from bsm_mesh.results.shaking import imbalance_of
from bsm_mesh.solve.motion.shaking_memory import ShakingMemory


def divergence(memory: ShakingMemory, shaking: Shaking) -> str:
    """Return the reason for explicit motion that is not finite, and the cure."""
    return f"after {memory.time:.4g} s of shaking the explicit motion diverges: {_smaller_steps(shaking)}"


def imbalance(memory: ShakingMemory, shaking: Shaking) -> str:
    """Return the reason for energies that do not balance within `Shaking.max_imbalance`; nothing where they do."""
    error = imbalance_of(memory.records[:, 2:])
    if error <= shaking.max_imbalance:
        return ""
    cure = _smaller_steps(shaking)
    if shaking.integrator == "implicit":
        cure += ", contact_damping, or integrator = 'explicit'"
    return (
        f"the energy balance of the shaking has an error of {100 * error:.2g} % of the greatest energy (allowed: "
        f"{100 * shaking.max_imbalance:g} %): {cure}"
    )


def _smaller_steps(shaking: Shaking) -> str:
    """Return the cure of time steps that are too long."""
    text = f"give shaking a smaller time_step (now {shaking.time_step:g})"
    return text if shaking.mass_scaling == 1 else f"{text} or mass_scaling (now {shaking.mass_scaling:g})"
