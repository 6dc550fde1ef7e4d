"""The factor of safety: by how much strength can be divided before the model fails."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import get_args

from bsm_mesh.errors import raise_faults
from bsm_mesh.model.in_stage import model_up_to, resting_stage
from bsm_mesh.model.materials import Joint
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.residual import residual_note
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.model.values import Rules
from bsm_mesh.safety.answer import FACTOR, Safety, Settings, answer_of, notes_on, run_options
from bsm_mesh.safety.bound import Limit, limit_of
from bsm_mesh.safety.bracket import Bracket, Range
from bsm_mesh.safety.criterion import Failure
from bsm_mesh.safety.driver import Found, Search
from bsm_mesh.safety.trials import STARTS, Reduction, Start, StrengthTrials, slides_in, strength_trials
from bsm_mesh.solve.stages.as_built import counted_blocks

LEAST, GREATEST = 0.05, 20.0  # factors beyond are not tried
STIFFER = 10.0  # of the joints, in the spread
MENTIONED = 0.02  # a spread greater than this part of the factor is said in the answer


def factor_of_safety(
    model: Model,
    options: Options | None = None,
    *,
    stage: str | None = None,
    joints: Sequence[str] | None = None,
    rocks: bool | None = None,
    bolts: bool = False,
    start: Start = "stage",
    tolerance: float = 0.005,
    failure: Failure | None = None,
    trials: int = 40,
    processes: int = 1,
    spread: bool = False,
    report: Callable[[str], None] = lambda text: None,
) -> Safety:
    """Return the factor of safety of a stage: by how much strength can be divided before the model fails.

    Limit analysis gives an upper bound with its proof. Then whole runs are tried: each is stable, unstable or
    undecided, and undecided is never counted as failed. The bracket between the last stable and the first unstable
    factor is made narrower until it is closed.

    Where an earlier stage is not stable with the given strength, the factor is below 1. Strength is then raised in
    every stage up to the one in question, whatever `start` is. The same holds after a slide in an earlier stage, if the
    stage in question is unstable from where the blocks lie.

    Parameters
    ----------
    model : Model
        The model.
    options : Options, optional
        How it is solved, instead of the model's own options.
    stage : str, optional
        The stage in question, ``initial`` for the first; None: the last.
    joints : sequence of str, optional
        Joints whose tan(friction), cohesion and tensile strength are divided; None: all.
    rocks : bool, optional
        Whether the strength of rock faces is divided too; None: where all joints are.
    bolts : bool
        Whether the capacities of bolts are divided too.
    start : {"stage", "after", "throughout"}
        Strength is reduced as the stage begins; once it is at rest; or in all stages before as well.
    tolerance : float
        Width of the bracket over the factor.
    failure : Failure, optional
        What counts as failure.
    trials : int
        Most trials.
    processes : int
        Trials that run at the same time. A script that asks for more than one needs ``if __name__ == "__main__"``.
    spread : bool
        Whether the other starts and stiffer joints are tried as well.
    report : callable
        Called with a short text on progress.

    Raises
    ------
    ModelError
        If the model cannot be analysed, or nothing has a strength.

    Examples
    --------
    On a slope of 20 degrees: tan(35) / tan(20) = 1.92, within the bracket.

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
    >>> answer = bsm.factor_of_safety(model.replace(gravity_direction=-110))
    >>> answer.stable <= 1.9238 <= answer.unstable
    True
    """
    rules = Rules("safety")
    rules.a_thing("model", model, Model)
    rules.choice("start", start, get_args(Start))
    raise_faults(rules.faults)
    settings = Settings(tolerance=tolerance, failure=failure or Failure(), trials=trials, processes=processes)
    chosen = None if joints is None else (joints,) if isinstance(joints, str) else joints
    reduction = Reduction(joints=chosen, rocks=chosen is None if rocks is None else rocks, bolts=bolts)
    given = run_options(model, options, processes)
    number = resting_stage(model, stage, "a factor of safety")
    name = [INITIAL, *(each.name for each in model.stages)][number]
    model = model_up_to(model, number)
    reduction.parts(model, 1.0)
    report("limit analysis")
    limit = limit_of(model, reduction, given.falls)
    runs = strength_trials(model, given, reduction, None, start, report)
    found = _search(runs, limit, settings, report)
    notes = [*_on_start(runs, name), *_on_slides(found, name), *notes_on(found, settings), *_on_bound(runs, limit)]
    notes += _on_opening(found, limit)
    others: list[tuple[str, Bracket]] = []
    for text, changed, other in _others(model, runs.start) if spread else ():
        report(f"spread: {text}")
        other_runs = strength_trials(changed, given, reduction, None, other, report)
        if other_runs.start != other:
            notes.append(f"not in the spread: {text}: {other_runs.unreached}")
            continue
        others.append((text, _search(other_runs, limit, settings, report).bracket))
    notes += _on_spread(found.bracket, others)
    beyond = beside(found.bracket, limit, settings)
    notes += [residual] if beyond and (residual := residual_note(model)) else []
    answer = answer_of(found, limit, FACTOR, name, STARTS[runs.start].format(stage=name), reduction.words(model))
    return replace(answer, spread=tuple(others), notes=tuple(notes), beside=beyond)


def _search(runs: StrengthTrials, limit: Limit, settings: Settings, report: Callable[[str], None]) -> Found:
    bound = None if runs.has_moved else _bound(limit, settings.tolerance)
    first = 1.0 if bound is None or bound > 1 else max(bound * (1 - 0.8 * settings.tolerance), LEAST)
    within = Range(good=LEAST, bad=GREATEST, first=first, bound=bound, tolerance=settings.tolerance, is_factor=True)
    model = runs.model
    counts = counted_blocks(model, runs.options.falls)
    search = Search(runs, within, settings.failure, model.blocks, counts, report, runs.known)
    return search.run(settings.trials, settings.processes)


def _bound(limit: Limit, tolerance: float) -> float | None:
    """Return a factor at which failure is proved, just beyond the limit."""
    bound = max(limit.factor * (1 + tolerance / 20), LEAST)
    return bound if bound < GREATEST else None


def _others(model: Model, start: Start) -> list[tuple[str, Model, Start]]:
    """Return the other starts that differ for a model, and the model with stiffer joints: name, model, start."""
    name = model.stages[-1].name if model.stages else INITIAL
    kinds = ("stage", "after", "throughout") if model.stages else ("stage", "after")
    others: list[tuple[str, Model, Start]] = [
        (STARTS[kind].format(stage=name), model, kind) for kind in get_args(Start) if kind in kinds and kind != start
    ]
    stiffer = model.replace(joints=[_stiffer(joint) for joint in model.joints])
    return [*others, (f"joints {STIFFER:g} times as stiff", stiffer, start)]


def _stiffer(joint: Joint) -> Joint:
    if joint.filling is not None:
        return replace(joint, filling=replace(joint.filling, young=STIFFER * joint.filling.young))
    assert joint.normal_stiffness is not None
    shear = None if joint.shear_stiffness is None else STIFFER * joint.shear_stiffness  # or that of the law
    return replace(joint, normal_stiffness=STIFFER * joint.normal_stiffness, shear_stiffness=shear)


def _on_start(runs: StrengthTrials, stage: str) -> tuple[str, ...]:
    """Say why strength was divided in every stage where another start was asked for."""
    if not runs.unreached:
        return ()
    return (f"{runs.unreached}; the strength of every stage up to '{stage}' is raised until they are stable",)


def _on_bound(runs: StrengthTrials, limit: Limit) -> tuple[str, ...]:
    """Say where the bound is not one of this stage."""
    if math.isfinite(limit.unproved):
        return (
            f"limit analysis found no forces beyond {limit.unproved:.5g}, without a proof: failure is judged by "
            "movement alone",
        )
    if not runs.has_moved or math.isinf(limit.factor):
        return ()
    return (
        "blocks moved in earlier stages: the bound by limit analysis is that of where they were given, and was "
        "not used",
    )


def beside(bracket: Bracket, limit: Limit, settings: Settings) -> str:
    """Return what limit analysis says where its factor differs from that of the trials by more than the tolerance."""
    factor = min(limit.factor, limit.unproved)
    if math.isinf(factor) or bracket.stable is None or bracket.unstable is None:
        return ""
    wide = 1 + settings.tolerance
    if bracket.stable / wide <= factor <= bracket.unstable * wide:
        return ""
    proof = "initial geometry" if math.isfinite(limit.factor) else "initial geometry, without proof"
    return f"upper bound by limit analysis: {factor:.4g} ({proof})"


def _on_slides(found: Found, stage: str) -> tuple[str, ...]:
    """Say which blocks slid in stages before the one in question, at the last stable factor."""
    if (stable := found.states.get(found.bracket.stable or 0.0)) is None:
        return ()
    number = [each.name for each in stable.stages].index(stage)
    its = "the factor is that of where the blocks reached rest; that stage has its own (--stage, in Python stage=)"
    return tuple(f"{slide}: {its}" for slide in slides_in(stable.stages[:number], stable.blocks))


def _on_opening(found: Found, limit: Limit) -> tuple[str, ...]:
    """Say why no strength is enough in the runs where statics knows of forces that would do."""
    tried = [trial.value for trial in found.trials]
    if found.bracket.stable is not None or found.bracket.unstable is None or found.bracket.undecided:
        return ()
    if limit.factor <= LEAST or min(tried) > LEAST:
        return ()
    below = f" below {limit.factor:.4g}" if math.isfinite(limit.factor) else ""
    return (
        f"blocks fall at {1 / LEAST:g} times the strength too, though statics proves nothing{below}: their joints "
        "open as they move, and open joints carry no shear; not strength but stiffness (normal over shear), in-situ "
        "stress and bolts decide",
    )


def _on_spread(bracket: Bracket, others: list[tuple[str, Bracket]]) -> tuple[str, ...]:
    """Say how far other starts lead apart, where that is worth a word."""
    values = [each.stable for _, each in (("", bracket), *others) if each.stable is not None]
    if bracket.stable is None or max(values) - min(values) <= MENTIONED * bracket.stable:
        return ()
    return (f"the factor depends on the start and on stiffness: {min(values):.4g} to {max(values):.4g}",)
