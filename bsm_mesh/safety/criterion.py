"""When a trial counts as failed: blocks fall, or move too far from where they are in a reference state."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Protocol

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import numbered, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.quantities import MOVEMENT
from bsm_mesh.model.values import Rules
from bsm_mesh.movements import distances
from bsm_mesh.results.records import Status
from bsm_mesh.results.results import Results
from bsm_mesh.safety.bracket import Verdict

HARDLY = 1e-3  # of a size: a smaller movement is reported as less than this


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Ended:
    """How a trial ended.

    Attributes
    ----------
    value : float
        The value of the trial.
    status : Status
        The verdict of the run.
    reason : str
        Its reason.
    displacement : (n, 3) float64 [m, m, rad]
        Of the blocks in the stage; in space (n, 6).
    down : (k,) int32
        Blocks that fall.
    seconds : float
        Processor time.
    results : Results or None
        The run; None: forgotten.
    """

    value: float
    status: Status
    reason: str
    displacement: FloatArray
    down: IntArray
    seconds: float
    results: Results | None


@dataclass(frozen=True, eq=False, slots=True)
class Judgement:
    """Judgement of a run: the verdict, the reason, and which blocks (k,) fail."""

    verdict: Verdict
    reason: str
    blocks: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int32))


class Criterion(Protocol):
    """The criterion that separates good values from bad ones."""

    @property
    def movement(self) -> float:
        """Part of a block's size: a block that moves by more from the reference state has failed."""

    def judge(self, ended: Ended, reference: Ended | None, blocks: Blocks, counts: BoolArray) -> Judgement:
        """Return the description of a run; from `reference` the movement of the blocks (n,) in `counts` counts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """The displacement that counts as failure.

    Attributes
    ----------
    movement : float
        Part of a block's size, the root of its area. A block that moves further from its place in the reference state
        has failed, even if it reaches rest again.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Failure(movement=0.02).movement
    0.02
    """

    movement: Annotated[float, MOVEMENT] = 0.05

    def __post_init__(self) -> None:
        rules = Rules("failure")
        rules.numbers(self)
        raise_faults(rules.faults)

    def judge(self, ended: Ended, reference: Ended | None, blocks: Blocks, counts: BoolArray) -> Judgement:
        """Return whether a run has failed; undecided where it has no verdict.

        From `reference` the movement of the blocks (n,) in `counts` counts; None: it does not count.
        """
        parts = movement(ended, reference, blocks, counts)
        far = np.flatnonzero(parts > self.movement).astype(np.int32)
        if ended.status is Status.UNSTABLE:  # the first block that falls ends the run, amid the others
            return Judgement(Verdict.UNSTABLE, ended.reason, np.union1d(ended.down, far))
        if not ended.status.is_stable:
            return Judgement(Verdict.UNDECIDED, ended.reason)
        if reference is None or not far.size:
            return Judgement(Verdict.STABLE, ended.reason)
        worst = int(parts.argmax())
        most = f"{100 * parts[worst]:.3g} % of its size"
        moved = f"block {worst} moved by {most}"
        if far.size > 1:
            moved = f"{numbered('block', far, 4)} moved (block {worst} by {most})"
        reason = (
            f"at rest, but {moved} from the position at {reference.value:.4g}; "
            f"more than {100 * self.movement:g} % counts as failure"
        )
        return Judgement(Verdict.UNSTABLE, reason, far)


def movement(ended: Ended, reference: Ended | None, blocks: Blocks, counts: BoolArray) -> FloatArray:
    """Return how far every block that counts is from where it is in the reference state, over its size, (n,).

    Without one: from where it was as the stage began.
    """
    origin = np.zeros_like(ended.displacement) if reference is None else reference.displacement
    parts: FloatArray = distances(ended.displacement - origin) / blocks.moments.size
    return parts * counts


def of_size(moved: float) -> str:
    """Return a movement, over the size of its block, in words.

    Examples
    --------
    >>> of_size(0.1234), of_size(2e-5)
    ('12.3 % of their size', 'less than 0.1 % of their size')
    """
    return f"{100 * moved:.3g} % of their size" if moved >= HARDLY else f"less than {100 * HARDLY:g} % of their size"
