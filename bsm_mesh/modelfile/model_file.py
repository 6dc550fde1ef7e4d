"""The model file read: faults reported by key and place."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError

from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.quantity import Quantity
from bsm_mesh.modelfile.build_parts import faults_of_parts
from bsm_mesh.modelfile.mesh_tables import Table
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.reading import as_typed, refuse_special
from bsm_mesh.version import __version__

SCHEMA_VERSION = 1  # what ModelFile describes
MAX_BYTES = 64 << 20
MAX_KEYS = 30  # of a table in a message: no table has more
MAX_HOMES = 3  # tables that have a key, in a message
MEMBER = re.compile(r"(function|lax|constrained|list|tuple|dict|union|literal|nullable)[a-z-]*\[")  # pydantic's
MESHES = (".msh", ".vtu", ".vtk", ".inp", ".unv", ".bdf", ".med", ".geo")  # endings that are no model file's
TOO_WIDE = "has more digits than TOML knows (64 bits); correct it"
PLAIN_WORDS = {  # for pydantic's names of faults
    "string_type": "must be a text, in quotes",
    "list_type": "must be a list, in brackets",
    "too_short": "must not be empty: give block numbers, or leave the support out",  # blocks of a support
    "int_type": "must be a whole number, without quotes",
    "int_from_float": "must be a whole number",
}
HOW_TO_GIVE = {
    "mesh": '; for example [mesh] with file = "mesh.msh"',
    "rock": "; for example [rock.gneiss] with unit_weight, young and poisson",
}


def read_model_file(path: Path) -> ModelFile:
    """Return the content of a model file.

    Raises
    ------
    ModelError
        If the file is missing or no TOML, or with every key and value that is wrong.
    """
    return validated(read_toml(path, "model file"), path.name)


def read_toml(path: Path, kind: str) -> dict[str, Any]:
    """Return the content of a TOML file as it is.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        Its kind, for messages: ``model file``.

    Raises
    ------
    ModelError
        If the file is missing, too large or no TOML.
    """
    refuse_special(path)
    try:
        too_large = path.stat().st_size > MAX_BYTES
        text = (
            "" if too_large else path.read_text(encoding="utf-8-sig")
        )  # some editors begin a file with a byte order mark
    except FileNotFoundError:
        alike = sorted(entry.name for entry in path.parent.glob("*.toml"))
        raise ModelError(f"{path}: there is no such file{nearest(path.name, alike) if alike else ''}") from None
    except IsADirectoryError:
        raise ModelError(f"{path} is a folder; give the {kind} in it ({kind.partition(' ')[0]}.toml)") from None
    except UnicodeDecodeError:
        raise ModelError(f"{path}: not a text file; a {kind} is TOML in UTF-8") from None
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError:  # a NUL in it
        raise ModelError(f"{path}: is no path; correct it") from None
    if too_large:
        raise ModelError(f"{path}: is larger than any {kind} ({MAX_BYTES >> 20} MB); is it the mesh?")
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        if path.suffix.lower() in MESHES:
            raise ModelError(
                f"{path}: is a mesh, no {kind}; name it in one ([mesh] file = {path.name!r}), or read its blocks in "
                f"Python: converters.read_blocks({path.name!r}, blocks='regions')"
            ) from None
        if path.suffix.lower() == ".py":
            raise ModelError(
                f"{path}: is a Python script, no {kind}; name a script with build(path) in one "
                f"([mesh] geometry = {path.name!r}), or the mesh that it writes ([mesh] file)"
            ) from None
        raise ModelError(f"{path}: not valid TOML: {_toml_fault(str(error), text)}") from None
    except ValueError:  # of int(), which takes no thousands of digits
        raise ModelError(f"{path}: a whole number in it {TOO_WIDE}") from None
    except RecursionError:
        raise ModelError(f"{path}: not a {kind}: brackets nested too deep") from None
    raise_faults([f"{path.name}: {key} = a whole number that {TOO_WIDE}" for key in _too_wide(content)])
    _refuse_other_kind(content, path, kind)
    return content


def _refuse_other_kind(content: dict[str, Any], path: Path, kind: str) -> None:
    """Raise for a model file where a study file is expected, and the other way round."""
    of_model, of_study = not content.keys().isdisjoint(("mesh", "rock")), "vary" in content
    if kind == "study file" and of_model and not of_study:
        raise ModelError(
            f"{path}: is a model file, not a study file; solve it with `{as_typed('run', path)}`, or write a study "
            f'file with model = "{path.name}" and a table [vary]'
        )
    if kind == "model file" and of_study and not of_model:
        model = f", or give its model file: {path.parent / str(content['model'])}" if "model" in content else ""
        raise ModelError(f"{path}: is a study file, not a model file; run it with `{as_typed('study', path)}`{model}")


def validated(content: dict[str, Any], name: str) -> ModelFile:
    """Return the content of a model file, checked; `name` is the file's, for messages.

    Raises
    ------
    ModelError
        With every key and value that is wrong.
    """
    version = content.get("schema_version")
    if isinstance(version, int) and version > SCHEMA_VERSION:  # what else it holds cannot be judged
        raise ModelError(
            f"{name}: schema_version = {version}: is of a newer bsm-mesh; "
            f"version {__version__} reads {SCHEMA_VERSION}: update it"
        )
    if content.get("dimensions") == 3:
        raise ModelError(f"{name}: is a model of three dimensions, and this command is for the plane")
    try:
        return ModelFile.model_validate(content)
    except ValidationError as error:
        told = dict.fromkeys([*sentences(error), *faults_of_parts(content)])
        raise ModelError([f"{name}: {text}" for text in told]) from None


def _too_wide(content: Any, key: str = "") -> Iterator[str]:
    """Return where whole numbers are beyond the 64 bits of TOML: Python has them, but no floats or texts of them."""
    if isinstance(content, int) and content.bit_length() > 64:
        yield key
    items = content.items() if isinstance(content, dict) else enumerate(content, 1) if isinstance(content, list) else ()
    for name, value in items:
        yield from _too_wide(value, f"{key}.{name}" if key else str(name))


def _toml_fault(message: str, text: str) -> str:
    """Return the parser's message in plainer words, with the line that it is about."""
    if "Cannot overwrite a value" in message:
        message = message.replace("Cannot overwrite a value", "a key is given twice")
    found = re.search(r"at line (\d+)", message)
    lines = text.split("\n")
    if found is None or int(found[1]) > len(lines):
        return message
    line = lines[int(found[1]) - 1]
    comma = "a comma is no decimal point: " if re.search(r"=\s*[-+]?\d+,\d", line) else ""
    return f"{comma}{message}: {_shown(line.strip())[1:-1]}"


