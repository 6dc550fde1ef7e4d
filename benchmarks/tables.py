"""The rows of benchmarks as tables of a page: times by part, growth, what others take."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from benchmarks.campaign.tables import as_markdown
from benchmarks.cases import CASES
from benchmarks.measure import PARTS
from benchmarks.pages import tell, titled
from benchmarks.report import ENOUGH, NO_ANSWER, Row, exponent, spent

MAKER = "python -m benchmarks"  # in the marks of pages
Found = dict[str, dict[str, list[Row]]]  # rows by scene and program


def read(paths: Iterable[Path]) -> tuple[str, Found]:
    """Return where rows were measured, and all rows; of a scene, program and size in two files those of the last."""
    said: list[str] = []
    found: Found = {}
    for path in paths:
        kept: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        said.append(kept["where"])
        for name, programs in kept["cases"].items():
            for program, rows in programs.items():
                before = found.setdefault(name, {}).get(program, [])
                by_size = {row["asked"]: row for row in before + rows}
                found[name][program] = [by_size[size] for size in sorted(by_size)]
    return "; ".join(dict.fromkeys(said)), found


def write_into(page: Path, paths: Iterable[Path]) -> None:
    """Write the tables of stored rows into a page."""
    said, found = read(paths)
    order = [name for name in CASES if name in found]
    parts = [
        (title, as_markdown(rows) if len(rows) > 1 else "")
        for title, rows in (
            ("Processor seconds and memory by size", of_sizes({name: found[name] for name in order})),
            ("Scenes", of_scenes({name: found[name] for name in order})),
            ("Growth", of_growth({name: found[name] for name in order})),
            ("Meshes, files and commands", of_files({name: found[name] for name in order})),
        )
    ]
    tell(titled(said, parts), MAKER, page)


def of_sizes(found: Found) -> list[list[str]]:
    """Return a row a scene and start: processor seconds and memory [GB] at each size that was asked for."""
    ours = [(name, program) for name in found if _is_solved(name) for program in found[name] if program in _ours(name)]
    runs = {key: {row["asked"]: row for row in found[key[0]][key[1]] if "seconds" in row} for key in ours}
    sizes = sorted({size for run in runs.values() for size in run if size >= ENOUGH})
    rows = [["model", "", *(f"{size:.0f} blocks" for size in sizes)]]
    for (name, program), run in runs.items():
        cells = [_cost(run[size]) if size in run else "" for size in sizes]
        rows.append([CASES[name].title, program, *cells])
    return rows


def _cost(row: Row) -> str:
    """Return seconds, memory and verdict of a run."""
    return f"{spent(row):.2g} s, {_memory(row)} GB, {row['verdict'].replace('_', ' ')}"


def of_scenes(found: Found) -> list[list[str]]:
    """Return a row a run: verdict, cost, and the parts of its time."""
    heads = ["factorization", "solution", "contacts, assembly", "motion", "rest"]
    rows = [["scene", "program", "blocks", "verdict", "processor s", "GB", "factorizations", *heads]]
    for name, program, row in _each(found, solved=True):
        parts, whole = row.get("parts", {}), spent(row)
        sums = (("factorization",), ("solution",), ("contacts", "assembly"), ("motion",), ("model", "rest"))
        shares = [f"{100 * sum(parts.get(key, 0.0) for key in keys) / whole:.0f} %" for keys in sums]
        split = shares if program in _ours(name) else [""] * len(sums)
        count = str(row.get("factorizations", ""))
        rows.append([name, program, str(row["blocks"]), row["verdict"], f"{whole:.2f}", _memory(row), count, *split])
    return rows


def of_growth(found: Found) -> list[list[str]]:
    """Return a row a scene and program: the exponent of growth, and at its largest size what a block takes."""
    rows = [
        ["scene", "program", "processor time grows as blocks to the", "largest, blocks", "ms a block", "kB a block"]
    ]
    for name, programs in found.items():
        for program, runs in programs.items():
            answered = [
                row for row in runs if _is_solved(name) and "seconds" in row and row["verdict"] not in NO_ANSWER
            ]
            growth = exponent(answered)
            if growth is None:
                continue
            last = answered[-1]
            each = f"{1000 * spent(last) / last['blocks']:.2g}", f"{1024**2 * last['memory'] / last['blocks']:.2g}"
            rows.append([name, program, f"{growth:.2f}", str(last["blocks"]), *each])
    return rows


def of_files(found: Found) -> list[list[str]]:
    """Return a row a mesh, file or command: its parts."""
    rows = [["what", "which", "blocks", "processor s", "parts", "GB", ""]]
    for name, program, row in _each(found, solved=False):
        parts = ", ".join(f"{part} {seconds:.2f}" for part, seconds in row.get("parts", {}).items())
        rows.append([name, program, str(row["blocks"]), f"{spent(row):.2f}", parts, _memory(row), row["note"]])
    return rows


def _is_solved(name: str) -> bool:
    """Return whether the programs of a case solve a scene: its times have the parts of a solution."""
    return set(PARTS) <= set(CASES[name].parts)


def _ours(name: str) -> list[str]:
    return [program for program in CASES[name].programs if program not in ("pymunk", "limit", "scikit-fem")]


def _each(found: Found, *, solved: bool) -> Iterable[tuple[str, str, Row]]:
    """Return scene, program and row of every run with a time, of cases that solve scenes or of the others."""
    for name, programs in found.items():
        if _is_solved(name) == solved:
            sized = [(row["asked"], number, row) for number, rows in enumerate(programs.values()) for row in rows]
            labels = list(programs)
            for _, number, row in sorted(sized, key=lambda one: one[:2]):
                if "seconds" in row and row["blocks"] >= (ENOUGH if solved else 0) * 0.9:
                    yield name, labels[number], row


def _memory(row: Row) -> str:
    return f"{row['memory']:.2f}" if "memory" in row else ""
