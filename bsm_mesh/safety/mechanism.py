"""The mechanism of failure: blocks, and the joints that slip or open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import numbered, place
from bsm_mesh.results.joint_sets import JointSet, joint_sets
from bsm_mesh.safety.driver import Found


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Mechanism:
    """How a model fails.

    Attributes
    ----------
    value : float
        The value at which it was seen.
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


def mechanism_of(found: Found) -> Mechanism | None:
    """Return what fails at the first unstable value."""
    value = found.bracket.unstable
    if value is None or value not in found.states:
        return None
    trial = next(trial for trial in found.trials if trial.value == value)
    results, last = found.states[value], found.states.get(found.bracket.stable or 0.0)
    stage, moments = results.stages[-1], results.blocks.moments
    area = moments.bulk[trial.blocks]
    centre = (
        np.average(moments.centroid[trial.blocks], axis=0, weights=area)
        if len(area)
        else np.zeros(moments.centroid.shape[1])
    )
    return Mechanism(
        value=value,
        blocks=trial.blocks,
        area=float(area.sum()),
        part=float(area.sum() / moments.bulk[stage.present].sum()),
        centre=tuple(centre.tolist()),
        joints=() if last is None else joint_sets(last, last.stages[-1]),
    )
