"""Oracles: what a run contradicts.

Each is one-sided where it has to be. Proofs: `check` (a stable end is not in equilibrium by its own forces), `end` (a
stable end that no forces can hold, by `statics`), `start` (it is stable, nearly unmoved, where limit analysis proves
that
it cannot), `closed form`, `sense` (an unstable end in which nothing moved). Strong hints, no proofs: `symmetry` (the
same model in other words has another verdict), `friction` (stable, but not with more friction) and `route` (tilted in
stages it has another verdict than at once). `programs` compares the two limit analyses, which must agree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign import outcome
from benchmarks.campaign.outcome import DECIDED, Record, noticeable
from benchmarks.campaign.scene import FloatArray, Scene, polygon_centre
from benchmarks.campaign.statics import unbalanced, weights
from benchmarks.campaign.transforms import mirrored, noded, renumbered, scaled, turned
from benchmarks.campaign.trial import Trial, generator_of
from bsm_mesh.results import Results

PROOFS = ("check", "end", "start", "closed form", "sense", "programs")
HINTS = ("symmetry", "friction", "route")
MOST_BLOCKS = 1200  # for linear programs
LACK = 1e-2  # of a block's weight, summed over all blocks, that geometry and springs may leave out of balance
TOUCHING = 1e-6, 2e-3  # of a block's size: at the start, and at the end beside what joints have closed
MOST_REACH = 0.05  # of a block's size
FELL = 0.05  # of its own size: an unstable block moved more
RESTED = 0.3  # of a block's size: what rests by a closed form moves less
MOVED = 0.05  # of how far blocks move to a rest that is known
SHARE_OF_TWINS, SHARE_OF_STRONGER = 0.25, 0.12  # of the models
NOTHING = 1e-9  # of a block's weight: no lack

Finding = tuple[str, str]


@dataclass(frozen=True, eq=False, kw_only=True)
class Case:
    """A model that has run."""

    trial: Trial
    record: Record
    results: Results


Oracle = Callable[[Case, dict[str, Any]], Iterator[Finding]]


def judge(case: Case) -> Record:
    """Return facts that oracles found, and the contradictions."""
    facts: dict[str, Any] = {}
    found = [finding for oracle in ORACLES for finding in oracle(case, facts)]
    return {"facts": facts, "contradictions": [f"{name}: {text}" for name, text in found]}


def _check(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    if case.record["status"] == "stable":
        check = case.results.check()
        if not check.ok:
            yield "check", str(check)


def _sense(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    record = case.record
    if record["status"] == "unstable" and not record["fallen"]:
        yield "sense", "unstable without an unstable block"
    elif record["status"] == "unstable" and record["fell"] < FELL:
        yield "sense", f"unstable, but no unstable block moved more than {record['fell']:.1e} of its size"


def _start(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    """Judge the geometry without what stages take away: the program's limit analysis, and where it can, ours."""
    scene, record = case.trial.scene.at_the_end(), case.record
    if scene.count > MOST_BLOCKS:
        return
    facts["admissible"] = bsm.limit_analysis(scene.model()).admissible
    lack = None
    if not (scene.table or scene.bolts):
        lack = facts["lack_at_start"] = outcome.rounded(_lack_at_start(scene))
    ran_through = record["stage"].split("/")[0] == record["stage"].split("/")[1]
    stands = record["status"] == "stable" and ran_through and record["moved"] < noticeable(record)
    if case.trial.expected is not None and case.trial.expected.moved:  # a little movement is enough, and is judged
        stands = False
    if stands and (not facts["admissible"] if lack is None else lack > LACK):
        yield "start", f"is after {record['moved']:.1e} of a block where limit analysis says that it must move"
    # of cohesion ours takes more than there is
    differ = lack is not None and (lack > LACK if facts["admissible"] else lack < NOTHING and not scene.cohesion)
    if differ:
        yield "programs", f"limit analysis says admissible: {facts['admissible']}, but {lack:.1e} weights lack"


def _lack_at_start(scene: Scene) -> float:
    loads = weights(scene.polygons, scene.unit_weight, scene.gravity)
    for block, at, force in scene.loads:
        loads[block, :2] += force
        arm = np.asarray(at) - polygon_centre(scene.polygons[block])
        loads[block, 2] += arm[0] * force[1] - arm[1] * force[0]
    reach = TOUCHING[0] * scene.size
    free = np.setdiff1d(np.arange(scene.count), scene.held)
    return unbalanced(
        scene.polygons,
        loads,
        free,
        friction=scene.friction,
        cohesion=scene.cohesion,
        reach=reach,
        size=scene.size,
    )


