"""Random models of blocks with zones in large displacement: ``python -m benchmarks.zone_families``.

The families are those of the campaign (`benchmarks.campaign`). Rock is a thousand times as stiff as the joints, so that
the answers of rigid blocks hold. The first table compares with closed forms. The second one has the verdicts beside
those of rigid blocks. Statics of the deformed outlines judges every rest, as the campaign's oracle ``end`` does. Their
deformation needs no tolerance; what the joints close by has the one of rigid blocks. ``--table`` makes one of both.
With ``--into PAGE`` the tables take the place of what is between that page's marks.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import count, islice
from time import process_time
from typing import NamedTuple

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign import outcome
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.oracles import LACK, RESTED, lack_at_end
from benchmarks.campaign.scene import FloatArray, Scene
from benchmarks.campaign.trial import Trial, trial_of
from benchmarks.pages import add_into, tell
from bsm_mesh.errors import ModelError
from bsm_mesh.results import Results
from examples.numbers.pages import markdown
from tests.scenes.kinked_plane import KinkedPlane

COMMAND = "python -m benchmarks.zone_families"
CLOSED = ("incline", "column", "tower", "plane", "arch", "beam", "corner", "layers", "rocking")
KINKED = "slabs over a kink, on loose ground"
VERDICTS = ("slope", "leaning", "pile", "wall", "plane", "layers", "incline", "rocking", KINKED)
STIFFER = 1e3  # times the joints, over the size of a block
FEW_BLOCKS, MAX_BLOCKS = 30, {"slope": 90, "leaning": 90}  # of a model: its motion takes a minute
MAX_MODELS = {"slope": 2, "leaning": 2}  # 60 blocks and more: their motion takes minutes


def zoned(scene: Scene) -> bsm.Model:
    """Return the model of a scene, whose blocks have zones in large displacement."""
    model = scene.model()
    zones = bsm.Zones(size=4 * scene.size, order=1, displacement="large")
    young = min(STIFFER * scene.kn * scene.size, 1e13)
    return model.replace(rocks=[replace(rock, young=young, poisson=0.2, zones=zones) for rock in model.rocks])


def closed_forms(models: int) -> str:
    """Return the table of models with an answer in closed form."""
    rows = []
    for name in CLOSED:
        start = process_time()
        trials = [trial_of(FAMILIES[name], seed) for seed in range(models)]
        ends = [ended(each) for each in trials if each.expected is not None and each.expected.rests is not None]
        counts = [ends.count(end) for end in ("right", "not converged", "wrong", "refused")]
        rows.append((FAMILIES[name].title, *map(str, (len(ends), *counts, round(process_time() - start)))))
        print(*rows[-1], file=sys.stderr, flush=True)
    header = "family", "judged", "right", "not converged", "wrong", "refused", "processor time, s"
    return markdown(header, rows)


def ended(trial: Trial) -> str:
    """Return whether a run ended as its closed form says, as the campaign judges it, or how else.

    Blocks that do not rest where they were given may rest elsewhere.
    """
    assert trial.expected is not None
    try:
        results = bsm.run(zoned(trial.scene))
    except ModelError as error:
        print(trial.family, trial.seed, error, file=sys.stderr, flush=True)
        return "refused"
    if results.status == "not_converged":
        return "not converged"
    moves = outcome.moved(results, trial.scene.size) > RESTED if trial.expected.rests else _moved(results, trial.scene)
    rests = results.status != "unstable" and not moves
    if rests != trial.expected.rests:
        print(trial.family, trial.seed, results.status, trial.expected, file=sys.stderr, flush=True)
    return "right" if rests == trial.expected.rests else "wrong"


def verdicts(models: int) -> str:
    """Return the table of verdicts, beside those of rigid blocks, with the rests that statics refuses."""
    rows = []
    for name in VERDICTS:
        start, most = process_time(), min(models, MAX_MODELS.get(name, models))
        runs = [(_end(scene, name), _end(scene, name, rigid=True)) for scene in islice(_scenes(name), most)]
        zones, rigid = zip(*runs, strict=True)
        same = sum(one.status == other.status for one, other in runs)
        numbers = [_counts(zones), _counts(rigid), same, sum(end.moved for end in zones)]
        numbers += [sum(end.refused for end in ends) for ends in (zones, rigid)]
        title = FAMILIES[name].title if name in FAMILIES else name
        rows.append((title, *map(str, (*numbers, round(process_time() - start)))))
        print(*rows[-1], file=sys.stderr, flush=True)
    header = (
        "family",
        "zones",
        "rigid blocks",
        "same verdict",
        "rests after movement",
        "rests refused",
        "of rigid blocks",
    )
    return markdown((*header, "processor time, s"), rows)


class End(NamedTuple):
    """The end of a run: its status, whether a rest moved noticeably, and whether statics refuses that rest."""

    status: str
    moved: bool = False
    refused: bool = False


def _scenes(name: str) -> Iterator[Scene]:
    """Return the scenes of a family that are not too large, one after the other."""
    for seed in count():
        if name == KINKED:
            yield _kinked(seed)
        elif (scene := trial_of(FAMILIES[name], seed).scene).count <= MAX_BLOCKS.get(name, FEW_BLOCKS):
            yield scene


def _kinked(seed: int) -> Scene:
    """Return a slab that slides over a kink, on two blocks that rest on a third one."""
    drawn = KinkedPlane.drawn(seed, loose=True, bare=False)
    return Scene(polygons=drawn.outlines, held=np.array([2]), friction=drawn.friction, kn=1e10, ks=5e9)


def _end(scene: Scene, name: str, *, rigid: bool = False) -> End:
    """Return the end of the run of a scene, of rigid blocks or of blocks with zones."""
    try:
        results = outcome.run(scene)[0] if rigid else bsm.run(zoned(scene))
    except ModelError as error:
        print(name, error, file=sys.stderr, flush=True)
        return End("refused")
    if results.status != "stable":
        return End(str(results.status))
    lack = lack_of(scene, results)
    if lack > LACK:
        print(name, scene.digest, f"{lack:.1e} weights lack", file=sys.stderr, flush=True)
    return End("stable", _moved(results, scene), lack > LACK)


def _moved(results: Results, scene: Scene) -> bool:
    """Return whether blocks moved by more than joints close."""
    closure = outcome.closure(results) / scene.size
    return outcome.moved(results, scene.size) > outcome.noticeable({"closure": closure})


def lack_of(scene: Scene, results: Results) -> float:
    """Return by how many weights the loads of a rest exceed what forces do between blocks, as they deformed."""
    return lack_at_end(scene, results, outlines(results), outcome.closure(results) / scene.size)


def outlines(results: Results) -> list[FloatArray]:
    """Return the blocks where they are at the end, with zones as they deformed."""
    evidence = results.stages[-1].evidence
    if evidence is None or evidence.outline is None or evidence.outline_offsets is None:
        return outcome.final_polygons(results)
    return np.split(evidence.outline, evidence.outline_offsets[1:-1])


def _counts(ends: Sequence[End]) -> str:
    """Return how many ended in which way, in words."""
    found = Counter(end.status for end in ends)
    return ", ".join(f"{number} {status.replace('_', ' ')}" for status, number in sorted(found.items()))


TABLES = {"closed forms": (closed_forms, 10), "verdicts": (verdicts, 4)}  # and models of each family


def main() -> None:
    """Make the tables, and print them or put them into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--models", type=int, help="of each family; by default 10 with closed forms, and 4 others")
    parser.add_argument("--table", choices=TABLES, help="this one alone")
    add_into(parser, COMMAND)
    given = parser.parse_args()
    made = [make(given.models or most) for name, (make, most) in TABLES.items() if given.table in (None, name)]
    tell("\n\n".join(made), COMMAND, given.into)


if __name__ == "__main__":
    main()
