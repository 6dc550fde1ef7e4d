"""Construction stages, one after the other, from the start or from a checkpoint."""

from __future__ import annotations

from functools import partial

from bsm_mesh.errors import counted, named_stage
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.results.records import StageResult
from bsm_mesh.solve.stages.checkpoint import Resumption
from bsm_mesh.solve.stages.scheme import Finished, Reporter, Stages

AT_THE_START = Resumption()


def solve_stages(
    model: Model, stages: Stages, report: Reporter, finished: Finished, resumption: Resumption = AT_THE_START
) -> tuple[StageResult, ...]:
    """Return the results of all stages up to the first that is not stable; ``initial`` is the first.

    Parameters
    ----------
    model : Model
        The model.
    stages : Stages
        What solves one of its stages after the other.
    report : callable
        Called with a short text on progress.
    finished : callable
        Gets the stages so far at the end of each.
    resumption : Resumption
        Where the run continues, if it was interrupted, and where it ends.

    Raises
    ------
    ModelError
        If the start cannot be analysed.
    """
    begun = resumption.begun
    if begun is None:
        stages.start()
    else:
        stages.recall(begun)
    results = list(resumption.stages)
    last = len(model.stages) if resumption.until is None else resumption.until
    for number in range(len(results), 1 + last):
        if results and not results[-1].status.is_at_rest:
            break
        name = model.stages[number - 1].name if number else INITIAL
        progress = begun.stage if begun is not None and begun.finished == number else None
        if progress is not None:
            report(f"{named_stage(name)} continues after {counted(len(progress.steps), 'step')}")
        elif number:
            report(named_stage(name))
        solve = stages.solution(number, results[-1] if results else None, progress)
        results.append(solve())
        finished(tuple(results))
        stages.end(number)
        resumption.keep(partial(stages.checkpoint, number + 1), True)
    return tuple(results)
