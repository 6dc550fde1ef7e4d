"""A model file with other values of some of its keys: read once, meshed once, built for every set of values."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, Union, get_args, get_origin

import numpy as np

from bsm_mesh.app.build import LoadedModel, build_model
from bsm_mesh.app.build_marks import places_in
from bsm_mesh.app.build_mesh import geometry_faults, read_blocks
from bsm_mesh.app.mesh_tables import Table
from bsm_mesh.app.model_file import read_toml, validated
from bsm_mesh.app.model_tables import ModelFile
from bsm_mesh.app.reach import Reach
from bsm_mesh.app.units import In
from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.quantities import Quantity

if TYPE_CHECKING:
    from bsm_mesh.converters import MeshReport

PART = re.compile(r'"([^"]+)"|([^."]+)')
NOT_OF_BLOCKS = ("default_joint", "contact_points", "allow_unused")  # keys of [mesh] that leave the blocks as they are


class Variation:
    """A model file whose keys take other values.

    A key is the way to it: ``joint.J1.friction``, ``gravity.direction``, ``mesh.parameters.seed``. Of what may stand
    more than once the number from 1, or the name, says which: ``load.1.pressure``, ``stage.crown.pressure``; so does
    the number of a value in a list: ``load.1.traction.2``. A name with a dot in it stands in quotes:
    ``joint."J1.5".friction``. A key that the file leaves out may be given, a table of keys as well.

    It pickles small: what was read goes along, the mesh is read or built anew where it arrives, once.

    Parameters
    ----------
    path : Path
        The model file.
    scripts : bool
        Whether it may run a geometry script and name any path.

    Raises
    ------
    ModelError
        For faults of the file.
    """

    def __init__(self, path: Path, *, scripts: bool = True) -> None:
        self.path = path.absolute()
        self._reach = Reach(folder=self.path.parent, scripts=scripts)
        self._content = read_toml(path, "model file")
        self.file = validated(self._content, path.name)
        self._mesh: tuple[Blocks, MeshReport] | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_mesh": None}

    @property
    def digest(self) -> str:
        """SHA-256 of the file's content; of the mesh that it names nothing is in it."""
        return hashlib.sha256(json.dumps(self._content, sort_keys=True, default=str).encode()).hexdigest()

    def model(self, values: Mapping[str, object]) -> LoadedModel:
        """Return the model, its options and notes with the values of some keys.

        The blocks are read or meshed once and shared by all models, unless a value changes what they are made of.

        Parameters
        ----------
        values : mapping of str to value
            As the file could give them: numbers, texts with units, lists.

        Raises
        ------
        ModelError
            With every key that is not known and every value that is wrong, and for faults of the model as a whole.
        """
        content = self._with(values)
        return build_model(validated(content, self.path.name), self.path, self._reach, mesher=self._read_blocks)

    def check(self, keys: Sequence[str]) -> None:
        """Raise a `ModelError` for the keys that the model file cannot have."""
        self._with(dict.fromkeys(keys, 0))
        given = [key_parts(key)[2] for key in keys if key.startswith("mesh.parameters.") and len(key_parts(key)) > 2]
        if not given or self.file.mesh.geometry is None:
            return
        from bsm_mesh.geometries.cases import case_parameters, find_case

        with geometry_faults():
            case = find_case(self._reach.geometry(self.file.mesh.geometry))
            known = case_parameters(case)
        if case.script is None:  # a script of the user's may take any name
            raise_faults(
                [
                    f"'mesh.parameters.{name}': {case.name} has no parameter '{name}'{nearest(name, known)}"
                    for name in given
                    if name not in known
                ]
            )

    def quantity(self, key: str) -> Quantity | None:
        """Return what kind of number a key holds; None where it holds something else, or several kinds.

        Raises
        ------
        ModelError
            If the model file cannot have the key.
        """
        return _quantity_in(_put(copy.deepcopy(self._content), key, None))

    def base(self, key: str) -> object:
        """Return the value that the file gives a key; None where it leaves the key out."""
        place: Any = self._content
        for part in key_parts(key):
            if isinstance(place, dict):
                place = place.get(part)
            elif isinstance(place, list):
                number = _number_of(part, place)
                place = None if number is None else place[number]
            else:
                return None
        return copy.deepcopy(place)

    def _with(self, values: Mapping[str, object]) -> dict[str, Any]:
        content, faults = copy.deepcopy(self._content), list[str]()
        for key, value in values.items():
            try:
                _put(content, key, value.item() if isinstance(value, np.generic) else value)
            except ModelError as error:
                faults.extend(f"{self.path.name}: {fault}" for fault in error.faults)
        raise_faults(faults)
        return content

    def _read_blocks(self, file: ModelFile, path: Path, reach: Reach) -> tuple[Blocks, MeshReport]:
        """Return the blocks; those of the file as it is are kept."""
        same = {name: getattr(self.file.mesh, name) for name in NOT_OF_BLOCKS}
        changed = file.mesh.model_copy(update=same) != self.file.mesh or file.groups != self.file.groups
        if changed or places_in(file) != places_in(self.file):
            return read_blocks(file, path, reach)
        if self._mesh is None:
            self._mesh = read_blocks(file, path, reach)
        return self._mesh


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
    if not found or not re.fullmatch(rf"(?:{PART.pattern})(?:\.(?:{PART.pattern}))*", key):
        raise ModelError(f"'{key}' is no key; write the way to it with dots, for example joint.J1.friction")
    return found


