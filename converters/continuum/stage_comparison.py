"""One stage of a run compared with the continuum."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.continuum.bolt_forces import bolt_force_error
from bsm_mesh.converters.continuum.comparability import corners_met, jointed_length, slipping_length
from bsm_mesh.converters.continuum.comparison import Comparison
from bsm_mesh.converters.continuum.differences import Difference, measure_difference, stress_errors
from bsm_mesh.converters.continuum.history_values import history_values
from bsm_mesh.converters.continuum.joint_forces import joint_force_error
from bsm_mesh.converters.continuum.joint_movement import joint_movement, joint_movement_errors
from bsm_mesh.converters.continuum.references import References
from bsm_mesh.converters.continuum.refinement import refinement_of
from bsm_mesh.model.model import Model
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.stress import stress_is_known
from bsm_mesh.solve.zones.solution import ContinuumSolution

STILL = 1e-9  # of a block's size: less than this in both methods is no movement


def compare_stage(model: Model, results: Results, number: int, references: References) -> Comparison:
    """Return one stage of a run with the continuum."""
    nominal, matched = references.nominal[number], references.matched[number]
    stage, moments = results.stages[number], model.blocks.moments
    area = moments.area * stage.present
    held = np.zeros(model.blocks.count, dtype=bool)
    held[stage.supports.block] = True
    forces = moved = None
    if nominal.contacts.length.size:
        forces = joint_force_error(stage.contacts, nominal.contacts, held)
        moved = joint_movement(model.blocks, stage.displacement + stage.origin, nominal.contacts)
    bolts = bolt_force_error(stage.bolts, nominal.bolts)
    errors = _displacement_errors(stage, nominal, matched, area)
    levels = [level[number] for level in references.halved if number < len(level)]
    finer = references.finer[number : number + 1] if errors else ()
    rigid = matched is nominal
    strained = area * _strained(model, stage)
    counted = (strained > 0)[:, None, None]
    return Comparison(
        present=stage.present,
        stress=stage.stress,
        displacement=stage.displacement,
        nominal=nominal,
        matched=matched,
        stress_difference=stage.stress - nominal.stress,
        displacement_difference=stage.displacement - matched.displacement,
        stress_errors=stress_errors(stage.stress * counted, nominal.stress * counted, strained),
        displacement_errors=errors,
        force_error=None if forces is None else forces[0],
        worst_pair=None if forces is None else forces[1],
        joint_movement=moved,
        movement_errors=joint_movement_errors(moved, nominal.contacts, held) if moved and errors else (),
        bolts=stage.bolts,
        bolt_error=None if bolts is None else bolts[0],
        worst_bolt="" if bolts is None else bolts[1],
        slipping=(
            slipping_length(stage.contacts, held, jointed_length(nominal.contacts, held)),
            slipping_length(nominal.contacts, held),
        ),
        corners=corners_met(model, stage.contacts),
        histories=history_values(model, results, number, nominal, matched),
        refined=_change(finer[0], nominal, moments.area) if finer else None,
        refinement=refinement_of(levels, references.asked, area, held, rigid) if references.asked and errors else None,
        area=moments.area,
        centroid=moments.centroid,
        bsm_seconds=sum(before.seconds for before in results.stages[: number + 1]),
        fem_seconds=nominal.seconds,
        notes=matched.notes,
    )


def _strained(model: Model, stage: StageResult) -> BoolArray:
    known = stress_is_known(model.blocks, stage)
    return known if known.any() else stage.present


def _displacement_errors(
    stage: StageResult, nominal: ContinuumSolution, matched: ContinuumSolution, area: FloatArray
) -> tuple[Difference, ...]:
    ours = stage.displacement[:, :2]
    greatest = max(np.abs(ours).max(), np.abs(matched.displacement[:, :2]).max())
    if greatest <= STILL * np.sqrt(area[stage.present].mean()):
        return ()
    named = {"displacement, matched E*": matched, "displacement, nominal E": nominal}
    if matched is nominal:
        named = {"displacement": nominal}
    return tuple(
        measure_difference(name, "m", ours, solution.displacement[:, :2], area) for name, solution in named.items()
    )


def _change(finer: ContinuumSolution, coarse: ContinuumSolution, area: FloatArray) -> float:
    one, other = coarse.displacement[:, :2], finer.displacement[:, :2]
    return measure_difference("refined", "m", one, other, area).l2
