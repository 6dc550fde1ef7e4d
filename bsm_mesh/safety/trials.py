"""Runs of a model that differ in one number; stages before the one in question are solved once."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.in_stage import model_up_to, stage_number, strength_in_stage
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.strength import with_bolt_capacities, with_strength
from bsm_mesh.model.values import Rules
from bsm_mesh.movements import distances
from bsm_mesh.results.movement import moved_in_words
from bsm_mesh.results.records import StageResult, Status
from bsm_mesh.results.results import Results
from bsm_mesh.safety.criterion import Ended
from bsm_mesh.solve.stages.checkpoint import Checkpoint, Resumption
from bsm_mesh.solving import solve

Start: TypeAlias = Literal["stage", "after", "throughout"]
Change: TypeAlias = Callable[[Model, float], Model]
"""Returns a model with the value in question."""

STARTS: dict[str, str] = {
    "stage": "strength reduced as stage '{stage}' begins",
    "after": "strength reduced after stage '{stage}' is at rest",
    "throughout": "strength reduced in every stage up to '{stage}'",
}
REDUCED = "strength reduced"
MOVED = 0.01  # of the median block's size: within it the geometry is that which was given


@dataclass(frozen=True, slots=True, kw_only=True)
class Reduction:
    """Which strength a factor divides.

    Attributes
    ----------
    joints : sequence of str or None
        Joints; None: all that have a law.
    rocks : bool
        The faces of rock without a joint too.
    bolts : bool
        The capacities of the bolts too.
    """

    joints: Sequence[str] | None = None
    rocks: bool = True
    bolts: bool = False

    def __post_init__(self) -> None:
        rules = Rules("safety")
        if self.joints is not None:
            object.__setattr__(self, "joints", rules.texts("joints", self.joints))
        rules.truth("rocks", self.rocks)
        rules.truth("bolts", self.bolts)
        raise_faults(rules.faults)

    def parts(self, model: Model, factor: float) -> dict[str, float]:
        """Return the part of its strength that every joint and rock keeps, as `Stage.strength` takes it.

        Raises
        ------
        ModelError
            If a joint does not exist, or nothing has a strength to be reduced.
        """
        known = [joint.name for joint in model.joints]
        for name in self.joints or ():
            if name not in known:
                raise ModelError(f"safety: there is no joint '{name}'{nearest(name, known)}")
        chosen = [joint.name for joint in model.joints if joint.law is not None]
        if self.joints is not None:
            for name in self.joints:
                if name not in chosen:
                    raise ModelError(
                        f"safety: joint '{name}' has no law (friction), so that it has no strength to reduce"
                    )
            chosen = list(self.joints)
        names = [*chosen, *(f"rock:{rock.name}" for rock in model.rocks if self.rocks and rock.can_fail)]
        if not names:
            raise ModelError(
                "safety: nothing has a strength to reduce: no joint has a law (friction), and no rock friction, "
                "cohesion or tensile strength"
            )
        return dict.fromkeys(names, 1 / factor)

    def words(self, model: Model) -> str:
        """Return the reduced quantity of a model, in words."""
        zones = self.rocks and any(rock.yields for rock in model.rocks)
        faces = self.rocks and (not zones or any(rock.has_strength and not rock.yields for rock in model.rocks))
        parts = []
        if self.joints is not None:
            parts.append(f"joint {', '.join(self.joints)}")
        elif model.joints or not zones:
            parts.append("all joints")
        parts += ["rock faces"] * faces + ["rock in zones"] * zones + ["bolts"] * self.bolts
        whole = "; bolts keep their full capacity (--bolts divides it too; in Python bolts=True)"
        return ", ".join(parts) + self._left(model) + whole * bool(model.bolts and not self.bolts)

    def _left(self, model: Model) -> str:
        """Return the parts of the divided strength that stages have left, in words; empty: all of it."""
        had, divided = strength_in_stage(model, len(model.stages)), self.parts(model, 1.0)
        left = [f"{name} {had[name]:.4g}" for name in divided if had.get(name, 1.0) != 1.0]
        return f"; of the strength that stages left, a part of the given one: {', '.join(left)}" if left else ""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class StrengthTrials:
    """Trials of a model at reduced strength; picklable.

    Attributes
    ----------
    model : Model
        The model up to the stage in question, the last of its stages.
    options : Options
        How it is solved.
    reduction : Reduction
        Which strength is reduced.
    start : {"stage", "after", "throughout"}
        From when on.
    begun : Checkpoint or None
        State before the stage in which the strength is reduced; None: it is reduced from the start.
    before : Results or None
        Results up to there.
    unreached : str
        Why the stage is not reached with the strength that is given, so that strength is divided throughout, whatever
        start was asked for; empty: it is reached.
    known : tuple of Ended
        Trials that were run to find that out.
    """

    model: Model
    options: Options
    reduction: Reduction
    start: Start
    begun: Checkpoint | None = None
    before: Results | None = None
    unreached: str = ""
    known: tuple[Ended, ...] = ()

    def run(self, factor: float, limit: float | None = None) -> Ended:
        """Return how the model ends with its strength divided by a factor, or once a block moved that far [m]."""
        resumption = None
        if self.begun is not None:
            assert self.before is not None
            resumption = Resumption(begun=self.begun, stages=self.before.stages)
        return ended(self.changed(factor), limited(self.options, limit), factor, resumption)

    @property
    def has_moved(self) -> bool:
        """Whether blocks moved in earlier stages, so that the proof of them as given does not hold here."""
        if self.before is None:
            return False
        last, blocks = self.before.stages[-1], self.before.blocks
        moved = distances((last.displacement + last.origin)[last.present])
        return bool(moved.max() > MOVED * blocks.moments.median_size)

    def changed(self, factor: float) -> Model:
        """Return the model with its strength divided by a factor."""
        model = self.model
        if self.reduction.bolts:
            model = with_bolt_capacities(model, 1 / factor)
        parts = self.reduction.parts(model, factor)
        if self.start == "throughout" or (self.start == "stage" and not model.stages):
            return with_strength(model, parts)
        has = strength_in_stage(model, len(model.stages))
        left = {name: part * has.get(name, 1.0) for name, part in ({**dict.fromkeys(has, 1.0), **parts}).items()}
        if self.start == "after":
            return model.replace(stages=[*model.stages, Stage(name=REDUCED, strength=left)])
        *former, last = model.stages
        return model.replace(stages=[*former, replace(last, strength=left)])


def strength_trials(
    model: Model, options: Options, reduction: Reduction, stage: str | None, start: Start, report: Callable[[str], None]
) -> StrengthTrials:
    """Return the trials of a model's stage, what comes before it solved.

    Where an earlier stage is not stable with the given strength, the stage is reached with more strength only. Then
    strength is divided in every stage, and the factor is below 1.

    The same holds where blocks slid in an earlier stage and the stage is unstable from where they lie.
    """
    number = stage_number(model, stage)
    model = model_up_to(model, number)
    reduction.parts(model, 1.0)
    trials = StrengthTrials(model=model, options=options, reduction=reduction, start=start)
    first = number if start == "stage" else number + 1  # of the stages in which strength is reduced
    if start == "throughout" or first == 0:
        return trials
    kept: list[Checkpoint] = []

    def keep(make: Callable[[], Checkpoint], is_end: bool) -> None:
        if is_end:
            kept[:] = [make()]

    before = solve(model, options, report=report, resumption=Resumption(keep=keep, until=first - 1))
    if not before.status.is_stable:
        failed = before.stages[-1]
        why = f"stage '{failed.name}' is {failed.status.value} with the strength that is given ({failed.reason})"
        return replace(trials, start="throughout", unreached=why)
    reached = replace(trials, begun=kept[0], before=before)
    slides = slides_in(before.stages, model.blocks) if start == "stage" else []
    return _after_slide(reached, slides[0], report) if slides else reached


def _after_slide(reached: StrengthTrials, slide: str, report: Callable[[str], None]) -> StrengthTrials:
    """Return the trials from where blocks lie after a slide; throughout, if the stage is unstable from there."""
    report(f"{slide}: trial with the strength that is given")
    first = reached.run(1.0)
    if first.status is not Status.UNSTABLE:
        return replace(reached, known=(first,))
    name = reached.model.stages[-1].name
    why = f"{slide} with the strength that is given, and stage '{name}' is unstable after it ({first.reason})"
    return replace(reached, start="throughout", begun=None, before=None, unreached=why, known=(first,))


def slides_in(stages: Sequence[StageResult], blocks: Blocks) -> list[str]:
    """Return how far blocks moved in stages before they reached rest, a text for each stage in which they did."""
    return [f"{moved} in stage '{stage.name}'" for stage in stages if (moved := moved_in_words(blocks, stage))]


def limited(options: Options, limit: float | None) -> Options:
    """Return options with a displacement limit [m], unless theirs is less."""
    limits = [each for each in (options.displacement_limit, limit) if each is not None]
    return replace(options, displacement_limit=min(limits)) if limits else options


def ended(model: Model, options: Options, value: float, resumption: Resumption | None = None) -> Ended:
    """Return how a model ends; displacements are those of its last stage."""
    began = time.process_time()
    results = solve(model, options, resumption=resumption, proves=False)
    last = results.stages[-1]
    reached = len(results.stages) == len(model.stages) + 1
    return Ended(
        value=value,
        status=last.status,
        reason=last.reason if reached else f"stage '{last.name}': {last.reason}",
        displacement=last.stage_displacement,
        down=last.unstable_blocks,
        seconds=time.process_time() - began,
        results=results,
    )
