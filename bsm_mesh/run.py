"""Run a model: from what is given to what came out."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Results, StepRecord
from bsm_mesh.solve.options import Options

if TYPE_CHECKING:
    from bsm_mesh.solve.stages import Reporter, Scheme

Observer = Callable[[StepRecord], None]


def run(
    model: Model,
    options: Options | None = None,
    observer: Observer | None = None,
    report: Reporter = lambda text: None,
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

    Raises
    ------
    ModelError
        If the model cannot be analysed: a part free to move, overlapping blocks, rigid rocks without a joint.
    """
    options = options or Options()
    watch: Observer = observer or (lambda record: None)
    from bsm_mesh.solve.stages import solve_stages  # compiled code: not before it is needed

    scheme: Scheme
    if options.scheme == "linear":
        from bsm_mesh.solve.linear import LinearScheme

        scheme = LinearScheme(model, options, report)
    else:
        from bsm_mesh.solve.nonlinear import ContinuationScheme

        scheme = ContinuationScheme(model, options, report)
    stages = solve_stages(model, scheme, report, watch)
    return Results(
        blocks=model.blocks,
        joint_names=tuple(joint.name for joint in model.joints),
        stages=stages,
        scheme=options.scheme,
        linear_solver=scheme.linear_solver,
        model_digest=model.digest,
        title=model.title,
    )
