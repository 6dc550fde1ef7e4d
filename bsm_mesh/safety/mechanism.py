"""The mechanism of failure: blocks, and the joints that slip or open."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import numbered, place
from bsm_mesh.movements import in_mechanism
from bsm_mesh.results.joint_sets import JointSet, joint_sets
from bsm_mesh.results.results import Results
from bsm_mesh.safety.bound import Limit
from bsm_mesh.safety.driver import Found


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Mechanism:
    """How a model fails.

    Attributes
    ----------
    value : float
        The value at which it was seen, or beyond which it is proved.
    blocks : (k,) int32
        Blocks that fail.
    area : float [m2]
        Their area; in space their volume [m3].
    part : float
        Their part of the area of all blocks.
    centre : tuple of float [m]
        Their common centroid, where they were given.
    joints : tuple of JointSet
        How the joints are used just before, at the last stable value; none where no value was stable.
    """

    value: float
    blocks: IntArray
    area: float
    part: float
    centre: tuple[float, ...]
    joints: tuple[JointSet, ...]

    def __repr__(self) -> str:
        around = place(round(x, 2) + 0.0 for x in self.centre)
        named = numbered("block", self.blocks, 6)
        return f"Mechanism at {self.value:.4g}: {named}: {100 * self.part:.3g} % of all, around {around} m"


def mechanism_of(found: Found, limit: Limit) -> Mechanism | None:
    """Return the blocks that fail at the first unstable value; where limit analysis proves that, with those it moves.

    Blocks may rest again after a short way, so the movement of the trial alone names chips rather than their slab.
    """
    value = found.bracket.unstable
    if value is None or value not in found.states:
        return None
    trial = next(trial for trial in found.trials if trial.value == value)
    results, last = found.states[value], found.states.get(found.bracket.stable or 0.0)
    moving = _moving(results, limit) if value >= limit.factor else np.zeros(0, dtype=np.int32)
    joints = () if last is None else joint_sets(last, last.stages[-1])
    return _mechanism(value, results, np.union1d(trial.blocks, moving), joints)


def collapse_of(found: Found, limit: Limit) -> Mechanism | None:
    """Return the mechanism of the bound by limit analysis; None without a bound."""
    results = next(iter(found.states.values()), None)
    if results is None or limit.mechanism is None or not math.isfinite(limit.factor):
        return None
    moving = _moving(results, limit)
    return _mechanism(limit.factor, results, moving) if moving.size else None


def _moving(results: Results, limit: Limit) -> IntArray:
    """Return the blocks (k,) that count and move in the mechanism of a bound."""
    if limit.mechanism is None:
        return np.zeros(0, dtype=np.int32)
    moves = in_mechanism(limit.mechanism, results.blocks.moments.gyration) & results.stages[-1].counts
    return np.flatnonzero(moves).astype(np.int32)


def _mechanism(value: float, results: Results, blocks: IntArray, joints: tuple[JointSet, ...] = ()) -> Mechanism:
    """Return the mechanism of some blocks (k,) of a model."""
    stage, moments = results.stages[-1], results.blocks.moments
    area, centroid = moments.bulk[blocks], moments.centroid
    centre = np.average(centroid[blocks], axis=0, weights=area) if len(area) else np.zeros(centroid.shape[1])
    return Mechanism(
        value=value,
        blocks=blocks,
        area=float(area.sum()),
        part=float(area.sum() / moments.bulk[stage.present].sum()),
        centre=tuple(centre.tolist()),
        joints=joints,
    )
