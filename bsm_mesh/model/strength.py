"""Strength that is a part of the given one: of joint laws, of joints and rocks of a model, of its bolts.

A factor of safety divides by it the tangent of every friction angle and every cohesion (strength reduction); a stage
multiplies by what weathering or rain leaves. Tensile strength belongs to them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import gathered, nearest, placed, raise_faults
from bsm_mesh.model.bolt_layout import label
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.joint_laws import (
    BEYOND_STRENGTH,
    JointLaw,
    JointResponse,
    ReducibleLaw,
    StraightLaw,
    handed_on,
    refuse_factor,
    remembered_by,
    wear_length_of,
)
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.quantities import STRENGTH_FACTOR
from bsm_mesh.model.values import Rules

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model

ALL_JOINTS = "*"
OF_ROCK = "rock:"
BOLT_CAPACITIES = (
    "yield_strength",
    "anchor_capacity",
    "bond_strength",
    "bond_steel_grout",
    "bond_grout_rock",
    "bearing_strength",
    "plate",
)


@dataclass(frozen=True, slots=True)
class Reduced:
    """A law whose shear forces are those of another, divided by a factor.

    Attributes
    ----------
    law : JointLaw
        The other law, which knows nothing of it.
    factor : float
        More than 1 weakens, less strengthens.
    """

    law: JointLaw
    factor: float

    @property
    def wear_length(self) -> float | None:
        """That of the other law [m]."""
        return wear_length_of(self.law)

    @property
    def remembers(self) -> tuple[str, ...]:
        """Those of the other law."""
        return remembered_by(self.law)

    def respond(
        self,
        pressure: FloatArray,
        trial_shear: FloatArray,
        length: FloatArray,
        failed: BoolArray,
        *memory: FloatArray,
    ) -> JointResponse:
        """Return the response of the other law to a trial shear that is greater by the factor, divided by it."""
        trial = self.factor * np.minimum(trial_shear, BEYOND_STRENGTH)  # whoever asks for the strength asks with more
        answer = self.law.respond(pressure, trial, length, *handed_on(self.law, self, failed, memory))
        return replace(
            answer,
            shear=np.where(answer.sticking, trial_shear, answer.shear / self.factor),  # without rounding
            by_pressure=answer.by_pressure / self.factor,
            strength=answer.strength / self.factor,
        )

    def reduced(self, factor: float) -> JointLaw:
        """Return the other law, divided by both factors."""
        return reduced_law(self.law, self.factor * factor)


@dataclass(frozen=True, slots=True)
class ReducedStraight(Reduced):
    """A `Reduced` law whose strength is bounded by straight lines."""

    law: StraightLaw

    def strength_lines(self, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lines of the other law, divided by the factor."""
        slope, intercept = (np.asarray(values, dtype=float) for values in self.law.strength_lines(length))
        return slope / self.factor, intercept / self.factor


def reduced_law(law: JointLaw, factor: float) -> JointLaw:
    """Return a law at its strength over a factor: as it says itself, or with all its shear forces divided.

    Raises
    ------
    ModelError
        Where the factor, or a value of the law over it, is out of range.

    Examples
    --------
    >>> from bsm_mesh.model.joint_laws import MohrCoulomb
    >>> weaker = reduced_law(MohrCoulomb(friction=45, cohesion=3e3), 2)
    >>> round(weaker.friction, 3), weaker.cohesion
    (26.565, 1500.0)
    """
    refuse_factor(factor)
    if factor == 1:
        return law
    if isinstance(law, ReducibleLaw):
        return law.reduced(factor)
    return ReducedStraight(law, factor) if isinstance(law, StraightLaw) else Reduced(law, factor)


def law_name(law: JointLaw) -> str:
    """Return the name of a law's class; of a `Reduced` one that of the law which is reduced."""
    return type(law.law if isinstance(law, Reduced) else law).__name__


def with_strength(model: Model, factors: Mapping[str, float]) -> Model:
    """Return a model in which joints, and faces of rock, have other strength.

    The factor multiplies the tangent of friction angles, cohesion and tensile strength, residual values too. So
    strength reduction by a factor F is ``with_strength(model, {"*": 1 / F})``.

    Parameters
    ----------
    model : Model
        The model.
    factors : mapping of str to float
        Factor of each strength, by names of joints; ``"*"``: every joint with a law that is not named;
        ``"rock:NAME"``: faces of that rock without a joint, ``"rock:*"``: those of every rock that is not named.

    Raises
    ------
    ModelError
        With every fault: names that do not exist, named joints without a law, named rocks without strength. Factors
        and strengths out of range are faults too.
    """
    joints, rocks = joints_and_rocks_at(model, factors)
    pairs = zip((*joints, *rocks), (*model.joints, *model.rocks), strict=True)
    return model if all(one is other for one, other in pairs) else model.replace(joints=joints, rocks=rocks)


def joints_and_rocks_at(model: Model, factors: Mapping[str, float]) -> tuple[tuple[Joint, ...], tuple[Rock, ...]]:
    """Return the joints and rocks of `with_strength`, which names the increase."""
    raise_faults(_name_faults(model, factors))
    parts = resolved(model, factors)
    joints, rocks = [], []
    for joint in model.joints:
        with placed(f"joint '{joint.name}'"):
            joints.append(_joint_at(joint, parts.get(joint.name, 1.0)))
    for rock in model.rocks:
        with placed(f"rock '{rock.name}'"):
            rocks.append(_rock_at(rock, parts.get(OF_ROCK + rock.name, 1.0)))
    return tuple(joints), tuple(rocks)


