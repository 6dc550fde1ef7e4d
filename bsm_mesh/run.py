"""Run a model: from what is given to what came out."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from bsm_mesh.model.model import Model
from bsm_mesh.results.records import Results, StepRecord
from bsm_mesh.solve.options import Options

if TYPE_CHECKING:
    from bsm_mesh.solve.linear import Reporter

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
    if options.scheme == "linear":  # compiled code: not before it is needed
        from bsm_mesh.solve.linear import solve_linear

        stage, linear_solver = solve_linear(model, options, report, watch)
    else:
        from bsm_mesh.solve.nonlinear import solve_nonlinear

        stage, linear_solver = solve_nonlinear(model, options, report, watch)
    return Results(
        blocks=model.blocks,
        joint_names=tuple(joint.name for joint in model.joints),
        stages=(stage,),
        scheme=options.scheme,
        linear_solver=linear_solver,
        model_digest=model.digest,
        title=model.title,
    )
