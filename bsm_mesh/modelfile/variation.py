"""A model file with other values of some of its numbers: read once, meshed once, built for every set of values.

The numbers that can be varied, and the form of a value, are defined here for every command: `study`, `safety --vary`,
`back-analysis`.
"""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.errors import ModelError, gathered, nearest, placed, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.changes import NAMES, Change, change_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.quantity import Quantity, convert, number_of
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.modelfile.build import LoadedModel, build_file, checked
from bsm_mesh.modelfile.build_marks import geometry_faults, places_in
from bsm_mesh.modelfile.build_mesh import read_blocks
from bsm_mesh.modelfile.keys import PARTS, entry_number, key_parts, put, quantity_in
from bsm_mesh.modelfile.model_file import read_toml
from bsm_mesh.modelfile.model_tables import ModelFile
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.space_file import blocks_of
from bsm_mesh.modelfile.space_tables import SpaceFile

if TYPE_CHECKING:
    from bsm_mesh.converters import MeshReport
    from bsm_mesh.three_d.blocks.polyhedra import Polyhedra

CUT_BY = ("groups", "joint_set", "joint_plane", "excavation", "slope")  # tables that blocks in space depend on
NOT_OF_BLOCKS = ("default_joint", "contact_points", "allow_unused")  # keys of [mesh] that leave the blocks as they are


