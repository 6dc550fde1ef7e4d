"""Water along faces: which parts of lines are under water, and the pressure at their ends (Wang ch. 6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.records import StageResult

BESIDE = 0.05  # of a line's length: what is further from it is on another face
PARALLEL = 0.1  # sine: what is less turned lies along it
SHORTEST = 1e-6  # of a line's length


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class WetParts:
    """Parts of lines that are under water; along each of them the pressure is linear.

    Attributes
    ----------
    line : (p,) int64
        The line that each is a part of.
    ends : (p, 2) float64
        Where it begins and ends, as parts of the line's length.
    pressure : (p, 2) float64 [Pa]
        At its two ends.
    """

    line: IntArray
    ends: FloatArray
    pressure: FloatArray

    def mean(self, count: int) -> FloatArray:
        """Return the mean pressure over the length of each of so many lines, (count,) [Pa]."""
        share = np.diff(self.ends, axis=1)[:, 0] * self.pressure.mean(axis=1)
        return np.bincount(self.line, share, minlength=count)[:count].astype(np.float64)

    def at(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Return both ends of the parts of lines from `start` to `end` (k, 2), (p, 2, 2)."""
        along = (end - start)[self.line]
        ends: FloatArray = start[self.line][:, None] + self.ends[:, :, None] * along[:, None]
        return ends


def wet_parts(
    stage: StageResult, start: FloatArray, end: FloatArray, joint: IntArray, as_given: FloatArray | None = None
) -> WetParts:
    """Return the parts of lines that are under water in a stage.

    Parameters
    ----------
    stage : StageResult
        Its `water_table`, `water_gradient` and `joint_water`. Beyond the model the outermost pieces of the table
        continue.
    start, end : (k, 2) float64 [m]
        Ends of the lines, where they are.
    joint : (k,) int
        Number of the joint whose own pressure may stand instead of the table's; -1: none.
    as_given : (k, 2, 2) float64, optional [m]
        Both ends of the lines as the blocks were given, where these are others: a flow presses on them.
    """
    if stage.flow is not None:
        return _of_flow(stage.flow, np.stack([start, end], axis=1) if as_given is None else as_given)
    own = np.append(stage.joint_water, np.nan)[joint]
    given, under = np.flatnonzero(own > 0), np.flatnonzero(np.isnan(own))
    found = [
        WetParts(line=given, ends=np.tile([0.0, 1.0], (len(given), 1)), pressure=np.repeat(own[given, None], 2, axis=1))
    ]
    last = len(stage.water_table) - 1
    for piece, (table, gradient) in enumerate(zip(stage.water_table, stage.water_gradient, strict=True)):  # a few
        if np.isnan(gradient):  # results of schema version 3 do not say
            continue
        (x0, _), (x1, _) = table
        reach = (-np.inf if piece == 0 else x0, np.inf if piece == last else x1)
        part = _under(table, reach, start[under], end[under])
        found.append(WetParts(line=under[part.line], ends=part.ends, pressure=gradient * part.pressure))
    line = np.concatenate([part.line for part in found])
    order = np.argsort(line, kind="stable")
    ends, pressure = (np.concatenate([getattr(part, name) for part in found]) for name in ("ends", "pressure"))
    return WetParts(line=line[order], ends=ends[order], pressure=pressure[order])


def _under(table: FloatArray, reach: tuple[float, float], start: FloatArray, end: FloatArray) -> WetParts:
    """Return the parts of lines under a straight piece of the table within a reach of x; depths [m] for pressures."""
    (x0, y0), (x1, y1) = table
    slope = (y1 - y0) / (x1 - x0)
    x, dx = start[:, 0], end[:, 0] - start[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = np.sort(np.stack([(bound - x) / dx for bound in reach], axis=1), axis=1)
    upright = dx == 0
    inside = (x >= reach[0]) & (x < reach[1])
    t0 = np.where(upright, 0.0, np.clip(crossing[:, 0], 0.0, 1.0))
    t1 = np.where(upright, inside, np.clip(crossing[:, 1], 0.0, 1.0))
    depth, rise = y0 + slope * (x - x0) - start[:, 1], slope * dx - (end[:, 1] - start[:, 1])
    h0, h1 = depth + rise * t0, depth + rise * t1
    with np.errstate(divide="ignore", invalid="ignore"):
        surface = t0 + (t1 - t0) * h0 / (h0 - h1)  # where the line leaves the water
    t0, t1 = np.where(h0 < 0, surface, t0), np.where(h1 < 0, surface, t1)
    wet = np.flatnonzero(((h0 > 0) | (h1 > 0)) & (t1 > t0))
    return WetParts(
        line=wet,
        ends=np.stack([t0, t1], axis=1)[wet],
        pressure=np.maximum(np.stack([h0, h1], axis=1)[wet], 0.0),
    )


def _of_flow(flow: FlowResult, lines: FloatArray) -> WetParts:
    """Return the parts of lines (k, 2, 2) along which a flow presses."""
    import shapely

    segments, pressures = flow.under_pressure
    if not len(segments) or not len(lines):
        none = np.zeros((0, 2))
        return WetParts(line=np.zeros(0, np.int64), ends=none, pressure=none)
    vector = lines[:, 1] - lines[:, 0]
    length = np.hypot(*vector.T)
    tree = shapely.STRtree(shapely.linestrings(segments))
    line, segment = tree.query(shapely.linestrings(lines), predicate="dwithin", distance=BESIDE * length)
    unit = vector[line] / length[line][:, None]
    of = segments[segment] - lines[line, :1]
    along = (of * unit[:, None]).sum(axis=2) / length[line][:, None]
    beside = (of[:, :, 0] * unit[:, None, 1] - of[:, :, 1] * unit[:, None, 0]) / length[line][:, None]
    forward = along[:, 1] > along[:, 0]
    along, beside, pressure = (
        np.where(forward[:, None], values, values[:, ::-1]) for values in (along, beside, pressures[segment])
    )
    t0, t1 = np.maximum(along[:, 0], 0.0), np.minimum(along[:, 1], 1.0)
    reach = np.maximum(along[:, 1] - along[:, 0], np.finfo(float).tiny)
    on_it = (t1 - t0 > SHORTEST) & (np.abs(np.diff(beside, axis=1)[:, 0]) <= PARALLEL * reach)
    on_it &= np.abs(beside.mean(axis=1)) <= BESIDE
    line, t0, t1, along, reach, pressure = (v[on_it] for v in (line, t0, t1, along, reach, pressure))
    rise = (pressure[:, 1] - pressure[:, 0]) / reach
    ends = np.stack([t0, t1], axis=1)
    order = np.lexsort((t0, line))
    at_ends = pressure[:, :1] + rise[:, None] * (ends - along[:, :1])
    return WetParts(line=line[order], ends=ends[order], pressure=at_ends[order])
