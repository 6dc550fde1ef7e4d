"""Computed values of a history at the end of a stage, for values of any source to be compared with it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.beside import QUANTITIES, Beside, number_of
from bsm_mesh.model.locate import pairs_at
from bsm_mesh.results.histories import HistorySeries, Recorded
from bsm_mesh.results.movement import displacement_at
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results

ALONG = 120  # places on a line where a run is compared with another


def line_movement(
    results: Results, stage: StageResult, points: Sequence[Sequence[float]], distance: FloatArray
) -> dict[str, FloatArray]:
    """Return how a line moved at the end of a stage, at distances from its first point.

    Parameters
    ----------
    results : Results
        The result.
    stage : StageResult
        One of its stages.
    points : sequence of (x, y) [m]
        Of the line, where the blocks were given.
    distance : (k,) float64 [m]
        From the first point. Between the points of the line, in the order of their distances, lie straight pieces.

    Returns
    -------
    dict of str to (k,) float64 [m]
        ``extension``: by how much the distance from the first point has grown; ``towards``: displacement against the
        direction from the first point to the last, so into the opening where the first one lies on its wall;
        ``across``: displacement to the left of that direction. NaN where there is no block.
    """
    places = np.array(points, dtype=np.float64)
    from_first = np.hypot(*(places - places[0]).T)
    order = np.argsort(from_first, kind="stable")
    at = np.stack([np.interp(distance, from_first[order], places[order, axis]) for axis in (0, 1)], axis=1)
    moved = _moved(results, stage, np.concatenate([places[:1], at]))
    line, more = at - places[0], moved[1:] - moved[0]
    now, before = np.hypot(*(line + more).T), np.hypot(*line.T)
    length = np.where(now + before > 0, now + before, 1.0)
    end = places[order[-1]] - places[0]
    direction = end / np.hypot(*end)
    return {
        "extension": (more * (2 * line + more)).sum(axis=1) / length,  # without loss of digits
        "towards": -moved[1:] @ direction,
        "across": moved[1:] @ np.array([-direction[1], direction[0]]),
    }


def _moved(results: Results, stage: StageResult, points: FloatArray) -> FloatArray:
    """Return the displacements of points (k, 2) [m]; of those on an outline with the first block that is there."""
    row, found = pairs_at(results.blocks, points)
    row, found = row[stage.present[found]], found[stage.present[found]]
    block = np.full(len(points), -1)
    block[row[::-1]] = found[::-1]  # the first is written last
    moved = displacement_at(results.blocks, stage, block, points)
    moved[block < 0] = np.nan
    return moved


def found_beside(results: Results, recorded: Recorded, beside: Beside) -> float:
    """Return the computed value of a history where a value is compared with it, in its unit; NaN for none."""
    number = number_of(beside.stage, [stage.name for stage in results.stages])
    if number is None:
        return math.nan
    if beside.distance is not None:
        movement = line_movement(results, results.stages[number], recorded.points, np.array([beside.distance]))
        return float(movement[beside.quantity][0])
    return at_the_end(results.histories[recorded.name], beside.quantity, number)


def at_the_end(series: HistorySeries, quantity: str, number: int) -> float:
    """Return a quantity at the end of a stage, by its number: ``displacement`` is the length of it."""
    rows = np.flatnonzero(series.stage == number)
    if not len(rows):
        return math.nan
    if quantity == "displacement":
        return float(series.length[rows[-1]])
    return float(series[quantity][rows[-1]])


def values_of_run(results: Results, recorded: Recorded, source: str) -> tuple[Beside, ...]:
    """Return the computed values of a history at the end of each stage, for comparison with another run."""
    found: list[Beside] = []
    for number, stage in enumerate(results.stages):
        name = None if number == len(results.stages) - 1 else stage.name  # the last one is compared with the last one
        found += [
            Beside(quantity=quantity, value=value, stage=name, distance=distance, source=source)
            for quantity, value, distance in _of_stage(results, recorded, number)
            if math.isfinite(value)
        ]
    return tuple(found)


def _of_stage(results: Results, recorded: Recorded, number: int) -> Iterator[tuple[str, float, float | None]]:
    """Return quantities and their values at the end of a stage, of a line at places along it."""
    if recorded.kind == "line":
        yield from along_line(results, results.stages[number], recorded)
        return
    series = results.histories.get(recorded.name)
    if series is not None and series.recorded.kind == recorded.kind:
        for quantity in QUANTITIES[recorded.kind]:
            yield quantity, at_the_end(series, quantity, number), None


def along_line(results: Results, stage: StageResult, recorded: Recorded) -> Iterator[tuple[str, float, float | None]]:
    """Return quantities of a line, their values [m] and distances [m]: at many places, and at those recorded."""
    distance = np.union1d(np.linspace(0.0, max(recorded.distances), ALONG), recorded.distances)
    for quantity, values in line_movement(results, stage, recorded.points, distance).items():
        for at, value in zip(distance.tolist(), values.tolist(), strict=True):
            yield quantity, value, at


def set_beside(results: Results, values: dict[str, tuple[Beside, ...]]) -> Results:
    """Return results with more values compared with their histories, by the histories' names."""
    recorded = tuple(replace(one, measured=(*one.measured, *values.get(one.name, ()))) for one in results.recorded)
    return replace(results, recorded=recorded)
