"""Keys of a model file: the way to a place in its content, and the kind of number that is there."""

from __future__ import annotations

import re
from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.model.quantity import Quantity
from bsm_mesh.modelfile.mesh_tables import Table
from bsm_mesh.modelfile.units import AtAnyDepth, Each

PART = re.compile(r'"([^"]+)"|([^."]+)')
PARTS = re.compile(rf"(?:{PART.pattern})(?:\.(?:{PART.pattern}))*")


def key_parts(key: str) -> list[str]:
    """Return the parts of a key.

    Examples
    --------
    >>> key_parts('joint."J1.5".friction')
    ['joint', 'J1.5', 'friction']

    Raises
    ------
    ModelError
        If it is no key.
    """
    found = [match[1] or match[2] for match in PART.finditer(key)]
    if not PARTS.fullmatch(key):
        raise ModelError(f"'{key}' is no key; write the way to it with dots, for example joint.J1.friction")
    return found


def put(content: dict[str, Any], key: str, value: object, root: type[Table]) -> Any:
    """Put a value where a key leads to, in the content of a file; return the type that its schema `root` gives it."""
    parts = key_parts(key)
    place: Any = content
    schema: Any = root  # the type of `place`; None where anything may stand
    for k, part in enumerate(parts):
        way, last = ".".join(parts[:k]) or "a model file", k == len(parts) - 1
        if not isinstance(place, dict | list):
            raise ModelError(f"'{key}': {way} is a value, which has no keys")
        name: Any = _entry(place, part, way, key) if isinstance(place, list) else part
        schema = _type_of(schema, place, part, way, key)
        bare = _bare(schema)
        if last and _is_table(bare):
            raise ModelError(f"'{key}' is a table; add one of its keys{nearest(part, bare.by_key())}")
        if last:
            place[name] = value
        elif isinstance(place, dict):
            place = place.setdefault(name, [] if get_origin(bare) is list else {})
        else:
            place = place[name]
    return schema


def _type_of(schema: Any, place: Any, part: str, way: str, key: str) -> Any:
    """Return the type of the values of a key's part; raise where the table has no such key."""
    for each in _said_of(schema, (Each,)):
        return Annotated[float, each.quantity]
    for deep in _said_of(schema, (AtAnyDepth,)):
        is_number = isinstance(place, list) and not isinstance(place[_entry(place, part, way, key)], list)
        return Annotated[float, deep.quantity] if is_number else Annotated[Any, deep]
    schema = _bare(schema)
    if _is_table(schema):
        fields = schema.by_key()
        if part not in fields:
            raise ModelError(f"'{key}': {way} has no key '{part}'{nearest(part, fields)}")
        field = fields[part]
        return Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
    member = get_args(schema)[-1] if get_origin(schema) in (list, dict) else None
    if isinstance(place, dict) and _is_table(member) and part not in place:
        raise ModelError(f"'{key}': the model file has no [{way}.{part}]{nearest(part, place)}")
    return member


def _entry(place: list[Any], part: str, way: str, key: str) -> int:
    """Return which entry of a list a part of a key means, from 0."""
    number = entry_number(part, place)
    if number is not None:
        return number
    names = [entry["name"] for entry in place if isinstance(entry, dict) and isinstance(entry.get("name"), str)]
    if not place:
        raise ModelError(f"'{key}': the model file has no {way}")
    if names and not part.isdecimal():
        raise ModelError(f"'{key}': no {way} has the name '{part}'{nearest(part, names)}")
    raise ModelError(f"'{key}': write which {way} is meant by its number, 1 to {len(place)}")


def entry_number(part: str, place: list[Any]) -> int | None:
    """Return the place in a list of the entry of this name, or of this number from 1."""
    named = [k for k, entry in enumerate(place) if isinstance(entry, dict) and entry.get("name") == part]
    if named:
        return named[0]
    return int(part) - 1 if part.isdecimal() and 1 <= int(part) <= len(place) else None


def _is_table(schema: Any) -> bool:
    return isinstance(schema, type) and get_origin(schema) is None and issubclass(schema, Table)


def _bare(annotation: Any) -> Any:
    """Return a type without the description of it, and without that it may be left out."""
    if get_origin(annotation) is Annotated:
        return _bare(get_args(annotation)[0])
    kinds = [kind for kind in get_args(annotation) if kind is not NoneType]
    is_optional = get_origin(annotation) in (Union, UnionType) and len(kinds) == 1
    return _bare(kinds[0]) if is_optional else annotation


def quantity_in(annotation: Any) -> Quantity | None:
    """Return what kind of number a type is of, if it is one."""
    return next(_said_of(annotation, (Quantity,)), None)


def _said_of(annotation: Any, kinds: tuple[type, ...]) -> Iterator[Any]:
    """Return what of some kinds is said of a type, or of the members of a union."""
    if get_origin(annotation) is Annotated:
        inner, *said = get_args(annotation)
        yield from (one for one in said if isinstance(one, kinds))
        yield from _said_of(inner, kinds)
    elif get_origin(annotation) in (Union, UnionType):
        for part in get_args(annotation):
            yield from _said_of(part, kinds)


def numbers_of(table: type[Table], name: str = "") -> Iterator[tuple[str, str, Quantity]]:
    """Yield all numbers that a table of the file may hold: the table, the key, and the quantity.

    A table in a table has its own name; a list, or what stands under a user's own names, the name of its entries.
    """
    for key, field in table.model_fields.items():
        annotation = Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
        if (quantity := quantity_within(annotation)) is not None:
            yield name, key, quantity
        elif (inner := table_within(annotation)) is not None:
            yield from numbers_of(inner, key)


def quantity_within(annotation: Any) -> Quantity | None:
    """Return the quantity of a type that is a number, or whose entries are numbers."""
    each = next(_said_of(annotation, (Each,)), None)
    found = each.quantity if each is not None else quantity_in(annotation)
    bare = _bare(annotation)
    if found is None and get_origin(bare) in (list, dict):
        return quantity_within(get_args(bare)[-1])
    return found


def table_within(annotation: Any) -> type[Table] | None:
    """Return the table that a key holds, once, in a list or under names of the user's."""
    bare = _bare(annotation)
    if get_origin(bare) in (list, dict):
        bare = _bare(get_args(bare)[-1])
    return bare if _is_table(bare) else None
