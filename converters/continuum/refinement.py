"""Effect of finer elements and interfaces, and its limit: whether the blocks' own contact points are enough.

In elastic rock both are halved together, and what changes may come from the elements alone.

With every side halved k times the displacements of a stage are d_k. Where the changes fall by a ratio q from one level
to the next, the limit is d_k + (d_k - d_(k-1)) q / (1 - q) (Richardson's extrapolation with the order as found).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.converters.continuum.joint_forces import joint_force_error
from bsm_mesh.errors import listing
from bsm_mesh.solve.zones.solution import ContinuumSolution

COARSE = (
    0.1  # of the limit's r.m.s. displacement: a change by refining beyond which contact points are called too coarse
)
FALLING = 0.9  # ratio of two changes, above which there is no limit to extrapolate to


class Level(NamedTuple):
    """One refinement of the continuum: its size, its results and their changes.

    Attributes
    ----------
    cells, points : int
        Elements, and points of interfaces.
    greatest : float [m]
        Displacement of the block that moves most.
    change : float
        R.m.s. change of the blocks' displacements from the level before over their r.m.s.; 0 at the first.
    force_change : float or None
        The same of joint forces, from the first level; None without joints.
    """

    cells: int
    points: int
    greatest: float
    change: float
    force_change: float | None


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Refinement:
    """A stage of the continuum at several refinements.

    Attributes
    ----------
    levels : tuple of Level
        As given, then halved once, twice, ...
    asked : int
        How many halvings were asked for; fewer levels: the next found no equilibrium.
    limit : (n, 2) float64 [m] or None
        The displacements to which they tend; None where the changes do not fall, or there are less than two.
    too_coarse : (k,) int
        Blocks that refining moves by more than a tenth of the r.m.s. displacement, the one it moves most first.
    rigid : bool
        Whether all rock is rigid, so that the elements change nothing.
    """

    levels: tuple[Level, ...]
    asked: int
    limit: FloatArray | None
    too_coarse: IntArray
    rigid: bool

    @property
    def greatest_limit(self) -> float | None:
        """The displacement of the block that moves most in the limit [m]."""
        return None if self.limit is None else float(np.hypot(*self.limit.T).max())

    @property
    def sentence(self) -> str:
        """The effect of refining, in words; without a full stop."""
        what = "elements and interfaces" if self.levels[0].points else "elements"
        if len(self.levels) == 1:
            return f"with {what} halved the finite elements find no equilibrium"
        first, last = self.levels[0].greatest, self.levels[-1].greatest
        times = {1: "once", 2: "twice"}.get(len(self.levels) - 1, f"{len(self.levels) - 1} times")
        text = f"halving {what} {times} takes the greatest displacement from {first:.3g} to {last:.3g} m"
        if self.greatest_limit is not None:
            text += f", towards {self.greatest_limit:.3g} m"
        elif len(self.levels) > 2:
            text += ", and its changes do not fall yet"
        if len(self.levels) <= self.asked:
            text += "; halved once more they find no equilibrium"
        if not self.levels[0].points:
            return text
        if self.too_coarse.size:
            coarse = (
                "the blocks' own contact points" if self.rigid else "the elements, or the blocks' own contact points,"
            )
            return f"{text}; {coarse} are too coarse for block {listing(self.too_coarse)}"
        return f"{text}; the blocks' own contact points are fine enough"


def refinement_of(
    stages: Sequence[ContinuumSolution], asked: int, area: FloatArray, held: BoolArray, rigid: bool
) -> Refinement | None:
    """Return what refining did to a stage; None where nothing moves.

    Parameters
    ----------
    stages : sequence of ContinuumSolution
        The stage as given, halved once, twice, ...; up to the first without equilibrium.
    asked : int
        How many halvings were asked for.
    area : (n,) float64 [m2]
        Of the blocks that are there; 0 for others.
    held : (n,) bool
        Blocks with a support.
    rigid : bool
        Whether all rock is rigid.
    """
    moved = [stage.displacement[:, :2] for stage in stages]
    scale = _rms(moved[-1], area)
    if not scale > 0:
        return None
    changes = [_rms(b - a, area) / scale for a, b in pairwise(moved)]
    forces = [joint_force_error(stages[0].contacts, stage.contacts, held) for stage in stages]
    levels = tuple(
        Level(
            cells=len(stage.cell_block),
            points=stage.contacts.length.size,
            greatest=float(np.hypot(*displacement.T).max()),
            change=change,
            force_change=None if force is None else force[0].l2,
        )
        for stage, displacement, change, force in zip(stages, moved, [0.0, *changes], forces, strict=True)
    )
    limit = None
    if len(changes) > 1 and changes[-1] < FALLING * changes[-2]:
        ratio = changes[-1] / changes[-2]
        limit = moved[-1] + (moved[-1] - moved[-2]) * ratio / (1 - ratio)
    off = np.hypot(*((moved[-1] if limit is None else limit) - moved[0]).T) / scale
    order = np.argsort(-off, kind="stable")
    return Refinement(levels=levels, asked=asked, limit=limit, too_coarse=order[off[order] > COARSE], rigid=rigid)


def _rms(vectors: FloatArray, area: FloatArray) -> float:
    return float(np.sqrt((area[:, None] * vectors**2).sum() / area.sum()))
