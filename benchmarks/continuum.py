"""Set finite elements beside every example and starter: ``python -m benchmarks.continuum``.

A table of every stage: its class and the sentence of ``bsm-mesh compare``. With ``--into PAGE`` it takes the place of
what stands between that page's marks.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import bsm_mesh as bsm
from bsm_mesh.app.build import load_model_file
from bsm_mesh.converters.continuum import ComparedStage, compare_stages
from bsm_mesh.files import write_text

ROOT = Path(__file__).parents[1]
BEGIN, END = (
    "<!-- made by python -m benchmarks.continuum: begin -->",
    "<!-- made by python -m benchmarks.continuum: end -->",
)
HEADER = ("model", "stage", "class", "what compare says", "blocks s", "elements s")
Line = tuple[str, ...]


def all_models() -> list[Path]:
    """Return the model files of examples and starters."""
    return sorted((ROOT / "examples").glob("*/*.toml")) + sorted((ROOT / "bsm_mesh/app/starters").glob("*/*.toml"))


def name_of(model: Path) -> str:
    """Return what a model file is called in the table."""
    starter = "starter " if "starters" in model.parts else ""
    return f"{starter}{model.parent.name}/{model.stem}"


def lines_of(model: Path) -> list[Line]:
    """Return a line a stage of a model; one if it is refused."""
    name = name_of(model)
    try:
        loaded = load_model_file(model, lambda _: None)
        stages = compare_stages(loaded.model, bsm.run(loaded.model, loaded.options))
    except bsm.ModelError as error:
        return [(name, "-", "-", f"refused: {'; '.join(error.faults)}", "-", "-")]
    return [line(name, stage) for stage in stages]


def line(name: str, stage: ComparedStage) -> Line:
    """Return the line of a stage."""
    compared = stage.comparison
    seconds = ("-", "-") if compared is None else (f"{compared.bsm_seconds:.2g}", f"{compared.fem_seconds:.2g}")
    return name, stage.name, stage.kind.value, stage.sentence, *seconds


def table(lines: list[Line]) -> str:
    """Return the table in Markdown, and how many models are of each class by their last stage."""
    last = {found[0]: found[2] for found in lines}
    compared = {found[0] for found in lines if found[2] in ("comparable", "with interfaces")}
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(Counter(last.values()).items()))
    rows = [HEADER, tuple("---" for _ in HEADER), *lines]
    body = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    told = f"{len(last)} models, {len(compared)} of them compared in one stage at least. By their last stage: {counts}."
    return f"{told}\n\n{body}\n"


def put(page: Path, text: str) -> None:
    """Replace what stands between a page's marks."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise SystemExit(f"{page} has not both marks: {BEGIN} and {END}")
    write_text(page, f"{before}{BEGIN}\n{text}{END}{after}")


def main() -> int:
    """Compare what is asked for, and print the table or put it into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", type=Path, help="model files; all examples and starters by default")
    parser.add_argument("--into", type=Path, metavar="PAGE", help="a page in Markdown: what stands between its marks")
    given = parser.parse_args()
    lines: list[Line] = []
    for model in given.models or all_models():
        began = time.perf_counter()
        lines += lines_of(model.resolve())
        print(f"{lines[-1][0]}: {lines[-1][2]}, {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    if given.into:
        put(given.into, table(lines))
    else:
        print(table(lines))
    return int(any(found[2] == "-" for found in lines))


if __name__ == "__main__":
    sys.exit(main())
