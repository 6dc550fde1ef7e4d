"""Every stage of a run with its class, and the continuum if it has one."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.converters.continuum.comparability import Comparability, corners_met, obstacle
from bsm_mesh.converters.continuum.comparison import Comparison
from bsm_mesh.converters.continuum.references import Request, solve_references
from bsm_mesh.converters.continuum.stage_comparison import compare_stage
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.model import Model
from bsm_mesh.model.values import Rules
from bsm_mesh.model.zones import has_zones
from bsm_mesh.results.results import Results
from bsm_mesh.solve.zones.mesh import Mesher


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
        """Notes for the reader."""
        return f"Not comparable: {self.reason}." if self.comparison is None else self.comparison.sentence


def compare(model: Model, results: Results, *, order: int | None = None, joints: bool | None = None) -> Comparison:
    """Return the last stage of a run with the continuum, as `compare_stages` finds it.

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
    model: Model,
    results: Results,
    *,
    order: int | None = None,
    joints: bool | None = None,
    refine: bool = True,
    refinements: int = 0,
    mesher: Mesher | None = None,
    near_blocks: bool = False,
) -> tuple[ComparedStage, ...]:
    """Return every stage of a run with its class, and the continuum solutions of its model where it has any.

    Parameters
    ----------
    model : Model
        The model that was run.
    results : Results
        Its results.
    order : {1, 2} or None
        Polynomial order of the continuum's displacements; None: 1 with joints, which then act at the blocks' own
        contact points, else 2.
    joints : bool or None
        Whether the continuum's joints are interfaces with the model's laws, or ignored; None: interfaces.
    refine : bool
        Whether a continuum of the second order tells what finer elements and interfaces change, where joints are
        interfaces and `order` is 1.
    refinements : int
        How often elements and interfaces are halved to find where they lead, instead of the second order.
    mesher : Mesher or None
        Meshes the inside of the blocks; None: as `build_continuum_mesh` says.
    near_blocks : bool
        Whether the last part of every stage begins with the blocks' displacements and broken joints. Joints that break
        leave several equilibria, and this is the elements' own one near by.

    Raises
    ------
    ModelError
        If the results are another model's, or the continuum cannot be solved.
    """
    rules = Rules("compare")
    rules.a_thing("model", model, Model)
    rules.a_thing("results", results, Results)
    raise_faults(rules.faults)
    if results.model_digest != model.digest:
        raise ModelError("the results are not those of this model; run it again")
    refuse_zones(model)
    reasons = [obstacle(model, results, stage) for stage in results.stages]
    if all(reasons):
        return tuple(_refused(stage.name, reason) for stage, reason in zip(results.stages, reasons, strict=True))
    asked = Request(
        order=order, joints=joints, refine=refine, refinements=refinements, mesher=mesher, near_blocks=near_blocks
    )
    count = 1 + max(number for number, reason in enumerate(reasons) if not reason)
    references = solve_references(model, results, count, asked)
    kind = Comparability.WITH_INTERFACES if references.interfaces else Comparability.COMPARABLE
    found = []
    for number, stage in enumerate(results.stages):
        if reason := reasons[number]:
            found.append(_refused(stage.name, reason))
            continue
        if reason := references.obstacle(model, number):
            corners = corners_met(model, stage.contacts)
            found.append(_refused(stage.name, f"{reason}; {corners}" if corners else reason))
            continue
        compared = compare_stage(model, results, number, references)
        found.append(ComparedStage(name=stage.name, kind=kind, reason="", comparison=compared))
    return tuple(found)


def refuse_zones(model: Model) -> None:
    """Raise a `ModelError` for a model whose blocks have zones."""
    if has_zones(model):
        raise ModelError("zones are finite elements already; leave zones out of the rocks to compare rigid blocks")


def _refused(name: str, reason: str) -> ComparedStage:
    return ComparedStage(name=name, kind=Comparability.NOT_COMPARABLE, reason=reason, comparison=None)
