"""Values of laws at another strength: tangents of angles and cohesions divided by a factor."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from bsm_mesh.errors import placed, raise_faults
from bsm_mesh.model.quantities import STRENGTH_FACTOR
from bsm_mesh.model.values import Rules

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    OfLines = TypeVar("OfLines", bound=DataclassInstance)


def refuse_factor(factor: float) -> None:
    """Raise a `ModelError` for a factor by which no strength can be divided."""
    rules = Rules("reduced strength")
    rules.number("factor", factor, STRENGTH_FACTOR)
    raise_faults(rules.faults)


def reduced_angle(angle: float, factor: float) -> float:
    """Return the angle whose tangent is that of an angle, divided by a factor [degrees]."""
    refuse_factor(factor)
    return angle if factor == 1 else math.degrees(math.atan(math.tan(math.radians(angle)) / factor))


def reduced_angle_or_none(angle: float | None, factor: float) -> float | None:
    """Return `reduced_angle`; None of None."""
    return None if angle is None else reduced_angle(angle, factor)


def at_strength(law: OfLines, factor: float, **strength: Any) -> OfLines:
    """Return a law with other values; where one is out of range, say by what its strength was divided."""
    with placed(f"strength divided by {factor:g}"):
        return replace(law, **strength)


def above_peak(residual: float, name: str, peak: float) -> str:
    """Return the sentence on a residual friction that exceeds the peak [degrees]."""
    return (
        f"residual_friction = {residual:g} degrees is above {name} = {peak:g} degrees: the joint would grow stronger "
        "by failing; give less, or leave it out"
    )
