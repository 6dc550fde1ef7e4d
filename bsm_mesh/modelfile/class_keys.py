"""Keys of the model file that are fields of a class of the model: type, range, default and description are there."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import MISSING, Field, fields
from functools import cache
from typing import Any, TypeVar

from pydantic import Field as Key
from pydantic import create_model

from bsm_mesh.model.quantities import hint_of, quantities_of
from bsm_mesh.modelfile.mesh_tables import Table

AnyTable = TypeVar("AnyTable", bound=Table)


def keys_of(
    *owners: type, without: Collection[str] = (), optional: bool = False, names: Mapping[type, str] | None = None
) -> Callable[[type[AnyTable]], type[AnyTable]]:
    """Return a decorator that adds the fields of classes to the keys of a table.

    Parameters
    ----------
    *owners : type
        Dataclasses, documented as numpydoc asks for. Of a field that several have the first one's range holds.
    without : collection of str
        Fields that are no keys. Keys that the table declares itself stay as they are.
    optional : bool
        Whether every key may be left out, even where the class demands its field.
    names : mapping of type to str, optional
        Name of each class in a model file: the description of a key says whose it is.
    """

    def extended(table: type[AnyTable]) -> type[AnyTable]:
        keys: dict[str, Any] = {}
        for owner in owners:
            for field in fields(owner):
                if field.name not in {*without, *keys, *table.model_fields}:
                    said = _whose(field.name, owners, names) + descriptions_of(owner).get(field.name, "")
                    quantity, _ = quantities_of(owner).get(field.name, (None, True))
                    said += f" [{quantity.unit}]" if quantity is not None and quantity.unit else ""
                    hint, default = _form(owner, field, optional)
                    keys[field.name] = hint, Key(description=said or None, **default)
        doc, module = table.__doc__, table.__module__
        return create_model(table.__name__, __base__=table, __doc__=doc, __module__=module, **keys)

    return extended


def given_in(table: Table, owner: type, without: Collection[str] = ()) -> dict[str, Any]:
    """Return the fields of a class that a table gives; lists become tuples."""
    names = [f.name for f in fields(owner) if f.name in type(table).model_fields and f.name not in without]
    values = {name: getattr(table, name) for name in names}
    return {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}


def _form(owner: type, field: Field[Any], optional: bool) -> tuple[Any, dict[str, Any]]:
    """Return the type of a key, and its default where it may be left out."""
    hint = hint_of(owner, field.name)
    if optional:
        return hint | None, {"default": None}
    if field.default_factory is not MISSING:
        return hint, {"default_factory": field.default_factory}
    return hint, {} if field.default is MISSING else {"default": field.default}


def _whose(name: str, owners: Collection[type], names: Mapping[type, str] | None) -> str:
    mine = [names[owner] for owner in owners if any(name == field.name for field in fields(owner))] if names else []
    return f"{', '.join(mine)}: " if mine else ""


@cache
def descriptions_of(owner: type) -> dict[str, str]:
    """Return the descriptions of a class's attributes, in the words of a file: None is a key that is left out.

    Examples
    --------
    >>> from bsm_mesh.model import Rock
    >>> descriptions_of(Rock)["softening_slip"]
    'Slip over which strength falls to its residual value; left out: at the first slip'
    """
    return dict(_descriptions(inspect.getdoc(owner) or ""))


def _descriptions(text: str) -> Iterator[tuple[str, str]]:
    section = text.partition("Attributes\n----------\n")[2].partition("\n\n")[0]
    for head, lines in re.findall(r"^(\S.*?) : .*\n((?:    .*\n?)*)", section + "\n", flags=re.MULTILINE):
        said = " ".join(lines.split()).removesuffix(".").replace("`", "")
        said = re.sub(r"(^|[.] )None\b", r"\1Left out", said)
        for name in head.split(", "):
            yield name, re.sub(r"\bNone\b", "left out", said)
