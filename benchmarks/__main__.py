"""Every scene by every program that can solve it: tables, and scaling plots in a folder (``python -m benchmarks``).

Every size and program runs in a process of its own with a time limit, so that peak memory is its own; compiled code is
warmed up on a small model first. ``pip install '.[benchmark]'`` brings the peers along.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

from benchmarks import tables
from benchmarks.cases import CASES, PEER, run_entry
from benchmarks.report import Row, draw, keep, machine, print_findings, print_head, print_row

GRACE = 60.0  # to import, warm up and build the model [s]


def main() -> None:
    """Run what is asked for."""
    arguments = sys.argv[1:]
    given = parser().parse_args(arguments)
    if given.tables:
        try:
            tables.write_into(Path(given.into), [Path(path) for path in given.tables])
        except (OSError, ValueError) as error:
            sys.exit(f"error: {error}")
        return
    if given.worker:
        (n,) = given.sizes
        print(json.dumps(run_entry(CASES[given.scene[0]], given.worker, int(n), given)))
        return
    print(machine())
    folder = Path(given.folder)
    folder.mkdir(parents=True, exist_ok=True)
    found: dict[str, dict[str, list[Row]]] = {}
    for name in given.scene or CASES:
        found[name] = run_case(name, given)
        keep(found, given.threads, folder / "rows.json")
    print(f"\nwritten to {folder}: {', '.join(f'{name}.png' for name in found)}, rows.json")


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    made = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__.splitlines()[0])
    made.add_argument("--scene", nargs="+", choices=tuple(CASES), default=(), help="all, by default")
    made.add_argument("--sizes", nargs="+", type=float, help="blocks; the scene's own sizes by default")
    made.add_argument("--programs", nargs="+", metavar="NAME", help="all of the scene's, by default")
    made.add_argument("--time-limit", type=float, default=60.0, metavar="SECONDS", help="for every run (default 60)")
    made.add_argument("--folder", default="benchmark-results", help="for plots and rows.json (default %(default)s)")
    made.add_argument("--peer", metavar="NAME=COMMAND", help="another program: gets a JSON file, prints a JSON row")
    made.add_argument("--solver", default="auto", help="linear solver of bsm")
    made.add_argument("--threads", type=int, default=0, help="of the linear solver; 0: all cores")
    made.add_argument("--friction", type=float, help="degrees, instead of the scene's")
    made.add_argument("--k0", type=float, default=1.0, help="in-situ stress ratio where a scene has one (default 1)")
    made.add_argument("--max-steps", type=int, default=500, help="of bsm")
    made.add_argument("--trace", action="store_true", help="print every step of bsm")
    made.add_argument("--tables", nargs="+", metavar="ROWS", help="nothing is run: rows.json of earlier runs")
    made.add_argument("--into", default="docs/performance.md", metavar="PAGE", help="of --tables (default %(default)s)")
    made.add_argument("--worker", metavar="NAME", help=argparse.SUPPRESS)
    made.add_argument("--command", help=argparse.SUPPRESS)
    return made


def run_case(name: str, given: argparse.Namespace) -> dict[str, list[Row]]:
    """Print the table of a case as it comes, draw it, and return its rows by program."""
    case = CASES[name].at_friction(given.friction)
    labels = {program: program for program in case.programs if not given.programs or program in given.programs}
    if given.peer and case.build is not None:
        labels[PEER] = given.peer.partition("=")[0]
    rows: dict[str, list[Row]] = {label: [] for label in labels.values()}
    print_head(case)
    for size in given.sizes or case.sizes:
        for program, label in labels.items():
            before = rows[label][-1:]
            if before and gave_up(before[0], given.time_limit):
                row = {
                    "blocks": int(size),
                    "verdict": "not tried",
                    "note": f"no answer at {before[0]['blocks']} blocks",
                }
            else:
                row = in_own_process(name, program, int(size), given)
            rows[label].append(row | {"asked": int(size)})
            print_row(case, label, row)
    print_findings(case, rows)
    draw(case, rows, Path(given.folder) / f"{name}.png")
    return rows


def gave_up(row: Row, time_limit: float) -> bool:
    """Return whether a program had no answer in time, so that a larger scene is not worth trying."""
    late = row["verdict"] == "not_converged" and row["seconds"] >= time_limit
    return late or row["verdict"] in ("no answer", "failed", "not tried")


def in_own_process(case: str, program: str, n: int, given: argparse.Namespace) -> Row:
    """Return what a worker printed, or why there is nothing."""
    command = [sys.executable, "-m", "benchmarks", "--scene", case, "--worker", program, "--sizes", str(n)]
    for key in ("solver", "threads", "friction", "k0", "max_steps", "time_limit"):
        value = getattr(given, key)
        command += [] if value is None else [f"--{key.replace('_', '-')}", str(value)]
    command += ["--trace"] if given.trace else []
    command += ["--command", given.peer.partition("=")[2]] if program == PEER else []
    try:
        done = subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=None if given.trace else subprocess.PIPE,
            text=True,
            check=False,
            timeout=given.time_limit + GRACE,
        )
    except subprocess.TimeoutExpired:
        return {"blocks": n, "verdict": "no answer", "note": f"stopped after {given.time_limit:g} s"}
    if done.returncode:
        last = ((done.stderr or "").strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        return {"blocks": n, "verdict": "failed", "note": last}
    return json.loads(done.stdout.splitlines()[-1])


if __name__ == "__main__":
    main()
