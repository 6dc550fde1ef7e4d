"""Tables and scaling plots of benchmark rows."""

from __future__ import annotations

import json
import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.campaign.store import head_of
from benchmarks.cases import Case

Row = dict[str, Any]
COLUMNS = {
    "residual": ("residual", "8.1e"),
    "drift": ("drift m", "8.1e"),
    "steps": ("steps", "5d"),
    "factorizations": ("factors", "7d"),
    "seconds": ("seconds", "8.3f"),
    "processor": ("processor", "9.3f"),
    "memory": ("GB", "5.2f"),
}
LIBRARIES = ("bsm-mesh", "numpy", "scipy", "numba", "mkl", "pymunk", "scikit-fem")
NO_ANSWER = ("not_converged", "no answer")
ENOUGH = 1000  # blocks from which on growth is measured: smaller runs are mostly start-up


def machine() -> str:
    """Return a line on machine and versions; the load says whether others ran on it."""
    found = []
    for name in LIBRARIES:
        try:
            found.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            continue
    load = f"load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return (
        f"{os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}, {', '.join(found)}; {load}"
    )


def print_head(case: Case) -> None:
    """Print title and head of a table."""
    cells = [f"{head:>{_width(form)}s}" for head, form in COLUMNS.values()]
    parts = [f"{part[:9]:>9s}" for part in case.parts]
    print(f"\n{case.title}\n{'':12s}{'blocks':>8s}  {'verdict':14s}{'  '.join([*cells, *parts])}  note", flush=True)


def print_row(case: Case, program: str, row: Row) -> None:
    """Print one row."""
    cells = [f"{row[name]:{form}}" if name in row else f"{'-':>{_width(form)}s}" for name, (_, form) in COLUMNS.items()]
    given = row.get("parts", {})
    parts = [f"{given[part]:9.3f}" if part in given else f"{'-':>9s}" for part in case.parts]
    text = "  ".join([*cells, *parts])
    print(f"{program:12s}{row['blocks']:8d}  {row['verdict']:14s}{text}  {row['note']}", flush=True)


def _width(form: str) -> int:
    return int(form.split(".")[0].rstrip("d"))


def spent(row: Row) -> float:
    """Return the processor seconds of a row; the wall seconds where a program does not tell those."""
    return float(row.get("processor", row["seconds"]))


def exponent(rows: list[Row]) -> float | None:
    """Return the exponent of growth with the number of blocks over the rows with an answer; None for fewer than two."""
    answered = [
        row for row in rows if "seconds" in row and row["verdict"] not in NO_ANSWER and row["blocks"] >= 0.9 * ENOUGH
    ]
    if len(answered) < 2:
        return None
    sizes, values = np.log([row["blocks"] for row in answered]), np.log([spent(row) for row in answered])
    return float(np.polyfit(sizes, values, 1)[0])


def print_findings(case: Case, rows: dict[str, list[Row]]) -> None:
    """Print growth, the floor, and how many times as long others take, from a case's rows by program."""
    for program, found in rows.items():
        growth = exponent(found)
        texts = [] if growth is None else [f"grows as blocks^{growth:.2f}"]
        for row in found[-1:]:
            floor = row.get("parts", {}).get("factorization", 0.0)
            if floor and "factorizations" in row:
                texts.append(f"{row['blocks']} blocks: {spent(row) / floor:.2f} times its own factorizations")
        if texts:
            print(f"{program}: {'; '.join(texts)}")
    if "factorization" not in case.parts:  # its programs do different things
        return
    ours = {row["asked"]: row for found in list(rows.values())[:1] for row in found if "seconds" in row}
    for program, found in list(rows.items())[1:]:
        for row in found:
            if "seconds" in row and row["asked"] in ours and row["asked"] >= ENOUGH:
                times = spent(row) / spent(ours[row["asked"]])
                print(f"{program}: {times:.3g} times as long at {row['blocks']} blocks ({row['verdict']})")


def draw(case: Case, rows: dict[str, list[Row]], path: Path) -> None:
    """Draw processor seconds against blocks, logarithmic: hollow without an answer, dashed the floor."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for number, (program, found) in enumerate(rows.items()):
        timed = [row for row in found if "seconds" in row]
        if not timed:
            continue
        blocks, seconds = [row["blocks"] for row in timed], [spent(row) for row in timed]
        growth = exponent(found)
        label = program if growth is None else f"{program} (exponent {growth:.2f})"
        axes.plot(blocks, seconds, "-", color=f"C{number}", marker="o", label=label)
        open_ends = [row for row in timed if row["verdict"] in NO_ANSWER]
        size = {"marker": "o", "s": 60, "zorder": 3, "facecolors": "white", "edgecolors": f"C{number}"}
        axes.scatter([row["blocks"] for row in open_ends], [spent(row) for row in open_ends], **size)
        floors = [row for row in timed if "factorizations" in row and row["parts"]["factorization"] > 0]
        if floors:
            at, floor = [row["blocks"] for row in floors], [row["parts"]["factorization"] for row in floors]
            label = f"{program}, factorizations"
            axes.plot(at, floor, "--", color=f"C{number}", marker=".", label=label)
    axes.set(
        xscale="log", yscale="log", xlabel="blocks", ylabel="processor seconds", title=case.title.partition(":")[0]
    )
    axes.title.set_fontsize(9)
    axes.grid(which="both", alpha=0.3)
    if axes.lines:
        axes.legend(title="hollow: no answer", fontsize=8, title_fontsize=8)
    figure.savefig(path, dpi=120)


def keep(rows: dict[str, dict[str, list[Row]]], threads: int, path: Path) -> None:
    """Write all rows as JSON, and where they were measured."""
    content = {"machine": machine(), "where": where(threads), "cases": rows}
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")


def where(threads: int) -> str:
    """Return commit, date, processor and threads."""
    head = head_of(0.0)
    told = f"Commit {head['commit']}, bsm_mesh {head['engine']}, {head['date']}, {head['processor']}"
    return f"{told}, {f'{threads} threads' if threads > 1 else 'one thread' if threads else 'all cores'}"
