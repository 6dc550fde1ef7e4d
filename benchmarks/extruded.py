"""The plane's own models as slices of space: verdicts stage by stage, side by side (``python -m benchmarks.extruded``).

The models are the examples, and those of known factors of safety, their strength divided by 0.95 and by 1.05 of that.
Both are run with the options of the model file and one thread. Where verdicts differ, the slice is run between walls
too. Where displacements differ by more than `ASKED`, plane and slice are solved by other routes as well: where friction
leaves several equilibria, these differ by more. Every model is written as a line of JSON.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.continuum import all_models
from benchmarks.pages import add_into, tell
from benchmarks.slices import NoSliceError, Slice, extruded
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.strength import with_strength
from bsm_mesh.modelfile.variation import Variation
from examples.numbers.pages import markdown
from tests.scenes import large
from tests.scenes.known_factors import Known, known
from tests.scenes.openings import opening
from tests.scenes.two_stages import staged

ROOT = Path(__file__).parents[1]
MAKER = "python -m benchmarks.extruded"
SMALL = 1e-6  # of the displacement: less is rounding
ASKED = 1e-3  # of it: an explanation is asked for where a slice is off by more
BESIDE = (0.95, 1.05)  # of a known factor: at rest, in motion
GAPS = (1.8, 1.9, 1.95, 2.05, 2.1, 2.2)  # m, above the floor: its example has 2 m
MOST = 800  # blocks of a model that is run
HEADER = (
    "model",
    "blocks",
    "stages",
    "plane",
    "slice",
    "between walls",
    "displacement off by",
    "plane by other routes",
    "slice by other routes",
)


def _verdicts(stages: Sequence[str]) -> str:
    """Return verdicts in words, one where all are equal."""
    return stages[0] if len(set(stages)) == 1 else ", ".join(stages)


def models() -> dict[str, Callable[[], bsm.Model]]:
    """Return the models by their names, none of them built yet."""
    found: dict[str, Callable[[], bsm.Model]] = {}
    for path in all_models():
        if "starters" not in path.parts:
            found[f"{path.parent.name}/{path.stem}"] = partial(bsm.load, path)
    floor = ROOT / "examples/03_stratified_slope/floor.toml"
    for gap in GAPS:
        found[f"03_stratified_slope/floor, gap {gap:g} m"] = partial(_with_gap, floor, gap)
    for each in known():
        for part in BESIDE:
            found[f"{each.name}; {part:g} of the known factor"] = partial(_reduced, each, part)
    for bolted in (False, True):
        found[f"opening, {'with' if bolted else 'without'} bolts"] = partial(opening, bolted=bolted)
    found["six blocks of which two go"] = staged
    for build, k0 in ((large.jointed_slope, 1.0), (large.leaning_slope, None), (large.blocky_rock, 1.0)):
        found[f"{build.__name__}, 300 blocks"] = partial(_scene, build, k0)
    found["sliding_layers, 100 blocks"] = partial(_scene, partial(large.sliding_layers, 100), None)
    return found


def _with_gap(path: Path, gap: float) -> bsm.Model:
    return Variation(path).with_value("mesh.parameters.gap", gap)


def _reduced(each: Known, part: float) -> bsm.Model:
    names = each.joints or ("*",)
    return with_strength(each.build(), dict.fromkeys(names, 1 / (part * each.factor)))


def _scene(build: Callable[..., large.Scene], k0: float | None) -> bsm.Model:
    scene = build() if isinstance(build, partial) else build(300)
    return scene.model(k0)


def compared(model: bsm.Model) -> dict[str, Any]:
    """Return verdicts of a model, of its slice and, where they differ, of one between walls; blocks, displacement."""
    assert not in_space(model.blocks)
    options = replace(model.options or bsm.Options(), threads=1, scheme="continuation")
    seconds, runs = [], []
    for walls in (None, False, True):
        begun = time.process_time()
        each = model if walls is None else extruded(model, walls=walls)
        runs.append(bsm.run(each, options))
        seconds.append(round(time.process_time() - begun, 1))
        verdicts = [[str(stage.status) for stage in run.stages] for run in runs]
        if len(runs) > 1 and verdicts[0] == verdicts[1]:
            break
    told: dict[str, Any] = dict(zip(("plane", "slice", "walls"), verdicts, strict=False))
    told |= {"blocks": model.blocks.count, "seconds": seconds}
    if told["plane"] == told["slice"] and set(told["plane"]) == {"stable"}:
        told["off"], size = _off(model, runs[0], runs[1])
        if told["off"] > ASKED:
            for which, run in (("", runs[0]), ("slice_", runs[1])):
                ends = bsm.spread(run).spread
                told[f"{which}routes"] = max(end.difference or 0.0 for end in ends) / size
                told[f"{which}route_verdicts"] = sorted({str(end.status) for end in ends})
    return told


def _off(model: bsm.Model, plane: bsm.Results, space: bsm.Results) -> tuple[float, float]:
    """Return the greatest difference of displacements in the last stage over the greatest one, and that [m]."""
    last = [run.stages[-1] for run in (plane, space)]
    flat = Slice.of(model).flat(last[0].displacement[:, :2])
    there = last[0].present & last[1].present
    there[np.concatenate([run.unstable_blocks for run in (plane, space)])] = False
    off = np.abs(last[1].displacement[there][:, [0, 2]] - flat[there]).max(initial=0.0)
    size = np.abs(flat[there]).max(initial=0.0)
    return (float(off / size), float(size)) if size > 0 else (0.0, 0.0)


def table(records: Sequence[dict[str, Any]]) -> str:
    """Return the records as a table, and how many verdicts are equal."""
    rows = []
    for told in records:
        off, walls = told.get("off"), told.get("walls")
        rows.append(
            (
                told["name"],
                str(told["blocks"]),
                str(len(told["plane"])),
                _verdicts(told["plane"]),
                "the same" if told["slice"] == told["plane"] else _verdicts(told["slice"]),
                "" if walls is None else "the same" if walls == told["plane"] else _verdicts(walls),
                "-" if off is None else f"{off:.0e}" if off > SMALL else f"below {SMALL:.0e}",
                _routes(told, ""),
                _routes(told, "slice_"),
            )
        )
    same = sum(told["slice"] == told["plane"] for told in records)
    after = sum(told.get("walls", told["slice"]) == told["plane"] for told in records)
    stages = sum(len(told["plane"]) > 1 for told in records)
    text = (
        f"All verdicts are equal in {same} of {len(records)} models, and in {after} where walls hold the slices that "
        f"differ. {stages} models have stages."
    )
    return f"{markdown(HEADER, rows)}\n\n{text}"


def _routes(told: dict[str, Any], which: str) -> str:
    """Return by how much routes of the plane, or of the slice, differ, and their verdicts where there are several."""
    if f"{which}routes" not in told:
        return ""
    verdicts = told[f"{which}route_verdicts"]
    return ", ".join([f"{told[f'{which}routes']:.0e}", *(verdicts if len(verdicts) > 1 else [])])


def main() -> None:
    """Run the models that the file does not hold yet, and print the table of all lines in it."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.extruded", description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="file of lines that is continued")
    parser.add_argument("names", nargs="*", help="parts of the models' names; all by default")
    add_into(parser, MAKER)
    given = parser.parse_args()
    lines = given.file.read_text(encoding="utf-8").splitlines() if given.file.exists() else []
    known_names = {json.loads(line)["name"] for line in lines}
    every = models()
    for name, build in every.items():
        if name in known_names or not (not given.names or any(part in name for part in given.names)):
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model = build()
        try:
            if model.blocks.count > MOST:
                raise NoSliceError(f"has {model.blocks.count} blocks, more than {MOST}")
            told = {"name": name, **compared(model)}
        except (NoSliceError, bsm.ModelError) as reason:
            print(f"{name} is left out: {str(reason).splitlines()[0]}", file=sys.stderr, flush=True)
            continue
        with given.file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(told) + "\n")
        print(told, file=sys.stderr, flush=True)
    records = {told["name"]: told for told in map(json.loads, given.file.read_text(encoding="utf-8").splitlines())}
    tell(table([records[name] for name in every if name in records]), MAKER, given.into)


if __name__ == "__main__":
    main()