def sentences(error: ValidationError, root: type[Table] = ModelFile) -> Iterator[str]:
    """Return a sentence for everything that pydantic found in a file of the schema `root`."""
    found = [(fault, _path_of(fault, root)) for fault in error.errors(include_url=False)]
    paths = [path for _, path in found]
    for fault, path in found:
        if _of_another_kind(fault, path, paths):
            continue
        kind, given = fault["type"], fault["input"]
        if kind == "extra_forbidden":
            yield f"{_place(path[:-1], root)}: unknown key '{path[-1]}'{_where_it_belongs(path, root)}"
        elif kind == "missing":
            yield f"{_place(path[:-1], root)}: needs the key '{path[-1]}'{_how_to_give(path, root)}"
        elif kind in ("model_type", "model_attributes_type", "dict_type"):
            once = f"; write [{path[-1]}], in single brackets, once" if isinstance(given, list) and path else ""
            yield f"{_place(path, root)}: must be a table of keys, not {_shown(given)}{once}"
        elif kind == "list_type" and len(path) == 1:
            yield f"{_place(path, root)}: may be given more than once: write [[{path[0]}]], in double brackets"
        elif kind == "too_short" and path == ["rock"]:
            yield f"[rock]: needs a rock at least{_how_to_give(path, root)}"
        else:
            yield f"{_place(path, root)} = {_shown(given)}: {_in_words(fault, given)}"


def _of_another_kind(fault: Any, path: list[int | str], paths: list[list[int | str]]) -> bool:
    """Return whether a fault is that of a kind of value which was not meant, where a key takes several kinds."""
    if isinstance(fault["input"], dict | list):
        return any(len(other) > len(path) and other[: len(path)] == path for other in paths)
    return fault["type"] == "model_type" and paths.count(path) > 1


def _in_words(fault: Any, given: object) -> str:
    if fault["type"] == "literal_error":
        known = [name.strip("' ") for name in re.split(r",| or ", fault["ctx"]["expected"])]
        return f"is not known{nearest(str(given), known)}"
    message: str = PLAIN_WORDS.get(fault["type"], fault["msg"].removeprefix("Value error, "))
    return f"{message[0].lower()}{message[1:]}"


def _how_to_give(path: list[int | str], root: type[Table]) -> str:
    if len(path) == 1:
        return HOW_TO_GIVE.get(str(path[0]), "")
    table, key = _table_at(path[:-1], root), str(path[-1])
    kinds = [] if table is None or key not in table.model_fields else table.model_fields[key].metadata
    return next((f", for example {key} = {kind.example}" for kind in kinds if isinstance(kind, Quantity)), "")


