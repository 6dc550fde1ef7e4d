"""The arrays of a VTU file as numbers a person can look at one by one: components, units, names for numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.results.bolts import BoltStatus
from bsm_mesh.results.records import ContactStatus

if TYPE_CHECKING:
    from bsm_mesh.converters.vtk_files import Grid

NUMBERS = ("block_id", "block_a", "block_b", "bolt", "piece")  # tell which one it is, and not what it does
FORCES = ("load", "water", "reaction")  # x, y, moment
Names = Mapping[str, tuple[str, ...]]
STRESSES = ("stress", "stress_effective")  # XX YY ZZ XY YZ XZ
SIX = ("xx", "yy", "zz", "xy", "yz", "xz")  # of a stress in space


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class CellValues:
    """One number a cell.

    Attributes
    ----------
    name : str
        In words.
    unit : str
        Of `values`; empty where they have none.
    values : (k,) float64
        The numbers, SI.
    names : tuple of str
        Meanings of the values 0, 1, ..., where they have one.
    """

    name: str
    unit: str
    values: FloatArray
    names: tuple[str, ...] = ()


def cell_values(kind: str, grid: Grid, given: Names, *, in_space: bool = False) -> list[CellValues]:
    """Return what there is to look at in the cells of a file of a kind; arrays of several components one by one.

    Parameters
    ----------
    kind : str
        ``blocks``, ``joints``, ``contacts``, ``supports``, ``bolts`` or ``water``.
    grid : Grid
        The file.
    given : mapping of str to tuple of str
        Names of rocks and of joints, for the arrays ``rock`` and ``joint``; -1 is the last.
    in_space : bool
        Whether the blocks are polyhedra.
    """
    found = []
    for name, values in grid.cell_data.items():
        if name in NUMBERS:
            continue
        parts = np.asarray(values, dtype=np.float64).reshape(len(values), math.prod(np.shape(values)[1:]))
        if parts.shape[1] == 1:
            names, only = _names(kind, name, given), parts[:, 0]
            only = np.where(only < 0, len(names) - 1, only) if names else only
            unit = _unit_in_space(kind, name) if in_space else _units(kind, name)[0]
            found.append(CellValues(name=_words(name), unit=unit, values=only, names=names))
        else:
            found += (_components_in_space if in_space else _components)(kind, name, parts)
    return found


def _components_in_space(kind: str, name: str, parts: FloatArray) -> list[CellValues]:
    """Return the components of an array in space: of a vector with its magnitude, or of a stress."""
    chosen = dict(zip(SIX if name in STRESSES else "xyz", parts.T, strict=True))
    whole = {} if name in STRESSES else {"": np.linalg.norm(parts, axis=1)}
    unit = _unit_in_space(kind, name)
    return [
        CellValues(name=f"{_words(name)} {part}".strip(), unit=unit, values=values)
        for part, values in (whole | chosen).items()
    ]


def _unit_in_space(kind: str, name: str) -> str:
    """Return the unit of an array of polyhedra; that of bolts is the plane's."""
    from bsm_mesh.converters.array_units import unit_of
    from bsm_mesh.converters.three_d.stage_grids import UNITS

    return unit_of(kind, name) if kind == "bolts" else UNITS.get(name, "").replace("^", "")  # m2, m3


def _components(kind: str, name: str, parts: FloatArray) -> list[CellValues]:
    """Return the components of an array in the plane, and the magnitude of a vector."""
    x, y, last = _units(kind, name)
    if name in STRESSES:
        chosen = [("xx", x, parts[:, 0]), ("yy", y, parts[:, 1]), ("xy", x, parts[:, 3])]
    elif name in FORCES and kind == "blocks":
        chosen = [("x", x, parts[:, 0]), ("y", y, parts[:, 1]), ("moment", last, parts[:, 2])]
    elif name == "origin":
        chosen = [("x", x, parts[:, 0]), ("y", y, parts[:, 1]), ("rotation", last, parts[:, 2])]
    else:
        chosen = [("", x, np.hypot(parts[:, 0], parts[:, 1])), ("x", x, parts[:, 0]), ("y", y, parts[:, 1])]
    return [
        CellValues(name=f"{_words(name)} {part}".strip(), unit=unit, values=values) for part, unit, values in chosen
    ]


def _units(kind: str, name: str) -> Sequence[str]:
    """Return the units of the three components; a force in the plane is N/m, which says per metre of thickness."""
    from bsm_mesh.converters.array_units import PER_METRE, unit_of

    units = unit_of(kind, name).replace(PER_METRE, "").split(",")
    return [units[min(k, len(units) - 1)].strip() for k in range(3)]


def _names(kind: str, name: str, given: Names) -> tuple[str, ...]:
    states = BoltStatus if kind == "bolts" else ContactStatus
    known = {
        **given,
        "status": tuple(state.name.lower() for state in states),
        "unstable": ("stays", "falls"),
        "alive": ("not there", "there"),
    }
    return known.get(name, ())


def _words(name: str) -> str:
    return name.replace("_", " ")
