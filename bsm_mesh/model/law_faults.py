"""Faults in the response of a joint law, which may be of the user's own."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.joint_laws import BEYOND_STRENGTH, JointLaw, JointResponse, remembered_by

PROBED = (1.0, 1e3, 1e7)  # N/m: pressures from a pebble to deep rock, at which a law is asked besides
DEEPEST = 1e12  # N/m: beyond any wall strength, so that asperities shear off
FARTHEST = 1e3  # m: slip by which all that wears off has worn off
PAST = {
    "offset": 0.0,
    "first_tangential": 0.0,
    "mated": False,
    "slip_path": FARTHEST,
}  # state variables other than `failed`


def law_faults(law: Any, *, tension: bool) -> list[str]:
    """Return the faults of how a law answers, a sentence each: a law may be of the user's own.

    Parameters
    ----------
    law : object
        The input as a law.
    tension : bool
        Whether its contacts may carry tension, so that it is asked at negative pressures too.
    """
    if isinstance(law, str):
        return [f"law = {law!r}: names are for model files; give a law, for example bsm.MohrCoulomb(friction=35)"]
    who = f"the law {type(law).__name__}"
    if not callable(getattr(law, "respond", None)) or isinstance(law, type):
        return [f"{who}: has no method respond(pressure, trial_shear, length, failed) (docs/theory_joint_laws.md)"]
    if unknown := [name for name in remembered_by(law) if name not in PAST]:
        return [f"{who}: remembers {unknown[0]!r}; give a tuple of state variables of contacts: {', '.join(PAST)}"]
    pressure = np.array([0.0, 0.0, 1e5, 1e5, 1e5, *PROBED, *([-1e3] * tension)])
    trial = np.array([0.0, 0.0, 1.0, 1e9, 1e9, *(1e9 for _ in PROBED), *([1.0] * tension)])
    failed = np.array([False, True, False, True, False, *(False for _ in PROBED), *([False] * tension)])
    given = pressure, trial, np.ones(len(trial)), failed
    copies = tuple(values.copy() for values in given)
    try:
        with np.errstate(all="ignore"):
            answer = law.respond(*copies)
    except Exception as error:
        return [f"{who}: respond failed on arrays of {len(trial)} contacts: {type(error).__name__}: {error}"]
    if not isinstance(answer, JointResponse):
        return [f"{who}: respond returns {type(answer).__name__}; it must return a bsm.JointResponse"]
    faults = [
        text
        for field in fields(JointResponse)
        for text in _array_faults(field.name, getattr(answer, field.name), trial)
    ]
    if not faults:
        faults = _response_faults(answer, pressure, failed)
    if not all(np.array_equal(one, other) for one, other in zip(given, copies, strict=True)):
        faults.append("changes the arrays that it is given; it must return new ones")
    return [f"{who}: respond {text}" for text in faults]


def dilation_faults(angle: float, slip: float | None, law: JointLaw | None) -> list[str]:
    """Return the faults of a joint's dilation angle [degrees], which wears off on a slip [m], a sentence each."""
    if angle == 0:
        return [] if slip is None else [f"dilation_slip = {slip:g} m never acts: give dilation_angle, or leave it out"]
    if law is None:
        return [
            f"dilation_angle = {angle:g} degrees never acts: a joint without a law does not slide; give it a law "
            "(friction), or leave dilation_angle out"
        ]
    if slip is None:
        return [
            f"dilation_angle = {angle:g} degrees: over which slip does it wear off? Give dilation_slip, some "
            "millimetres to centimetres"
        ]
    pressure = np.array(PROBED)
    one, failed = np.ones_like(pressure), np.ones(len(pressure), dtype=bool)
    least = law.respond(pressure, BEYOND_STRENGTH * one, one, failed).strength
    if (least < math.tan(math.radians(angle)) * pressure * (1 - 1e-9)).any():
        return [
            f"dilation_angle = {angle:g} degrees is above the residual friction of its law: a sliding joint would give "
            "energy; give a dilation_angle of at most that friction angle"
        ]
    return []