def lack_at_end(scene: Scene, results: Results, polygons: list[FloatArray], closure: float) -> float:
    """Return by how many weights the loads at the end exceed what forces do between the blocks where they lie.

    Bolts and water act as recorded. What is nearer than a small gap and twice the closure of joints touches.

    Parameters
    ----------
    scene : Scene
        What ran.
    results : Results
        Its results.
    polygons : list of (k, 2) float64 [m]
        All blocks where they are at the end.
    closure : float
        By how much blocks overlap where they touch, over the size of a block.
    """
    stage = results.stages[-1]
    loads = stage.loads.copy()
    centre = results.blocks.moments.centroid + (stage.origin + stage.displacement)[:, :2]
    block, point, force = stage.bolts.on_blocks()
    arm = point - centre[block]
    np.add.at(loads, block, np.column_stack([force, arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]]))
    there = np.flatnonzero(stage.present)
    return unbalanced(
        [polygons[b] for b in there],
        loads[there],
        np.flatnonzero(~np.isin(there, scene.held)),
        friction=scene.friction,
        cohesion=scene.cohesion,
        reach=min(TOUCHING[1] + 2 * closure, MOST_REACH) * scene.size,
        size=scene.size,
    )


def _end(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    """Hold a stable end to what forces can do between the blocks where they lie."""
    scene, record, results = case.trial.scene, case.record, case.results
    if record["status"] != "stable" or scene.count > MOST_BLOCKS:
        return
    lack = lack_at_end(scene, results, outcome.final_polygons(results), record["closure"])
    facts["lack_at_end"] = outcome.rounded(lack)
    if lack > LACK:
        yield "end", f"{lack:.1e} weights of the stable end cannot be balanced by forces between touching blocks"


def _closed_form(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    expected, record = case.trial.expected, case.record
    if expected is None:
        return
    facts["form"], facts["margin"] = expected.form, outcome.rounded(expected.margin)
    if expected.rests is None:
        return
    facts["judged"] = True
    stable, far = record["status"] == "stable", record["moved"]
    limit = f"{expected.form}, {100 * abs(expected.margin):.3g} %"
    if expected.rests and (record["status"] == "unstable" or (stable and far > RESTED)):
        yield "closed form", f"{record['status']} after {far:.2g} of a block, but rests: {limit} below the limit"
    elif not expected.rests and stable and far < noticeable(record):
        yield "closed form", f"stable after {far:.1e} of a block, but must move: {limit} beyond the limit"
    wanted = expected.moved
    if not (expected.rests and stable) or wanted is None:
        return
    if abs(far - wanted) > expected.moved_within + MOVED * wanted + noticeable(record):
        yield "closed form", f"at rest after {far:.3g} of a block, but the form says {wanted:.3g}"


def _symmetry(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    generator = generator_of("twin", case.trial.family, case.trial.seed)
    scene = case.trial.scene
    if generator.random() > SHARE_OF_TWINS or scene.count > MOST_BLOCKS:
        return
    degrees, length, density = generator.uniform(0, 360), *(10 ** generator.uniform(-1, 1, 2))  # all within ranges
    twins: dict[str, Callable[[], Scene]] = {
        "mirrored": lambda: mirrored(scene),
        "renumbered": lambda: renumbered(scene, generator),
        "scaled": lambda: scaled(scene, float(length), float(length * density)),
        "noded": lambda: noded(scene, generator),
    }
    if not (scene.surface or scene.table or any(dig.table for dig in scene.digs)):
        twins["turned"] = lambda: turned(scene, float(degrees))
    kind = str(generator.choice(list(twins)))
    twin = _twin(twins[kind](), kind, facts)
    ours, other = case.record["status"], twin["status"]
    if ours != other and {ours, other} <= set(DECIDED):
        far = f"{case.record['moved']:.2g} and {twin['moved']:.2g} of a block"
        yield "symmetry", f"{ours}, but {kind} {other}, after {far}"


def _stronger(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    generator = generator_of("stronger", case.trial.family, case.trial.seed)
    record, scene = case.record, case.trial.scene
    chosen = generator.random() < SHARE_OF_STRONGER
    if not chosen or record["status"] != "stable" or record["moved"] > noticeable(record) or scene.count > MOST_BLOCKS:
        return
    more = float(generator.uniform(1, 10))
    twin = _twin(replace(scene, friction=min(scene.friction + more, 85.0)), "stronger", facts)
    if twin["status"] == "unstable":
        yield "friction", f"stable, but unstable with {more:.2g} degrees more, after {twin['moved']:.2g} of a block"


def _route(case: Case, facts: dict[str, Any]) -> Iterator[Finding]:
    scene, record = case.trial.scene, case.record
    if not any(dig.gravity is not None for dig in scene.digs):
        return
    twin = _twin(scene.at_the_end(), "at once", facts)
    if {record["status"], twin["status"]} == set(DECIDED):
        yield "route", f"{record['status']} in stages, but {twin['status']} at once"


def _twin(scene: Scene, kind: str, facts: dict[str, Any]) -> Record:
    """Return the record of another scene that is run beside; its verdict is a fact."""
    record = outcome.record_of(scene, *outcome.run(scene))
    facts.setdefault("twins", {})[kind] = record["status"]
    return record


ORACLES: tuple[Oracle, ...] = (_check, _sense, _closed_form, _start, _end, _symmetry, _stronger, _route)
