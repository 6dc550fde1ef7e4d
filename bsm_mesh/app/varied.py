"""The models of a file at values of one of its numbers: a key, or what no key holds."""

from __future__ import annotations

from pathlib import Path

from bsm_mesh.app.build import LoadedModel
from bsm_mesh.app.variation import Variation
from bsm_mesh.errors import ModelError
from bsm_mesh.model.model import Model
from bsm_mesh.safety.changes import NAMES, change_of


class Varied:
    """Returns the model of a file with a value of one of its numbers; picklable.

    Parameters
    ----------
    path : Path
        The model file.
    name : str
        A dotted key of it, or a number of `bsm_mesh.safety.changes`.
    scripts : bool
        Whether the file may run a geometry script and name any path.

    Raises
    ------
    ModelError
        For faults of the file, and where it cannot have the key.
    """

    def __init__(self, path: Path, name: str, *, scripts: bool = True) -> None:
        self._variation, self._name = Variation(path, scripts=scripts), name
        if change_of(name) is not None:
            return
        try:
            self._variation.check([name])
        except ModelError as error:
            raise ModelError(
                [f"{fault}; beside keys of the file there are {NAMES}" for fault in error.faults]
            ) from error

    def given(self) -> LoadedModel:
        """Return the model as the file gives it."""
        return self._variation.model({})

    def __call__(self, value: float) -> Model:
        """Return the model with a value."""
        change = change_of(self._name)
        if change is None:
            return self._variation.model({self._name: value}).model
        try:
            return change(self.given().model, value)
        except ModelError as error:
            raise ModelError([f"{self._name} = {value:g}: {fault}" for fault in error.faults]) from error
