"""Rocks, joints and joint laws as they are given; how they respond lives in `bsm_mesh.contact`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, get_args

from bsm_mesh.errors import placed, raise_faults
from bsm_mesh.model.hoek_brown import HoekBrown
from bsm_mesh.model.joint_laws import JointLaw, MohrCoulomb
from bsm_mesh.model.joint_laws.shear_stiffness import ShearCurve, barton_of, stiffness_faults
from bsm_mesh.model.law_faults import dilation_faults, law_faults, residual_tension_faults
from bsm_mesh.model.quantities import (
    APERTURE,
    CLOSURE,
    COHESION,
    DILATION,
    FRICTION,
    JOINT_TENSILE_STRENGTH,
    POISSON,
    REFERENCE_STRESS,
    SLIP,
    STIFFNESS,
    STIFFNESS_EXPONENT,
    TENSILE_STRENGTH,
    THICKNESS,
    UNIT_WEIGHT,
    WALL_STRENGTH,
    YOUNG,
)
from bsm_mesh.model.values import Rules, is_number, plain_numbers
from bsm_mesh.model.zones import Zones

RockStiffness = Literal["wang", "homogeneous", "triangle", "rigid"]
SOFTENING = ("residual_friction", "residual_cohesion", "softening_slip")  # of faces of rock


@dataclass(frozen=True, slots=True, kw_only=True)
class Filling:
    """A filling thick enough to keep the joint's walls apart (Wang 3.3.3).

    Attributes
    ----------
    thickness : float [m]
        Thickness of the filling.
    young : float [Pa]
        Elastic modulus E of the filling.
    poisson : float
        Poisson's ratio of the filling.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> clay = bsm.Filling(thickness=2e-3, young=50e6, poisson=0.3)
    >>> bsm.Joint("fault", filling=clay, law=bsm.MohrCoulomb(friction=22)).filling.thickness
    0.002
    """

    thickness: Annotated[float, THICKNESS]
    young: Annotated[float, YOUNG]
    poisson: Annotated[float, POISSON]

    def __post_init__(self) -> None:
        rules = Rules("filling")
        rules.numbers(self)
        raise_faults(rules.faults)
        plain_numbers(self)
        for name in ("normal_stiffness", "shear_stiffness"):
            rules.number(f"{name} of young, poisson and thickness", getattr(self, name), STIFFNESS)
        raise_faults(rules.faults)

    @property
    def normal_stiffness(self) -> float:
        """E' / thickness [Pa/m] (Wang Eq. 3.26)."""
        return confined_modulus(self.young, self.poisson) / self.thickness

    @property
    def shear_stiffness(self) -> float:
        """G / thickness [Pa/m] (Wang Eq. 3.26)."""
        return shear_modulus(self.young, self.poisson) / self.thickness