def strength_faults(model: Model, factors: Mapping[str, float]) -> list[str]:
    """Return what `with_strength` would raise, a sentence each."""
    faults: list[str] = []
    with gathered(faults):
        joints_and_rocks_at(model, factors)
    return faults


def _name_faults(model: Model, factors: Mapping[str, float]) -> list[str]:
    """Return the faults of factors of strength and of the names in them."""
    rules = Rules("strength")
    given = rules.mapping("factors", factors)
    joints = {joint.name: joint.law is not None for joint in model.joints}
    rocks = {OF_ROCK + rock.name: rock.can_fail for rock in model.rocks}
    for key, factor in given.items():
        rules.number(key, factor, STRENGTH_FACTOR)
        if key in (ALL_JOINTS, OF_ROCK + ALL_JOINTS):
            continue
        name, is_rock = key.removeprefix(OF_ROCK), key.startswith(OF_ROCK)
        if key not in (rocks if is_rock else joints):
            known = [rock.name for rock in model.rocks] if is_rock else joints
            kind = "rock" if is_rock else "joint"
            rules.faults.append(f"{rules.thing}: there is no {kind} '{name}'{nearest(name, known)}")
        elif is_rock and not rocks[key]:
            rules.faults.append(
                f"{rules.thing}: rock '{name}' has no strength that could be reduced: its faces carry whatever comes; "
                "give it cohesion, friction or tensile_strength"
            )
        elif not is_rock and not joints[key]:
            rules.faults.append(
                f"{rules.thing}: joint '{name}' has no law, so no strength that could be reduced; give it friction"
            )
    return rules.faults


def resolved(model: Model, factors: Mapping[str, float]) -> dict[str, float]:
    """Return the factor of every joint with a law, and of every rock with strength, that factors mean."""
    joints = [joint.name for joint in model.joints if joint.law is not None]
    rocks = [OF_ROCK + rock.name for rock in model.rocks if rock.can_fail]
    found = {}
    for names, rest in ((joints, ALL_JOINTS), (rocks, OF_ROCK + ALL_JOINTS)):
        for name in names:
            if name in factors or rest in factors:
                found[name] = float(factors[name if name in factors else rest])
    return found


def _joint_at(joint: Joint, part: float) -> Joint:
    if joint.law is None or part == 1:
        return joint
    tension = {name: part * getattr(joint, name) for name in ("tensile_strength", "residual_tensile_strength")}
    dilation = _scaled(joint.dilation_angle, part)
    return replace(joint, law=reduced_law(joint.law, 1 / part), dilation_angle=dilation, **tension)


def _scaled(degrees: float, part: float) -> float:
    """Return the angle [degrees] whose tangent is a part of an angle's."""
    return math.degrees(math.atan(part * math.tan(math.radians(degrees))))


def _rock_at(rock: Rock, part: float) -> Rock:
    if part == 1:
        return rock
    if rock.hoek_brown is not None and rock.zones is not None:
        flow = replace(rock.zones, dilation=_scaled(rock.zones.dilation, part))
        return replace(rock, hoek_brown=rock.hoek_brown.reduced(1 / part), zones=flow)
    if rock.law is None:
        return rock
    law = rock.law.reduced(1 / part)
    named = [field.name for field in fields(law) if getattr(rock, field.name) is not None]
    tension = None if rock.tensile_strength is None else part * rock.tensile_strength
    left = part * rock.residual_tensile_strength
    strengths = {name: getattr(law, name) for name in named}
    zones = rock.zones
    if zones is not None and zones.dilation:
        zones = replace(zones, dilation=min(_scaled(zones.dilation, part), law.friction))
    return replace(rock, tensile_strength=tension, residual_tensile_strength=left, zones=zones, **strengths)


def with_bolt_capacities(model: Model, factor: float) -> Model:
    """Return a model whose bolts carry other forces: all that limits them is multiplied by a factor.

    That is yield and anchorage, bond, plate and bearing strength; stiffness stays. Where a bolt no longer carries its
    pretension, that is its load.

    Raises
    ------
    ModelError
        Where the factor, or a capacity times it, is out of range.
    """
    refuse_factor(factor)
    if factor == 1:
        return model
    bolts = []
    for number, bolt in enumerate(model.bolts):
        with placed(f"{label(model.bolts, number)}: capacities times {factor:g}"):
            bolts.append(_bolt_at(bolt, factor))
    return model.replace(bolts=bolts)


def _bolt_at(bolt: Bolt, factor: float) -> Bolt:
    limits = {name: getattr(bolt, name) for name in BOLT_CAPACITIES if getattr(bolt, name) is not None}
    capacities = {name: factor * value for name, value in limits.items()}
    unstressed = replace(bolt, pretension=0.0, **capacities)
    bears = min(unstressed.yield_force, np.inf if unstressed.anchor_capacity is None else unstressed.anchor_capacity)
    return replace(unstressed, pretension=min(bolt.pretension, float(bears)))