def fails_by_slip(law: JointLaw) -> bool:
    """Return whether a contact that slides far enough fails by a law, at one of the pressures that are probed."""
    pressure = np.array([*PROBED, DEEPEST])
    one, intact = np.ones_like(pressure), np.zeros(len(pressure), dtype=bool)
    memory = (intact, *(np.full(len(pressure), PAST[name]) for name in remembered_by(law)))
    return bool(law.respond(pressure, BEYOND_STRENGTH * one, one, *memory).failed.any())


def loses_strength(law: JointLaw) -> bool:
    """Return whether far slip lessens the shear strength of a law, at one of the pressures that are probed."""
    pressure = np.array(PROBED)
    one, intact = np.ones_like(pressure), np.zeros(len(pressure), dtype=bool)
    slid = [np.full(len(pressure), PAST[name]) for name in remembered_by(law)]
    peak = law.respond(pressure, np.zeros_like(one), one, intact).strength
    failed = law.respond(pressure, BEYOND_STRENGTH * one, one, intact, *slid).failed
    left = law.respond(pressure, BEYOND_STRENGTH * one, one, failed, *slid).strength
    return bool((left < peak * (1 - 1e-9)).any())


def _array_faults(name: str, values: Any, like: FloatArray) -> list[str]:
    kind = np.dtype(bool if name in ("sticking", "failed") else float)
    if isinstance(values, np.ndarray) and values.shape == like.shape and values.dtype == kind:
        return []
    have = f"{values.dtype} of shape {values.shape}" if isinstance(values, np.ndarray) else type(values).__name__
    return [f"returns {name} as {have}; it must be an array of {kind} with an entry a contact, {like.shape} here"]


def _response_faults(answer: JointResponse, pressure: FloatArray, failed: BoolArray) -> list[str]:
    """Return the faults of an answer about contacts, of which the first two do not touch."""

    def where(bad: BoolArray) -> str:
        return f"at the pressure {pressure[np.flatnonzero(bad)[0]]:g} N/m"

    faults = []
    wild = ~(np.isfinite(answer.shear) & np.isfinite(answer.by_pressure))
    if wild.any():
        faults.append(
            f"returns shear or by_pressure that are not finite {where(wild)} "
            "(contacts that do not touch have pressure 0)"
        )
    none = ~(answer.strength >= 0)
    beyond = answer.shear > answer.strength * (1 + 1e-12)
    if none.any():
        faults.append(f"returns a strength that is not 0 or more {where(none)}")
    elif (negative := answer.shear < 0).any():
        faults.append(f"returns a negative shear {where(negative)}; it must return its magnitude")
    elif beyond.any():
        faults.append(f"returns more shear than strength {where(beyond)}")
    if (answer.failed != failed)[:2].any():
        faults.append(
            "changes the state of contacts that do not touch: pressure and trial shear 0 must leave failed as it is"
        )
    if (failed & ~answer.failed).any():
        faults.append("corrects contacts that have failed: failed stays true")
    return faults


def residual_tension_faults(residual: float, peak: float, law: JointLaw | None) -> list[str]:
    """Return the faults of the tensile strength that slip leaves [Pa] of a peak one, a sentence each."""
    if residual > peak:
        return [
            f"residual_tensile_strength = {residual:g} Pa is above tensile_strength = {peak:g} Pa: a joint grows no "
            "stronger by failing; exchange them, or leave residual_tensile_strength out"
        ]
    if residual > 0 and law is not None and not fails_by_slip(law):
        return [
            f"residual_tensile_strength = {residual:g} Pa never acts: by its law slip takes no tension away; give "
            "mohr_coulomb residual_cohesion or residual_friction (the peak values where slip takes tension alone), or "
            "leave residual_tensile_strength out"
        ]
    return []
