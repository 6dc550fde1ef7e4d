"""A result of another program compared with a stage of a run: averaged over the blocks, with the same tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.continuum.comparability import has_joints
from bsm_mesh.converters.continuum.comparison import enumerated, percent
from bsm_mesh.converters.continuum.differences import Difference, measure_difference, stress_errors
from bsm_mesh.converters.continuum.foreign_fields import FieldNames, PlaneFields, length_factor, plane_fields
from bsm_mesh.converters.continuum.matched import matched_constants
from bsm_mesh.converters.continuum.sampled import BlockAverages, block_averages_of
from bsm_mesh.converters.meshes.foreign_result import ForeignResult
from bsm_mesh.errors import ModelError, counted, nearest
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.solve.zones.departures import is_all_rigid

COVERED = 0.5  # of a block's area: with less of it in the other mesh a block is not compared


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class OutsideComparison:
    """A stage and the result of another program; differences are the first less the second.

    Attributes
    ----------
    stage : str
        Name of the stage.
    source : str
        The other result's file.
    reason : str
        Why they are not comparable; empty where they are. Then there are no differences.
    compared : (n,) bool
        Blocks that are there and that the other mesh covers.
    stress : pair of (n, 2, 2) float64 [Pa] or None
        Of both; None where the other result has none.
    displacement : pair of (n, 2) float64 [m] or None
        Of both; None where the other result has none.
    errors : tuple of Difference
        Of stress components, the whole tensor and the displacement, over the blocks compared.
    notes : tuple of str
        Which arrays were taken, and omissions.
    """

    stage: str
    source: str
    reason: str
    compared: BoolArray
    stress: tuple[FloatArray, FloatArray] | None
    displacement: tuple[FloatArray, FloatArray] | None
    errors: tuple[Difference, ...]
    notes: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """How far both lie apart, in words."""
        if self.reason:
            return f"Not comparable: {self.reason}."
        by_name = {error.name: error for error in self.errors}
        parts = [f"{percent(by_name[name].l2)} in {name}" for name in ("displacement", "stress") if name in by_name]
        return f"Blocks and {Path(self.source).name} differ by {enumerated(parts)}."


def compare_with(
    model: Model, results: Results, other: ForeignResult, names: FieldNames, stage: str | None = None
) -> OutsideComparison:
    """Return a stage of a run with the result of another program.

    Parameters
    ----------
    model : Model
        The model that was run.
    results : Results
        What came out.
    other : ForeignResult
        As `converters.meshes.foreign_files.read_foreign` returns it.
    names : FieldNames
        Names of its arrays.
    stage : str, optional
        Name of the stage; by default the last.

    Raises
    ------
    ModelError
        If there is no such stage, no field is found, or the other mesh covers no block.
    """
    ours, missed = _stage(model, results, stage)
    fields = plane_fields(other, names)
    averages = block_averages_of(other, fields, model.blocks, length_factor(other, names))
    compared = ours.present & (averages.covered >= COVERED)
    reason = missed
    if not reason and not ours.status.is_at_rest:
        reason = f"the blocks' stage '{ours.name}' is {ours.status.value}: there is no state of rest to compare"
    elif not reason and not compared.any():
        reason = f"{other.source} covers no block that is there by half or more"
    stress = displacement = None
    if not reason and fields.has("sxx", "syy", "sxy"):
        xx, yy, xy = (averages.fields[name] for name in ("sxx", "syy", "sxy"))
        theirs = np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2)
        stress = ours.stress, theirs
    if not reason and fields.has("ux", "uy"):
        displacement = ours.displacement[:, :2], np.stack([averages.fields["ux"], averages.fields["uy"]], axis=1)
    return OutsideComparison(
        stage=stage or ours.name,
        source=other.source,
        reason=reason,
        compared=compared,
        stress=stress,
        displacement=displacement,
        errors=_errors(stress, displacement, model.blocks.moments.area * compared),
        notes=(
            *_notes(fields, averages, ours, compared, other.has_elements),
            *_constants(model, displacement is not None),
        ),
    )


def stage_names(model: Model) -> tuple[str, ...]:
    """Return the names of a model's stages, the one before the first among them."""
    return INITIAL, *(stage.name for stage in model.stages)


