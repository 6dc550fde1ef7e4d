"""Whatever version 1.0.0 promised is still there: keys and values of model files, commands, options, public names.

`tests/stored/surface_1_0_0.json` was written from that version's schema, command line and modules.
"""

from __future__ import annotations

import inspect
import json
from enum import EnumType
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from bsm_mesh.commands.cli import cli
from bsm_mesh.modelfile.model_tables import ModelFile

STORED = json.loads((Path(__file__).parents[1] / "stored/surface_1_0_0.json").read_text(encoding="utf-8"))
MODULES = {"bsm_mesh": "bsm_mesh", "converters": "bsm_mesh.converters", "geometries": "bsm_mesh.geometries"}
ENUMERATED = ["boundary", "module", "names", "qualname", "start", "type", "value"]  # their call, before Python 3.12


def tables_of(schema: dict[str, Any]) -> dict[str, dict[str, list[str]]]:
    """Return the keys of every table of a schema, and the words that each may have."""
    tables = {"ModelFile": schema, **schema.get("$defs", {})}
    return {
        name: {key: sorted(words_of(value)) for key, value in sorted(table.get("properties", {}).items())}
        for name, table in tables.items()
    }


def words_of(part: Any) -> set[str]:
    """Return the words of all lists of choices in a part of a schema."""
    if isinstance(part, list):
        return set().union(*map(words_of, part)) if part else set()
    if not isinstance(part, dict):
        return set()
    return {str(word) for word in [*part.get("enum", []), *([part["const"]] if "const" in part else [])]}.union(
        *(words_of(value) for value in part.values())
    )


def names_of(module: str) -> dict[str, list[str]]:
    """Return the public names of a module with their parameters and, of classes, attributes."""
    found = {}
    for name in import_module(module).__all__:
        thing = getattr(import_module(module), name)
        try:
            parts = list(inspect.signature(thing).parameters)
        except (TypeError, ValueError):
            parts = []
        if isinstance(thing, EnumType):
            parts = ENUMERATED
        attributes = [f".{part}" for part in dir(thing) if not part.startswith("_")] if inspect.isclass(thing) else []
        found[name] = sorted([*parts, *attributes])
    return found


def options_of() -> dict[str, list[str]]:
    """Return the commands with their arguments and options."""
    return {
        name: sorted(word for part in command.params for word in (*part.opts, *part.secondary_opts))
        for name, command in cli.commands.items()
    }


def lost(before: dict[str, list[str]], now: dict[str, list[str]]) -> list[str]:
    gone = [name for name in before if name not in now]
    return gone + [f"{name}: {part}" for name in before for part in before[name] if part not in now.get(name, [part])]


def test_every_key_and_value_of_model_files_is_known() -> None:
    now = tables_of(ModelFile.model_json_schema(by_alias=True))
    for table, keys in STORED["model file"].items():
        assert lost(keys, now[table]) == [], table


def test_every_command_and_option_is_there() -> None:
    assert lost(STORED["commands"], options_of()) == []


@pytest.mark.parametrize("module", MODULES)
def test_every_public_name_is_there(module: str) -> None:
    assert lost(STORED[module], names_of(MODULES[module])) == []
