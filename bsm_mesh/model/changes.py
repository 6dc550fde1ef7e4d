"""Numbers of a model that no key of its file holds: a factor on a load, the rise of the water, a tilt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.model.earth_pressure import EarthPressure
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import (
    EdgeTractions,
    InSituTraction,
    LinearField,
    Load,
    PointForces,
    PointLoad,
    Pressure,
    Traction,
)
from bsm_mesh.model.model import Model
from bsm_mesh.model.quantities import COORDINATE, DIRECTION, LOAD_FACTOR
from bsm_mesh.model.quantity import Quantity
from bsm_mesh.model.water import Water

NAMES = "load.N.factor, stage.NAME.load.N.factor, water.rise, tilt.left, tilt.right"


@dataclass(frozen=True, slots=True)
class Change:
    """A change of a number of a model that no key of its file holds.

    Attributes
    ----------
    apply : callable
        Returns a model with a value of the number; picklable.
    quantity : Quantity
        What kind of number it is.
    neutral : float
        The value that leaves a model as it is.
    """

    apply: Callable[[Model, float], Model]
    quantity: Quantity
    neutral: float


def change_of(parts: Sequence[str]) -> Change | None:
    """Return what changes the number with a name, given as the parts between its dots; None for the key of a file."""
    match parts:
        case ["load", number, "factor"] if number.isdecimal():
            return Change(partial(with_load_factor, number=int(number)), LOAD_FACTOR, 1.0)
        case ["stage", stage, "load", number, "factor"] if number.isdecimal():
            return Change(partial(with_load_factor, stage=stage, number=int(number)), LOAD_FACTOR, 1.0)
        case ["water", "rise"]:
            return Change(with_water_rise, COORDINATE, 0.0)
        case ["tilt", "left"]:
            return Change(tilted_left, DIRECTION, 0.0)
        case ["tilt", "right"]:
            return Change(tilted_right, DIRECTION, 0.0)
    return None


def with_load_factor(model: Model, factor: float, *, number: int, stage: str | None = None) -> Model:
    """Return a model with one of its loads, or of a stage's, counted from 1, multiplied.

    Raises
    ------
    ModelError
        If there is no such stage or load.
    """
    if stage is None:
        return model.replace(loads=_with_factor(model.loads, number, factor, "[[load]]"))
    names = [each.name for each in model.stages]
    if stage not in names:
        raise ModelError(f"there is no stage '{stage}'{nearest(stage, names)}")
    changed = [
        replace(each, loads=_with_factor(each.loads, number, factor, f"load of stage '{stage}'"))
        if each.name == stage
        else each
        for each in model.stages
    ]
    return model.replace(stages=changed)


def with_water_rise(model: Model, rise: float) -> Model:
    """Return a model with all its water tables, or planes in space, those of stages too, raised [m].

    Raises
    ------
    ModelError
        If it has none.
    """
    waters = [model.water, *(stage.water for stage in model.stages)]
    if not any(water is not None and (water.table or water.plane) for water in waters):
        cure = "[water] plane" if in_space(model.blocks) else "[water] table"
        raise ModelError(f"water.rise: the model has no water table; give {cure}")
    stages = [replace(stage, water=_raised(stage.water, rise)) for stage in model.stages]
    return model.replace(water=_raised(model.water, rise), stages=stages)


def _raised(water: Water | None, rise: float) -> Water | None:
    if water is None:
        return None
    if water.plane is not None:
        x, y, z = water.plane.point
        return replace(water, plane=replace(water.plane, point=(x, y, z + rise)))
    return replace(water, table=tuple(tuple((x, y + rise) for x, y in table) for table in water.table))


def tilted_left(model: Model, angle: float) -> Model:
    """Return a model tilted to the left, counter-clockwise [degrees]: gravity turns the other way."""
    return _tilted(model, angle)


def tilted_right(model: Model, angle: float) -> Model:
    """Return a model tilted to the right, clockwise [degrees]."""
    return _tilted(model, -angle)


def _tilted(model: Model, angle: float) -> Model:
    if in_space(model.blocks):
        raise ModelError("tilt.left and tilt.right are for the plane; in space vary gravity.horizontal, with its trend")
    return model.replace(gravity_direction=model.gravity_direction - angle)


def _with_factor(loads: Sequence[Load], number: int, factor: float, what: str) -> tuple[Load, ...]:
    if not 1 <= number <= len(loads):
        raise ModelError(f"there is no {what} number {number}; there are {len(loads)}")
    return tuple(_multiplied(load, factor) if k + 1 == number else load for k, load in enumerate(loads))


def _multiplied(load: Load, factor: float) -> Load:
    if isinstance(load, PointLoad):
        return replace(load, force=tuple(factor * part for part in load.force))
    if isinstance(load, Pressure):
        return replace(load, pressure=_times(load.pressure, factor))
    if isinstance(load, Traction):
        return replace(load, traction=tuple(_times(part, factor) for part in load.traction))
    if isinstance(load, EarthPressure):
        return replace(load, factor=factor * load.factor)
    if isinstance(load, EdgeTractions):
        return replace(load, values=factor * np.asarray(load.values))
    if isinstance(load, PointForces):
        return replace(load, force=factor * load.force)
    assert isinstance(load, InSituTraction)
    raise ModelError("a load that balances the in-situ stress has no factor of its own; vary [in_situ]")


def _times(value: LinearField, factor: float) -> LinearField:
    return tuple(factor * part for part in value)
