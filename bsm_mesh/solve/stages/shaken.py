"""Notes on a stage that was shaken: the meaning of its verdict, and the way it was followed in time."""

from __future__ import annotations

from collections.abc import Iterator

from bsm_mesh.errors import counted
from bsm_mesh.model.base_motion import BaseMotion
from bsm_mesh.model.model import Model
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.movements import distances
from bsm_mesh.results.movement import verdict_in_words
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.shaking import ShakingResult


def notes_on_shaking(model: Model, stage: StageResult) -> Iterator[str]:
    """Return a sentence for everything that a reader of a shaken stage should know."""
    found = stage.shaking
    shaking = next((each.shaking for each in model.stages if each.name == stage.name), None)
    if found is None or shaking is None:
        return
    yield from _input(shaking, found)
    if stage.status.is_stable and max(BaseMotion(shaking).peaks) > 0:
        yield _survival(model, stage)
    yield _movement(stage, found)
    if found.heavier.any():
        yield (
            f"mass scaling: {counted(int(found.heavier.sum()), 'block')} were heavier than real for a time, the "
            f"heaviest {found.heaviest:.3g} times"
        )


def _survival(model: Model, stage: StageResult) -> str:
    verdict = verdict_in_words(model.blocks, stage)
    if verdict == stage.status.value:
        return "the blocks survived this record; that is no factor of safety"
    return f"this record displaced blocks ({verdict}); their rest after it is no factor of safety"


def _input(shaking: Shaking, found: ShakingResult) -> Iterator[str]:
    """Return what moved the blocks, and whether it ended with a movement."""
    base = BaseMotion(shaking)
    _, velocity = base.peaks
    if max(base.peaks) == 0:
        yield f"nothing shook the model: amplitude or scale is 0; the blocks were followed for {found.time[-1]:.4g} s"
        return
    if shaking.boundary is not None:
        if shaking.quantity == "stress":
            what = f"a stress of up to {velocity:.3g} Pa acted on"
        else:
            what = f"a wave of up to {velocity:.3g} m/s entered through"
        yield f"{what} the quiet boundary '{shaking.boundary}'; the blocks were followed for {found.time[-1]:.4g} s"
        return
    yield f"the base was shaken for {found.time[-1]:.4g} s, with {base.peaks_in_words}"
    end_velocity, end_displacement = base.at_end
    if abs(end_velocity) > 0.01 * velocity:
        yield (
            f"the record ends with a base velocity of {end_velocity:.3g} m/s and a base displacement of "
            f"{end_displacement:.3g} m: no baseline correction is made; displacements are relative to the base"
        )


def _movement(stage: StageResult, found: ShakingResult) -> str:
    moved = distances(stage.stage_displacement)
    return (
        f"permanent displacement up to {moved.max(initial=0.0):.3g} m; greatest velocity "
        f"{found.peak_velocity.max():.3g} m/s, at the end {found.end_velocity:.3g} m/s; {found.cycles} time steps, the "
        f"smallest {found.time_step:.3g} s; energy balance missed by {100 * found.imbalance:.2g} %"
    )
