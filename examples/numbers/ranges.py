"""The reference of the model file, from its schema: every key with its form, default, unit, range and description."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import TypeAdapter
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from bsm_mesh.modelfile.keys import quantity_within, table_within
from bsm_mesh.modelfile.mesh_tables import Table as FileTable
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.space_tables import SpaceFile
from examples.numbers.pages import Table, markdown

CUT_ROCK = ("mesh", "joint_set", "joint_plane", "excavation", "slope", "key_blocks")
ON_ROCK = ("support", "load", "bolt", "in_situ", "water", "gravity", "stage", "history")
PAGES: dict[str, tuple[type[FileTable], tuple[str, ...]]] = {  # page: model file, and its tables there
    "ground": (ModelFile, ("", "mesh", "rock", "joint")),
    "loads": (ModelFile, ("boundary", "support", "load", "gravity", "in_situ", "water", "flow")),
    "bolts": (ModelFile, ("bolt",)),
    "stages": (ModelFile, ("stage",)),
    "run": (ModelFile, ("history", "solver", "falls", "output", "report")),
    "space": (SpaceFile, ("", *CUT_ROCK, *ON_ROCK)),
}
HEADER = ("key", "default", "range and unit", "usual", "meaning")


def make_keys(file: type[FileTable], names: tuple[str, ...]) -> str:
    """Return the tables of a page, a heading each."""
    parts = []
    for name in names:
        if name == "":
            plain = {key: field for key, field in file.model_fields.items() if table_within(typed(field)) is None}
            parts.append(f"## Top level\n\n{markdown(HEADER, rows_of(plain))}")
            continue
        table = table_within(typed(file.model_fields[name]))
        assert table is not None
        for path, inner in tables_within(file, name, table):
            parts.append(f"## {title(file, path)}\n\n{markdown(HEADER, rows_of(inner.model_fields))}")
    return "\n\n".join(parts)


def tables_within(file: type[FileTable], path: str, table: type[FileTable]) -> Iterator[tuple[str, type[FileTable]]]:
    """Yield a table and the tables in it that stand nowhere else, each with the way to it."""
    yield path, table
    top = {table_within(typed(field)) for field in file.model_fields.values()}
    for key, field in table.model_fields.items():
        inner = table_within(typed(field))
        if inner is not None and inner not in top:
            yield from tables_within(file, f"{path}.{key}", inner)


def title(file: type[FileTable], path: str) -> str:
    """Return a table as it is written in a model file."""
    first, _, rest = path.partition(".")
    kind = get_origin(file.model_fields[first].annotation)
    name = f"{first}.NAME" if kind is dict else first
    return f"`[[{name}]]`" if kind is list and not rest else f"`[{name}{'.' + rest if rest else ''}]`"


def typed(field: FieldInfo) -> Any:
    """Return the type of a key with its annotations."""
    return Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation


def rows_of(fields: dict[str, FieldInfo]) -> list[tuple[str, ...]]:
    """Return a row for each key."""
    rows = []
    for key, field in fields.items():
        quantity = quantity_within(typed(field))
        meaning = (field.description or "").removesuffix(f" [{quantity.unit}]" if quantity else "")
        usual = quantity.usual_span.removesuffix(f" {quantity.unit}") if quantity else ""
        given = quantity.span if quantity else form(field.annotation) or form_of_schema(typed(field))
        meaning = meaning or ("its keys are in a table of their own" if table_within(typed(field)) else "")
        rows.append((f"`{field.alias or key}`", default_of(field), given, usual, meaning.replace("|", "or")))
    return rows


def default_of(field: FieldInfo) -> str:
    """Return the default of a key in the words of a model file."""
    if field.is_required():
        return "required"
    if field.default is PydanticUndefined or field.default is None or field.default in ("", ()):
        return "-"
    if isinstance(field.default, bool):
        return f"`{str(field.default).lower()}`"
    return f'`"{field.default}"`' if isinstance(field.default, str) else f"`{field.default}`"


def form(annotation: Any) -> str:
    """Return what may be given where it is not a number: words to choose from, or the kind of the value."""
    words = [f'`"{word}"`' if isinstance(word, str) else f"`{word}`" for word in choices(annotation)]
    if words:
        return ", ".join(words)
    return " or ".join(dict.fromkeys(kinds_of(annotation)))


def form_of_schema(annotation: Any) -> str:
    """Return what may be given by the JSON Schema of a type that reads its values itself."""
    schema = TypeAdapter(annotation).json_schema()
    return ", ".join(dict.fromkeys(_forms(schema))) or "table"


def _forms(schema: dict[str, Any]) -> Iterator[str]:
    for part in schema.get("anyOf", ()):
        yield from _forms(part)
    if "enum" in schema:
        yield from (f'`"{word}"`' for word in schema["enum"])
    elif schema.get("type") == "number" and "minimum" in schema and "maximum" in schema:
        yield f"{schema['minimum']:g} to {schema['maximum']:g}"
    elif schema.get("type") in NAMES:
        yield NAMES[schema["type"]]


NAMES = {"object": "table", "array": "list", "number": "number"}
KINDS = {bool: "`true` or `false`", str: "text", int: "whole number", float: "number", list: "list", dict: "table"}


def kinds_of(annotation: Any) -> Iterator[str]:
    """Yield the kinds of value that a type holds."""
    if get_origin(annotation) is Annotated:
        yield from kinds_of(get_args(annotation)[0])
    elif (kind := get_origin(annotation) or annotation) in KINDS:
        yield KINDS[kind]
    elif kind is tuple:
        yield KINDS[list]
    else:
        for part in get_args(annotation):
            yield from kinds_of(part)


def choices(annotation: Any) -> list[object]:
    """Return the words to choose from."""
    if get_origin(annotation) is Literal:
        return list(get_args(annotation))
    if get_origin(annotation) in (list, dict):
        return []
    return [word for part in get_args(annotation) for word in choices(part)]


TABLES = tuple(
    Table(name=f"keys-{page}", page=f"docs/keys_{page}.md", make=partial(make_keys, file, names), tolerance=0.0)
    for page, (file, names) in PAGES.items()
)
