"""Results as tables: a row a block, a contact, a held point, a joint set, a bolt's node or a step of every stage."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import ModelError, as_given
from bsm_mesh.results.bolts import BoltStatus
from bsm_mesh.results.joint_sets import ROCK_FACE, joint_sets
from bsm_mesh.results.records import ContactStatus, StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.stress import principal_stresses

Columns = dict[str, Any]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ResultTable:
    """A table of all stages, one below the other.

    Attributes
    ----------
    columns : mapping of str to (n,) array
        By name, the first two ``stage`` (its number) and ``stage_name``; texts are arrays of objects.
    units : mapping of str to str
        Of the columns that have one.
    """

    columns: Mapping[str, Any]
    units: Mapping[str, str]


def result_table(results: Results, name: str) -> ResultTable:
    """Return one of `TABLES`.

    Raises
    ------
    ModelError
        If there is no table of that name.
    """
    if not isinstance(name, str) or name not in _COLUMNS:
        raise ModelError(f"there is no table {as_given(name)} of results; known: {', '.join(TABLES)}")
    parts = [_COLUMNS[name](results, stage) for stage in results.stages]
    sizes = [len(next(iter(part.values()))) for part in parts]
    columns: Columns = {
        "stage": np.repeat(np.arange(len(parts)), sizes),
        "stage_name": _names(np.repeat(np.arange(len(parts)), sizes), [stage.name for stage in results.stages]),
    }
    columns |= {header: np.concatenate([part[header] for part in parts]) for header in parts[0]}
    units = {header: unit for header in columns for unit in [_UNITS.get((name, header), _UNIT.get(header))] if unit}
    return ResultTable(columns=columns, units=units)


def _names(numbers: IntArray, names: Sequence[str], other: str = "") -> Any:
    """Return the name of each number, `other` for -1."""
    return np.array([*names, other], dtype=object)[numbers]


def _blocks(results: Results, stage: StageResult) -> Columns:
    """Return a row a block that is there; the centroid is that of the given block."""
    blocks, here = results.blocks, np.flatnonzero(stage.present)
    sigma_1, sigma_3 = principal_stresses(stage.stress)
    columns = {
        "rock": _names(blocks.rock, blocks.rock_names),
        "x": blocks.moments.centroid[:, 0],
        "y": blocks.moments.centroid[:, 1],
        "area": blocks.moments.area,
        "displacement_x": stage.displacement[:, 0],
        "displacement_y": stage.displacement[:, 1],
        "rotation": stage.displacement[:, 2],
        "stage_displacement_x": stage.stage_displacement[:, 0],
        "stage_displacement_y": stage.stage_displacement[:, 1],
        "stage_rotation": stage.stage_displacement[:, 2],
        "stress_xx": stage.stress[:, 0, 0],
        "stress_yy": stage.stress[:, 1, 1],
        "stress_xy": stage.stress[:, 0, 1],
        "sigma_1": sigma_1,
        "sigma_3": sigma_3,
        "load_x": stage.loads[:, 0],
        "load_y": stage.loads[:, 1],
        "unstable": np.isin(np.arange(blocks.count), stage.unstable_blocks),
    }
    return {"block": here, **{header: values[here] for header, values in columns.items()}}


def _contacts(results: Results, stage: StageResult) -> Columns:
    """Return a row a contact; forces act on block b, tension positive."""
    c = stage.contacts
    return {
        "block_a": c.block_a,
        "block_b": c.block_b,
        "joint": _names(c.joint, results.joint_names, ROCK_FACE),
        "x": c.point[:, 0],
        "y": c.point[:, 1],
        "normal_x": c.normal[:, 0],
        "normal_y": c.normal[:, 1],
        "length": c.length,
        "normal_force": c.normal_force,
        "shear_force": c.shear_force,
        "water_pressure": c.water_pressure,
        "slip": c.slip,
        "opening": c.opening,
        "utilisation": c.utilisation,
        "status": _names(c.status, [status.name.lower() for status in ContactStatus]),
    }


def _supports(results: Results, stage: StageResult) -> Columns:
    """Return a row a held point; forces act on the block."""
    s = stage.supports
    return {
        "block": s.block,
        "x": s.point[:, 0],
        "y": s.point[:, 1],
        "force_x": s.reaction[:, 0],
        "force_y": s.reaction[:, 1],
        "moment": s.moment,
    }


def _joints(results: Results, stage: StageResult) -> Columns:
    """Return a row a joint set."""
    sets = joint_sets(results, stage)
    fields = {
        "length": "length",
        "slipping_share": "slipping",
        "open_share": "open",
        "mean_pressure": "pressure",
        "mean_slip": "slip",
        "greatest_slip": "greatest_slip",
        "mean_opening": "opening",
        "greatest_opening": "greatest_opening",
    }
    numbers = {header: np.array([getattr(one, f) for one in sets], dtype=np.float64) for header, f in fields.items()}
    return {"joint": np.array([one.name for one in sets], dtype=object), **numbers}


def _bolts(results: Results, stage: StageResult) -> Columns:
    """Return a row a node: its bond force, and the forces of the element that begins there, NaN at the last."""
    bolts = stage.bolts
    bolt = np.repeat(np.arange(bolts.count), np.diff(bolts.node_start))
    columns: Columns = {
        "bolt": bolt,
        "name": _names(bolt, bolts.names),
        "status": _names(bolts.status[bolt], [status.name.lower() for status in BoltStatus]),
        "block": bolts.block,
        "station": bolts.station,
        **dict(zip("xyz", bolts.point.T, strict=False)),
        "bond_force": bolts.bond_force,
        "slip": bolts.slip,
    }
    for header in ("axial_force", "plastic_stretch", "shear_force", "utilisation"):
        columns[header] = np.full(len(bolt), np.nan)
        columns[header][bolts.first_node] = getattr(bolts, header)
    return columns


def _flow(results: Results, stage: StageResult) -> Columns:
    """Return a row a place where water may enter or leave the joints; inflow is negative."""
    flow = stage.flow
    if flow is None:
        return {"place": np.zeros(0, dtype=object), "outflow": np.zeros(0), "nodes": np.zeros(0, dtype=np.int64)}
    return {
        "place": np.array(flow.places, dtype=object),
        "outflow": flow.leaving,
        "nodes": np.array([int((flow.place == k).sum()) for k in range(len(flow.places))]),
    }


def _steps(results: Results, stage: StageResult) -> Columns:
    """Return a row an accepted step."""
    kinds: dict[str, Any] = {
        "step": np.int64,
        "residual": np.float64,
        "max_displacement": np.float64,
        "newton_iterations": np.int64,
        "factorizations": np.int64,
        "open_contacts": np.int64,
        "slipping_contacts": np.int64,
        "seconds": np.float64,
        "method": object,
    }
    return {header: np.array([getattr(s, header) for s in stage.steps], dtype=kind) for header, kind in kinds.items()}


_COLUMNS: dict[str, Callable[[Results, StageResult], Columns]] = {
    "blocks": _blocks,
    "contacts": _contacts,
    "joints": _joints,
    "supports": _supports,
    "bolts": _bolts,
    "flow": _flow,
    "steps": _steps,
}
TABLES = tuple(_COLUMNS)

_UNIT = {
    **dict.fromkeys(
        ("x", "y", "z", "length", "slip", "opening", "station", "plastic_stretch", "max_displacement"), "m"
    ),
    **dict.fromkeys(("displacement_x", "displacement_y", "stage_displacement_x", "stage_displacement_y"), "m"),
    **dict.fromkeys(("mean_slip", "greatest_slip", "mean_opening", "greatest_opening"), "m"),
    **dict.fromkeys(("rotation", "stage_rotation"), "rad"),
    **dict.fromkeys(("stress_xx", "stress_yy", "stress_xy", "sigma_1", "sigma_3"), "Pa"),
    **dict.fromkeys(("water_pressure", "mean_pressure"), "Pa"),
    **dict.fromkeys(("normal_force", "shear_force", "load_x", "load_y", "force_x", "force_y"), "N/m"),
    "area": "m^2",
    "outflow": "m^2/s",
    "moment": "N",
    "seconds": "s",
}
_UNITS = {("bolts", header): "N" for header in ("axial_force", "bond_force", "shear_force")}
