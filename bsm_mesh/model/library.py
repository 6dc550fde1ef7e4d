"""Published values for rocks and joints, to start from (Wang Tables A.1, A.2, A.3 and 8.3).

The elastic moduli of the Cassiar rocks in Table A.1 are ten times those of Table 8.3, which the analyses used:
Table 8.3's are given where it has the rock, a tenth of A.1's otherwise. Values of other rocks are the typical ones;
their ranges are wide, and a project's own tests come first.

Examples
--------
>>> from bsm_mesh import library
>>> library.rock("sandstones", unit_weight=24e3).young
18000000000.0
>>> library.joint("serpentine joints", law=library.strength("serpentinite joints")).law
MohrCoulomb(friction=28.0, cohesion=0.0, residual_friction=None, residual_cohesion=None, softening_slip=None)
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, TypeVar

from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.joint_laws import JointLaw, MohrCoulomb
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.values import Rules

CASSIAR = "Cassiar Mining Corporation and Piteau Associates (1990)"
FRANKLIN = "Franklin and Dusseault (1989)"
GOODMAN = "Goodman (1989), Introduction to Rock Mechanics, 2nd ed."


@dataclass(frozen=True, slots=True)
class RockEntry:
    """Elastic constants of a rock (Wang Table A.1): E [Pa], Poisson's ratio, unit weight [N/m3], and where from."""

    name: str
    young: float
    poisson: float | None
    unit_weight: float | None
    source: str


@dataclass(frozen=True, slots=True)
class JointEntry:
    """Stiffness of a joint [Pa/m] (Wang Table A.2), what was tested, and where it comes from."""

    name: str
    normal_stiffness: float
    shear_stiffness: float
    test: str
    source: str


@dataclass(frozen=True, slots=True)
class StrengthEntry:
    """Cohesion [Pa] and friction angle [degrees] (Wang Table A.3), pressure range, and where they come from."""

    name: str
    cohesion: float
    friction: float
    pressure: str
    source: str


def _cassiar(name: str, young: float, poisson: float, weight: float | None, table: str) -> RockEntry:
    return RockEntry(name, young * 1e9, poisson, weight and weight * 1e3, f"{CASSIAR}; Wang Table {table}")


def _typical(name: str, young: float, poisson: float | None) -> RockEntry:
    return RockEntry(name, young * 1e9, poisson, None, f"{FRANKLIN}; Wang Table A.1, typical value")


def _tested(name: str, normal: float, shear: float, test: str, source: str) -> JointEntry:
    return JointEntry(name, normal * 1e9, shear * 1e9, test, f"{source}; Wang Table A.2")


def _strength(name: str, cohesion: float, friction: float, pressure: str = "", source: str = CASSIAR) -> StrengthEntry:
    return StrengthEntry(name, cohesion * 1e6, friction, pressure, f"{source}; Wang Table A.3")


ROCKS: tuple[RockEntry, ...] = (
    _cassiar("argillite", 21.0, 0.24, 28.2, "8.3"),
    _cassiar("serpentinite", 9.65, 0.30, 25.3, "8.3"),
    _cassiar("volcanics", 25.99, 0.24, 29.9, "A.1, a tenth"),
    _cassiar("sylvester group rocks", 21.1, 0.24, 28.1, "A.1, a tenth"),
    _cassiar("serpentinite rock shear", 1.79, 0.33, None, "A.1, a tenth"),
    _typical("crystalline limestones", 60, 0.25),
    _typical("porous limestones", 45, 0.24),
    _typical("chalk", 2, 0.10),
    _typical("salt", 26, 0.26),
    _typical("sandstones", 18, 0.15),
    _typical("quartzite", 62, 0.18),
    _typical("slates and high-durability shales", 40, 0.22),
    _typical("low-durability shales", 5, None),
    _typical("coal", 3, 0.42),
    _typical("coarse-grained igneous rocks", 56, 0.20),
    _typical("fine-grained igneous rocks", 62, 0.22),
    _typical("schists", 40, 0.15),
)

JOINTS: tuple[JointEntry, ...] = (
    _tested("serpentine shear zones", 2.03, 0.27, "laboratory direct shear, large cores", CASSIAR),
    _tested("serpentine joints", 9.52, 0.86, "laboratory direct shear, large cores, 1.72 MPa", CASSIAR),
    _tested("argillite joints", 43.2, 0.667, "laboratory direct shear, large cores", CASSIAR),
    _tested("boise sandstone, sawn", 35.1, 1.29, "laboratory direct shear, dry, 2.43 MPa", "Mahtab (1969)"),
    _tested("marly sand filling", 1.96, 2.34, "field direct shear, 1-2 mm thick, 0.98 MPa", "Goodman (1968)"),
    _tested("closely jointed shale in limestone", 0.24, 0.02, "field direct shear, 2-5 mm, 0.02 MPa", "Goodman (1968)"),
    _tested("shale interbed, wet", 0.26, 0.02, "field direct shear, 2-5 mm thick, 0.02-0.03 MPa", "Goodman (1968)"),
    _tested("sierra white granite", 100, 1.7, "not said", "Goodman, Heuze and Ohnishi (1972)"),
    _tested("shale, natural joint at 3.5 MPa", 8.6, 43.6, "laboratory direct shear, NX cores", "Rosso (1976)"),
    _tested("shale, natural joint at 7.1 MPa", 81.1, 49.7, "laboratory direct shear, NX cores", "Rosso (1976)"),
    _tested("shale, natural joint at 10.6 MPa", 102, 77.0, "laboratory direct shear, NX cores", "Rosso (1976)"),
    _tested("shale, natural joint, triaxial 1-2.7 MPa", 38.5, 22.3, "jointed triaxial, NX cores", "Rosso (1976)"),
    _tested("shale, natural joint, triaxial 3.5-8.6 MPa", 96.3, 33.4, "jointed triaxial, NX cores", "Rosso (1976)"),
    _tested("shale, natural joint, triaxial 7.1-18 MPa", 96.3, 96.3, "jointed triaxial, NX cores", "Rosso (1976)"),
)