@dataclass(frozen=True, slots=True)
class Rock:
    """A rock: its weight, elasticity and the strength of its unjointed faces.

    Attributes
    ----------
    name : str
        As in the physical group ``rock:name``.
    unit_weight : float [N/m3]
        Weight per volume; 0 for a rock without weight.
    young : float or None [Pa]
        Elastic modulus E; None: rigid.
    poisson : float or None
        Poisson's ratio; needed with `young`.
    cohesion, tensile_strength : float or None [Pa]
        Strength of faces of rock without a joint.
    friction : float or None [degrees]
        Friction angle of faces of rock without a joint. A rock that gives none of the three has elastic
        faces of unlimited strength.
    stiffness : {"wang", "homogeneous", "triangle", "rigid"}
        How E and Poisson's ratio become contact stiffness: the thesis's Eqs. 3.24-3.26; the pair that makes
        every mesh elastically homogeneous (with no Poisson effect); the pair calibrated for triangles; rigid.
    residual_friction, residual_cohesion : float or None [degrees, Pa]
        Residual strength of those faces, as `MohrCoulomb` takes it; None: slip takes nothing away.
    softening_slip : float or None [m]
        Slip over which strength falls to its residual value; None: at the first slip.
    residual_tensile_strength : float [Pa]
        Tension that faces still carry once they have failed by slip; one that has opened carries none.
    zones : Zones or None
        Triangles that its blocks are divided into, with `young` and `poisson`; None: its blocks are rigid.
    hoek_brown : HoekBrown or None
        Strength of zones with ``law="hoek_brown"``.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> rock = bsm.Rock("gneiss", unit_weight=26e3, young=20e9, poisson=0.25)
    >>> rock.young
    20000000000.0
    """

    name: str
    unit_weight: Annotated[float, UNIT_WEIGHT]
    young: Annotated[float, YOUNG] | None = None
    poisson: Annotated[float, POISSON] | None = None
    cohesion: Annotated[float, COHESION] | None = None
    friction: Annotated[float, FRICTION] | None = None
    tensile_strength: Annotated[float, TENSILE_STRENGTH] | None = None
    stiffness: RockStiffness = "wang"
    residual_friction: Annotated[float, FRICTION] | None = None
    residual_cohesion: Annotated[float, COHESION] | None = None
    softening_slip: Annotated[float, SLIP] | None = None
    residual_tensile_strength: Annotated[float, TENSILE_STRENGTH] = 0.0
    zones: Zones | None = field(default=None, metadata={"in_hash": "given"})
    hoek_brown: HoekBrown | None = field(default=None, metadata={"in_hash": "given"})

    def __post_init__(self) -> None:
        rules = Rules("rock", self.name)
        rules.name(self.name)
        rules.numbers(self)
        rules.a_thing("zones", self.zones, Zones, optional=True)
        rules.a_thing("hoek_brown", self.hoek_brown, HoekBrown, optional=True)
        rules.choice("stiffness", self.stiffness, get_args(RockStiffness))
        if not rules.faults and self.young is not None and self.poisson is None and self.stiffness != "rigid":
            rules.faults.append(f"{rules.thing}: young is given without poisson; give poisson (0 to 0.5) as well")
        if not rules.faults and self.zones is not None and self.is_rigid:
            cure = "give young and poisson" if self.young is None else "its stiffness is 'rigid': leave stiffness out"
            rules.faults.append(f"{rules.thing}: zones deform by the rock's elasticity; {cure}")
        raise_faults(rules.faults)
        raise_faults([f"{rules.thing}: {text}" for text in (*self._plastic_faults(), *self._idle_faults())])
        with placed(rules.thing):
            law = self.law
        left = residual_tension_faults(self.residual_tensile_strength, self.tensile_strength or 0.0, law)
        raise_faults([f"{rules.thing}: {text}" for text in left])
        plain_numbers(self)

    @property
    def is_rigid(self) -> bool:
        """Whether faces of this rock have no compliance of their own."""
        return self.young is None or self.stiffness == "rigid"

    @property
    def has_strength(self) -> bool:
        """Whether unjointed faces can fail: the rock gives cohesion, friction or tensile strength."""
        return not (self.cohesion is None and self.friction is None and self.tensile_strength is None)

    @property
    def can_fail(self) -> bool:
        """Whether its unjointed faces or its zones have a strength."""
        return self.has_strength or self.hoek_brown is not None

    @property
    def yields(self) -> bool:
        """Whether its zones yield."""
        return self.zones is not None and self.zones.law != "elastic"

    def _plastic_faults(self) -> list[str]:
        """Return the conflicts of the strength of zones with the rest of the rock, a sentence each."""
        by_curve = self.zones is not None and self.zones.law == "hoek_brown"
        if by_curve != (self.hoek_brown is not None):
            cure = "give hoek_brown, with sigma_ci, gsi and mi" if by_curve else 'give zones = { law = "hoek_brown" }'
            return [f"hoek_brown is the strength of zones that yield by it; {cure}"]
        if self.zones is None or not self.yields:
            return []
        found = []
        if by_curve and self.has_strength:
            found.append("zones yield by hoek_brown; leave cohesion, friction and tensile_strength out")
        if not self.can_fail:
            found.append("zones yield by the rock's strength; give cohesion, friction or tensile_strength")
        if any(getattr(self, name) is not None for name in SOFTENING) or self.residual_tensile_strength:
            found.append("zones that yield keep their strength; leave the residual strength and softening_slip out")
        if not by_curve and self.zones.dilation > (self.friction or 0.0):
            limit = f"friction = {self.friction or 0.0:g}"
            found.append(f"zones: dilation = {self.zones.dilation:g} is above {limit}, and would create energy")
        return found

    def _idle_faults(self) -> list[str]:
        """Return a sentence on residual strength where there is none that slip could reduce."""
        given = [name for name in SOFTENING if getattr(self, name) is not None]
        if not given or self.can_fail:
            return []
        return [
            f"{given[0]} = {getattr(self, given[0]):g} never acts: faces of a rock without cohesion, friction and "
            f"tensile_strength carry whatever comes; give these, or leave {given[0]} out"
        ]

    @property
    def law(self) -> MohrCoulomb | None:
        """The law of faces without a joint; None: they carry whatever comes."""
        if not self.has_strength:
            return None
        return MohrCoulomb(
            friction=self.friction or 0.0,
            cohesion=self.cohesion or 0.0,
            residual_friction=self.residual_friction,
            residual_cohesion=self.residual_cohesion,
            softening_slip=self.softening_slip,
        )

    @property
    def contact_moduli(self) -> tuple[float, float]:
        """Moduli (E_N, E_T) [Pa] whose quotient with the depth h is the contact stiffness; infinite if rigid."""
        if self.is_rigid:
            return math.inf, math.inf
        assert self.young is not None
        assert self.poisson is not None
        E, mu = self.young, self.poisson
        if self.stiffness == "wang":  # Wang Eqs. 3.21, 3.24
            return confined_modulus(E, mu), shear_modulus(E, mu)
        if self.stiffness == "homogeneous":
            plane_strain = E / (1 - mu**2)
            return plane_strain, plane_strain
        lame, G = confined_modulus(E, mu) - 2 * shear_modulus(E, mu), shear_modulus(E, mu)
        return 2 * (lame + G), 2 * G * (lame + G) / (2 * lame + G)


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint or joint set: stiffness per area and strength.

    Attributes
    ----------
    name : str
        As in the physical group ``joint:name``.
    normal_stiffness, shear_stiffness : float or None [Pa/m]
        Stiffness per area; None where `filling` gives them. A `shear_stiffness` that is None with a
        `reference_stress` is that of the law `BartonBandis`: peak strength over the displacement at the peak.
    filling : Filling or None
        A thick filling, instead of the two stiffnesses.
    law : JointLaw or None
        Strength: `Patton`, `MohrCoulomb`, `BartonBandis`, or a law of your own (`bsm_mesh.model.joint_laws`); None:
        elastic.
    tensile_strength : float [Pa]
        Tension the joint carries until it breaks; belongs to a law.
    residual_tensile_strength : float [Pa]
        Tension it still carries once it has failed by slip; where it has opened it carries none.
    dilation_angle : float [degrees]
        By which its walls part as they slide, back and forth, over the first `dilation_slip`; 0: they do not.
        Strength is the law's own, and at least as much as the angle takes at every pressure.
    dilation_slip : float or None [m]
        Slip after which dilation has worn off; needed with `dilation_angle`.
    crushing_strength : float or None [Pa]
        Effective normal stress that crushes its walls: a stage's notes name where it is exceeded; it limits nothing.
    max_closure : float or None [m]
        Greatest closure, to which it comes the nearer the stiffer it becomes (`bsm_mesh.model.joint_laws.closure`);
        `normal_stiffness` is that without stress then. None: its normal stiffness is constant.
    shear_stiffness_exponent : float or None
        Power of the normal stress over `reference_stress` by which `shear_stiffness` grows
        (`bsm_mesh.model.joint_laws.shear_stiffness`); None: it is constant, or the law's.
    reference_stress : float or None [Pa]
        Normal stress at which the joint is as stiff as `shear_stiffness`, and at which the linear scheme takes it.
    aperture : float or None [m]
        Hydraulic aperture without normal stress, which flow takes; 0: sealed.
    residual_aperture : float [m]
        Aperture that no stress closes.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> law = bsm.MohrCoulomb(friction=35, cohesion=20e3)
    >>> bsm.Joint("bedding", normal_stiffness=5e9, shear_stiffness=1e9, law=law).law.friction
    35
    """

    name: str
    normal_stiffness: Annotated[float, STIFFNESS] | None = None
    shear_stiffness: Annotated[float, STIFFNESS] | None = None
    filling: Filling | None = None
    law: JointLaw | None = None
    tensile_strength: Annotated[float, JOINT_TENSILE_STRENGTH] = 0.0
    max_closure: Annotated[float, CLOSURE] | None = None
    residual_tensile_strength: Annotated[float, JOINT_TENSILE_STRENGTH] = 0.0
    dilation_angle: Annotated[float, DILATION] = 0.0
    dilation_slip: Annotated[float, SLIP] | None = None
    crushing_strength: Annotated[float, WALL_STRENGTH] | None = None
    aperture: Annotated[float, APERTURE] | None = None
    residual_aperture: Annotated[float, APERTURE] = 0.0
    shear_stiffness_exponent: Annotated[float, STIFFNESS_EXPONENT] | None = None
    reference_stress: Annotated[float, REFERENCE_STRESS] | None = None

    def __post_init__(self) -> None:
        rules = Rules("joint", self.name)
        rules.name(self.name)
        rules.numbers(self)
        rules.a_thing("filling", self.filling, Filling, optional=True)
        grows = self.reference_stress is not None or self.shear_stiffness_exponent is not None
        given = [self.normal_stiffness is not None, self.shear_stiffness is not None or grows]
        if self.filling is not None and any(given):
            rules.faults.append(f"{rules.thing}: give normal_stiffness and shear_stiffness or filling, not both")
        elif self.filling is None and not all(given):
            rules.faults.append(
                f"{rules.thing}: needs normal_stiffness and shear_stiffness [Pa/m], or filling = "
                "{thickness, young, poisson}"
            )
        if self.filling is not None and self.max_closure is not None:
            rules.faults.append(
                f"{rules.thing}: max_closure is that of bare walls, and a filling keeps them apart; give "
                "normal_stiffness and shear_stiffness instead of filling, or leave max_closure out"
            )
        if self.filling is not None and grows:
            rules.faults.append(
                f"{rules.thing}: a filling's shear stiffness is G over its thickness at any stress; give "
                "normal_stiffness and shear_stiffness instead of filling, or leave reference_stress and "
                "shear_stiffness_exponent out"
            )
        tension = is_number(self.tensile_strength) and bool(self.tensile_strength > 0)
        if self.law is not None:
            rules.faults.extend(f"{rules.thing}: {text}" for text in law_faults(self.law, tension=tension))
        elif tension:
            rules.faults.append(
                f"{rules.thing}: tensile_strength = {self.tensile_strength:g} Pa never acts: a joint without a law "
                "carries any tension and shear; give it a law (friction), or leave tensile_strength out"
            )
        raise_faults(rules.faults)
        left = residual_tension_faults(self.residual_tensile_strength, self.tensile_strength, self.law)
        left += dilation_faults(self.dilation_angle, self.dilation_slip, self.law)
        left += stiffness_faults(self.shear_stiffness, self.shear_stiffness_exponent, self.reference_stress, self.law)
        if self.aperture is None and self.residual_aperture > 0:
            left.append("residual_aperture is the part of aperture that no stress closes; give aperture too")
        elif self.aperture is not None and self.residual_aperture > self.aperture:
            left.append(
                f"residual_aperture = {self.residual_aperture:g} m is above aperture = {self.aperture:g} m, and stress "
                "opens no joint; exchange them, or give a smaller one"
            )
        raise_faults([f"{rules.thing}: {text}" for text in left])
        plain_numbers(self)

    def without_law(self) -> Joint:
        """Return the joint as it is where nothing slips or opens."""
        return replace(
            self,
            shear_stiffness=self.shear_stiffness if self.filling is not None else self.contact_stiffness[1],
            shear_stiffness_exponent=None,
            reference_stress=None,
            law=None,
            tensile_strength=0.0,
            residual_tensile_strength=0.0,
            dilation_angle=0.0,
            dilation_slip=None,
        )

    @property
    def contact_stiffness(self) -> tuple[float, float]:
        """Normal and shear stiffness per area [Pa/m] (Wang's K_n'' and K_s'')."""
        if self.filling is not None:
            return self.filling.normal_stiffness, self.filling.shear_stiffness
        assert self.normal_stiffness is not None
        if self.shear_stiffness is None:
            assert self.shear_curve is not None
            assert self.reference_stress is not None
            return self.normal_stiffness, self.shear_curve.at(self.reference_stress)
        return self.normal_stiffness, self.shear_stiffness

    @property
    def shear_curve(self) -> ShearCurve | None:
        """Shear stiffness by the normal stress; None: it is constant."""
        if self.reference_stress is None:
            return None
        if self.shear_stiffness is not None and self.shear_stiffness_exponent is not None:
            return ShearCurve.power(self.shear_stiffness, self.reference_stress, self.shear_stiffness_exponent)
        barton = barton_of(self.law)
        assert barton is not None
        return ShearCurve.barton(barton, self.reference_stress)


def confined_modulus(young: float, poisson: float) -> float:
    """Return E' = (1 - mu) E / ((1 + mu)(1 - 2 mu)) [Pa] (Wang Eq. 3.21)."""
    return (1 - poisson) * young / ((1 + poisson) * (1 - 2 * poisson))


def shear_modulus(young: float, poisson: float) -> float:
    """Return G = E / (2 (1 + mu)) [Pa] (Wang Eq. 3.21)."""
    return young / (2 * (1 + poisson))
