"""Ranges: every number of the model file and of the classes has one, and both have the same."""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Iterator
from typing import Annotated, Any, get_args, get_type_hints

import pytest
from pydantic import ValidationError

import bsm_mesh as bsm
from bsm_mesh.model import quantities
from bsm_mesh.model.quantities import quantities_of
from bsm_mesh.model.quantity import Quantity
from bsm_mesh.modelfile import model_tables as tables
from bsm_mesh.modelfile.bolt_tables import BoltTable
from bsm_mesh.modelfile.class_keys import given_in, keys_of
from bsm_mesh.modelfile.material_tables import FillingTable, JointTable, RockTable
from bsm_mesh.modelfile.mesh_tables import Table
from bsm_mesh.modelfile.model_file import sentences
from tests.scenes.small_case import MODEL, Case

SAME: dict[Any, Any] = {  # table of the file: class of the model
    RockTable: bsm.Rock,
    FillingTable: bsm.Filling,
    JointTable: bsm.Joint,
    tables.SupportTable: bsm.PrescribedDisplacement,
    BoltTable: bsm.Bolt,
    tables.InSituTable: bsm.InSitu,
    tables.WaterTable: bsm.Water,
    tables.StageTable: bsm.Stage,
    tables.SolverTable: bsm.Options,
}
CLASSES = [*SAME.values(), bsm.Patton, bsm.MohrCoulomb, bsm.Roller, bsm.Model]
ALL = {name: value for name, value in vars(quantities).items() if isinstance(value, Quantity)}


def numbers_without_range(schema: Any, place: str) -> Iterator[str]:
    """Walk a JSON Schema; say where a number has no least or no greatest value."""
    if isinstance(schema, list):
        for part in schema:
            yield from numbers_without_range(part, place)
    elif isinstance(schema, dict):
        kind = schema.get("type")
        numeric = {"number", "integer"} & set(kind if isinstance(kind, list) else [kind])
        if (
            numeric
            and "const" not in schema
            and not ({"minimum", "exclusiveMinimum"} & set(schema) and {"maximum", "exclusiveMaximum"} & set(schema))
        ):
            yield place
        for key, part in schema.items():
            if key not in ("default", "examples", "enum", "description", "title"):
                yield from numbers_without_range(part, f"{place}.{key}")


def test_every_number_of_the_model_file_has_a_range() -> None:
    schema = tables.ModelFile.model_json_schema()
    assert list(numbers_without_range(schema, "model")) == []
    assert str(schema).count("'maximum'") > 60  # the walk sees them
    assert list(numbers_without_range({"properties": {"a": {"anyOf": [{"type": "number"}]}}}, "")) != []


@pytest.mark.parametrize("owner", CLASSES, ids=lambda owner: owner.__name__)
def test_every_number_of_a_class_has_a_range(owner: type) -> None:
    hints = get_type_hints(owner, localns={"Options": bsm.Options}, include_extras=True)
    for field in dataclasses.fields(owner):
        members = (
            get_args(hints[field.name]) if isinstance(hints[field.name], types.UnionType) else (hints[field.name],)
        )
        assert not {int, float} & set(members) or field.name == "surface", f"{owner.__name__}.{field.name}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wet(bsm.Rock):
    """A rock with a number more.

    Attributes
    ----------
    water : float or None [Pa]
        Pressure of its pores; None: dry.
    """

    water: Annotated[float, quantities.PRESSURE] | None = None


@keys_of(Wet, without=("name",))
class WetTable(Table):
    """A wet rock."""


def test_a_number_of_a_class_is_a_key_of_the_file() -> None:
    """Its type, range, default and description are in the class alone."""
    table = WetTable.model_validate({"unit_weight": "26 kN/m^3", "water": "20 kPa"})
    assert given_in(table, Wet) == {**given_in(RockTable(unit_weight=26e3), Wet), "water": 20e3}
    with pytest.raises(ValidationError) as refused:
        WetTable.model_validate({"water": "-1 Pa", "watr": 1})
    assert list(sentences(refused.value, WetTable))[:2] == [
        "top level: needs the key 'unit_weight'",
        f'water = "-1 Pa": {quantities.PRESSURE.rule_in_file}',
    ]
    assert "unknown key 'watr'; did you mean 'water'" in list(sentences(refused.value, WetTable))[2]
    described = WetTable.model_json_schema()["properties"]["water"]["description"]
    assert described == "Pressure of its pores; left out: dry [Pa]"


IN_SPACE = {"trend", "gravity_trend"}  # directions in space: keys of files with three dimensions alone


def test_the_file_has_every_number_of_the_classes() -> None:
    for table, owner in SAME.items():
        assert set(quantities_of(owner)) - IN_SPACE <= set(table.model_fields)


@pytest.mark.parametrize("name", ALL)
def test_ranges_are_closed_and_hold_what_is_usual(name: str) -> None:
    quantity = ALL[name]
    low, high = max(quantity.above, quantity.least), min(quantity.below, quantity.most)
    assert -math.inf < low < high < math.inf
    assert (quantity.least == -math.inf) != (quantity.above == -math.inf)
    assert (quantity.most == math.inf) != (quantity.below == math.inf)
    if quantity.usual is not None:
        assert low <= quantity.usual[0] < quantity.usual[1] <= high
    for bad in (math.nan, math.inf, -math.inf, 1e29, -1e29):
        assert not quantity.holds(bad)


