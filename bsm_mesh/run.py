"""Run a model: from what is given to what came out."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model
    from bsm_mesh.results.records import Results, StageResult, StepRecord
    from bsm_mesh.solve.options import Options
    from bsm_mesh.solve.stages import Reporter, Scheme

Observer: TypeAlias = "Callable[[StepRecord], None]"
Snapshot: TypeAlias = "Callable[[StepRecord, Callable[[], Results]], None]"


def run(
    model: Model,
    options: Options | None = None,
    observer: Observer | None = None,
    report: Reporter = lambda text: None,
    snapshot: Snapshot = lambda record, results: None,
) -> Results:
    """Return the results of a model.

    Parameters
    ----------
    model : Model
        What is given.
    options : Options, optional
        How to solve it.
    observer : callable, optional
        Gets the `StepRecord` of every accepted step.
    report : callable, optional
        Told what is being done, a few words each.
    snapshot : callable, optional
        Gets the `StepRecord` of every accepted step and a function that returns the results as they stand there: one
        stage, not yet in equilibrium. To be called at once, if at all: it costs something and is good until the next
        step only.

    Raises
    ------
    ModelError
        If the model cannot be analysed: nothing that loads it, a part free to move, overlapping blocks, rigid rocks
        without a joint.
    """
    from bsm_mesh.results.records import Results
    from bsm_mesh.solve.options import Options
    from bsm_mesh.solve.readiness import make_ready  # compiled code: not before it is needed
    from bsm_mesh.solve.stages import solve_stages

    options = options or Options()
    report("contacts")
    ready = make_ready(model, options)
    notes = ready.notes
    scheme: Scheme
    if options.scheme == "linear":
        from bsm_mesh.solve.linear.scheme import LinearScheme

        scheme = LinearScheme(model, options, report, ready.contacts)
    else:
        from bsm_mesh.solve.continuation.scheme import ContinuationScheme

        scheme = ContinuationScheme(model, options, report)
    del ready  # of a million blocks 1 GB

    model_digest = model.digest

    def results(stages: tuple[StageResult, ...]) -> Results:
        return Results(
            blocks=model.blocks,
            joint_names=tuple(joint.name for joint in model.joints),
            stages=stages,
            scheme=options.scheme,
            linear_solver=scheme.linear_solver,
            tolerance=options.tolerance,
            model_digest=model_digest,
            title=model.title,
        )

    def watch(record: StepRecord, stage: Callable[[], StageResult]) -> None:
        if observer is not None:
            observer(record)
        snapshot(record, lambda: results((stage(),)))

    def check(stage: StageResult) -> tuple[str, ...]:
        return results((stage,)).check().faults

    return results(solve_stages(model, scheme, report, watch, check, notes))
