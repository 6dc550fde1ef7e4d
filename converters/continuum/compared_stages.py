"""Every stage of a run with its class, beside the continuum where there is one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.converters.continuum.bolt_forces import bolt_force_error
from bsm_mesh.converters.continuum.comparability import (
    MAY_MOVE_FAR,
    Comparability,
    continuum_obstacle,
    has_joints,
    obstacle,
    rock_breaks,
    slipping_length,
)
from bsm_mesh.converters.continuum.comparison import Comparison
from bsm_mesh.converters.continuum.departures import is_all_rigid
from bsm_mesh.converters.continuum.differences import Difference, measure_difference, stress_errors
from bsm_mesh.converters.continuum.joint_forces import joint_force_error
from bsm_mesh.converters.continuum.mesh import Discretization
from bsm_mesh.converters.continuum.solution import ContinuumSolution
from bsm_mesh.converters.continuum.stages import Continuum
from bsm_mesh.errors import ModelError
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Fixed
from bsm_mesh.results.records import Results, StageResult

STILL = 1e-9  # of a block's size: less than this in both methods is no movement


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ComparedStage:
    """A stage's class, and the comparison where there is one.

    Attributes
    ----------
    name : str
        Of the stage.
    kind : Comparability
        The class.
    reason : str
        Why it is not comparable; empty where it is.
    comparison : Comparison or None
        None where it is not comparable.
    """

    name: str
    kind: Comparability
    reason: str
    comparison: Comparison | None

    @property
    def sentence(self) -> str:
        """What a reader should know."""
        return f"Not comparable: {self.reason}." if self.comparison is None else self.comparison.sentence


def compare(model: Model, results: Results, *, order: int | None = None, joints: bool | None = None) -> Comparison:
    """Return the last stage of a run beside the continuum, as `compare_stages` finds it.

    Raises
    ------
    ModelError
        As `compare_stages`, and with its reason where that stage is not comparable.
    """
    last = compare_stages(model, results, order=order, joints=joints, refine=False)[-1]
    if last.comparison is None:
        raise ModelError(f"stage '{last.name}' is not comparable with a continuum: {last.reason}")
    return last.comparison


def compare_stages(
    model: Model, results: Results, *, order: int | None = None, joints: bool | None = None, refine: bool = True
) -> tuple[ComparedStage, ...]:
    """Return every stage of a run with its class, beside the continuum solutions of its model where it has any.

    Parameters
    ----------
    model : Model
        What was run.
    results : Results
        What came out.
    order : {1, 2} or None
        Polynomial order of the continuum's displacements; None: 1 with joints, which then act at the blocks' own
        contact points, else 2.
    joints : bool or None
        Whether the continuum's joints are interfaces with the model's laws, or ignored; None: interfaces.
    refine : bool
        Whether a continuum of the second order tells what finer elements and interfaces change, where joints are
        interfaces and `order` is 1.

    Raises
    ------
    ModelError
        If the results are another model's, or the continuum cannot be solved.
    """
    if results.model_digest != model.digest:
        raise ModelError("the results are not those of this model; run it again")
    reasons = [obstacle(model, results, stage) for stage in results.stages]
    small = results.scheme in MAY_MOVE_FAR
    solved = _elastic(model) if small else model
    if all(reasons):
        return tuple(_refused(stage.name, reason) for stage, reason in zip(results.stages, reasons, strict=True))
    count = 1 + max(number for number, reason in enumerate(reasons) if not reason)
    breaks = not small and any(rock_breaks(stage.contacts) for stage in results.stages[:count])
    interfaces = (has_joints(model) or breaks) and joints is not False
    order = (1 if interfaces else 2) if order is None else order
    elements = Discretization(order=order, joints=interfaces, rock_breaks=breaks)
    continuum = Continuum(solved, elements)
    nominal = continuum.solve("nominal", count)
    matched = nominal if is_all_rigid(model) else continuum.solve("matched", count)
    finer = (
        Continuum(solved, replace(elements, order=2)).solve("nominal", count)
        if refine and interfaces and order == 1
        else ()
    )
    found = []
    for number, stage in enumerate(results.stages):
        reason = (
            reasons[number]
            or continuum_obstacle(model, nominal, number, small)
            or continuum_obstacle(model, matched, number, small)
        )
        if reason:
            found.append(_refused(stage.name, reason))
            continue
        compared = _compared(model, results, number, nominal[number], matched[number])
        if number < len(finer) and finer[number].converged and compared.displacement_errors:
            compared = replace(compared, refined=_change(finer[number], nominal[number], compared.area))
        kind = Comparability.WITH_INTERFACES if interfaces else Comparability.COMPARABLE
        found.append(ComparedStage(name=stage.name, kind=kind, reason="", comparison=compared))
    return tuple(found)


def _refused(name: str, reason: str) -> ComparedStage:
    return ComparedStage(name=name, kind=Comparability.NOT_COMPARABLE, reason=reason, comparison=None)


def _elastic(model: Model) -> Model:
    """Return the model with joints that neither slip nor open and rock that does not break, as in the linear scheme."""
    return model.replace(
        joints=[replace(joint, law=None, tensile_strength=0.0) for joint in model.joints],
        rocks=[
            replace(
                rock,
                cohesion=None,
                friction=None,
                tensile_strength=None,
                residual_friction=None,
                residual_cohesion=None,
            )
            for rock in model.rocks
        ],
    )


def _change(finer: ContinuumSolution, coarse: ContinuumSolution, area: FloatArray) -> float:
    one, other = coarse.displacement[:, :2], finer.displacement[:, :2]
    return measure_difference("refined", "m", one, other, area).l2


def _compared(
    model: Model, results: Results, number: int, nominal: ContinuumSolution, matched: ContinuumSolution
) -> Comparison:
    stage, moments = results.stages[number], model.blocks.moments
    area = moments.area * stage.present
    held = np.zeros(model.blocks.count, dtype=bool)
    held[stage.supports.block] = True
    forces = joint_force_error(stage.contacts, nominal.contacts, held) if nominal.contacts.length.size else None
    bolts = bolt_force_error(stage.bolts, nominal.bolts)
    strained = area * ~_held_as_a_whole(model)
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
        displacement_errors=_displacement_errors(stage, nominal, matched, area),
        force_error=None if forces is None else forces[0],
        worst_pair=None if forces is None else forces[1],
        bolt_error=None if bolts is None else bolts[0],
        worst_bolt="" if bolts is None else bolts[1],
        slipping=(slipping_length(stage.contacts, held), slipping_length(nominal.contacts, held)),
        refined=None,
        area=moments.area,
        centroid=moments.centroid,
        bsm_seconds=sum(before.seconds for before in results.stages[: number + 1]),
        fem_seconds=nominal.seconds,
        notes=matched.notes,
    )


def _held_as_a_whole(model: Model) -> BoolArray:
    held = np.zeros(model.blocks.count, dtype=bool)
    for support in model.supports:
        if isinstance(support, Fixed) and support.blocks is not None:
            held[list(support.blocks)] = True
    return held if not held.all() else np.zeros_like(held)


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