class Variation:
    """A model file whose numbers take other values.

    Their names are keys of the file, or those of numbers that no key holds (`bsm_mesh.model.changes`).

    A key is the way to it: ``joint.J1.friction``, ``gravity.direction``, ``mesh.parameters.seed``. Of tables that may
    be repeated the number from 1, or the name, selects one: ``load.1.pressure``, ``stage.crown.pressure``; so does
    the number of a value in a list: ``load.1.traction.2``. A name with a dot in it is in quotes:
    ``joint."J1.5".friction``. A key that the file leaves out may be given, a table of keys as well.

    It pickles small: the files' content goes along, the mesh is read or built anew in the process, once.

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
        self.file = checked(self._content, path.name)
        self._mesh: tuple[Blocks, MeshReport] | None = None
        self._cut: Polyhedra | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_mesh": None, "_cut": None}

    @property
    def digest(self) -> str:
        """SHA-256 of the file's content; of the mesh that it names nothing is in it."""
        return hashlib.sha256(json.dumps(self._content, sort_keys=True, default=str).encode()).hexdigest()

    def model(self, values: Mapping[str, object]) -> LoadedModel:
        """Return the model, its options and notes with the values of some keys.

        The blocks are read or meshed once and shared by all models, unless a value changes their geometry.

        Parameters
        ----------
        values : mapping of str to value
            As the file could give them: numbers, texts with units, lists.

        Raises
        ------
        ModelError
            With every key that is not known and every value that is wrong, and for faults of the model as a whole.
        """
        changes = _changes(values)
        content = self._with({key: value for key, value in values.items() if key not in changes})
        file = checked(content, self.path.name)
        loaded = build_file(file, self.path, self._reach, mesher=self._read_blocks, cutter=self._cut_blocks)
        model = loaded.model
        for name, change in changes.items():
            value = values[name]
            with placed(f"{name} = {value}"):
                model = change.apply(model, convert(value, change.quantity))
        return replace(loaded, model=model)

    def with_value(self, name: str, value: float) -> Model:
        """Return the model with a value of one number; `functools.partial` of it suits a search, picklable."""
        return self.model({name: value}).model

    def overriding(self, key: str, stage: str) -> list[str]:
        """Return a note on each stage up to `stage` that has its own value of a key, such as ``gravity.horizontal``.

        Entries of lists are left out: loads of a stage act besides those of the model.
        """
        if stage == INITIAL or isinstance(self._content.get(key_parts(key)[0]), list):
            return []
        names = [table["name"] for table in self._content.get("stage", [])]
        ways = {name: f'stage."{name}".{key}' if "." in name else f"stage.{name}.{key}" for name in names}
        return [
            f"stage '{name}' has its own {key}; there {ways[name]} is to be varied"
            for name in names[: names.index(stage) + 1]
            if self.base(ways[name]) is not None
        ]

    def check(self, keys: Sequence[str]) -> None:
        """Raise a `ModelError` for the numbers that the model cannot have."""
        changes = _changes(keys)
        try:
            self._with(dict.fromkeys((key for key in keys if key not in changes), 0))
        except ModelError as error:
            raise ModelError(
                [f"{fault}; in addition to keys of the file there are {NAMES}" for fault in error.faults]
            ) from None
        if changes:
            self.model({key: change.neutral for key, change in changes.items()})
        self._check_parameters(keys)

    def _check_parameters(self, keys: Sequence[str]) -> None:
        """Raise for parameters that the geometry does not have."""
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
        """Return what kind of number a name represents; None where a key holds something else, or several kinds.

        Raises
        ------
        ModelError
            If the model file cannot have the key.
        """
        change = change_of(key_parts(key))
        if change is not None:
            return change.quantity
        return quantity_in(put(copy.deepcopy(self._content), key, None, type(self.file)))

    def unit(self, name: str) -> str:
        """Return the unit of a number, or the words behind a part of something; empty for none."""
        quantity = self.quantity(name)
        return "" if quantity is None else quantity.unit or quantity.part_of

    def ends(self, name: str, given: Sequence[float | str]) -> tuple[float, ...]:
        """Return values between which a number is looked for, in its unit.

        Raises
        ------
        ModelError
            If the model cannot have the number, or the number no such value.
        """
        self.check([name])
        quantity, found, faults = self.quantity(name), list[float](), list[str]()
        if quantity is not None and quantity.whole:
            raise ModelError(f"{name}: is a whole number, between two of which no limit can be looked for")
        for value in given:
            try:
                found.append(number_of(value, quantity))
            except ValueError as error:
                faults.append(f"{name} = {value}: {error}")
                continue
            if quantity is not None and not quantity.holds(found[-1]):
                faults.append(f"{name} = {value}: {quantity.rule_in_file}")
        raise_faults(faults)
        return tuple(found)

    def base(self, key: str) -> object:
        """Return the value that the file gives a key; None where it leaves the key out."""
        place: Any = self._content
        for part in key_parts(key):
            if isinstance(place, dict):
                place = place.get(part)
            elif isinstance(place, list):
                number = entry_number(part, place)
                place = None if number is None else place[number]
            else:
                return None
        return copy.deepcopy(place)

    def _with(self, values: Mapping[str, object]) -> dict[str, Any]:
        content, faults = copy.deepcopy(self._content), list[str]()
        for key, value in values.items():
            with gathered(faults, self.path.name):
                put(content, key, value.item() if isinstance(value, np.generic) else value, type(self.file))
        raise_faults(faults)
        return content

    def _read_blocks(self, file: ModelFile, path: Path, reach: Reach) -> tuple[Blocks, MeshReport]:
        """Return the blocks of the plane; those of the file as it is are kept."""
        assert isinstance(self.file, ModelFile)
        changed = self._changes_mesh(file) or file.groups != self.file.groups
        if changed or places_in(file) != places_in(self.file):
            return read_blocks(file, path, reach)
        if self._mesh is None:
            self._mesh = read_blocks(file, path, reach)
        return self._mesh

    def _cut_blocks(self, file: SpaceFile, path: Path, reach: Reach, joints: list[Any], bodies: list[Any]) -> Polyhedra:
        """Return the blocks in space; those of the file as it is are kept."""
        if self._changes_mesh(file) or any(getattr(file, name) != getattr(self.file, name) for name in CUT_BY):
            return blocks_of(file, path, reach, joints, bodies)
        if self._cut is None:
            self._cut = blocks_of(file, path, reach, joints, bodies)
        return self._cut

    def _changes_mesh(self, file: ModelFile | SpaceFile) -> bool:
        """Return whether the mesh or the box of a file is another one."""
        same = {name: getattr(self.file.mesh, name) for name in NOT_OF_BLOCKS if hasattr(self.file.mesh, name)}
        return file.mesh.model_copy(update=same) != self.file.mesh


def _changes(names: Iterable[str]) -> dict[str, Change]:
    """Return what changes those of some numbers that no key holds."""
    return {name: change for name in names if PARTS.fullmatch(name) and (change := change_of(key_parts(name)))}
