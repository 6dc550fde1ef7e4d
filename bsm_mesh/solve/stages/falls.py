"""The treatment of unstable blocks: the run ends, or they are taken away and the others continue."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.errors import counted, numbered
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.falls import MOST_OF_A_CHIP
from bsm_mesh.model.model import Model
from bsm_mesh.movements import distances, translations
from bsm_mesh.results.falls import Fall
from bsm_mesh.results.movement import moved_beside, moved_beyond, moved_far
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


def within_limit(stage: StageResult, limit: float | None) -> StageResult:
    """Return a stage at rest, unstable where a block that counts moved in it by more than a limit [m], if there is one.

    Blocks that explicit motion follows are stopped there (`solve.continuation.verdict`); this is for one step to rest.
    """
    if limit is None or stage.status is not Status.STABLE:
        return stage
    far = np.flatnonzero((distances(stage.stage_displacement) > limit) & stage.counts).astype(np.int32)
    if not far.size:
        return stage
    return replace(stage, status=Status.UNSTABLE, reason=moved_beyond(limit), unstable_blocks=far)


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


def notes_on_movement(blocks: Blocks, stage: StageResult) -> list[str]:
    """Report blocks far from their place at the stage's start: at rest, or too small to count."""
    far = moved_far(blocks, stage)
    moved = distances(stage.stage_displacement)
    large, small = far[stage.counts[far]], far[~stage.counts[far]]
    notes = []
    if large.size:
        notes.append(
            f"before it reached rest, {counted(large.size, 'block')} moved by more than a tenth of "
            f"{'its' if large.size == 1 else 'their'} size, up to {moved[large].max():.3g} m: "
            f"{numbered('block', large)}; if that is a failure, give a smaller displacement_limit in [solver]"
        )
    if small.size:
        notes.append(
            f"{counted(small.size, 'block')} too small to count (falls.ignore_below) moved by up to "
            f"{moved[small].max():.3g} m: {numbered('block', small)}"
        )
    return notes


def note_on_others(blocks: Blocks, stage: StageResult, free: BoolArray) -> list[str]:
    """Report that blocks that fell ended the run before the others' own verdict, and the keys that give it.

    `free` (n,): blocks that are there and not fixed; their mean area is that of ``falls.ignore_below``.
    """
    down = stage.unstable_blocks
    others = stage.counts & free
    others[down] = False
    if not down.size or not others.any():
        return []
    beside, bulk = moved_beside(blocks, stage), blocks.moments.bulk
    note = f"the fall of {numbered('block', down, 6)} ended the run, and the other blocks have no verdict"
    if beside.size:
        most = distances(stage.stage_displacement)[beside].max()
        note += (
            f": {numbered('block', beside, 12)} moved by more than a tenth of "
            f"{'its' if beside.size == 1 else 'their'} size, up to {most:.3g} m"
        )
    note += f'; with on_fall = "remove" in [falls] the run continues without {"it" if down.size == 1 else "them"}'
    if (share := math.ceil(100 * float(bulk[down].max() / bulk[free].mean())) / 100) <= MOST_OF_A_CHIP:
        note += f", and with ignore_below = {share:g} chips of this size do not count"
    return [note]