STRENGTHS: tuple[StrengthEntry, ...] = (
    _strength("serpentinite shear zones", 0.14, 26.75),  # 26.5-27: the middle, as for the ranges below
    _strength("serpentinite joints", 0.0, 28.0, "1.7 MPa"),
    _strength("argillite joints", 0.0, 30.15),
    _strength("argillite", 0.69, 32.0),
    _strength("barren serpentinite", 0.35, 26.0),
    _strength("ore bearing serpentinite", 0.21, 26.0),
    _strength("berea sandstone", 27.2, 27.8, "0-200 MPa", GOODMAN),
    _strength("bartlesville sandstone", 8.0, 37.2, "0-203 MPa", GOODMAN),
    _strength("pottsville sandstone", 14.9, 45.2, "0-68.9 MPa", GOODMAN),
    _strength("repetto siltstone", 34.7, 32.1, "0-200 MPa", GOODMAN),
    _strength("muddy shale", 38.4, 14.4, "0-200 MPa", GOODMAN),
    _strength("stockton shale", 0.34, 22.0, "0.8-4.1 MPa", GOODMAN),
    _strength("edmonton bentonitic shale", 0.3, 7.5, "0.1-3.1 MPa, water content 30 %", GOODMAN),
    _strength("sioux quartzite", 70.6, 48.0, "0-203 MPa", GOODMAN),
    _strength("texas slate, 30 degrees to cleavage", 26.2, 21.0, "34.5-276 MPa", GOODMAN),
    _strength("texas slate, 90 degrees to cleavage", 70.3, 26.9, "34.5-276 MPa", GOODMAN),
    _strength("georgia marble", 21.2, 25.3, "5.6-68.9 MPa", GOODMAN),
    _strength("wolf camp limestone", 23.6, 34.8, "0-203 MPa", GOODMAN),
    _strength("indiana limestone", 6.72, 42.0, "0-9.6 MPa", GOODMAN),
    _strength("hasmark dolomite", 22.8, 35.5, "0.8-5.9 MPa", GOODMAN),
    _strength("chalk", 0.0, 31.5, "10-90 MPa", GOODMAN),
    _strength("blaine anhydrite", 43.4, 29.4, "0-203 MPa", GOODMAN),
    _strength("inada biotite granite", 55.2, 47.7, "0.1-98 MPa", GOODMAN),
    _strength("stone mountain granite", 55.1, 51.0, "0-68.9 MPa", GOODMAN),
    _strength("nevada test site basalt", 66.2, 31.0, "3.4-34.5 MPa", GOODMAN),
    _strength("schistose gneiss, 90 degrees to schistosity", 46.9, 28.0, "0-69 MPa", GOODMAN),
    _strength("schistose gneiss, 30 degrees to schistosity", 14.8, 27.6, "0-69 MPa", GOODMAN),
)

Entry = TypeVar("Entry", RockEntry, JointEntry, StrengthEntry)


def rock(name: str, **changes: Any) -> Rock:
    """Return a rock of Table A.1 (8.3 for Cassiar); `changes` set or replace fields of `Rock`.

    Raises
    ------
    ModelError
        For an unknown name, or a rock whose table row lacks its unit weight or Poisson's ratio where none is given.
    """
    entry = _find("rock", name, ROCKS)
    given = {"young": entry.young, "poisson": entry.poisson, "unit_weight": entry.unit_weight, **changes}
    if given["unit_weight"] is None:
        raise ModelError(f"the library has no unit weight of '{entry.name}'; give it: unit_weight = 26e3 [N/m3], or 0")
    return Rock(given.pop("name", name), **given)


def joint(name: str, law: JointLaw | None = None, **changes: Any) -> Joint:
    """Return a joint with the stiffness of Table A.2; `changes` set or replace fields of `Joint`."""
    entry = _find("joint", name, JOINTS)
    found = Joint(name, normal_stiffness=entry.normal_stiffness, shear_stiffness=entry.shear_stiffness, law=law)
    return dataclasses.replace(found, **changes)


def strength(name: str) -> MohrCoulomb:
    """Return the strength of Table A.3 as a Mohr-Coulomb law; the middle where the table gives a range."""
    entry = _find("strength", name, STRENGTHS)
    return MohrCoulomb(friction=entry.friction, cohesion=entry.cohesion)


def _find(kind: str, name: str, entries: tuple[Entry, ...]) -> Entry:
    rules = Rules("library")
    rules.text(f"the name of a {kind}", name)
    raise_faults(rules.faults)
    found = next((entry for entry in entries if entry.name == name.lower()), None)
    if found is None:
        raise ModelError(f"the library has no {kind} '{name}'{nearest(name.lower(), [e.name for e in entries])}")
    return found