def _put(content: dict[str, Any], key: str, value: object) -> Any:
    """Put a value where a key leads to, in the content of a model file; return the type that the schema gives it."""
    parts = key_parts(key)
    place: Any = content
    schema: Any = ModelFile  # the type of `place`; None where anything may stand
    for k, part in enumerate(parts):
        way, last = ".".join(parts[:k]) or "a model file", k == len(parts) - 1
        if not isinstance(place, dict | list):
            raise ModelError(f"'{key}': {way} is a value, which has no keys")
        name: Any = _entry(place, part, way, key) if isinstance(place, list) else part
        schema = _type_of(_bare(schema), place, part, way, key)
        bare = _bare(schema)
        if last and _is_table(bare):
            raise ModelError(f"'{key}' is a table; add one of its keys{nearest(part, bare.model_fields)}")
        if last:
            place[name] = value
        elif isinstance(place, dict):
            place = place.setdefault(name, [] if get_origin(bare) is list else {})
        else:
            place = place[name]
    return schema


def _type_of(schema: Any, place: Any, part: str, way: str, key: str) -> Any:
    """Return the type of what a part of a key holds; raise where the table has no such key."""
    if _is_table(schema):
        if part not in schema.model_fields:
            raise ModelError(f"'{key}': {way} has no key '{part}'{nearest(part, schema.model_fields)}")
        field = schema.model_fields[part]
        return Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
    member = get_args(schema)[-1] if get_origin(schema) in (list, dict) else None
    if isinstance(place, dict) and _is_table(member) and part not in place:
        raise ModelError(f"'{key}': the model file has no [{way}.{part}]{nearest(part, place)}")
    return member


def _entry(place: list[Any], part: str, way: str, key: str) -> int:
    """Return which entry of a list a part of a key means, from 0."""
    number = _number_of(part, place)
    if number is not None:
        return number
    names = [entry["name"] for entry in place if isinstance(entry, dict) and isinstance(entry.get("name"), str)]
    if not place:
        raise ModelError(f"'{key}': the model file has no {way}")
    if names and not part.isdecimal():
        raise ModelError(f"'{key}': no {way} has the name '{part}'{nearest(part, names)}")
    raise ModelError(f"'{key}': write which {way} is meant by its number, 1 to {len(place)}")


def _number_of(part: str, place: list[Any]) -> int | None:
    """Return the place in a list of the entry of this name, or of this number from 1."""
    named = [k for k, entry in enumerate(place) if isinstance(entry, dict) and entry.get("name") == part]
    if named:
        return named[0]
    return int(part) - 1 if part.isdecimal() and 1 <= int(part) <= len(place) else None


def _is_table(schema: Any) -> bool:
    return isinstance(schema, type) and get_origin(schema) is None and issubclass(schema, Table)


def _bare(annotation: Any) -> Any:
    """Return a type without what is said of it, and without that it may be left out."""
    if get_origin(annotation) is Annotated:
        return _bare(get_args(annotation)[0])
    kinds = [kind for kind in get_args(annotation) if kind is not NoneType]
    is_optional = get_origin(annotation) in (Union, UnionType) and len(kinds) == 1
    return _bare(kinds[0]) if is_optional else annotation


def _quantity_in(annotation: Any) -> Quantity | None:
    """Return what kind of number a type is of, if it is one."""
    if get_origin(annotation) is Annotated:
        inner, *said = get_args(annotation)
        kinds = (one.quantity if isinstance(one, In) else one for one in said)
        return next((kind for kind in kinds if isinstance(kind, Quantity)), None) or _quantity_in(inner)
    if get_origin(annotation) in (Union, UnionType):
        return next((found for part in get_args(annotation) if (found := _quantity_in(part)) is not None), None)
    return None
