"""Movement of blocks: of points in them, and how far they went before they reached rest.

A landing after a fall is an equilibrium, and often a failure too.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import counted
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.quantity import shown
from bsm_mesh.movements import carried, distances, translations, turned, turns
from bsm_mesh.results.records import StageResult, Status, StepRecord

FAR = 0.1  # of a block's size


def moved_far(blocks: Blocks, stage: StageResult) -> IntArray:
    """Return the blocks at rest that lie far from where the stage found them, (k,)."""
    if not stage.status.is_stable:
        return np.zeros(0, np.intp)
    return np.flatnonzero(distances(stage.stage_displacement) > FAR * blocks.moments.size)


def gave_way(blocks: Blocks, stage: StageResult) -> tuple[int, IntArray]:
    """Return how many blocks that count fell in a stage that is stable, and those that moved far, (k,)."""
    far = moved_far(blocks, stage)
    fallen = sum(not fall.ignored for fall in stage.falls) if stage.status.is_stable else 0
    return fallen, far[stage.counts[far]]


def moved_beside(blocks: Blocks, stage: StageResult) -> IntArray:
    """Return the blocks that count and moved far as well when others fell and ended the run, (k,)."""
    if stage.status is not Status.UNSTABLE or not stage.unstable_blocks.size:
        return np.zeros(0, np.intp)
    far = (distances(stage.stage_displacement) > FAR * blocks.moments.size) & stage.counts
    far[stage.unstable_blocks] = False
    return np.flatnonzero(far)


LOST_CONTACT = "a block has lost all contact and moves freely"  # reason of a collapse


def moved_beyond(limit: float) -> str:
    """Return the reason of a collapse by the displacement limit [m]."""
    return f"a block moved more than {limit:.3g} m"


def step_in_words(step: StepRecord) -> str:
    """Return the progress of an accepted step: the unbalanced force, or the time reached in a record."""
    at = f"step {step.step}: unbalanced force {step.residual:.1e}"
    if step.time is not None:
        at = f"shaken for {step.time:.4g} s"
    return f"stage {step.stage}, {at}, displacement in the stage {step.max_displacement:.3g} m"


def share_in_words(part: float) -> str:
    """Return a part of the whole in per cent, in two digits.

    Examples
    --------
    >>> share_in_words(1.0), share_in_words(0.0784), share_in_words(0.0005)
    ('100 %', '7.8 %', '0.05 %')
    """
    return f"{shown(float(f'{100 * part:.2g}'))} %"


def verdict_in_words(blocks: Blocks, stage: StageResult) -> str:
    """Return the verdict on a stage as a person reads it, with the blocks that gave way before the others reached rest.

    `stable, after 3 blocks moved by up to 3.8 m (1.3 times the block's size)`: they moved by more than a tenth of their
    size in the stage, and lie somewhere. `stable, after 2 blocks fell`: they were taken away. Blocks that are too small
    to count (``falls.ignore_below``) do not enter. `unstable, 1 block falls: 0.05 % of the area`.
    """
    verdict = stage.status.value.replace("_", " ")
    if stage.status is Status.NO_VERDICT:
        return f"{verdict}: nothing can fail in this scheme"
    if stage.status is Status.UNSTABLE and stage.unstable_blocks.size:
        bulk, down = blocks.moments.bulk, stage.unstable_blocks
        share = share_in_words(float(bulk[down].sum() / bulk[stage.present].sum()))
        fall = f"{counted(down.size, 'block')} fall{'s' if down.size == 1 else ''}"
        return f"{verdict}, {fall}: {share} of the {blocks.bulk_name}"
    if not stage.status.is_stable:
        return verdict
    fallen, _ = gave_way(blocks, stage)
    told = [f"{counted(fallen, 'block')} fell"] if fallen else []
    told += [moved] if (moved := moved_in_words(blocks, stage)) else []
    return ", after ".join([Status.STABLE.value, *([" and ".join(told)] if told else [])])


def moved_in_words(blocks: Blocks, stage: StageResult) -> str:
    """Return how far blocks that count moved in a stage before they reached rest; empty: not far."""
    _, far = gave_way(blocks, stage)
    if not far.size:
        return ""
    moved = distances(stage.stage_displacement[far])
    most = int(moved.argmax())
    up_to = "by" if far.size == 1 else "by up to"
    size = part_of_size(blocks, int(far[most]), moved[most])
    return f"{counted(far.size, 'block')} moved {up_to} {moved[most]:.3g} m ({size})"


def part_of_size(blocks: Blocks, block: int, length: float) -> str:
    """Return a length [m] as a part of a block's size, in words."""
    share = length / float(blocks.moments.size[block])
    return f"{share:.2g} times the block's size" if share >= 1 else f"{share:.2g} of the block's size"


def displacement_of(blocks: Blocks, displacement: FloatArray, block: IntArray, point: FloatArray) -> FloatArray:
    """Return the displacement of points in blocks, by exact rotation about the centroid.

    Parameters
    ----------
    blocks : Blocks
        As they were given.
    displacement : (n, 3) float64 [m, m, rad]
        Of every block; in space (n, 6).
    block : (k,) int
        The block of each point.
    point : (k, 2) float64 [m]
        In the given geometry.

    Returns
    -------
    (k, 2) float64 [m]
    """
    return carried(point - blocks.moments.centroid[block], displacement[block])


def displacement_at(blocks: Blocks, stage: StageResult, block: IntArray, point: FloatArray) -> FloatArray:
    """Return the displacement of points (k, 2) of blocks (k,) at the end of a stage, by their zones if there are some.

    Points are in the given geometry; the displacement counts as ``StageResult.displacement``. Blocks that are not there
    give NaN.
    """
    zones = stage.zones
    of_block = displacement_of(blocks, stage.displacement, block, point)
    moved = of_block if zones is None else zones.displacement_at(block, point)
    moved[~stage.present[block]] = np.nan
    return moved


def greatest_displacement(stage: StageResult) -> float:
    """Return the greatest displacement of a node of zones [m], without zones of a centroid; of blocks that count."""
    return stage.max_displacement if stage.zones is None else stage.zones.max_displacement(stage.counts)


def as_given(blocks: Blocks, moved: FloatArray, block: IntArray, point: FloatArray) -> FloatArray:
    """Return where points (k, 2) [m] of moved blocks were in the given geometry; `moved` as in `displacement_of`."""
    centroid, own = blocks.moments.centroid[block], moved[block]
    before: FloatArray = centroid + turned(point - centroid - translations(own), -turns(own))
    return before