def _shown(value: object) -> str:
    text = str(value).lower() if isinstance(value, bool) else f'"{value}"' if isinstance(value, str) else f"{value}"
    return text if len(text) < 60 else f"{text[:57]}..."


def _path_of(fault: Any, root: type[Table]) -> list[int | str]:
    """Return the keys of a fault's place; an unknown key may have any name."""
    loc = fault["loc"]
    return [*_path(loc[:-1], root), loc[-1]] if fault["type"] == "extra_forbidden" else list(_path(loc, root))


def _path(loc: tuple[int | str, ...], root: type[Table]) -> Iterator[int | str]:
    """Return the keys of pydantic's location, without its names for the members of a union."""
    table: type[Table] | None = root
    free = False  # the next part is a user's own name or a number
    for part in loc:
        if free or isinstance(part, int):
            free = False
            yield part
        elif table is not None and (part == table.__name__ or MEMBER.match(part)):
            continue
        elif table is not None and part in table.by_key():
            annotation = table.by_key()[part].annotation
            table, free = _table_in(annotation), "dict[" in str(annotation)
            yield part
        elif table is not None:
            yield part  # unknown to the table: the fault itself
            table = None


def _table_in(annotation: Any) -> type[Table] | None:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return annotation
    found = (_table_in(part) for part in get_args(annotation))
    return next((table for table in found if table is not None), None)


def _where_it_belongs(path: list[int | str], root: type[Table]) -> str:
    """Return the tables within a table that have an unknown key, else the known keys."""
    table, key = _table_at(path[:-1], root), str(path[-1])
    if table is None:
        return nearest(key, [])
    if key in table.meant:
        return f"; {table.meant[key]}"
    fields = table.by_key()
    inner = {name: _table_in(field.annotation) for name, field in fields.items() if _is_one_table(field.annotation)}
    homes = [f"{name} = {{ {key} = ... }}" for name, kind in inner.items() if kind is not None and key in kind.by_key()]
    if homes:
        return f"; it belongs in {' or '.join(homes)}"
    return _of_other_dimensions(path, root) or _of_other_tables(key, root) or nearest(key, fields, most=MAX_KEYS)


def _of_other_tables(key: str, root: type[Table]) -> str:
    """Return the tables at the top of a file that have a key, where it is in few of them."""
    homes = []
    for name, field in root.by_key().items():
        table, kind = _table_in(field.annotation), str(field.annotation)
        if table is not None and key in table.by_key():
            homes.append(f"[{name}.NAME]" if "dict[" in kind else f"[{name}]" if _is_one_table(kind) else f"[[{name}]]")
    return f"; it belongs in {' or '.join(homes)}" if 0 < len(homes) <= MAX_HOMES else ""


def _of_other_dimensions(path: list[int | str], root: type[Table]) -> str:
    """Return that a key is for models of three dimensions, or for those of the plane, where it is."""
    if root not in (ModelFile, SpaceFile):
        return ""
    other = SpaceFile if root is ModelFile else ModelFile
    known = path[:1] == path or str(path[0]) in other.by_key()
    table = _table_at(path[:-1], other) if known else None
    if table is None or str(path[-1]) not in table.by_key():
        return ""
    in_space = "; it is for three dimensions: write dimensions = 3 above all tables"
    return in_space if root is ModelFile else "; it is for models of the plane; leave it out"


def _is_one_table(annotation: Any) -> bool:
    return not re.search(r"(dict|list|tuple)\[", str(annotation))


def _table_at(path: list[int | str], root: type[Table]) -> type[Table] | None:
    table: type[Table] | None = root
    free = False  # the next part is a user's own name
    for part in path:
        if free or isinstance(part, int) or table is None:
            free = False
        else:
            field = table.by_key().get(str(part))
            if field is None:
                return None
            table, free = _table_in(field.annotation), "dict[" in str(field.annotation)
    return table


def _place(path: list[int | str], root: type[Table]) -> str:
    """Return ``[rock.gneiss] young`` or ``[[support]] number 2, fix``."""
    if not path:
        return "top level"
    field = root.by_key().get(str(path[0]))
    if field is not None and len(path) > 1 and isinstance(path[1], int):
        rest = ".".join(str(part) for part in path[2:])
        return f"[[{path[0]}]] number {path[1] + 1}" + (f", {rest}" if rest else "")
    if path[0] == "groups" and len(path) > 1:
        return f'[groups] "{path[1]}"'
    if field is None or _table_in(field.annotation) is None:
        return ".".join(str(part) for part in path)
    depth = 2 if "dict[" in str(field.annotation) else 1
    table, rest = ".".join(str(p) for p in path[:depth]), ".".join(str(p) for p in path[depth:])
    return f"[{table}]" + (f" {rest}" if rest else "")
