"""Random models with an answer in closed form, of blocks with zones: ``python -m benchmarks.zone_families``.

The families are those of the campaign (`benchmarks.campaign`). Rock is a thousand times as stiff as the joints, so that
the closed forms of rigid blocks hold. With ``--into PAGE`` the table takes the place of what is between that page's
marks.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from time import process_time

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.trial import Trial, trial_of
from benchmarks.pages import add_into, tell
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.motion.falling import SETTINGS as COLLAPSE
from examples.numbers.pages import markdown

COMMAND = "python -m benchmarks.zone_families"
CLOSED = ("incline", "column", "tower", "plane", "arch", "beam", "corner", "layers", "rocking")
STIFFER = 1e3  # times the joints, over the size of a block


def zoned(trial: Trial) -> bsm.Model:
    """Return the model of a trial, whose blocks have zones in large displacement."""
    scene, model = trial.scene, trial.scene.model()
    zones = bsm.Zones(size=4 * scene.size, order=1, displacement="large")
    young = min(STIFFER * scene.kn * scene.size, 1e13)
    return model.replace(rocks=[replace(rock, young=young, poisson=0.2, zones=zones) for rock in model.rocks])


def ended(trial: Trial) -> str:
    """Return whether the blocks rest where the closed form says so, or how the run ended; they may rest elsewhere."""
    assert trial.expected is not None
    try:
        results = bsm.run(zoned(trial))
    except ModelError as error:
        print(trial.family, trial.seed, error, file=sys.stderr, flush=True)
        return "refused"
    if results.status == "not_converged":
        return "not converged"
    moved = np.hypot(*results.stages[-1].displacement[:, :2].T).max()
    rests = results.status != "unstable" and moved < COLLAPSE.free_move * trial.scene.size
    if rests != trial.expected.rests:
        print(trial.family, trial.seed, results.status, trial.expected, file=sys.stderr, flush=True)
    return "right" if rests == trial.expected.rests else "wrong"


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--models", type=int, default=10, help="of each family")
    add_into(parser, COMMAND)
    given = parser.parse_args()
    rows = []
    for name in CLOSED:
        start = process_time()
        trials = [trial_of(FAMILIES[name], seed) for seed in range(given.models)]
        ends = [ended(each) for each in trials if each.expected is not None and each.expected.rests is not None]
        counts = [ends.count(end) for end in ("right", "not converged", "wrong", "refused")]
        rows.append((FAMILIES[name].title, *map(str, (len(ends), *counts, round(process_time() - start)))))
        print(*rows[-1], file=sys.stderr, flush=True)
    header = "family", "judged", "right", "not converged", "wrong", "refused", "processor time, s"
    tell(markdown(header, rows), COMMAND, given.into)


if __name__ == "__main__":
    main()
