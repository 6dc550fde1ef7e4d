"""The treatment of unstable blocks: the run ends, or they are taken away and the others continue."""

from __future__ import annotations

from dataclasses import replace

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import counted, numbered
from bsm_mesh.model.model import Model
from bsm_mesh.movements import distances, translations
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.records import StageResult, Status


def falls_of(
    model: Model, block: IntArray, small: BoolArray, stage: StageResult, moved: FloatArray
) -> tuple[Fall, ...]:
    """Return the records of blocks (k,) that fall at the end of a stage so far.

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
    """Return a stage with the blocks taken away in it, named, and its verdict; `unit` is that of the blocks' bulk."""
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