SILLY = [  # old, new, words: what was once taken without a word
    ('"26 kN/m^3"', '"26e9 kN/m^3"', "[rock.gneiss] unit_weight"),
    ("friction = 35", 'law = "mohr_coulomb"\nfriction = 35\ncohesion = 1e29', "[joint.J1] cohesion"),
    ('fix = "all"', "direction = 1e29", "[[support]] number 1, direction = 1e+29: must be -360 to 360 degrees"),
    ('"1 MPa"', "1e29", "[[load]] number 1, pressure"),
    ('file = "mesh.msh"', 'file = "mesh.msh"\nunit = "Ym"', '[mesh] unit = "Ym": must be 1e-6 to 10000 m'),
    ('file = "mesh.msh"', 'file = "mesh.msh"\nunit = "nm"', "rock is measured in um to km"),
    ('boundary = "bottom"', "blocks = []", "[[support]] number 1, blocks = []: must not be empty"),
    *(
        (MODEL[-1:], f"\n{text}\n", words)
        for text, words in (
            ("[gravity]\ndirection = 1e29", "[gravity] direction = 1e+29: must be -360 to 360 degrees"),
            ("[gravity]\nhorizontal = 15", "[gravity] horizontal = 15: must be -2 to 2, for example 0.15"),
            ('[[stage]]\nname = "a"\ngravity = {vertical = -9.81}', "gravity.vertical = -9.81: must be -2 to 2"),
            ('[[stage]]\nname = "a"\nstrength = {J1 = 0}', "strength.J1 = 0: must be 1e-6 to 1e6"),
            ('[[stage]]\nname = "a"\nstrength = {J2 = 0.5}', "stage 'a': strength: there is no joint 'J2'"),
            ("[in_situ]\nsurface = 2\nk0 = -5", "[in_situ] k0 = -5: must be 0 to 20, for example 0.5"),
            ("[in_situ]\nsurface = 2\nk0 = 1e29", "[in_situ] k0 = 1e+29: must be 0 to 20"),
            ("[in_situ]\nsurface = 2\nk0 = {a = 1e29}", "[in_situ] k0"),
            ("[in_situ]\nsurface = -1", "the whole model lies above the surface"),
            ("[in_situ]\nsurface = 20e3", "the surface lies 19998 m above the model, at most 10000 m"),
            (
                "[water]\ntable = [[0, 20e3]]",
                "water: the table lies 19998 m above the model, at most 10000 m are taken",
            ),
            ("[in_situ]\nsurface = 1e29", "[in_situ] surface = 1e+29: must be"),
            ("[in_situ]\nsurface = 2\nk0 = {b = 0.1, c = -0.1}", "a tension at the depth 2 m"),
            ('[in_situ]\nmethod = "gravity"\nk0 = 0.5', "in_situ: k0 belongs to a surface; give the surface"),
            ('[in_situ]\nstress = {yy = "-1 MPa"}\nk0 = 0.5', "k0 belongs to a surface; a given stress has it"),
            ("[water]\ntable = [[0, 1]]\nunit_weight = 0", "[water] unit_weight = 0: must be 1e-9 to 1e6"),
            (
                "[water]\ntable = [[0, 1]]\nunit_weight = 9.81",
                "water: unit_weight = 9.81 N/m^3 is 2650 times less than",
            ),
            ("[solver]\ntolerance = 0.05", "[solver] tolerance = 0.05: must be 1e-12 to 1e-4"),
            ("[solver]\ntolerance = 1e-300", "lost in rounding"),
            ("[solver]\nmax_steps = 0", "[solver] max_steps = 0: must be a whole number, 1 to"),
            ('[solver]\ndisplacement_limit = "2 Mm"', "[solver] displacement_limit"),
            (
                "[[bolt]]\ndiameter = 25\nstart = [0, 0]\nend = [1, 1]",
                "[[bolt]] number 1, diameter = 25: must be 0.001",
            ),
            (
                '[[bolt]]\ndiameter = "25 mm"\nradial = {centre = [0, 0], radius = 1, length = 1, count = 10000000}',
                "[[bolt]] number 1, radial.count = 10000000: must be a whole number, 1 to 10000",
            ),
            (
                '[[stage]]\nname = "a"\npressure = "1 kPa"',
                "stage 'a': pressure acts on surfaces that the stage lays bare",
            ),
        )
    ),
]


@pytest.mark.parametrize(("old", "new", "words"), SILLY)
def test_silly_numbers_are_refused(case: Case, old: str, new: str, words: str) -> None:
    text = MODEL[:-1] + new if old == MODEL[-1:] else MODEL.replace(old, new)
    case.write("model.toml", text)
    case.refuses("check", "model.toml", says=[words])


@pytest.mark.parametrize(
    ("value", "needed"),
    [(26, True), (26e3, False), (1, False), (2.6e-5, False), (0, False)],  # in kN/m^3, N/m^3, of a scheme, N/mm^3, none
)
def test_a_plain_unit_weight_in_kilonewtons_needs_its_unit(value: float, needed: bool) -> None:
    assert quantities.UNIT_WEIGHT.needs_unit(value) is needed
