"""Whether nodes on straight edges change an answer: the same model with them and without.

A conforming mesh has a node wherever a joint ends on another. It is no corner, and no answer may hang on it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import islice

import bsm_mesh as bsm
from benchmarks.campaign import outcome, runner
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.outcome import DECIDED, OPTIONS, Record, noticeable
from benchmarks.campaign.scene import Scene
from benchmarks.campaign.tables import Row
from benchmarks.campaign.transforms import noded
from benchmarks.campaign.trial import generator_of, trial_of
from bsm_mesh.solve.limit_analysis import strength_limit

MOST_BLOCKS = 200
BOUND, FACTOR = 1e-3, 2e-3  # of the bound and of the factor: what differs by more is another answer
TOLERANCE = 5e-4  # of a factor of safety
STIFF = 30.0
STIFFER = f"where that differs it is the same with joints {STIFF:g} times as stiff"
EVERY = 20  # model has its factor found
HEAD = ["question", "models", "differ", "first of each family"]


@dataclass(frozen=True, kw_only=True)
class Answers:
    """What is asked of a model."""

    record: Record
    stands: bool  # stable where it was given, and nothing was taken away as too small to count
    admissible: bool
    bound: float | None
    factor: float | None


def study(count: int, tell: Callable[[str], None]) -> list[Row]:
    """Return a table of what nodes change, over so many models that runs decide; Ctrl-C ends it early.

    Faces with nodes have more contact points, and as little as a third of the stiffness against rotation. Where
    that changes a verdict the same model is asked again with stiffer joints: an answer that hung on their stiffness
    is the same then.
    """
    asked: dict[str, list[str]] = {question: [] for question in [*QUESTIONS, STIFFER]}
    differ: dict[str, list[str]] = {question: [] for question in [*QUESTIONS, STIFFER]}

    def judge(question: str, name: str, agree: bool | None, tale: str) -> None:
        if agree is not None:
            asked[question].append(name)
        if agree is False:
            differ[question].append(name)
            tell(f"{name}: {question}: {tale}")

    try:
        for number, (name, scene) in enumerate(islice(_scenes(), count)):
            if number % 100 == 0:
                tell(f"{number} of {count} models")
            scenes = (scene, noded(scene, generator_of("nodes", name, number)))
            both = [_answers(each, number % EVERY == 0) for each in scenes]
            tale = f"{both[0]} and with nodes {both[1]}"
            for question, judged in QUESTIONS.items():
                judge(question, name, judged(*both), tale)
            if _stands(*both) is False:
                judge(STIFFER, name, _same_if_stiffer(*scenes), "no")
    except KeyboardInterrupt:
        tell("ended early")
    return [HEAD, *([q, str(len(asked[q])), str(len(differ[q])), _some(differ[q])] for q in asked)]


def _some(names: list[str]) -> str:
    """Return some names, the first of every family: the log has all of them."""
    families: dict[str, list[str]] = {}
    for name in names:
        families.setdefault(name.rsplit(" ", 1)[0], []).append(name)
    first = [f"{found[0]} and {len(found) - 1} more" if len(found) > 1 else found[0] for found in families.values()]
    return ", ".join(first) or "none"


def _same_if_stiffer(*scenes: Scene) -> bool | None:
    """Return whether both stand or both do not with stiffer joints; None if those are too stiff for rounding."""
    try:
        stand = {_answers(replace(s, kn=STIFF * s.kn, ks=STIFF * s.ks), with_factor=False).stands for s in scenes}
    except bsm.ModelError:
        return None
    return len(stand) == 1


def _scenes() -> Iterable[tuple[str, Scene]]:
    """Yield the scenes of all families in turn, from one that the campaign does not have, the first stage alone."""
    base = {name: family.models for name, family in FAMILIES.items() if not name.endswith("+nodes")}
    for family, seed in runner.in_turn({name: 100 * models for name, models in base.items()}):
        scene = trial_of(FAMILIES[family], seed + FAMILIES[family].models).scene
        if scene.count <= MOST_BLOCKS and scene.k0 is None:
            yield f"{family} {seed + FAMILIES[family].models}", replace(scene, digs=())


def _answers(scene: Scene, with_factor: bool) -> Answers:
    model = scene.model()
    results, *rest = outcome.run(scene)
    record, factor = outcome.record_of(scene, results, *rest), None
    stands = record["status"] == "stable" and record["moved"] < noticeable(record)
    stands = stands and not any(stage.falls for stage in results.stages)
    if with_factor and stands:
        found = bsm.factor_of_safety(model, OPTIONS, tolerance=TOLERANCE)
        if found.stable is not None and found.unstable is not None and found.is_closed:
            factor = (found.stable + found.unstable) / 2
    return Answers(
        record=record,
        stands=stands,
        admissible=bsm.limit_analysis(model).admissible,
        bound=_bound_of(model),
        factor=factor,
    )


def _bound_of(model: bsm.Model) -> float | None:
    try:
        return strength_limit(model).factor
    except bsm.ModelError:  # nothing that touches has a strength
        return None


def _verdict(one: Answers, other: Answers) -> bool | None:
    here, there = one.record["status"], other.record["status"]
    return here == there if {here, there} <= set(DECIDED) else None


def _stands(one: Answers, other: Answers) -> bool | None:
    return None if _verdict(one, other) is None else one.stands == other.stands


def _no_contradiction(one: Answers, other: Answers) -> bool | None:
    standing = [each for each in (one, other) if each.stands]
    return all(each.admissible for each in standing) if standing else None


def _admissible(one: Answers, other: Answers) -> bool | None:
    return one.admissible == other.admissible


def _bound(one: Answers, other: Answers) -> bool | None:
    if one.bound is None or other.bound is None:
        return None if one.bound == other.bound else False
    return _near(one.bound, other.bound, BOUND)


def _factor(one: Answers, other: Answers) -> bool | None:
    return None if one.factor is None or other.factor is None else _near(one.factor, other.factor, FACTOR)


def _near(one: float, other: float, part: float) -> bool:
    return one == other or abs(one - other) <= part * max(abs(one), abs(other))


QUESTIONS: dict[str, Callable[[Answers, Answers], bool | None]] = {
    "the verdict is the same": _verdict,
    "whether it stays where it was given is the same": _stands,
    "what stays where it was given is admissible": _no_contradiction,
    "admissible is the same": _admissible,
    "the bound of the factor is the same": _bound,
    "the factor is the same": _factor,
}
