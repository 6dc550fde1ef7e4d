"""Agreement that other commands have measured, told in a line each from the tables where they wrote it."""

from __future__ import annotations

import re
from itertools import takewhile
from pathlib import Path

import numpy as np

from examples.numbers.pages import markdown

DOCS = Path(__file__).parents[1] / "docs"
NOTHING = 0.1  # %: "less than 0.1 %" in sentences
Rows = list[dict[str, str]]


def table_with(page: str, *columns: str) -> Rows:
    """Return the rows of the first table of a page that has columns, by column.

    Raises
    ------
    ValueError
        Where there is none.
    """
    lines = (DOCS / page).read_text(encoding="utf-8").splitlines()
    headers = (k for k, line in enumerate(lines) if line.startswith("|") and set(columns) <= set(_cells(line)))
    first = next(headers, None)
    if first is None:
        raise ValueError(f"{page} has no table with the columns {', '.join(columns)}")
    below = takewhile(lambda line: line.startswith("|"), lines[first + 2 :])
    return [dict(zip(_cells(lines[first]), _cells(line), strict=True)) for line in below]


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def against_elements() -> tuple[str, str]:
    """Return what blocks were compared with, and how far displacements and joint forces lie apart."""
    rows = table_with("continuum.md", "class")
    sentences = [cell for row in rows for cell in row.values() if "Blocks and finite elements" in cell]
    apart: dict[str, list[float]] = {"displacement": [], "joint forces": []}
    for text in sentences:
        told = text.partition("refining")[0]
        for what, found in apart.items():
            match = re.search(rf"(less than )?([\d.]+) % in {what}", told)
            if match:
                found.append(NOTHING if match[1] else float(match[2]))
    words = [
        f"{what}: median {_percent(np.median(found))}, three quarters within {_percent(np.quantile(found, 0.75))}, "
        f"greatest {_percent(max(found))}"
        for what, found in apart.items()
    ]
    what = f"{len(rows)} stages of examples and starters, {len(sentences)} of them compared"
    return what, "; ".join(words)


def _percent(value: float) -> str:
    return "less than 0.1 %" if value <= NOTHING else f"{value:.1f} %"


def against_program(program: str, *, gives_verdicts: bool) -> tuple[str, str]:
    """Return what a program was compared with, and how far forces lie apart where the blocks are stable."""
    rows = table_with("other_programs.md", "model", "program", "verdict or movement")
    ours = {row["model"]: row["verdict or movement"] for row in rows if row["program"] == "bsm-mesh"}
    theirs = {row["model"]: row for row in rows if row["program"] == program}
    apart = [float(row["greatest difference of a pair"].split()[0])
             for model, row in theirs.items() if ours[model] == "stable"]  # fmt: skip
    told = f"forces between two blocks: {100 * min(apart):.2g} to {100 * max(apart):.2g} % of the weight"
    if not gives_verdicts:
        return f"{len(apart)} stable models", told
    moved = {model: float(row["verdict or movement"].split()[1]) for model, row in theirs.items()}
    same = sum((moved[model] < 1e-3) == (verdict == "stable") for model, verdict in ours.items())
    return f"{len(theirs)} models", f"verdicts: {same} of {len(theirs)} the same; {told}"


def against_known_answers() -> tuple[str, str]:
    """Return what the campaign asked, and how many contradictions it found."""
    oracles = table_with("campaign.md", "oracle", "models", "contradictions")
    families = table_with("campaign.md", "family", "models", "stable")
    models = next(row["models"] for row in families if row["family"] == "all")
    proofs = [row for row in oracles if row[""] == "proof"]
    closed = next(row for row in oracles if row["oracle"] == "closed form")
    against, asked = (sum(int(row[column]) for row in proofs) for column in ("contradictions", "models"))
    found = f"{against} contradictions in {asked} proofs; by closed forms {closed['contradictions']}"
    return f"{models} random models, {closed['models']} of them with closed forms", found


def table() -> str:
    """Return the table of the measurement elsewhere."""
    others = "[other programs](other_programs.md#comparison)"
    lines = (
        ("finite elements with the same joints", *against_elements(), "[continuum](continuum.md#every-example)"),
        ("LMGC90", *against_program("lmgc90", gives_verdicts=True), others),
        ("compas_dem, RBE", *against_program("compas_dem", gives_verdicts=False), others),
        (
            "closed forms, limit analysis, certificates, the model itself in another frame",
            *against_known_answers(),
            "[campaign](campaign.md#what-todays-solver-does)",
        ),
    )
    return markdown(("compared with", "on", "found", "page"), lines)