def stages_of(model: Model, times: Sequence[float], given: Sequence[str]) -> tuple[str, ...]:
    """Return the stage that each of several results of another program belongs to.

    Parameters
    ----------
    model : Model
        With its stages.
    times : sequence of float
        When each result is.
    given : sequence of str
        A stage for each, as the user names it. Without names, one result is that of the last stage. As many results
        as stages are theirs in order, and times that are whole numbers are numbers of stages, from 0.

    Raises
    ------
    ModelError
        If there is no such stage, or it does not follow which stage a result belongs to.
    """
    known = stage_names(model)
    for name in given:
        if name not in known:
            raise ModelError(f"there is no stage '{name}'{nearest(name, list(known))}")
    if len(set(given)) < len(given):
        raise ModelError(f"a stage is named twice among {', '.join(given)}; each result has a stage of its own")
    if given and len(given) == len(times):
        return tuple(given)
    if not given and len(times) == 1:
        return (known[-1],)
    if not given and len(times) == len(known):
        return known
    if not given and all(time in range(len(known)) for time in times) and len(set(times)) == len(times):
        return tuple(known[int(time)] for time in times)
    raise ModelError(
        f"{counted(len(times), 'result')} of the other program, {counted(len(given), 'stage')} named for them, and "
        f"{len(known)} in the model ({', '.join(known)}); name a stage for each result, --stage {known[-1]}"
    )


def _stage(model: Model, results: Results, name: str | None) -> tuple[StageResult, str]:
    """Return a stage, or the last with why the one that is asked for did not come to be."""
    last = results.stages[-1]
    if name is not None and name not in stage_names(model):
        raise ModelError(f"there is no stage '{name}'{nearest(name, list(stage_names(model)))}")
    by_name = {stage.name: stage for stage in results.stages}
    if name is None or name in by_name:
        return by_name.get(name or "", last), ""
    return last, f"the run ended in stage '{last.name}' ({last.status.value}), before '{name}'"


def _errors(
    stress: tuple[FloatArray, FloatArray] | None, displacement: tuple[FloatArray, FloatArray] | None, area: FloatArray
) -> tuple[Difference, ...]:
    on = (area > 0)[:, None]
    errors: list[Difference] = []
    if stress is not None:
        ours, theirs = (of * on[:, :, None] for of in stress)
        errors.extend(stress_errors(ours, theirs, area))
    if displacement is not None:
        errors.append(measure_difference("displacement", "m", displacement[0] * on, displacement[1] * on, area))
    return tuple(errors)


def _notes(
    fields: PlaneFields, averages: BlockAverages, ours: StageResult, compared: BoolArray, has_elements: bool
) -> tuple[str, ...]:
    notes = [f"taken from the other result: {', '.join(fields.named)}"]
    if left := int((ours.present & ~compared).sum()):
        notes.append(f"not compared: {counted(left, 'block')}, less than half of which the other mesh covers")
    if not has_elements:
        notes.append("a table has no elements: fields are interpolated between the nodes, across openings too")
    elif beyond := int((~ours.present & (averages.covered >= COVERED)).sum()):
        notes.append(f"the other mesh has rock in the place of {counted(beyond, 'block')} taken away before")
    return tuple(notes)


def _constants(model: Model, moves: bool) -> tuple[str, ...]:
    """Return the elastic constants that another program would need for the blocks' displacements, where it matters."""
    if not moves or has_joints(model) or is_all_rigid(model):
        return ()
    told = matched_constants(model).notes
    return (*told, "displacements can agree only with a continuum of these constants, stresses with the rock's own")
