"""Histories as they are recorded: quantities and units of each, values at every step, and the series that they make."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray, Portable, show_only
from bsm_mesh.errors import UnknownNameError, counted, nearest
from bsm_mesh.model.beside import Beside
from bsm_mesh.model.histories import History
from bsm_mesh.model.kinds import in_space
from bsm_mesh.movements import lengths, translations, turns
from bsm_mesh.results.joint_sets import faces_of_joints, joint_set
from bsm_mesh.results.movement import displacement_at

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model
    from bsm_mesh.results.records import StageResult
    from bsm_mesh.results.results import Results

Values = tuple[float, ...]
COMPONENTS = ("u", "v", "w")  # of a displacement: along x, y and z


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """The record under a name.

    Attributes
    ----------
    name, kind : str
        Of the history; ``point``, ``line``, ``block``, ``joint`` or ``bolt``.
    quantities, units : tuple of str
        One of each a column; a share has the unit "".
    distances : tuple of float [m]
        Of a line: of each further point from the first one, a column each.
    points : tuple of (x, y) or (x, y, z) [m]
        Of a point or a line, where the blocks were given.
    measured : tuple of Beside
        The values compared with it.
    """

    name: str
    kind: str
    quantities: tuple[str, ...]
    units: tuple[str, ...]
    distances: tuple[float, ...] = ()
    points: tuple[tuple[float, ...], ...] = ()
    measured: tuple[Beside, ...] = ()


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class HistorySeries(Portable):
    """A history over all steps, one row a step.

    Attributes
    ----------
    recorded : Recorded
        The histories of the columns.
    stage, step : (k,) int
        Number of the stage, and of the step within it, from 0.
    values : (k, q) float64
        A column a quantity, in its unit; NaN while a block is not there.
    """

    recorded: Recorded
    stage: IntArray
    step: IntArray
    values: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    def __getitem__(self, quantity: str) -> FloatArray:
        known = self.recorded.quantities
        if quantity not in known:
            raise UnknownNameError(f"history '{self.recorded.name}' has no {quantity!r}{nearest(str(quantity), known)}")
        column: FloatArray = self.values[:, known.index(quantity)]
        return column

    def keys(self) -> tuple[str, ...]:
        """Return the quantities: ``dict(series)`` has a column each, ``pandas.DataFrame(dict(series))`` a table."""
        return self.recorded.quantities

    @property
    def length(self) -> FloatArray:
        """Length of the displacement of a point or a block [m], (k,)."""
        parts = [name for name in COMPONENTS if name in self.recorded.quantities]
        return lengths(np.column_stack([self[name] for name in parts]))

    def __repr__(self) -> str:
        given = zip(self.recorded.quantities, self.recorded.units, strict=True)
        columns = ", ".join(f"{name} [{unit}]" if unit else name for name, unit in given)
        size = counted(len(self.step), "step")
        head = f"HistorySeries of {self.recorded.kind} '{self.recorded.name}': {size}, {columns}"
        return f"{head}; last {', '.join(f'{value:.4g}' for value in self.values[-1])}" if len(self.step) else head


def recorded_of(history: History, *, spatial: bool) -> Recorded:
    """Return the record of a history in the plane, or in space (`spatial`)."""
    further = tuple(f"extension_{number}" for number in range(1, len(history.points)))
    moved = tuple((name, "m") for name in COMPONENTS[: 3 if spatial else 2])
    columns = {
        "point": moved,
        "line": tuple((name, "m") for name in further),
        "block": (*moved, ("rotation", "deg")),
        "joint": (("slip", "m"), ("opening", "m"), ("slipping_share", ""), ("open_share", "")),
        "bolt": (("axial_force", "N"),),
    }[history.kind]
    names, units = zip(*columns, strict=True)
    first, *others = history.points or ((0.0,),)
    distances = tuple(math.dist(first, other) for other in others)
    return Recorded(
        name=history.name,
        kind=history.kind,
        quantities=names,
        units=units,
        distances=distances,
        points=history.points,
        measured=tuple(history.measured),
    )


def series_of(recorded: Sequence[Recorded], stages: Sequence[StageResult]) -> dict[str, HistorySeries]:
    """Return the series by name."""
    steps = [step for stage in stages for step in stage.steps]
    stage, step = (np.array([getattr(s, name) for s in steps], dtype=np.int64) for name in ("stage", "step"))
    width = sum(len(one.quantities) for one in recorded)
    values = np.array([s.recorded for s in steps], dtype=np.float64).reshape(len(steps), width)
    ends = np.cumsum([len(one.quantities) for one in recorded])
    parts = np.split(values, ends[:-1], axis=1) if len(recorded) else []
    return {
        one.name: HistorySeries(recorded=one, stage=stage, step=step, values=part)
        for one, part in zip(recorded, parts, strict=True)
    }


class Recorder:
    """Measures the histories of a model.

    Parameters
    ----------
    model : Model
        The model.
    """

    def __init__(self, model: Model) -> None:
        self._histories = model.histories
        self._spatial = in_space(model.blocks)
        self._blocks = [history.blocks(model.blocks) for history in model.histories]

    @property
    def recorded(self) -> tuple[Recorded, ...]:
        """The record, in the order of the values."""
        return tuple(recorded_of(history, spatial=self._spatial) for history in self._histories)

    def measure(self, results: Results) -> Values:
        """Return all values of the last stage of results, in the order of `recorded`."""
        stage, found = results.stages[-1], list[float]()
        for history, block in zip(self._histories, self._blocks, strict=True):
            if history.block is not None:
                found += _of_block(stage, history.block)
            elif history.joint is not None:
                found += _of_joint(results, stage, results.joint_names.index(history.joint))
            elif history.bolt is not None:
                found.append(_of_bolt(stage, history.bolt))
            else:
                found += _of_points(results, stage, block, np.array(history.points), as_line=history.kind == "line")
        return tuple(found)


def _of_points(
    results: Results, stage: StageResult, block: IntArray, point: FloatArray, *, as_line: bool
) -> list[float]:
    """Return the displacement of one point, or by how much the distances of all others from the first have grown."""
    moved = displacement_at(results.blocks, stage, block, point)
    if not as_line:
        return [float(part) for part in moved[0]]
    line, more = point[1:] - point[0], moved[1:] - moved[0]
    now, before = lengths(line + more), lengths(line)
    grown: list[float] = ((more * (2 * line + more)).sum(axis=1) / (now + before)).tolist()  # without loss of digits
    return grown


def _of_block(stage: StageResult, block: int) -> list[float]:
    """Return the displacement [m] and the rotation [deg] of a block; in space the angle about its axis."""
    own = stage.displacement[[block]]
    (moved,), (turn,) = translations(own).tolist(), turns(own).tolist()
    if not stage.present[block]:
        return [math.nan] * (len(moved) + 1)
    return [*moved, math.degrees(math.hypot(*turn) if isinstance(turn, list) else turn)]


def _of_joint(results: Results, stage: StageResult, joint: int) -> list[float]:
    """Return mean slip and opening [m], share of the length or area at strength, and open, of a joint."""
    found = joint_set("", faces_of_joints(results, stage), joint, stage.counts)
    return [np.nan] * 4 if found is None else [found.slip, found.opening, found.slipping, found.open]


def _of_bolt(stage: StageResult, bolt: str) -> float:
    """Return the greatest axial force [N] of a bolt, or of all that have its name."""
    mine = [number for number, name in enumerate(stage.bolts.names) if name == bolt]
    return float(stage.bolts.greatest_force[mine].max()) if mine else np.nan
