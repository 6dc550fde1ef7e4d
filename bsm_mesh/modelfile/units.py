"""The pydantic types of the model file that are more than one number: points, lines, stresses that vary in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import PlainValidator, WithJsonSchema

from bsm_mesh.model.quantities import BLOCK, COORDINATE, FORCE, FORCE_IN_SPACE, STRESS, STRESS_GRADIENT
from bsm_mesh.model.quantity import Quantity, convert, schema_of


@dataclass(frozen=True, slots=True)
class Each:
    """Quantity of every entry of a list."""

    quantity: Quantity


@dataclass(frozen=True, slots=True)
class AtAnyDepth:
    """Quantity of every number in lists of lists, as of points and of lines."""

    quantity: Quantity


def components(quantity: Quantity, axes: str, told: str = "") -> Any:
    """Return the pydantic type of a vector or point, a number for each of the axes such as "xy"."""
    count, names = {2: "two", 3: "three"}[len(axes)], ", ".join(axes)

    def read(value: object) -> tuple[float, ...]:
        if not isinstance(value, list | tuple) or len(value) != len(axes):
            raise ValueError(f"needs {count} numbers [{names}] in {quantity.unit}{told}")
        return tuple(convert(part, quantity) for part in value)

    schema = {"type": "array", "items": schema_of(quantity), "minItems": len(axes), "maxItems": len(axes)}
    return Annotated[Any, PlainValidator(read), WithJsonSchema(schema), Each(quantity)]


def _linear_stress(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple):
        return convert(value, STRESS), 0.0, 0.0
    if len(value) != 3:
        raise ValueError("needs one stress, or three values [c, a_x, a_y] for c + a_x x + a_y y")
    return _coefficients(value)


def _space_stress(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple):
        return convert(value, STRESS), 0.0, 0.0, 0.0
    if len(value) != 4:
        raise ValueError("needs one stress, or four values [c, a_x, a_y, a_z] for c + a_x x + a_y y + a_z z")
    return _coefficients(value)


def _coefficients(value: list[object] | tuple[object, ...]) -> tuple[float, ...]:
    return convert(value[0], STRESS), *(convert(part, STRESS_GRADIENT) for part in value[1:])


def _linear_stress_pair(value: object) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("needs two components [t_x, t_y], each a stress or [c, a_x, a_y]")
    return tuple(map(_linear_stress, value))


def _space_stress_triple(value: object) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise ValueError("needs three components [t_x, t_y, t_z], each a stress or [c, a_x, a_y, a_z]")
    return tuple(map(_space_stress, value))


def _linear_schema(axes: str = "xy") -> dict[str, Any]:
    parts, count = [schema_of(STRESS), *[schema_of(STRESS_GRADIENT)] * len(axes)], 1 + len(axes)
    several = {"type": "array", "prefixItems": parts, "minItems": count, "maxItems": count}
    form = ", ".join(["c", *(f"a_{axis}" for axis in axes)])
    return {"anyOf": [*schema_of(STRESS)["anyOf"], several], "description": f"Pa, or [{form}]"}


LinearStress = Annotated[Any, STRESS, PlainValidator(_linear_stress), WithJsonSchema(_linear_schema())]
SpaceStress = Annotated[Any, STRESS, PlainValidator(_space_stress), WithJsonSchema(_linear_schema("xyz"))]
LinearStressPair = Annotated[
    Any,
    PlainValidator(_linear_stress_pair),
    WithJsonSchema({"type": "array", "items": _linear_schema(), "minItems": 2, "maxItems": 2}),
    Each(STRESS),
]
SpaceStressTriple = Annotated[
    Any,
    PlainValidator(_space_stress_triple),
    WithJsonSchema({"type": "array", "items": _linear_schema("xyz"), "minItems": 3, "maxItems": 3}),
    Each(STRESS),
]


def _line(value: object) -> Any:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("needs points [[x, y], ...] in m")
    read = []
    for point in value:
        if not isinstance(point, list | tuple) or len(point) != 2:
            raise ValueError("needs points [[x, y], ...] in m")
        read.append((convert(point[0], COORDINATE), convert(point[1], COORDINATE)))
    return tuple(read)


def lines_of(value: object) -> Any:
    """Return one line or several as several."""
    if not isinstance(value, list | tuple):
        raise ValueError("needs points [[x, y], ...] in m, or several such lists")
    if not value:
        return ()
    first = value[0]
    several = isinstance(first, list | tuple) and len(first) > 0 and isinstance(first[0], list | tuple)
    return tuple(_line(line) for line in (value if several else [value]))


def _level(value: object) -> Any:
    return _line(value) if isinstance(value, list | tuple) else convert(value, COORDINATE)


_POINTS = {"type": "array", "items": {"type": "array", "items": schema_of(COORDINATE), "minItems": 2, "maxItems": 2}}
LINES_SCHEMA: dict[str, Any] = {"anyOf": [_POINTS, {"type": "array", "items": _POINTS}]}
Lines = Annotated[Any, AtAnyDepth(COORDINATE), PlainValidator(lines_of), WithJsonSchema(LINES_SCHEMA)]
Level = Annotated[
    Any,
    COORDINATE,
    AtAnyDepth(COORDINATE),
    PlainValidator(_level),
    WithJsonSchema({"anyOf": [*schema_of(COORDINATE)["anyOf"], _POINTS]}),
]


def _region(value: object) -> Any:
    if isinstance(value, str):
        return value
    if isinstance(value, int) and not isinstance(value, bool):
        return convert(value, BLOCK)
    try:
        points = _line(value)
    except ValueError:
        points = ()
    if len(points) < 3:
        raise ValueError("must be the name of an excavation group, a block's number, or a polygon [[x, y], ...] in m")
    return points


Region = Annotated[
    Any, PlainValidator(_region), WithJsonSchema({"anyOf": [{"type": "string"}, schema_of(BLOCK), _POINTS]})
]


def _space_region(value: object) -> Any:
    if isinstance(value, str):
        return value
    if isinstance(value, int) and not isinstance(value, bool):
        return convert(value, BLOCK)
    raise ValueError("must be the name of an excavation, or a block's number")


SpaceRegion = Annotated[
    Any, PlainValidator(_space_region), WithJsonSchema({"anyOf": [{"type": "string"}, schema_of(BLOCK)]})
]


Point = components(COORDINATE, "xy")
Force = components(FORCE, "xy")
Vector = components(COORDINATE, "xyz", ": east, north, up")
SpaceForce = components(FORCE_IN_SPACE, "xyz", ": east, north, up")
