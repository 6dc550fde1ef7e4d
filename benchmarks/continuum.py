"""Set finite elements beside every example and starter: ``python -m benchmarks.continuum``.

A table of every stage: its class and the sentence of ``bsm-mesh compare``. With ``--into PAGE`` it takes the place of
what is between that page's marks.
"""

from __future__ import annotations

import argparse
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from bsm_mesh.converters.continuum import compare_stages
from bsm_mesh.converters.continuum.references import Request, continuum_of
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.solve.zones.elasticity import nominal_constants
from bsm_mesh.solve.zones.stages import Continuum
from examples.numbers.pages import markdown

ROOT = Path(__file__).parents[1]
COMMAND = "python -m benchmarks.continuum"
HEADER = ("model", "stage", "class", "what compare says", "blocks ms", "elements ms")
REPEATS = 3  # of which the quickest counts
Line = tuple[str, ...]


def all_models() -> list[Path]:
    """Return the model files of examples and starters."""
    found = sorted((ROOT / "examples").glob("*/*.toml")) + sorted(
        (ROOT / "bsm_mesh/commands/starters").glob("*/*.toml")
    )
    tables = {path: tomllib.loads(path.read_text(encoding="utf-8")) for path in found}
    return [path for path, table in tables.items() if "mesh" in table and table.get("dimensions", 2) == 2]  # no study


def name_of(model: Path) -> str:
    """Return what a model file is called in the table."""
    starter = "starter " if "starters" in model.parts else ""
    return f"{starter}{model.parent.name}/{model.stem}"


def lines_of(model: Path) -> list[Line]:
    """Return a line a stage of a model; one if it is refused."""
    name = name_of(model)
    try:
        loaded = load_model_file(model, lambda _: None)
        results = bsm.run(loaded.model, loaded.options)
        stages = compare_stages(loaded.model, results)
    except bsm.ModelError as error:
        return [(name, "-", "-", f"refused: {'; '.join(error.faults)}", "-", "-")]
    compared = [number for number, stage in enumerate(stages) if stage.comparison is not None]
    lines = [(name, stage.name, stage.kind.value, stage.sentence, "-", "-") for stage in stages]
    if compared:
        cost = cost_of(loaded.model, loaded.options, results, 1 + compared[-1])
        lines[compared[-1]] = (*lines[compared[-1]][:4], *(f"{float(f'{1e3 * seconds:.2g}'):g}" for seconds in cost))
    return lines


def cost_of(model: bsm.Model, options: bsm.Options, results: bsm.Results, count: int) -> tuple[float, float]:
    """Return processor seconds of the run and of one continuum solution, both of the first `count` stages."""
    stages = model.stages[: count - 1]
    there = {None, *(stage.name for stage in stages)}
    shorter = model.replace(stages=stages, bolts=[bolt for bolt in model.bolts if bolt.stage in there], histories=())
    solved, elements = continuum_of(shorter, results, count, Request())
    return (
        min(_seconds(lambda: bsm.run(shorter, options)) for _ in range(REPEATS)),
        min(_seconds(lambda: Continuum(solved, elements).solve(nominal_constants(solved))) for _ in range(REPEATS)),
    )


def _seconds(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def table(lines: list[Line]) -> str:
    """Return the table in Markdown, and how many models are of each class by their last stage."""
    last = {found[0]: found[2] for found in lines}
    compared = {found[0] for found in lines if found[2] in ("comparable", "with interfaces")}
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(Counter(last.values()).items()))
    times = [(float(found[4]), float(found[5])) for found in lines if found[4] != "-"]
    ratios = sorted(elements / blocks for blocks, elements in times if blocks > 0)
    told = f"{len(last)} models, {len(compared)} of them compared in one stage at least. By their last stage: {counts}."
    if ratios:
        told += (
            " Processor time, up to the last stage compared: one continuum solution takes "
            f"{ratios[len(ratios) // 2]:.2g} times as long as the blocks' "
            f"(median of the models; {ratios[0]:.2g} to {ratios[-1]:.2g}), "
            f"all together {sum(e for _, e in times) / 1e3:.2g} s against {sum(b for b, _ in times) / 1e3:.2g} s."
        )
    return f"{told}\n\n{markdown(HEADER, lines)}"


def main() -> int:
    """Compare what is asked for, and print the table or put it into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", type=Path, help="model files; all examples and starters by default")
    add_into(parser, COMMAND)
    given = parser.parse_args()
    lines: list[Line] = []
    for model in given.models or all_models():
        began = time.perf_counter()
        lines += lines_of(model.resolve())
        print(f"{lines[-1][0]}: {lines[-1][2]}, {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    tell(table(lines), COMMAND, given.into)
    return int(any(found[2] == "-" for found in lines))


if __name__ == "__main__":
    sys.exit(main())
