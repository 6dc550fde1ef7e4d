"""Published values for rocks, joints and bolts, to start from (Wang Tables A.1, A.2, A.3 and 8.3; steel by standards).

The elastic moduli of the Cassiar rocks in Table A.1 are ten times those of Table 8.3, which the analyses used.
Here they are those of Table 8.3, or a tenth of those of Table A.1 for rocks that Table 8.3 does not have.
Argillite is in both, with other values: A.1's has a name of its own. Values of other rocks are the typical ones.
Their ranges are wide, and a project's own tests come first.

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
from typing import Any, TypeAlias, TypeVar

from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.joint_laws import JointLaw, MohrCoulomb
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.values import Rules

CASSIAR = "Cassiar Mining Corporation and Piteau Associates (1990)"
FRANKLIN = "Franklin and Dusseault (1989)"
GOODMAN = "Goodman (1989), Introduction to Rock Mechanics, 2nd ed."


Range: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class RockEntry:
    """Elastic constants of a rock (Wang Table A.1): E [Pa], Poisson's ratio, unit weight [N/m3], and where from.

    `young_range` and `poisson_range` are the reported values, None where the table gives none.
    """

    name: str
    young: float
    poisson: float | None
    unit_weight: float | None
    source: str
    young_range: Range | None = None
    poisson_range: Range | None = None


@dataclass(frozen=True, slots=True)
class JointEntry:
    """Stiffness of a joint [Pa/m] (Wang Table A.2), the specimen, and the source."""

    name: str
    normal_stiffness: float
    shear_stiffness: float
    test: str
    source: str


@dataclass(frozen=True, slots=True)
class StrengthEntry:
    """Cohesion [Pa] and friction angle [degrees] (Wang Table A.3), pressure range, and where they come from.

    `friction_range` is the table's range instead of one angle, of which `friction` is the middle.
    """

    name: str
    cohesion: float
    friction: float
    pressure: str
    source: str
    friction_range: Range | None = None


@dataclass(frozen=True, slots=True)
class BoltEntry:
    """The steel of a bolt: nominal diameter [m], E and yield strength [Pa], and the standards that they are from."""

    name: str
    diameter: float
    young: float
    yield_strength: float
    source: str


def _bar(name: str, diameter: float, yield_strength: float, source: str) -> BoltEntry:
    return BoltEntry(name, diameter * 1e-3, 200e9, yield_strength * 1e6, source)


def _cassiar(name: str, young: float, poisson: float, weight: float | None, table: str) -> RockEntry:
    return RockEntry(name, young * 1e9, poisson, weight and weight * 1e3, f"{CASSIAR}; Wang Table {table}")


def _typical(
    name: str, young: float, young_range: Range, poisson: float | None, poisson_range: Range | None
) -> RockEntry:
    reported = young_range[0] * 1e9, young_range[1] * 1e9
    source = f"{FRANKLIN}; Wang Table A.1, typical value"
    return RockEntry(name, young * 1e9, poisson, None, source, reported, poisson_range)


def _tested(name: str, normal: float, shear: float, test: str, source: str) -> JointEntry:
    return JointEntry(name, normal * 1e9, shear * 1e9, test, f"{source}; Wang Table A.2")


def _strength(
    name: str, cohesion: float, friction: float | Range, pressure: str = "", source: str = CASSIAR
) -> StrengthEntry:
    given = friction if isinstance(friction, tuple) else None
    middle = friction if not isinstance(friction, tuple) else (friction[0] + friction[1]) / 2
    return StrengthEntry(name, cohesion * 1e6, middle, pressure, f"{source}; Wang Table A.3", given)


ROCKS: tuple[RockEntry, ...] = (
    _cassiar("argillite", 21.0, 0.24, 28.2, "8.3"),
    _cassiar("serpentinite", 9.65, 0.30, 25.3, "8.3"),
    _cassiar("argillites of table a.1", 17.44, 0.23, 26.7, "A.1, a tenth"),
    _cassiar("volcanics", 25.99, 0.24, 29.9, "A.1, a tenth"),
    _cassiar("sylvester group rocks", 21.1, 0.24, 28.1, "A.1, a tenth"),
    _cassiar("serpentinite rock shear", 1.79, 0.33, None, "A.1, a tenth"),
    _typical("crystalline limestones", 60, (17, 100), 0.25, (0.06, 0.50)),
    _typical("porous limestones", 45, (10, 100), 0.24, (0.15, 0.29)),
    _typical("chalk", 2, (0.1, 12), 0.10, (0.05, 0.15)),
    _typical("salt", 26, (5, 44), 0.26, (0.06, 0.73)),
    _typical("sandstones", 18, (1, 100), 0.15, (0.02, 0.51)),
    _typical("quartzite", 62, (11, 119), 0.18, (0.10, 0.40)),
    _typical("slates and high-durability shales", 40, (12, 96), 0.22, (0.02, 0.38)),
    _typical("low-durability shales", 5, (2, 30), None, None),
    _typical("coal", 3, (1, 30), 0.42, (0.17, 0.49)),
    _typical("coarse-grained igneous rocks", 56, (8, 125), 0.20, (0.05, 0.39)),
    _typical("fine-grained igneous rocks", 62, (7, 117), 0.22, (0.07, 0.38)),
    _typical("schists", 40, (5, 98), 0.15, (0.01, 0.40)),
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
    _strength("serpentinite shear zones", 0.14, (26.5, 27.0)),
    _strength("serpentinite joints", 0.0, (26.0, 30.0), "1.7 MPa"),
    _strength("argillite joints", 0.0, (27.3, 33.0)),
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

EUROPEAN = "nominal diameters of EN 10080, which has no grades; B500 of DIN 488-1 and BS 4449; E of EN 1992-1-1"
AMERICAN = "ASTM A615/A615M, nominal diameters and least yield strength; E of ACI 318"

BOLTS: tuple[BoltEntry, ...] = (
    *(_bar(f"b500 {diameter} mm", diameter, 500.0, EUROPEAN) for diameter in (12, 16, 20, 25, 28, 32, 40)),
    *(
        _bar(f"grade {grade} no. {number}", diameter, strength, AMERICAN)
        for grade, strength in ((60, 420.0), (75, 520.0))
        for number, diameter in ((6, 19.1), (7, 22.2), (8, 25.4), (9, 28.7), (10, 32.3), (11, 35.8))
    ),
)

Entry = TypeVar("Entry", RockEntry, JointEntry, StrengthEntry, BoltEntry)


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


def bolt(name: str, start: tuple[float, float], end: tuple[float, float], **changes: Any) -> Bolt:
    """Return a bolt of a bar's steel from head to tip [m]; `changes` set or replace fields of `Bolt`.

    How it is bonded is not the bar's: give `bond_strength`, `bond_stiffness`, `spacing` and so on.

    Examples
    --------
    >>> round(bolt("B500 25 mm", (0, 0), (0, -3), spacing=1.5).yield_force)
    245437
    """
    entry = _find("bolt", name, BOLTS)
    steel = {"diameter": entry.diameter, "young": entry.young, "yield_strength": entry.yield_strength}
    return Bolt(start=start, end=end, **{**steel, **changes})


def _find(kind: str, name: str, entries: tuple[Entry, ...]) -> Entry:
    rules = Rules("library")
    rules.text(f"the name of a {kind}", name)
    raise_faults(rules.faults)
    found = next((entry for entry in entries if entry.name == name.lower()), None)
    if found is None:
        raise ModelError(f"the library has no {kind} '{name}'{nearest(name.lower(), [e.name for e in entries])}")
    return found
