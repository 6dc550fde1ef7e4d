"""What is done with blocks that come down: the run ends, or they are taken away and the others go on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal, get_args

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import counted, numbered, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.model import Model
from bsm_mesh.model.quantities import SHARE
from bsm_mesh.model.values import Rules
from bsm_mesh.movements import distances, translations
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.records import StageResult, Status

OnFall = Literal["stop", "remove"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Falls:
    """What is done with blocks that come down.

    Attributes
    ----------
    ignore_below : float
        Smaller blocks, by their share of the mean area (in space: volume), are taken away when they come loose, and do
        not count for the verdict: slivers of a mesh, chips. 0: every block counts.
    on_fall : {"stop", "remove"}
        ``"stop"``: the stage is unstable, and the run ends. ``"remove"``: whatever comes down is listed and taken away,
        as a roof is scaled, and the others go on: the stage is stable after falls where they come to rest.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> bsm.Falls().ignore_below, bsm.Falls(on_fall="remove").on_fall
    (0.01, 'remove')
    """

    ignore_below: Annotated[float, SHARE] = 0.01
    on_fall: OnFall = "stop"

    def __post_init__(self) -> None:
        rules = Rules("falls")
        rules.numbers(self)
        rules.choice("on_fall", self.on_fall, get_args(OnFall))
        raise_faults(rules.faults)

    def small(self, blocks: Blocks, counted_blocks: BoolArray) -> BoolArray:
        """Return which blocks (n,) are too small to count; the mean is that of the blocks (n,) that may move."""
        bulk = blocks.moments.bulk
        mean = float(bulk[counted_blocks].mean()) if counted_blocks.any() else 0.0
        small: BoolArray = bulk < self.ignore_below * mean
        return small

    def takes_away(self, small: BoolArray) -> bool:
        """Return whether the run goes on without blocks that come down, (k,) of which are small."""
        return small.size > 0 and (self.on_fall == "remove" or bool(small.all()))


def falls_of(
    model: Model, block: IntArray, small: BoolArray, stage: StageResult, moved: FloatArray
) -> tuple[Fall, ...]:
    """Return the records of blocks (k,) that come down at the end of a stage so far.

    `small` (k,) are those that are too small to count, `moved` (n, 3) is the displacement since blocks were given.
    """
    origin = model.blocks.moments.centroid
    place, went = origin + translations(moved), distances(stage.stage_displacement)
    bulk = model.blocks.moments.bulk
    weight = bulk * model.unit_weights
    return tuple(
        Fall(
            block=int(b),
            origin=tuple(origin[b].tolist()),
            place=tuple(place[b].tolist()),
            moved=float(went[b]),
            area=float(bulk[b]),
            weight=float(weight[b]),
            step=stage.steps[-1].step,
            reason=stage.reason,
            ignored=bool(ignored),
        )
        for b, ignored in zip(block, small, strict=True)
    )


def after_falls(stage: StageResult, falls: tuple[Fall, ...], unit: str) -> StageResult:
    """Return a stage with what was taken away in it, named, and its verdict; `unit` is that of the blocks' bulk."""
    ignored = [fall for fall in falls if fall.ignored]
    others = [fall for fall in falls if not fall.ignored]
    status = Status.STABLE_AFTER_FALLS if stage.status is Status.STABLE and others else stage.status
    notes = stage.notes
    if ignored:
        notes = (
            *notes,
            f"taken away when loose, too small to count: {counted(len(ignored), 'block')} of "
            f"{sum(fall.bulk for fall in ignored):.3g} {unit} in all (falls.ignore_below): "
            f"{numbered('block', (fall.block for fall in ignored))}",
        )
    return replace(stage, status=status, notes=notes, falls=falls)
