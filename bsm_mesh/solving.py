"""Solve a model: from the input to the result, by one route or several."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

from bsm_mesh.errors import ModelError

if TYPE_CHECKING:
    from bsm_mesh.arrays import IntArray
    from bsm_mesh.model.model import Model
    from bsm_mesh.model.options import Options
    from bsm_mesh.results.evidence import Proof
    from bsm_mesh.results.histories import Recorder
    from bsm_mesh.results.records import StageResult, StepRecord
    from bsm_mesh.results.results import Results
    from bsm_mesh.solve.continuation.plan import Route
    from bsm_mesh.solve.stages.checkpoint import Keep, Resumption
    from bsm_mesh.solve.stages.scheme import Reporter, Scheme, Stages, Watchers

Observer: TypeAlias = "Callable[[StepRecord], None]"
Snapshot: TypeAlias = "Callable[[StepRecord, Callable[[], Results]], None]"
Finished: TypeAlias = "Callable[[Results], None]"
TURNED_OVER = "record turned over"
SILENCE = 3.0  # s between reports of one work
Output: TypeAlias = "str | os.PathLike[str] | Literal[False] | None"


def spread(results: Results, report: Reporter = lambda text: None) -> Results:
    """Return results with where other routes lead (`Results.spread`): other methods first, loads in parts.

    Of a model with shaken stages these are a half and a quarter of the time step, and the record turned over.
    Where dynamic relaxation was tried it is repeated with half the damping. Verdicts that differ under the same loads
    mean that the model is near its limit. A record turned over is another load.

    Parameters
    ----------
    results : Results
        What `run` returned.
    report : callable
        Called with a short text on progress.

    Raises
    ------
    ModelError
        If the results are not of the continuation (other schemes have one route), or were read back.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> model = bsm.Model(
    ...     blocks=bsm.Blocks.from_polygons(
    ...         [[(0, 0), (3, 0), (3, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="granite"
    ...     ),
    ...     rocks=[bsm.Rock("granite", unit_weight=26e3)],
    ...     joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))],
    ...     default_joint="J1",
    ...     supports=[bsm.Fixed(blocks=[0])],
    ... )
    >>> results = bsm.spread(bsm.run(model))
    >>> {end.status.value for end in results.spread}
    {'stable'}
    """
    from dataclasses import replace

    from bsm_mesh.results.results import Results
    from bsm_mesh.results.spread import route_end
    from bsm_mesh.solve.continuation.plan import OTHERS, USUAL

    if not isinstance(results, Results):
        raise ModelError(f"spread: {type(results).__name__} is no bsm.Results; give what bsm.run returned")
    model, options = results.model, results.options
    if model is None or options is None:
        raise ModelError("spread: these results were read back, without their model; give what bsm.run returned")
    refuse_one_route(options, model)
    tried = {name for stage in results.stages for step in stage.steps for name in (step.method, *step.tried)}
    routes = [route for route in OTHERS if not route.repeats or route.repeats in tried]
    runs = _other_shakings(model) or [(route.name, _in_parts(model, route.parts), route) for route in routes]
    ends = [route_end(USUAL.name, results, results)]
    for name, other, route in runs:
        report(f"spread: {name}")
        found = solve(other, options, route=route)
        ends.append(route_end(name, found, results, same_loads=name != TURNED_OVER))
    return replace(results, spread=tuple(ends))


def _other_shakings(model: Model) -> list[tuple[str, Model, Route | None]]:
    """Return a model with shaken stages at smaller time steps, and with the record turned over; others: nothing."""
    from dataclasses import replace

    if not any(stage.shaking is not None for stage in model.stages):
        return []
    found: list[tuple[str, Model, Route | None]] = []
    for name, part, sign in (("time step / 2", 0.5, 1), ("time step / 4", 0.25, 1), (TURNED_OVER, 1.0, -1)):
        stages = [
            stage
            if (given := stage.shaking) is None
            else replace(stage, shaking=replace(given, time_step=part * given.time_step, scale=sign * given.scale))
            for stage in model.stages
        ]
        found.append((name, model.replace(stages=stages), None))
    return found


def refuse_one_route(options: Options, model: Model) -> None:
    """Raise a `ModelError` where a way to solve has no other routes."""
    from bsm_mesh.model.zones import has_zones

    if has_zones(model):
        raise ModelError("spread: zones have one route; leave zones out of the rocks to try others")
    if options.scheme != "continuation":
        raise ModelError(f"spread: scheme = '{options.scheme}' has one route; only 'continuation' has others")


def _in_parts(model: Model, parts: tuple[float, ...]) -> Model:
    """Return a model whose stages release the excavation forces in more parts."""
    from dataclasses import replace

    def finer(relaxation: Sequence[float]) -> tuple[float, ...]:
        before, found = 0.0, []
        for part in relaxation:
            found += [before + share * (part - before) for share in parts]
            before = part
        return tuple(found)

    return model.replace(stages=[replace(stage, relaxation=finer(stage.relaxation)) for stage in model.stages])


def _seldom(report: Reporter) -> Reporter:
    """Return a reporter that passes on a text some seconds after the last."""
    last = time.monotonic()

    def passes_on(text: str) -> None:
        nonlocal last
        if time.monotonic() > last + SILENCE:
            last = time.monotonic()
            report(text)

    return passes_on


def _stages_of(
    model: Model, options: Options, report: Reporter, route: Route | None, watchers: Watchers, keep: Keep
) -> Stages:
    """Return the stages of a model that can be analysed: of rigid blocks by a scheme, or of blocks with zones."""
    from bsm_mesh import space
    from bsm_mesh.model.kinds import in_space
    from bsm_mesh.model.notes import notes_of
    from bsm_mesh.model.zones import has_zones
    from bsm_mesh.solve.continuation.plan import USUAL
    from bsm_mesh.solve.continuation.scheme import ContinuationScheme
    from bsm_mesh.solve.linear.readiness import make_ready, solver_faults  # compiled code: not before it is needed
    from bsm_mesh.solve.stages.block_stages import BlockStages
    from bsm_mesh.solve.stages.solution import Analysis

    if has_zones(model):
        from bsm_mesh.solve.zones.scheme import ZoneStages

        report("zones")
        return ZoneStages(model, options, watchers, _seldom(report))
    report("contacts")
    scheme: Scheme
    if in_space(model.blocks):
        space.refuse_unready(model, solver_faults(options), options.scheme)
        scheme = ContinuationScheme(model, options, report, route or USUAL)
        return BlockStages(Analysis(model, scheme, watchers, options.falls, keep), report, tuple(notes_of(model)))
    ready = make_ready(model, options)
    if options.scheme == "linear":
        from bsm_mesh.solve.linear.scheme import LinearScheme

        scheme = LinearScheme(ready.model, options, report, ready.contacts)
    else:
        scheme = ContinuationScheme(ready.model, options, report, route or USUAL)
    run = Analysis(ready.model, scheme, watchers, options.falls, keep, ready.flow)
    return BlockStages(run, report, ready.notes)


def solve(
    model: Model,
    options: Options,
    observer: Observer | None = None,
    report: Reporter = lambda text: None,
    snapshot: Snapshot = lambda record, results: None,
    finished: Finished = lambda results: None,
    resumption: Resumption | None = None,
    route: Route | None = None,
    *,
    proves: bool = True,
) -> Results:
    """Return the results of a model, from where `resumption` says, by a route; other arguments as in `run`.

    `proves` says whether limit analysis is asked to prove unstable verdicts. Of zones it always is: there the proof
    is the verdict.
    """
    from bsm_mesh import space
    from bsm_mesh.model.kinds import in_space
    from bsm_mesh.model.zones import has_zones
    from bsm_mesh.results.evidence import Proof
    from bsm_mesh.results.histories import Recorder
    from bsm_mesh.solve.stages.scheme import Watchers
    from bsm_mesh.solve.stages.sequence import AT_THE_START, solve_stages

    def prove(part: Model, down: IntArray) -> Proof:
        from bsm_mesh.solve.limit.proof import prove as proof_of  # of every unstable block only

        if not (proves or has_zones(model)):
            return Proof(text="no proof was asked for")
        report("limit analysis")
        return space.proof_in_space(part) if in_space(part.blocks) else proof_of(part, down)

    begun, recorder = resumption or AT_THE_START, Recorder(model)

    def watch(record: StepRecord, stage: Callable[[], StageResult]) -> None:
        if observer is not None:
            observer(record)
        snapshot(record, lambda: results((stage(),), finished=False))

    def check(stage: StageResult) -> tuple[str, ...]:
        return results((stage,)).check().faults

    def end(stages: tuple[StageResult, ...]) -> None:
        finished(results(stages, finished=False))

    def record(stage: Callable[[], StageResult]) -> tuple[float, ...]:
        return recorder.measure(results((stage(),), finished=False)) if model.histories else ()

    stages = _stages_of(model, options, report, route, Watchers(watch, check, prove, record), begun.keep)
    results = _results_of(model, options, recorder, stages)
    return results(solve_stages(model, stages, report, end, begun))


def _results_of(model: Model, options: Options, recorder: Recorder, solved: Stages) -> Callable[..., Results]:
    """Return what makes the results of a model from stages, and from whether the run is at its end."""
    from bsm_mesh.results.results import Results, StageResults

    digest = model.digest

    def results(stages: tuple[StageResult, ...], *, finished: bool = True) -> Results:
        return Results(
            blocks=model.blocks,
            joint_names=tuple(joint.name for joint in model.joints),
            stages=StageResults(stages),
            scheme=solved.name,
            linear_solver=solved.linear_solver,
            tolerance=options.tolerance,
            model_digest=digest,
            title=model.title,
            default_joint=model.default_joint,
            recorded=recorder.recorded,
            finished=finished,
            model=model,
            options=options,
        )

    return results
